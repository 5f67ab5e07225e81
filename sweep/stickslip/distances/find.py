"""Margins of many cells: each parameter by itself, then all of them together, and every proposal simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.margins import margin_dataset
from stickslip.distances.joint import Cheapest, cheapest
from stickslip.distances.reach import FACTOR, Reach, reach_of, within_of
from stickslip.distances.regimes import Asked, Floats, Labels, codes, decided
from stickslip.distances.single import Borders, nearest
from stickslip.engine import Options
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.parameter import NAN

_TOGETHER = 512  # cells whose rays are held at once
_OF_JOINT = 1e-8  # tolerance of joint changes, whose cost is known no better


@dataclass(frozen=True)
class Question:
    """What is asked of every cell.

    parameters : that may change. costs : of a change of each by itself, relative to the others; 1 unless given.
    within : how far, a factor or ranges in SI. into : names of the regimes to be entered; None for any other.
    scan : places looked at first on either side. tolerance : of borders. beyond : how far past a border a proposal is
    simulated, over the value. joint : whether the cheapest joint change is looked for.
    """

    parameters: tuple[str, ...]
    costs: Mapping[str, float]
    within: float | Mapping[str, float | tuple[float, float]] = FACTOR
    into: tuple[str, ...] | None = None
    scan: int = 32
    tolerance: float = 1e-9
    beyond: float = 0.01
    joint: bool = True

    def __post_init__(self) -> None:
        within_of(self.within, self.parameters)
        codes(self.into or ())
        if not self.parameters or len(set(self.parameters)) != len(self.parameters):
            raise ValueError(f"parameters: got {self.parameters!r}, expected different names, at least one")
        for name, cost in self.costs.items():
            if name not in self.parameters:
                raise ValueError(f"costs: got one for {name!r}, expected {', '.join(self.parameters)}")
            if not 0 < cost < np.inf:
                raise ValueError(f"costs: got {cost!r} for {name}, expected a number above 0")
        if not 0 <= self.beyond < 1:
            raise ValueError(f"beyond: got {self.beyond!r}, expected a share from 0 to below 1")

    @property
    def of_each(self) -> Floats:
        """The cost of each parameter."""
        return np.array([self.costs.get(name, 1.0) for name in self.parameters])


def find_margins(
    cells: Cells,
    question: Question,
    options: Options,
    dims: Sequence[str],
    shape: Sequence[int],
    coordinates: Mapping[str, xr.Variable],
    attributes: Mapping[str, str],
) -> xr.Dataset:
    """The margins of cells, every parameter of length n, as a dataset over `dims`. Raises Interrupted on Ctrl-C."""
    size = cells["mass"].size
    parts = [_margins({name: values[i : i + _TOGETHER] for name, values in cells.items()}, question, options)
             for i in range(0, size, _TOGETHER)]  # fmt: skip
    table = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    told = dict(attributes) | _told(question, table, options)
    return margin_dataset(question.parameters, dims, shape, coordinates, table, told)


def _margins(cells: Cells, question: Question, options: Options) -> dict[str, NDArray[Any]]:
    """The columns of some cells, by names of the dataset."""
    asked = Asked(cells, options)
    size = cells["mass"].size
    home = asked.regimes(np.arange(size), {})
    into = None if question.into is None else codes(question.into)
    within = within_of(question.within, question.parameters)
    reaches = [reach_of(name, cells, within[name]) for name in question.parameters]
    table: dict[str, NDArray[Any]] = {"regime": home}
    for reach in reaches:
        found = nearest(asked, reach, home, into, question.scan, question.tolerance)
        table |= {f"{name}_{reach.name}": values for name, values in _single(asked, reach, found, question).items()}
    if question.joint:
        tolerance = max(question.tolerance, _OF_JOINT)
        best = cheapest(asked, reaches, question.of_each, home, into, question.scan, tolerance)
        table |= _joint(asked, reaches, best, question)
    return table


def _single(asked: Asked, reach: Reach, found: Borders, question: Question) -> dict[str, NDArray[Any]]:
    """What is said of one parameter: both borders, the nearer of them as distance and as factor, and the checks."""
    size = reach.value.size
    middle = found.low + (found.high - found.low) / 2
    nearer = np.argmin(np.where(np.isnan(found.change), np.inf, np.abs(found.change)), axis=1)
    border = middle[np.arange(size), nearer]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(reach.by_factor, border / reach.value, NAN)
    checked = [_checked(asked, [reach], found.change[:, [side]], question.beyond) for side in (0, 1)]
    return {
        "margin": border - reach.value, "ratio": ratio, "border": middle, "border_width": found.high - found.low,
        "beyond": found.beyond, "checked": np.stack([regimes for regimes, _ in checked], axis=1),
        "proposed": np.stack([values[:, 0] for _, values in checked], axis=1),
    }  # fmt: skip


def _joint(asked: Asked, reaches: Sequence[Reach], best: Cheapest, question: Question) -> dict[str, NDArray[Any]]:
    """What is said of the cheapest joint change."""
    found = {"joint_cost": np.where(np.isfinite(best.cost), best.cost, NAN)}
    everywhere = np.arange(best.cost.size)
    known = np.isfinite(best.cost)
    for i, reach in enumerate(reaches):
        values = reach.at(np.nan_to_num(best.changes[:, i]), everywhere)
        found[f"joint_{reach.name}"] = np.where(known, values, NAN)
    regimes, values = _checked(asked, reaches, best.changes, question.beyond)
    found["joint_checked"] = regimes
    return found | {f"joint_proposed_{reach.name}": values[:, i] for i, reach in enumerate(reaches)}


def _checked(asked: Asked, reaches: Sequence[Reach], changes: Floats, beyond: float) -> tuple[Labels, Floats]:
    """Regimes of cells a little past the border, and the values there; 0 and NaN where there is none.

    changes : (n, k) up to the border. The length of the change grows by the share `beyond`, or by as much as a single
    parameter has to change by that share of its value, if that is more.
    """
    there = np.flatnonzero(~np.isnan(changes).any(axis=1))
    regimes = np.zeros(len(changes), np.int8)
    values = np.full(changes.shape, NAN)
    length = np.linalg.norm(changes[there], axis=1, keepdims=True)
    by_factor = np.stack([reach.by_factor[there] for reach in reaches], axis=1).any(axis=1, keepdims=True)
    more = np.where(by_factor, np.maximum(beyond * length, np.log1p(beyond)), beyond * length)
    further = changes[there] * (1 + more / np.where(length > 0, length, 1.0))
    for i, reach in enumerate(reaches):
        values[there, i] = reach.at(further[:, i], there)
    regimes[there] = asked.regimes(there, {reach.name: values[there, i] for i, reach in enumerate(reaches)})
    return regimes, values


def _told(question: Question, table: Mapping[str, NDArray[Any]], options: Options) -> dict[str, str | float]:
    """What was done and what it cannot see, as global attributes."""
    open_cells = int(np.count_nonzero(~decided(table["regime"])))
    none = [name for name in question.parameters if np.isnan(table[f"margin_{name}"]).all()]
    within = within_of(question.within, question.parameters)
    told: dict[str, str | float] = {
        "margin_within": ", ".join(f"{name}: {_spelled(one)}" for name, one in within.items()),
        "margin_into": ", ".join(question.into) if question.into else "any other regime",
        "margin_scan": f"{question.scan} places on either side, evenly spaced in the change: what begins and ends "
        "between two of them can be missed",
        "margin_tolerance": question.tolerance,
        "margin_rtol": options.rtol,
        "margin_check": f"proposals were simulated {100 * question.beyond:g} % past the border",
        "margin_found": f"no border within reach along {', '.join(none)}" if none else "a border along each parameter",
    }
    if open_cells:
        told["margin_undecided"] = f"{open_cells} cells are unresolved or failed and have no margin"
    if question.joint:
        costs = ", ".join(f"{name}: {cost:g}" for name, cost in zip(question.parameters, question.of_each, strict=True))
        told["joint_costs"] = f"{costs}; of a change by the factor e, or by its scale where the value is 0"
    return told


def _spelled(within: float | tuple[float, float]) -> str:
    return f"{within[0]!r} to {within[1]!r}" if isinstance(within, tuple) else f"a factor of {within:g}"
