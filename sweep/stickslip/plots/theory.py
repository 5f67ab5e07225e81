"""Linear theory over a map, of models that know it by formulas: at points of its own, however few cells the map has."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import quantity_of, shared_by
from stickslip.dataset.display import MapAxis
from stickslip.engine import Options, by_theory
from stickslip.errors import ConfigError
from stickslip.vocabulary.cells import as_cells, parameters_of
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import QUANTITIES

Floats = NDArray[np.float64]
_POINTS = 129  # along an axis


def over_plane(panel: xr.Dataset, name: str, x: MapAxis, y: MapAxis) -> tuple[Floats, Floats, Floats] | None:
    """Points along x and along y, in the units in which they are shown, and a result of theory, (y, x), there.

    None where the model of the contact knows it from cells alone, or the dataset says too little.
    """
    coords = {
        quantity_of(str(key)): array for key, array in panel.coords.items() if quantity_of(str(key)) in QUANTITIES
    }
    law = law_with_theory(panel)
    if law is None or any(set(array.dims) - {x.dim, y.dim} for array in coords.values()):
        return None
    try:
        values = {}
        for key, array in coords.items():
            along = _between(x if array.dims == (x.dim,) else y, array.values) if array.dims else array.values
            values[key] = np.broadcast_to(along[:, None] if array.dims == (y.dim,) else along, (_POINTS,) * 2).ravel()
        cells = as_cells(parameters_of(values), law)
        ratio = by_theory(name, cells, Options(law)).reshape(_POINTS, _POINTS)
    except (TypeError, ValueError):  # not all that a cell has is among the coordinates
        return None
    return _between(x, x.centres), _between(y, y.centres), ratio


def law_with_theory(ds: xr.Dataset) -> str | None:
    """The law of a map, if linear theory of its contact needs no cells, and this process knows it."""
    try:
        law = str(shared_by(ds)["law"])
        return law if model_of(law).growth else None
    except (ConfigError, KeyError):
        return None


def _between(axis: MapAxis, values: NDArray[np.float64]) -> Floats:
    """Values at the points of an axis, at more of them: by ratio where the axis is."""
    at, own = np.linspace(0.0, axis.length - 1.0, _POINTS), np.arange(axis.length)
    if axis.is_log and (values > 0).all():
        return np.exp(np.interp(at, own, np.log(values)))
    return np.interp(at, own, values)
