"""Made-up grids and maps for tests of what happens around the numbers: labels, files, plots.

The regimes come from the sign of the linear damping ratio, so that maps look like maps; no kernel runs.
"""

from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from stickslip.dataset.build import cell_coordinates, evaluated_dataset, map_dataset, provenance, variable_of
from stickslip.vocabulary.quantities import PARAMETERS, VARIABLES

FIXED = {"mass": 1.0, "damping": 0.05, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1,
         "mu_stop": float("nan"), "mu_static": float("nan"), "displacement": 0.0, "velocity": float("nan")}  # fmt: skip


@dataclass
class Coordinate:
    name: str
    dim: str
    values: np.ndarray
    units: str
    long_name: str
    spacing: str = "linear"
    labels: list[str] | None = None


@dataclass
class Grid:
    """Has what `dataset.map_dataset` reads of a grid."""

    coords: list[Coordinate]
    fixed: dict[str, float] = field(default_factory=dict)
    written_in: dict[str, str] = field(default_factory=dict)
    labelled: None = None

    @property
    def dims(self):
        return tuple(dict.fromkeys(c.dim for c in self.coords))

    @property
    def shape(self):
        lengths = {c.dim: len(c.values) for c in self.coords}
        return tuple(lengths[dim] for dim in self.dims)

    @property
    def size(self):
        return int(np.prod(self.shape))


def axis(name, values, spacing="linear", dim=None, labels=None) -> Coordinate:
    declared = PARAMETERS[name]
    return Coordinate(name, dim or name, np.asarray(values, float), declared.units, declared.long_name, spacing, labels)


def make_grid(*axes: Coordinate, **fixed: float) -> Grid:
    named = {c.name for c in axes}
    defaults = FIXED | {"stiffness": 10.0, "belt_speed": 0.2} | fixed
    return Grid(list(axes), {name: value for name, value in defaults.items() if name not in named})


def make_results(grid: Grid) -> dict[str, np.ndarray]:
    """Results that depend smoothly on the parameters: flat, last dimension fastest, as an engine gives them."""
    p = {name: xr.DataArray(value) for name, value in grid.fixed.items()}
    p |= {c.name: xr.DataArray(c.values, dims=c.dim) for c in grid.coords}
    slope = p["a2"] - p["a3"] / p["a4"] * np.exp(-p["belt_speed"] / p["a4"])
    zeta = (p["damping"] + p["normal_load"] * slope) / (2 * np.sqrt(p["stiffness"] * p["mass"]))
    shape = xr.DataArray(np.zeros(grid.shape), dims=grid.dims)

    def flat(values) -> np.ndarray:
        return (values + shape).transpose(*grid.dims).values.ravel()

    zeta = flat(zeta)
    sticks = zeta < 0
    period = flat(2 * np.pi * np.sqrt(p["mass"] / p["stiffness"]) + 0.6 / p["belt_speed"] / p["stiffness"])
    return {
        "regime": np.select([sticks, zeta < 1], [1.0, 2.0], 3.0),
        "status": np.where(sticks, 1.0, 2.0),
        "breakaway_time": flat(1.3 * p["normal_load"] / p["stiffness"] / p["belt_speed"]),
        "period": np.where(sticks, period, np.nan),
        "spring_force_max": flat(1.3 * p["normal_load"] + p["belt_speed"]),
        "damping_ratio": zeta,
        "equilibrium_crossings": np.where(sticks, np.nan, 2.0),
        "steps": np.full(grid.size, 321.0),
    }


def make_map(*axes: Coordinate, title="A made-up map", **fixed: float) -> xr.Dataset:
    grid = make_grid(*axes, **fixed)
    return map_dataset(grid, make_results(grid), provenance("title: made up µ\n", title=title))


def plane(rows=6, columns=8, **fixed: float) -> xr.Dataset:
    """Stiffness (log) by belt speed (linear)."""
    return make_map(
        axis("stiffness", np.geomspace(0.1, 1000, rows), "log"),
        axis("belt_speed", np.linspace(0.02, 0.6, columns)),
        **fixed,
    )


def cell_dataset(cells, results, attributes):
    """A list of cells along ``cell``, as `evaluate` makes it, of numbers and lists."""
    columns = {
        name: variable_of(VARIABLES[name], ("cell",), np.asarray(values).reshape(-1)).values
        for name, values in results.items()
    }
    size = next(iter(columns.values())).size
    return evaluated_dataset(("cell",), (size,), cell_coordinates(cells, size), columns, attributes)
