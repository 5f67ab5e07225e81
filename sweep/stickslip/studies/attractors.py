"""The attractors of cells: regimes they reach, share that settles, unstable cycle, critical disturbances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from stickslip.config.grid import build_grid
from stickslip.config.model import Config, Group
from stickslip.config.problems import ProblemCollector
from stickslip.config.studies import Moved, ReportTable, Study
from stickslip.dataset.build import NO_FILL, given_cells, grid_coordinates, study_dataset
from stickslip.dataset.display import unit_of
from stickslip.engine import Options, Results, StopFlag
from stickslip.errors import ArgumentError, Path
from stickslip.studies import starts
from stickslip.studies.exact import exact_results, slips_on_curve
from stickslip.studies.lines import CellsOrConfig, decided
from stickslip.studies.study import MOST_ROWS, axis_names, joined, parts_over
from stickslip.vocabulary.cells import Cells, Parameters, taken
from stickslip.vocabulary.results import FLAGS, REGIME_MESSAGES, REGIMES, SHARE_METHODS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TOGETHER = 256  # cells that are held with their samples
_STATE = ("displacement", "velocity")  # of a start, which the box replaces
_STATES_IN_BOX = "expected no axis: the starting states are those of the box (attractors)"
_PROBED = 64  # cells that tell what the others may take
_EXACT_COST, _SEARCH_COST = 40, 300  # cells that the cycle takes, and the search for critical disturbances


class AttractorStudy(Study):
    """The attractors of cells."""

    section, variables = starts.Attractors, starts.VARIABLES
    title, subject, caption = "Attractors", "settling_share", "share that settles"
    about = "How large a share of a box of starting states settles, and how large a shock ends sliding."
    examples = (
        "configs/attractors.yaml",
        'configs/quickstart.yaml --displacement 0 "2 m" --velocity -1 1 -o basins.nc',
    )
    name, counted, weight = "attractor set", "cells", 4096 // _TOGETHER
    columns: Mapping[str, np.dtype[Any]] = {
        name: np.dtype(np.int8 if name in FLAGS or name == "coexisting" else np.float64) for name in starts.VARIABLES
    }

    def __init__(self, cells: Cells, box: starts.Attractors, options: Options) -> None:
        self._cells, self._box = cells, box
        self.dims, self.shape = cells.dims, cells.shape
        self.options = replace(options, early_stop=True)
        known = slips_on_curve(cells[: min(cells.size, _PROBED)], options)
        share = float(known.mean()) if known.size else 1.0
        self.cells_each = _EXACT_COST + int((1.0 - share) * (box.samples + _SEARCH_COST))

    @classmethod
    def of(cls, given: CellsOrConfig, section: starts.Attractors, options: Options) -> AttractorStudy:
        """The attractors from the box of the section; what is said of the state at the start is left out."""
        if not isinstance(given, Config):
            return cls(given_cells(given, options), section, options)
        if not given.has_cells:
            raise ArgumentError("config", "the configuration has a drive: cells of a rig have no attractors")
        for path in _state_axes(given):
            raise ArgumentError(str(path[-1]), _STATES_IN_BOX)
        return cls(build_grid(given), section, options)

    @classmethod
    def check(cls, section: starts.Attractors, config: Config, problems: ProblemCollector) -> None:
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
        work = starts.Motions(self.options, stop, moved)
        parts = [{name: np.zeros(0) for name in self.columns}]
        for first in range(items.start, items.stop, _TOGETHER):
            parts.append(_attractors(self._cells[first : min(first + _TOGETHER, items.stop)], self._box, work))
        whole = joined(parts)
        return {name: whole[name].astype(kind) for name, kind in self.columns.items()}

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The attractors with the dimensions of the cells."""
        whole = joined(parts)
        coordinates = {name: c for name, c in grid_coordinates(self._cells).items() if name not in _STATE}
        attributes = dict(attributes) | {
            "box_displacement": np.array(self._box.displacement), "box_velocity": np.array(self._box.velocity),
            "attractors_seed": self._box.seed, "attractors_rtol": self.options.rtol,
        }  # fmt: skip
        values = {name: whole[name] for name in starts.VARIABLES}
        ds = study_dataset("attractors", starts.VARIABLES, values, self.dims, self.shape, coordinates, attributes)
        coexisting = ds["coexisting"].variable
        names = REGIMES[1:]  # a bit each; the code of a regime counts them from 1
        masks = coexisting.attrs | {
            "flag_masks": (2 ** np.arange(len(names))).astype(np.int8),
            "flag_meanings": " ".join(names),
            "comment": "; ".join(f"{name}: {REGIME_MESSAGES[name]}" for name in names),
        }
        ds["coexisting"] = xr.Variable(coexisting.dims, coexisting.values.astype(np.int8), masks, NO_FILL)
        return ds


def _attractors(cells: Parameters, box: starts.Attractors, work: starts.Motions) -> Results:
    """By names of `VARIABLES`, of cells that are held together: exactly where their phase plane is known, else sampled.

    Numbers do not depend on how cells are cut into parts. Raises StoppedError.
    """
    steady, codes = starts.steady_state(cells, work.options), np.arange(len(REGIMES))
    start = work.results(cells, *starts.unloaded(cells))
    stick, sliding = start["regime"], work.from_sliding(cells, steady)
    reached = (codes == stick[:, np.newaxis]) | (codes == sliding[:, np.newaxis])
    exact, results = exact_results(cells, stick, box, work)
    share = results["settling_share"]
    results |= {
        "damping_ratio": start["damping_ratio"], "regime_from_stick": stick, "regime_from_sliding": sliding,
        "settling_share_low": share.copy(), "settling_share_high": share.copy(),
        "share_error": np.where(exact, 0.0, np.nan),
        "share_method": np.where(exact, SHARE_METHODS.index("exact"), SHARE_METHODS.index("sampled")),
    }  # fmt: skip
    rest = np.flatnonzero(~exact)
    if rest.size:
        others, slides = taken(cells, rest), starts.settled(sliding[rest])
        shares, met = starts.sampled_shares(others, box, work)
        reached[rest] |= met
        for name, values in shares.items():
            results[name][rest] = values
        for name, values in starts.critical_disturbances(taken(others, slides), steady[rest[slides]], work).items():
            results[name][rest] = np.where(decided(sliding[rest]), 0.0, np.nan)
            results[name][rest[slides]] = values
    # Where some states settle for certain they do, though no motion was started there.
    unseen = exact & (results["settling_share"] > 0) & ~reached[:, starts.SETTLED].any(axis=1)
    damped, creep = starts.SETTLED
    reached[unseen & (results["damping_ratio"] < 1), damped] = True
    reached[unseen & (results["damping_ratio"] >= 1), creep] = True
    for kind in ("shock", "shift"):
        ways = results[f"critical_{kind}_along"], results[f"critical_{kind}_against"]
        results[f"critical_{kind}"] = np.minimum(*ways)
    results["coexisting"] = reached[:, 1:] @ 2.0 ** np.arange(len(REGIMES) - 1)  # a cell not computed reaches nothing
    return results


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
