"""What a figure of the article is here: a plot, its data and its findings, from configurations of `configs/article`.

Figures are made by functions of no arguments. The helpers below are what such functions share: cells and trajectories
of a configuration, and the places where the regime, or Eq. (3), changes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.api.cells import evaluate, simulate
from stickslip.api.studies import border as find_border
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.reader import load_config
from stickslip.config.resolve import config_path
from stickslip.dataset.build import provenance
from stickslip.plots.layout import Figure as Plot
from stickslip.studies.search import Looked, Scan, search_lines
from stickslip.vocabulary.quantities import PARAMETERS, REGIMES

Cell = Mapping[str, float]
Findings = dict[str, float | str]
Floats = NDArray[np.float64]

FOLDER = "article"  # of the configurations, below configs/
STICK_SLIP = REGIMES.index("stick_slip")


@dataclass(frozen=True)
class Made:
    """A figure made: its plot, its data and its findings (numbers in SI, regimes by name)."""

    plot: Plot
    data: xr.Dataset
    findings: Findings


@dataclass(frozen=True)
class Figure:
    """A figure of the article.

    description : what it shows. function : makes it. configs : names of its configurations in `configs/article`.
    statement : what the article says. agrees, differs : what came out, with fields in braces for the findings; no
    `differs` where there is nothing to add.
    """

    description: str
    function: Callable[[], Made]
    configs: tuple[str, ...]
    statement: str
    agrees: str
    differs: str = ""


# --- cells and trajectories -------------------------------------------------------------------------------------------


def configuration(name: str) -> Config:
    """The configuration `name` of the article's."""
    return load_config(config_path(config_name(name)))


def config_name(name: str) -> str:
    """The name of a configuration below configs/, which is one of the article's unless it names its folder."""
    return name if "/" in name else f"{FOLDER}/{name}"


def cells(config: Config) -> dict[str, Floats]:
    """The parameters of every cell, SI, by names of `PARAMETERS`; the last axis runs fastest."""
    grid = build_grid(config)
    return grid[:]


def cell(config: Config, position: int = 0, **changed: float) -> dict[str, float]:
    """The parameters of one cell, with some of them `changed`."""
    return {name: float(values[position]) for name, values in cells(config).items()} | changed


def trajectory(one: Cell, duration: float, samples: int) -> xr.Dataset:
    """One cell over time (s)."""
    given: dict[str, Any] = dict(one)
    return simulate(duration=duration, samples=samples, **given)


def traces(some: Mapping[str, Cell], dim: str, duration: float, samples: int = 2001) -> xr.Dataset:
    """Trajectories of several cells over the same time.

    some : cells by the labels they get along `dim`. Parameters that are equal in all of them stay without dimension.
    """
    each = [trajectory(one, duration, samples) for one in some.values()]
    label = xr.Variable((dim,), list(some), {"long_name": dim.replace("_", " ")})
    together = xr.concat(
        each, dim=dim, data_vars="all", coords="different", compat="equals", join="exact", combine_attrs="override"
    )
    return together.assign_coords({dim: label})


def labelled(data: xr.Dataset, title: str, configs: Sequence[str], findings: Findings) -> xr.Dataset:
    """`data` with attributes that say what it is, what it was made from and what was found in it."""
    text = "\n---\n".join(configuration(name).to_yaml() for name in configs)
    attributes = provenance(text, title=title, action="article")
    found = "; ".join(f"{name}: {value:.9g}" if isinstance(value, float) else f"{name}: {value}"
                      for name, value in findings.items())  # fmt: skip
    for name, declared in PARAMETERS.items():
        if name in data.coords and not data[name].attrs:
            data[name].attrs.update(units=declared.units, long_name=declared.long_name)
    claimed = data.assign_attrs(attributes | {"findings": found})
    del claimed.attrs["Conventions"]  # CF wants a date in a coordinate called time; these count from the start
    return claimed


# --- what cells do ----------------------------------------------------------------------------------------------------


def regimes(some: Mapping[str, Floats] | Cell, rtol: float = 1e-6) -> list[str]:
    """Names of the regimes of some cells."""
    return [REGIMES[i] for i in evaluate(dict(some), rtol=rtol)["regime"].values]


def stick_slip_border(
    some: Mapping[str, Floats | float],
    along: str,
    between: tuple[float, float],
    *,
    rtol: float = 1e-8,
    tolerance: float = 1e-11,
) -> Floats:
    """The last value of a parameter in stick-slip before it ends, per cell.

    Raises ValueError unless stick-slip ends once between those values.
    """
    found = find_border(some, along, between, tolerance, scan=2, rtol=rtol)
    below, above = (found[name].values == STICK_SLIP for name in ("regime_below", "regime_above"))
    ends = below != above
    if (ends.sum(axis=1) != 1).any():
        raise ValueError(f"{along} from {between[0]:g} to {between[1]:g}: expected one end of stick-slip per cell")
    inside = found["border"].values + np.where(below, -0.5, 0.5) * found["border_width"].values
    return np.asarray(inside[ends], np.float64)


def border_of_tendency(
    some: Mapping[str, Floats | float], along: str, between: tuple[float, float], *, rtol: float = 1e-8
) -> float:
    """Where along a parameter Eq. (3), evaluated for what occurred in one cell, changes its sign."""

    def signs(_: NDArray[np.int64], place: Floats) -> Looked:
        found = evaluate({**some, along: place}, rtol=rtol)["tendency"].values
        return Looked((found >= 0).astype(np.int8), np.isfinite(found), found)

    found, _ = search_lines(1, Scan.over(*between, 2), 1e-11, signs)
    if found.size != 1:
        raise ValueError(f"{along} from {between[0]:g} to {between[1]:g}: expected one change of sign of Eq. (3)")
    return float((found["low"] + found["high"])[0] / 2)
