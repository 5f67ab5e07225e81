"""The attractors of cells: regimes they reach, share that settles, unstable cycle, critical disturbances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import scipy  # type: ignore[import-untyped]
import xarray as xr
from pydantic import Field, field_validator

from stickslip.config.grid import build_grid
from stickslip.config.model import Config, Group
from stickslip.config.problems import ProblemCollector
from stickslip.config.sections import RANGE, Read, StudySection, interval, of_row, refused
from stickslip.config.studies import MOST_ROWS, Moved, ReportTable, Study
from stickslip.dataset.build import NO_FILL, given_cells, grid_coordinates, study_dataset
from stickslip.dataset.display import axis_names, parts_over, unit_of
from stickslip.engine import Options, Results, Scales, StopFlag, joined
from stickslip.errors import ArgumentError, Path
from stickslip.studies.exact import (
    DISTURBANCE,
    SETTLED,
    Box,
    Motions,
    exact_results,
    settled,
    slips_on_curve,
    steady_state,
    unloaded,
)
from stickslip.studies.lines import CellsOrConfig, decided
from stickslip.studies.search import Flags, Floats, Integers, Looked, Scan, search_lines
from stickslip.vocabulary.cells import Cells, Parameters, taken
from stickslip.vocabulary.models import model_with
from stickslip.vocabulary.parameter import Parameter, Variable, table
from stickslip.vocabulary.quantities import FLAGS, PARAMETERS, REGIME_MESSAGES, REGIMES, SHARE_METHODS
from stickslip.vocabulary.quantities import VARIABLES as CELL_VARIABLES

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def _ends(name: str) -> Read:
    return Read(lambda value: interval(PARAMETERS[name], value), RANGE)


_STATE = {name: _ends(name) for name in ("displacement", "velocity")}  # of a start, which the box replaces
RANDOMISATIONS = 16  # of Sobol points: so many that their scatter is known to a fifth
Interval = tuple[float, float]
_CHANGES = "inf: no change does that; 0: any does"
VARIABLES = table(
    Variable("coexisting", "1", "regimes reached from different starting states"),
    Variable("regime_from_stick", "1", "regime reached from sticking, with no load on the contact"),
    Variable("regime_from_sliding", "1", "regime reached from close to steady sliding"),
    Variable("settling_share", "1", "share of the starting states in the box that settle to steady sliding"),
    Variable("share_error", "1", "standard error of the share that settles; 0 where it is exact"),
    Variable("settling_share_low", "1", "share that settles if no undecided starting state does"),
    Variable("settling_share_high", "1", "share that settles if all undecided starting states do"),
    Variable("share_method", "1", "how the share that settles was found"),
    Variable("unstable_amplitude", "m", "half the range of displacement on the unstable cycle"),
    Variable("unstable_velocity_amplitude", "m s-1", "half the range of velocity on the unstable cycle"),
    Variable("unstable_period", "s", "period of the unstable cycle"),
    Variable("critical_shock", "m s-1", "smallest change of velocity after which steady sliding does not come back",
             comment=_CHANGES),
    Variable("critical_shock_along", "m s-1", "critical change of velocity, along the motion of the belt"),
    Variable("critical_shock_against", "m s-1", "critical change of velocity, against the motion of the belt"),
    Variable("critical_shift", "m", "smallest change of displacement after which steady sliding does not come back",
             comment=_CHANGES),
    Variable("critical_shift_along", "m", "critical change of displacement, along the motion of the belt"),
    Variable("critical_shift_against", "m", "critical change of displacement, against the motion of the belt"),
    CELL_VARIABLES["damping_ratio"],
)  # fmt: skip


class Attractors(StudySection):
    """Which attractors cells have: regimes by starting state, and the share of a box of states that settles."""

    key = "attractors"
    rows = table(
        Parameter("samples", "1", "starting states drawn per cell where the share that settles is not exact", key,
                  default=1024, at_least=RANDOMISATIONS, at_most=2**20, whole=True),
        Parameter("seed", "1", "seed of the starting states: the same seed, the same states", key,
                  default=1, at_least=0, at_most=2**32 - 1, whole=True),
    )  # fmt: skip
    displacement: Annotated[Interval, _STATE["displacement"]] = Field(
        description="displacements of the box of starting states, [low, high]"
    )
    velocity: Annotated[Interval, _STATE["velocity"]] = Field(
        description="velocities of the box of starting states, [low, high]"
    )
    samples: int = of_row(rows["samples"])
    seed: int = of_row(rows["seed"])

    @field_validator("samples")
    @classmethod
    def _samples(cls, value: int) -> int:
        points, rest = divmod(value, RANDOMISATIONS)
        if rest or points & (points - 1):
            raise refused(f"{RANDOMISATIONS} times a power of 2")
        return value

    @property
    def points(self) -> int:
        """Points of each randomisation."""
        return self.samples // RANDOMISATIONS

    @property
    def box(self) -> Box:
        """The starting states."""
        return Box(self.displacement, self.velocity)


# --- the study --------------------------------------------------------------------------------------------------------

_CELLS_TOGETHER = 256  # that are held with their samples
_STATES_IN_BOX = "expected no axis: the starting states are those of the box (attractors)"
_PROBED = 64  # cells that tell what the others may take
_EXACT_COST, _SEARCH_COST = 40, 300  # cells that the cycle takes, and the search for critical disturbances


class AttractorStudy(Study):
    """The attractors of cells."""

    section, variables = Attractors, VARIABLES
    title, subject, caption = "Attractors", "settling_share", "share that settles"
    about = "How large a share of a box of starting states settles, and how large a shock ends sliding."
    examples = (
        "configs/attractors.yaml",
        'configs/quickstart.yaml --displacement 0 "2 m" --velocity -1 1 -o basins.nc',
    )
    name, counted, weight = "attractor set", "cells", 4096 // _CELLS_TOGETHER
    columns: Mapping[str, np.dtype[Any]] = {
        name: np.dtype(np.int8 if name in FLAGS or name == "coexisting" else np.float64) for name in VARIABLES
    }

    def __init__(self, cells: Cells, section: Attractors, options: Options) -> None:
        self._cells, self._section = cells, section
        self.dims, self.shape = cells.dims, cells.shape
        self.options = replace(options, early_stop=True)
        known = slips_on_curve(cells[: min(cells.size, _PROBED)], options)
        share = float(known.mean()) if known.size else 1.0
        self.cells_each = _EXACT_COST + int((1.0 - share) * (section.samples + _SEARCH_COST))

    @classmethod
    def of(cls, given: CellsOrConfig, section: Attractors, options: Options) -> AttractorStudy:
        """The attractors from the box of the section; what is said of the state at the start is left out."""
        if not isinstance(given, Config):
            return cls(given_cells(given, options), section, options)
        if not given.has_cells:
            raise ArgumentError("config", "the configuration has a drive: cells of a rig have no attractors")
        for path in _state_axes(given):
            raise ArgumentError(str(path[-1]), _STATES_IN_BOX)
        return cls(build_grid(given), section, options)

    @classmethod
    def check(cls, section: Attractors, config: Config, problems: ProblemCollector) -> None:
        """Note axes of starting states, which are those of the box."""
        for path in _state_axes(config):
            problems.add(path, _STATES_IN_BOX, at_key=True)

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | ReportTable]:
        """Which regimes coexist, how much of the box settles, and what a shock may be."""
        share, exact = ds["settling_share"], ds["share_method"] == SHARE_METHODS.index("exact")
        if share.size <= MOST_ROWS:
            words = [*axis_names(ds, share.dims), "regimes", "critical shock"]
            rows = [[*where, *_row(cell)] for where, cell in parts_over(ds, share.dims)]
            yield ReportTable("", words, ["share that settles", "standard error"], rows)
        else:
            masks, counts = np.unique(ds["coexisting"].values, return_counts=True)
            rows = [[_regimes_in(int(mask)), f"{count:,}"] for mask, count in zip(masks, counts, strict=True)]
            yield ReportTable("", ["regimes"], ["cells"], rows)
            yield f"settling {float(share.mean()):.1%} of the starting states on average"
        yield f"shares   {int(exact.sum()):,} of {exact.size:,} exact, the others sampled"

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Figure | None:
        """Over one parameter lines of the share; over more a map of it."""
        from stickslip.plots import check_plain
        from stickslip.plots.attractors import plot_attractors

        if variable not in (None, cls.subject) or len(set(ds[cls.subject].dims) - set(select)) != 1:
            return None
        check_plain(look, "no map: lines over one parameter")
        return plot_attractors(ds, select=select, title=title)

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The attractors of a range of cells."""
        work = Motions(self.options, stop, moved)
        parts = [{name: np.zeros(0) for name in self.columns}]
        for first in range(items.start, items.stop, _CELLS_TOGETHER):
            parts.append(
                _attractors(self._cells[first : min(first + _CELLS_TOGETHER, items.stop)], self._section, work)
            )
        whole = joined(parts)
        return {name: whole[name].astype(kind) for name, kind in self.columns.items()}

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The attractors with the dimensions of the cells."""
        whole = joined(parts)
        coordinates = {name: c for name, c in grid_coordinates(self._cells).items() if name not in _STATE}
        attributes = dict(attributes) | {
            "box_displacement": np.array(self._section.displacement), "box_velocity": np.array(self._section.velocity),
            "attractors_seed": self._section.seed, "attractors_rtol": self.options.rtol,
        }  # fmt: skip
        values = {name: whole[name] for name in VARIABLES}
        ds = study_dataset("attractors", VARIABLES, values, self.dims, self.shape, coordinates, attributes)
        coexisting = ds["coexisting"].variable
        names = REGIMES[1:]  # a bit each; the code of a regime counts them from 1
        masks = coexisting.attrs | {
            "flag_masks": (2 ** np.arange(len(names))).astype(np.int8),
            "flag_meanings": " ".join(names),
            "comment": "; ".join(f"{name}: {REGIME_MESSAGES[name]}" for name in names),
        }
        ds["coexisting"] = xr.Variable(coexisting.dims, coexisting.values.astype(np.int8), masks, NO_FILL)
        return ds


def _attractors(cells: Parameters, section: Attractors, work: Motions) -> Results:
    """By names of `VARIABLES`, of cells that are held together: exactly where their phase plane is known, else sampled.

    Numbers do not depend on how cells are cut into parts. Raises StoppedError.
    """
    steady, codes = steady_state(cells, work.options), np.arange(len(REGIMES))
    start = work.results(cells, *unloaded(cells))
    stick, sliding, moving = start["regime"], np.zeros(steady.size, np.int8), np.isfinite(steady)
    near = taken(cells, moving)
    sliding[moving] = work.regimes(near, steady[moving], DISTURBANCE * near["belt_speed"])
    reached = (codes == stick[:, np.newaxis]) | (codes == sliding[:, np.newaxis])
    exact, results = exact_results(cells, stick, section.box, work)
    share = results["settling_share"]
    results |= {
        "damping_ratio": start["damping_ratio"], "regime_from_stick": stick, "regime_from_sliding": sliding,
        "settling_share_low": share.copy(), "settling_share_high": share.copy(),
        "share_error": np.where(exact, 0.0, np.nan),
        "share_method": np.where(exact, SHARE_METHODS.index("exact"), SHARE_METHODS.index("sampled")),
    }  # fmt: skip
    rest = np.flatnonzero(~exact)
    if rest.size:
        others, slides = taken(cells, rest), settled(sliding[rest])
        shares, met = sampled_shares(others, section, work)
        reached[rest] |= met
        for name, values in shares.items():
            results[name][rest] = values
        for name, values in critical_disturbances(taken(others, slides), steady[rest[slides]], work).items():
            results[name][rest] = np.where(decided(sliding[rest]), 0.0, np.nan)
            results[name][rest[slides]] = values
    # Where some states settle for certain they do, though no motion was started there.
    unseen = exact & (results["settling_share"] > 0) & ~reached[:, SETTLED].any(axis=1)
    damped, creep = SETTLED
    reached[unseen & (results["damping_ratio"] < 1), damped] = True
    reached[unseen & (results["damping_ratio"] >= 1), creep] = True
    for kind in ("shock", "shift"):
        ways = results[f"critical_{kind}_along"], results[f"critical_{kind}_against"]
        results[f"critical_{kind}"] = np.minimum(*ways)
    results["coexisting"] = reached[:, 1:] @ 2.0 ** np.arange(len(REGIMES) - 1)  # a cell not computed reaches nothing
    return results


# --- cells whose phase plane is not known -----------------------------------------------------------------------------

_SCAN = Scan(1e-4, 10.0, 48, "log")  # of a disturbance, over the scale of the cell
_TOLERANCE = 1e-6
_TOGETHER = 2**16  # motions that are held at once
_LOST, _SETTLES = 0, 1


def _states_in(section: Attractors) -> Floats:
    """Scrambled Sobol points in the box, one randomisation after the other (states, 2), the same for every cell."""
    seeds = np.random.SeedSequence(section.seed).spawn(RANDOMISATIONS)
    sobol = (scipy.stats.qmc.Sobol(2, scramble=True, rng=np.random.default_rng(seed)) for seed in seeds)
    whole = np.concatenate([points.random(section.points) for points in sobol])
    return np.asarray(scipy.stats.qmc.scale(whole, *zip(*section.box, strict=True)))


def sampled_shares(cells: Parameters, section: Attractors, work: Motions) -> tuple[Results, Flags]:
    """The shares of the box that settle, with error and bounds, by names of `VARIABLES`; and the regimes that were
    reached (cells, regimes).

    The randomisations are independent and each is unbiased, so that their scatter gives the standard error of their
    mean; that of independent points (the binomial one) would be too large several times, since Sobol points fill the
    box evenly. Where all agree the error is that of one state in all of them.
    """
    states, each = _states_in(section), section.samples
    total = cells["mass"].size * each
    parts = []
    for first in range(0, total, _TOGETHER):
        cell, state = divmod(np.arange(first, min(first + _TOGETHER, total)), each)
        parts.append(work.regimes(taken(cells, cell), states[state, 0], states[state, 1]))
    regimes = np.concatenate(parts).reshape(-1, RANDOMISATIONS, section.points)
    ends, known = settled(regimes), decided(regimes)
    with np.errstate(invalid="ignore"):
        share = ends.sum(axis=(1, 2)) / known.sum(axis=(1, 2))
        parts = ends.sum(axis=2) / known.sum(axis=2)
    error = np.maximum(parts.std(axis=1, ddof=1) / np.sqrt(RANDOMISATIONS), 1.0 / (each + 2))
    low, high = ends.mean(axis=(1, 2)), (ends | ~known).mean(axis=(1, 2))
    results = {"settling_share": share, "share_error": error, "settling_share_low": low, "settling_share_high": high}
    return results, np.stack([(regimes == code).any(axis=(1, 2)) for code in range(len(REGIMES))], axis=1)


def critical_disturbances(cells: Parameters, steady: Floats, work: Motions) -> Results:
    """The smallest disturbances of steady sliding after which it does not come back, of a scan narrowed by halving.

    By names of `VARIABLES`, along and against the motion of the belt; 0 where the smallest of the scan is enough, inf
    where the largest is not, NaN where undecided states come before. They are measured by the speed of the belt, and
    that to which friction deflects the spring.
    """
    by, turn, none = Scales(cells), np.sign(cells["belt_speed"]), np.zeros(steady.size)
    speed = np.abs(cells["belt_speed"]) + by.load * model_with(cells).start_of(cells) / by.impedance
    length = speed * by.time
    smallest = {}
    for way, sign in (("along", turn), ("against", -turn)):
        smallest[f"critical_shock_{way}"] = speed * _first_lost(cells, steady, none, sign * speed, work)
        smallest[f"critical_shift_{way}"] = length * _first_lost(cells, steady, sign * length, none, work)
    return smallest


def _first_lost(cells: Parameters, steady: Floats, shift: Floats, shock: Floats, work: Motions) -> Floats:
    """Return how many times a disturbance of displacement and velocity is enough, per cell."""

    def looked(line: Integers, place: Floats) -> Looked:
        regimes = work.regimes(taken(cells, line), steady[line] + place * shift[line], place * shock[line])
        return Looked(np.where(settled(regimes), _SETTLES, _LOST).astype(np.int8), decided(regimes))

    lines = steady.size
    brackets, _ = search_lines(lines, _SCAN, _TOLERANCE, looked)
    start = looked(np.arange(lines), np.full(lines, _SCAN.low))
    lost = np.where(start.labels == _SETTLES, np.inf, 0.0)
    lost[~start.decided] = np.nan
    for bracket in brackets[::-1]:  # the lowest of a line comes last
        line = bracket["line"]
        if bracket["below"] == _SETTLES and lost[line] != 0.0:
            wide = bracket["high"] - bracket["low"] > 1.5 * _TOLERANCE * bracket["high"]
            lost[line] = np.nan if wide else 0.5 * (bracket["low"] + bracket["high"])
    return lost


def _regimes_in(mask: int) -> str:
    """`stick_slip or damped`: the regimes of a mask."""
    return " or ".join(name for code, name in enumerate(REGIMES) if code and mask >> (code - 1) & 1) or "not computed"


def _row(cell: xr.Dataset) -> tuple[str, ...]:
    """What a table says of a cell."""
    share, error, shock = (float(cell[name]) for name in ("settling_share", "share_error", "critical_shock"))
    special = {0.0: "any", np.inf: "none is enough"}
    text = "unknown" if shock != shock else special.get(shock) or unit_of(cell["critical_shock"]).text(shock)
    return _regimes_in(int(cell["coexisting"])), text, f"{share:.6g}", f"{error:.2g}" if error else "exact"


def _state_axes(config: Config) -> Iterator[Path]:
    for axis in config.axes:
        for member in axis.members:
            if member.name in _STATE:
                yield ("axes", axis.name, "zip", member.name) if isinstance(axis, Group) else ("axes", axis.name)
