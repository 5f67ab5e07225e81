"""Goals: what is asked of the plane of two parameters, and whether a place of it is quiet over whole ranges."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Annotated, Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field

from stickslip.config.grid import build_grid
from stickslip.config.model import Config, Group, Range, Values
from stickslip.config.sections import RANGE, Read, choice, interval, of_row, refused
from stickslip.dataset.build import given_cells
from stickslip.engine import Options
from stickslip.errors import ArgumentError
from stickslip.studies.changes import MarginSearch
from stickslip.studies.contours import Contours
from stickslip.studies.draws import computed_where
from stickslip.studies.lines import PARAMETER, CellsOrConfig, Side
from stickslip.studies.plane import OPEN
from stickslip.studies.search import Floats, Integers, Labels, Looked, Scan
from stickslip.vocabulary.cells import Cells, Parameters, impossible, taken
from stickslip.vocabulary.models import laws_with, model_of
from stickslip.vocabulary.parameter import Parameter, table
from stickslip.vocabulary.quantities import PARAMETERS, REGIMES, SEARCHABLE, UNDECIDED, VERDICTS, VIBRATING, listed
from stickslip.vocabulary.units import ends_of

PROBABILITY = 0.95  # where quantities scatter and no other one is wanted
_RANGES = "a range for each of some parameters: {belt_speed: 5..60 mm/s}"
_WITHIN = 2.0  # factor up and down of what panels have, where no range is given
_TEXT = {"type": "string", "pattern": r"\.\."}


def _quiet_over(value: object) -> object:
    """Ranges by parameter, of two ends or "5..60 mm/s"; of the belt speed above 0."""
    if not isinstance(value, Mapping) or not value:
        raise refused(_RANGES)
    ranges = {}
    for name, ends in value.items():
        row = SEARCHABLE[choice(name, SEARCHABLE, "a parameter of a cell", inside=True)]
        if isinstance(ends, str):
            try:
                ends = ends_of(name, ends)
            except ValueError:
                raise refused(_RANGES) from None
        ranges[name] = interval(replace(row, above=0) if name == "belt_speed" else row, ends)
    return ranges


class Goal(Contours):
    """The region of a plane in which cells are quiet over whole ranges; the other axes, materials say, are panels."""

    key, options = "goal", {"axes": "--over", "probability": "--with"}
    rows = Contours.rows | table(
        *(replace(Contours.rows[name], section="goal", default=value,
                  long_name=Contours.rows[name].long_name.partition("; unless")[0])
          for name, value in {"points": 257, "scan": 65, "tolerance": 1e-5}.items()),
        Parameter("samples", "1", "values of each range that are looked at first, by equal ratios", key,
                  default=9, at_least=2, at_most=1000, whole=True),
        Parameter("probability", "1", "probability of being quiet throughout, of what scatters (uncertain); "
                  f"{PROBABILITY:g} unless given", key, above=0, at_most=1, absent=f"{PROBABILITY:g}"),
    )  # fmt: skip
    quiet_over: Annotated[
        dict[str, tuple[float, float]],
        Read(_quiet_over, {"type": "object", "minProperties": 1, "propertyNames": PARAMETER.schema,
                           "additionalProperties": {"anyOf": [RANGE, _TEXT]}}),
    ] = Field(description="by parameter, the range throughout which cells are to be quiet")  # fmt: skip
    probability: float | None = of_row(rows["probability"])
    samples: int = of_row(rows["samples"])
    points: int = of_row(rows["points"])
    tolerance: float = of_row(rows["tolerance"])
    scan: int = of_row(rows["scan"])


@dataclass(frozen=True, eq=False)
class GoalPlane:
    """The plane of a goal, its panels and its ranges.

    panels : the cells in which the plane is opened. as_they_are : their parameters, what scatters at its median;
    coefficients follow from what is measured where `measured`. here : by parameter of the plane (y, x), what panels
    have; NaN for a curve without a minimum, or where it is an axis (`is_plane`). ranges : to be quiet over.
    """

    panels: Cells
    as_they_are: Parameters
    measured: bool
    here: Parameters
    is_plane: bool
    y: Side
    x: Side
    ranges: tuple[Side, ...]


def goal_plane(given: CellsOrConfig, section: Goal, options: Options) -> GoalPlane:
    """The plane of a configuration, or of cells. Raises TypeError or ValueError for what cannot be goal."""
    config = given if isinstance(given, Config) else None
    names, written = _names(config, section), {} if config is None else config.written_in
    if config is not None:
        panels, axes, changed, known = _of_config(config, section, names)
    else:
        panels, axes, known = _of_cells(given, section, names, options), {}, set[str]()
        changed = {*names, *section.quiet_over}
    for name in (*names, *section.quiet_over):
        if options.law not in (laws := laws_with(name)):
            raise ArgumentError("axes", f"{name} is for the law {listed(laws)}, not {options.law}")
    model, cells = model_of(options.law), panels[:]
    measured = bool((changed | known) & {*model.measured})
    if measured and (replaced := changed & {*model.replaced}):
        follows = f"{min(replaced)} follows from {listed(model.measured, 'and')}"
        raise ArgumentError("axes", f"{follows} here, expected one of these to change or to scatter, or none")
    cells = model.with_measured(cells) if measured else cells
    here = {name: np.full(panels.size, np.nan) if name in axes or name not in cells else cells[name] for name in names}
    y, x = (_side(name, section, axes.get(name), here[name], written.get(name)) for name in names)
    ranges = tuple(Side(*ends, section.samples, "log" if ends[0] > 0 else "linear", name)
                   for name, ends in section.quiet_over.items())  # fmt: skip
    return GoalPlane(panels, cells, measured, here, any(name in axes for name in names), y, x, ranges)


def _names(config: Config | None, section: Goal) -> tuple[str, str]:
    """The parameters of the plane, y and x. Raises ArgumentError."""
    names = section.axes
    if names is None:
        single = [axis.name for axis in (config.axes if config else ()) if not isinstance(axis, Group)]
        free = [name for name in single if name not in section.quiet_over][-2:]
        if len(free) < 2:
            raise ArgumentError("axes", "missing, expected the two parameters of the plane, y and x")
        names = free[0], free[1]
    if both := [name for name in names if name in section.quiet_over]:
        raise ArgumentError("quiet_over", f"got {both[0]}, which is a parameter of the plane, expected others")
    if other := [name for name in section.between or () if name not in names]:
        raise ArgumentError("between", f"got a range for {other[0]!r}, expected {names[0]} or {names[1]}")
    return names


def _of_config(
    config: Config, section: Goal, names: tuple[str, str]
) -> tuple[Cells, dict[str, Range | Values], set[str], set[str]]:  # fmt: skip
    """The panels, the axes of the configuration that the plane takes, what changes or scatters, and what is given."""
    if not config.has_cells:
        raise ArgumentError("axes", "the configuration has a drive: cells of a rig have no regime to be quiet in")
    uncertain = config.uncertain
    if uncertain is None and section.probability not in (None, 1.0):
        raise ArgumentError("probability", "got one, and nothing scatters, expected a section uncertain")
    if uncertain is not None and uncertain.subset is not None:
        raise ArgumentError("probability", "goals take Sobol points, expected no subset in uncertain")
    varied = {*names, *section.quiet_over}
    scattered = {} if uncertain is None else uncertain.values(np.zeros((1, len(uncertain.names))))
    if both := varied & scattered.keys():
        name = min(both)
        key, place = ("axes", "along the plane") if name in names else ("quiet_over", "over this range")
        message = f"{name} is uncertain, expected one that is known: {place} it takes each value in turn"
        raise ArgumentError(key, message)
    given = {*config.fixed(), *(member.name for axis in config.axes for member in axis.members)}
    own = {axis.name: axis for axis in config.axes if not isinstance(axis, Group) and axis.name in varied}
    known = {name: float(values[0]) for name, values in scattered.items()}
    known |= {name: float(axis.points()[0]) for name, axis in own.items()}
    return build_grid(config.at(**known)), own, varied | scattered.keys(), given


def _of_cells(given: Any, section: Goal, names: tuple[str, str], options: Options) -> Cells:
    """Cells as `evaluate` takes them; what is open in them need not be given."""
    between = section.between or {}
    ends = {**section.quiet_over, **{name: between[name] for name in names if name in between}}
    missing = {name: ends[name][1] for name in ends if name in PARAMETERS and name not in given}
    whole = given.assign(missing) if isinstance(given, xr.Dataset) else {**given, **missing}
    return given_cells(whole, options)


def _side(name: str, section: Goal, axis: Range | Values | None, here: Floats, written: str | None) -> Side:
    """A parameter of the plane: over the range of the section, of its axis, or about what panels have."""
    between, spacing, known = (section.between or {}).get(name), None, here[np.isfinite(here)]
    if between is None and axis is not None:
        between = float(np.nanmin(axis.points())), float(np.nanmax(axis.points()))
        spacing = axis.spacing if isinstance(axis, Range) else None
    elif between is None and known.size and known.min() > 0:
        between = float(known.min()) / _WITHIN, float(known.max()) * _WITHIN
    if between is None or not between[0] < between[1]:
        raise ArgumentError("between", f"missing, expected a range of {name}, (low, high)")
    return Side(*between, section.points, spacing or Scan.over(*between, 2).spacing, name, written)


# --- verdicts ---------------------------------------------------------------------------------------------------------


VIBRATES, QUIET, IMPOSSIBLE = (VERDICTS.index(name) for name in ("vibrates", "quiet", "impossible"))
ROUNDS = 3  # of halving the distance to the values looked at next
_TOGETHER = 65_536  # cells with a draw each that are looked at together
_VIBRATING = [REGIMES.index(name) for name in VIBRATING]


class Judged(NamedTuple):
    """Of places (n,): verdicts, `plane.OPEN` if undecided; shares of the draws that are quiet and undecided, and the
    standard error of the first; a guide to borders, as `search.Looked` has it."""

    verdict: Labels
    quiet: Floats
    undecided: Floats
    error: Floats
    guide: Floats


@dataclass(frozen=True, eq=False)
class Demand(MarginSearch):
    """A search whose labels are verdicts.

    measured, ranges : of the plane. drawn : what scatters, (draws,), `scramblings` independent parts one after the
    other. probability : of being quiet.
    """

    measured: bool = False
    ranges: tuple[Side, ...] = ()
    drawn: Parameters = field(default_factory=dict)
    scramblings: int = 1
    probability: float = 1.0

    @property
    def draws(self) -> int:
        """Return how many cells stand for a place at a value of each range."""
        return next((values.size for values in self.drawn.values()), 1)

    def judged(self, panel: Integers, changed: Parameters, shares: bool = False) -> Judged:
        """Verdicts on cells of panels with some other values. Unless `shares` are needed, no place is looked at further
        once it is known to vibrate. Raises StoppedError."""
        step, parts = max(_TOGETHER // self.draws, 1), []
        for start in range(0, max(panel.size, 1), step):
            part = slice(start, start + step)
            parts.append(self._together(panel[part], taken(changed, part), shares))
        return Judged(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def looked(self, which: Integers, changed: Parameters, into: list[int] | None) -> Looked:
        """Whether verdicts are among `into`; what is undecided is not quiet, and known to be."""
        judged = self.judged(which, changed)
        return Looked(np.isin(judged.verdict, into or []).astype(np.int8), judged.verdict != IMPOSSIBLE, judged.guide)

    def guide_at(self, cells_at: object) -> None:
        """None: theory knows no verdicts."""
        return

    def _computed(self, which: Integers, changed: Parameters) -> tuple[Labels, Floats]:
        judged = self.judged(which, changed)
        return judged.verdict, judged.guide

    @property
    def allowed(self) -> int:
        """Return how many draws need not be quiet."""
        return int((1.0 - self.probability) * self.draws * (1 + 1e-12))

    def _together(self, panel: Integers, changed: Parameters, shares: bool) -> Judged:
        lanes = {name: np.repeat(v, self.draws) for name, v in (taken(self.cells, panel) | changed).items()}
        lanes |= {name: np.tile(values, panel.size) for name, values in self.drawn.items()}
        seen = _Lanes(self, lanes, panel.size * self.draws, self.draws if shares else self.allowed)
        for place in _places(len(self.ranges), self.ranges[0].points):
            which = np.flatnonzero(seen.open)
            seen.look(which, np.broadcast_to(place, (which.size, len(place))))
        seen.close_in(1.0 / (self.ranges[0].points - 1))
        shape = panel.size, self.scramblings, self.draws // self.scramblings
        vibrates, undecided = (flags.reshape(shape) for flags in (seen.vibrates, seen.undecided & ~seen.vibrates))
        quiet = 1.0 - (vibrates | undecided).mean(axis=2)
        error = np.zeros(panel.size)
        if shape[1] > 1:
            error = np.fmax(quiet.std(axis=1, ddof=1) / np.sqrt(shape[1]), 1.0 / self.draws)
        allowed = self.allowed
        bad, open_ones = (flags.sum(axis=(1, 2)) for flags in (vibrates, undecided))
        verdict = np.where(bad > allowed, VIBRATES, np.where(bad + open_ones > allowed, OPEN, QUIET))
        verdict[~seen.possible.reshape(shape).any(axis=(1, 2))] = IMPOSSIBLE
        closest = np.where(seen.undecided, -np.inf, seen.closest).reshape(panel.size, self.draws)
        guide = np.partition(closest, allowed, axis=1)[:, allowed] if allowed < self.draws else np.inf * bad
        return Judged(verdict.astype(np.int8), quiet.mean(axis=1), undecided.mean(axis=(1, 2)), error,
                      np.where(np.isfinite(guide), guide, np.nan))  # fmt: skip


class _Lanes:
    """Cells with a draw each, all of them over the ranges, and what was seen of each so far.

    closest : least slip speed over the belt speed, below 0 where it sticks again; at : where that was, as shares of
    the ranges (lanes, ranges). possible : whether there is such a cell. most : draws of a place that may vibrate.
    """

    def __init__(self, demand: Demand, cells: Parameters, size: int, most: int) -> None:
        self._demand, self._cells, self._most = demand, cells, most
        self.vibrates, self.undecided, self.possible = (np.zeros(size, np.bool_) for _ in range(3))
        self.closest, self.at = np.full(size, np.inf), np.zeros((size, len(demand.ranges)))

    @property
    def open(self) -> NDArray[np.bool_]:
        """Return which lanes may still matter: not of places where more than `most` draws vibrate."""
        vibrating = self.vibrates.reshape(self.vibrates.size // self._demand.draws, self._demand.draws)
        return np.asarray(~(vibrating | (vibrating.sum(axis=1, keepdims=True) > self._most)).ravel())

    def look(self, which: Integers, shares: Floats) -> None:
        """Compute some lanes at shares (which, ranges) of the ranges."""
        if not which.size:
            return
        demand, law = self._demand, self._demand.options.law
        model, cells = model_of(law), taken(self._cells, which)
        cells |= {side.name: _value(side, shares[:, i]) for i, side in enumerate(demand.ranges)}
        cells = model.without_measured(cells) if demand.measured else cells
        possible = ~impossible(cells, model.rules.get(law, ()))
        computed = computed_where(cells, possible, demand.options, demand.stop, demand.moved)
        regime, margin = computed["regime"], computed.get("restick_margin")
        margin = np.full(regime.shape, np.nan) if margin is None else margin
        self.possible[which] |= possible
        self.vibrates[which] |= np.isin(regime, _VIBRATING)
        self.undecided[which] |= np.isin(regime, UNDECIDED)
        with np.errstate(divide="ignore", invalid="ignore"):
            near = margin / np.abs(cells["belt_speed"])
        closer = near < self.closest[which]
        self.closest[which[closer]], self.at[which[closer]] = near[closer], shares[closer]

    def close_in(self, distance: float) -> None:
        """Look about the places that are closest to sticking, at halves of a distance, and of these, and so on."""
        for _ in range(ROUNDS):
            distance /= 2
            for column, sign in product(range(self.at.shape[1]), (-1.0, 1.0)):
                shares = self.at.copy()
                shares[:, column] += sign * distance
                inside = (shares[:, column] >= 0) & (shares[:, column] <= 1)
                which = np.flatnonzero(inside & self.open & np.isfinite(self.closest))
                self.look(which, shares[which])


def _places(ranges: int, points: int) -> Iterator[NDArray[np.float64]]:
    """Shares of the ranges that are looked at first, their ends before what is between: most vibrate there."""
    shares = np.linspace(0.0, 1.0, points)
    places = product(range(points), repeat=ranges)
    for place in sorted(places, key=lambda place: sum(0 < i < points - 1 for i in place)):
        yield shares[list(place)]


def _value(side: Side, share: Floats) -> Floats:
    """Values at shares of a range, by ratio where it is above 0; the ends are exact."""
    if side.spacing == "log":
        between = side.low * (side.high / side.low) ** share
    else:
        between = side.low + (side.high - side.low) * share
    return np.asarray(np.select([share == 0.0, share == 1.0], [side.low, side.high], between))
