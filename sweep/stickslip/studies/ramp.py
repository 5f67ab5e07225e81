"""Slow ramps of a parameter up and down again: each value starts from where the motion at the one before ended."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.config.model import Config
from stickslip.config.problems import ProblemCollector
from stickslip.config.sections import of_row
from stickslip.config.studies import Moved, Regime, ReportTable, Study, shown
from stickslip.dataset.build import NO_FILL, grid_coordinates, shown_in, study_dataset, text_index
from stickslip.dataset.display import axis_names, parts_over, unit_of
from stickslip.engine import Options, Results, StopFlag, joined
from stickslip.errors import ArgumentError
from stickslip.studies.attractors import VARIABLES as OF_ATTRACTORS
from stickslip.studies.exact import DISTURBANCE, SETTLED, Box, Motions, exact_results, settled, unloaded
from stickslip.studies.lines import CellsOrConfig, LineSection, Side, check_lines, opened
from stickslip.studies.search import Floats
from stickslip.vocabulary.cells import Cells, Parameters, as_cells, taken
from stickslip.vocabulary.parameter import Parameter, Variable, of_section, table
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES, REGIMES, VARIABLES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Lines = NDArray[np.intp]
State = tuple[Floats, Floats]

_VIBRATION_END = "vibration_end"
_CELL = ("regime", "status", "velocity_amplitude", "displacement_amplitude", "period", "stick_fraction")
_OF_BOTH = ("unstable_amplitude", "unstable_velocity_amplitude", "unstable_period", "damping_ratio")
# By line, direction and value ("along" stands for the parameter); between both branches, by line and value.
_WAYS = ("direction", "along")
_BRANCHES = {name: replace(VARIABLES[name], dims=_WAYS) for name in _CELL}
_BETWEEN = {name: replace(OF_ATTRACTORS[name], dims=("along",)) for name in _OF_BOTH}
_ENDS = "where vibration ends, between this value and the next of the ramp"
_END = Variable(_VIBRATION_END, "parameter", _ENDS, dims=_WAYS)
_TOGETHER = 256  # cells that are held with the samples of their cycles
_STATES = of_section("start", PARAMETERS.values())
_CARRIED = "is a starting state, which a ramp carries from value to value"
_ANY = Box((0.0, 1.0), (-1.0, 1.0))  # of starting states, whose share nobody asks for
_STICK_SLIP, _SUSTAINED, _STUCK = (REGIMES.index(name) for name in ("stick_slip", "sustained", "stuck"))
_HALVINGS = 30  # of a step of the ramp
_DECIDED = 10  # of these, the first; closer to the end motions are within the tolerance of it, and may be undecided


class Ramp(LineSection):
    """Ends of vibration as a parameter goes slowly up and down; the other axes are lines."""

    key = "ramp"
    rows = table(
        Parameter("points", "1", "values to wait at, on each way", key,
                  default=200, at_least=2, at_most=10_000_000, whole=True),
    )  # fmt: skip
    points: int = of_row(rows["points"])


class RampStudy(Study):
    """Attractors of lines of cells, its items, as their parameter goes through values (SI) up and down again.

    The ramp waits at every value until the motion has come to its attractor: to a cycle or to steady sliding, where a
    disturbance of `DISTURBANCE` of the belt speed is left. It begins with an unloaded contact that sticks; down goes on
    where up ended. A value where the motion stays undecided passes on the state it started from.

    Columns: `_BRANCHES` and `vibration_end` by line, direction and value; `_BETWEEN` by line and value.
    """

    section, variables = Ramp, _BRANCHES | {_VIBRATION_END: _END} | _BETWEEN
    about = (
        "Each value starts from where the motion at the one before ended. The other axes of CONFIG are lines of their "
        "own; a plot shows a single line."
    )
    examples = (
        "configs/quickstart.yaml --along belt_speed --plot ramp.png",
        'configs/quickstart.yaml --along belt_speed --between 0.2 "1 m/s" -o ramp.nc',
    )
    caption = "ramp"
    name, counted, ragged, weight = "ramp", "lines", True, 64

    def __init__(self, cells: Cells, side: Side, options: Options) -> None:
        self._cells, self._side = cells, side
        self.title = f"Slow ramp: {QUANTITIES[side.name].long_name}"
        self._values = side.places
        self.dims, self.shape = cells.dims, cells.shape
        self.cells_each, self.options = 3 * side.points, replace(options, early_stop=True)
        self.columns = dict.fromkeys(self.variables, np.dtype(np.float64))
        if side.name in _STATES:
            raise ArgumentError("along", f"{side.name} {_CARRIED}")
        for end in self._values[[0, -1]]:
            self._at(end, np.arange(cells.size))

    @classmethod
    def of(cls, given: CellsOrConfig, section: Ramp, options: Options) -> RampStudy:
        """The ramps of cells along the parameter of the section."""
        cells, (side,) = opened(given, section.ranges(given), section.points, options)
        return cls(cells, side, options)

    @classmethod
    def check(cls, section: Ramp, config: Config, problems: ProblemCollector) -> None:
        """Note a parameter that no ramp can have, and lines that there are not."""
        if section.along in _STATES:
            problems.add((section.key, "along"), f"{section.along} {_CARRIED}")
        else:
            check_lines(section, config, problems)

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """Report the changes of regime on the way up, and on the way down."""
        *dims, _, along = ds["regime"].dims
        words = [*axis_names(ds, dims), "way", "regime", "then"]
        rows = ([*where, *row] for where, line in parts_over(ds, dims) for row in _changes(line, str(along)))
        yield from shown(ReportTable("", words, ["from", "to"], rows))

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Figure:
        """The branches of a variable."""
        from stickslip.plots import check_plain
        from stickslip.plots.attractors import plot_of_ramp

        check_plain(look, "a ramp")
        return plot_of_ramp(ds, variable, select=select, title=title)

    def _at(self, value: ArrayLike, lines: Lines) -> Parameters:
        """The cells of some lines at a value of the parameter."""
        moved = {self._side.name: np.array(np.broadcast_to(value, lines.size))}
        return as_cells(self._cells.take(lines, **moved), self.options.law)

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The ramps of a range of lines."""
        lines, work = np.arange(items.start, items.stop), Motions(self.options, stop, moved)
        results = self._followed(lines, work) | self._between(lines, work)
        return {name: results[name].ravel() for name in self.columns}

    def blank(self, items: range) -> Results:
        """Lines of which nothing is known."""
        each = {name: (1 if name in _BETWEEN else 2) * self._values.size for name in self.columns}
        return {name: np.full(len(items) * each[name], np.nan) for name in self.columns}

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The ramps with the dimensions of the lines, `direction` and the parameter."""
        name, unit, about = self._side.name, self._side.written_in, QUANTITIES[self._side.name]
        rows = self.variables | {_VIBRATION_END: replace(_END, units=about.units)}
        rows = {key: replace(row, dims=tuple(name if dim == "along" else dim for dim in row.dims))
                for key, row in rows.items()}  # fmt: skip
        ways = {key: () if key in _BETWEEN else (2,) for key in rows}
        values = {key: column.reshape(-1, *ways[key], self._values.size) for key, column in joined(parts).items()}
        axis = {"units": about.units, "long_name": about.long_name, "axis_spacing": self._side.spacing}
        coordinates = grid_coordinates(self._cells) | {
            name: shown_in(xr.Variable((name,), self._values, axis, NO_FILL), unit),
            "direction": text_index("direction", ("up", "down"), "direction of the ramp"),
        }
        ds = study_dataset("ramp", rows, values, self.dims, self.shape, coordinates, attributes)
        shown_in(ds[_VIBRATION_END].variable, unit)
        return ds

    def _followed(self, lines: Lines, work: Motions) -> Results:
        """By names of `_BRANCHES`, and `vibration_end`, arrays (lines, direction, values).

        `vibration_end`, at the last value that vibrates: the one, between it and the next, at which vibration gives way
        to steady sliding; NaN elsewhere, and where that is not known.
        """
        values, state = self._values, None
        shape = lines.size, 2, values.size
        columns: Results = {name: np.full(shape, np.nan) for name in (*_BRANCHES, _VIBRATION_END)}
        for direction, order in enumerate((range(values.size), range(values.size)[::-1])):
            vibrated, before = np.zeros(lines.size, np.bool_), order[0]
            for i in order:
                cells = self._at(values[i], lines)
                state = unloaded(cells) if state is None else state
                results = work.results(cells, *state)
                for name in _BRANCHES:
                    columns[name][:, direction, i] = results[name]
                ended = np.flatnonzero(vibrated & settled(results["regime"]))
                if ended.size:
                    between, last = (values[before], values[i]), (state[0][ended], state[1][ended])
                    columns[_VIBRATION_END][ended, direction, before] = self._end(lines[ended], between, last, work)
                state = _passed_on(cells, results, state)
                vibrated, before = np.isin(results["regime"], (_STICK_SLIP, _SUSTAINED)), i
        return columns

    def _end(self, lines: Lines, between: tuple[float, float], state: State, work: Motions) -> Floats:
        """The value at which vibration ends on lines that vibrate at the first of two, not at the other; NaN where a
        motion between them stays undecided. state : from the first value.
        """
        last, first = (np.full(lines.size, value) for value in between)  # that vibrates; that does not
        known = np.ones(lines.size, np.bool_)
        for k in range(_HALVINGS):
            middle = 0.5 * (last + first)
            cells = self._at(middle, lines)
            results = work.results(cells, *state)
            vibrates = np.isin(results["regime"], (_STICK_SLIP, _SUSTAINED))
            known &= vibrates | settled(results["regime"]) | (k >= _DECIDED)
            last, first = np.where(vibrates, middle, last), np.where(vibrates, first, middle)
            x, v = _passed_on(cells, results, state)
            state = np.where(vibrates, x, state[0]), np.where(vibrates, v, state[1])
        return np.where(known, 0.5 * (last + first), np.nan)

    def _between(self, lines: Lines, work: Motions) -> Results:
        """By names of `_BETWEEN`, arrays (lines, values): unstable cycle, stability of steady sliding.

        NaN where there is no unstable cycle, or it is not known exactly (`exact.py` says of which cells it is).
        """
        values = self._values
        cells = self._at(np.tile(values, lines.size), np.repeat(lines, values.size))
        parts = []
        for first in range(0, lines.size * values.size, _TOGETHER):
            part = taken(cells, slice(first, first + _TOGETHER))
            start = work.results(part, *unloaded(part))
            _, known = exact_results(part, start["regime"], _ANY, work)
            parts.append(known | {"damping_ratio": start["damping_ratio"]})
        return {name: np.concatenate([part[name] for part in parts]) for name in _BETWEEN}


def _changes(line: xr.Dataset, along: str) -> Iterator[tuple[str, ...]]:
    """The changes of regime on both ways, with the values between which they are; or the regime all the way."""
    unit = unit_of(line[along])
    for direction, step in (("up", 1), ("down", -1)):
        codes = line["regime"].sel(direction=direction).values[::step]
        names, values = [REGIMES[code] for code in codes], [unit.text(value) for value in line[along].values[::step]]
        changes = np.flatnonzero(np.diff(codes))
        for i in changes:
            yield direction, Regime(names[i]), Regime(names[i + 1]), values[i], values[i + 1]
        if not changes.size:
            yield direction, Regime(names[0]), "", "", ""


def _passed_on(cells: Parameters, results: Results, state: State) -> State:
    """A state on each attractor.

    Of stick-slip one of the stick phase: the belt then loads the contact up to the break-away of the next value, from
    where the slip is the same whatever was before. A contact with memory has none: where its spring pulls least.
    """
    regime = results["regime"]
    slides, sticks = np.isin(regime, SETTLED), np.isin(regime, (_STICK_SLIP, _STUCK))
    x, v = state
    least = np.where(cells["belt_speed"] < 0.0, results["cycle_force_max"], results["cycle_force_min"])
    restick = results["restick_displacement"]
    x = np.where(regime == _STICK_SLIP, np.where(np.isnan(restick), least / cells["stiffness"], restick), x)
    x = np.where(slides | (regime == _STUCK), results["settled_displacement"], x)
    x = np.where(regime == _SUSTAINED, results["cycle_force_max"] / cells["stiffness"], x)
    v = np.where(sticks, np.nan, np.where(slides, DISTURBANCE * cells["belt_speed"], v))
    return x, np.where(regime == _SUSTAINED, 0.0, v)
