"""Attractors of cells, and along ramps, as labelled datasets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import shown_in, variable_of
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import ATTRACTOR_VARIABLES, BETWEEN_VARIABLES, RAMP_VARIABLES


def attractor_dataset(
    dims: Sequence[str],
    shape: Sequence[int],
    coordinates: Mapping[str, xr.Variable],
    results: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """The attractors of cells.

    dims, shape, coordinates : of the cells. results : by names of `ATTRACTOR_VARIABLES`, flat.
    """
    variables = {
        name: variable_of(declared, dims, results[name].reshape(shape))
        for name, declared in ATTRACTOR_VARIABLES.items()
    }
    variables["coexisting"] = _masks(variables["coexisting"])
    return xr.Dataset(variables, dict(coordinates), dict(attributes))


def _masks(variable: xr.Variable) -> xr.Variable:
    """Regimes that may be there together, a bit each (CF: flag_masks); the code of a regime counts the bits from 1."""
    names = REGIMES[1:]
    attributes = variable.attrs | {
        "flag_masks": (2 ** np.arange(len(names))).astype(np.int8),
        "flag_meanings": " ".join(names),
        "comment": "; ".join(f"{name}: {REGIME_MESSAGES[name]}" for name in names),
    }
    return xr.Variable(variable.dims, variable.values.astype(np.int8), attributes, {"_FillValue": None})


def ramp_dataset(
    along: str,
    values: NDArray[np.float64],
    dims: Sequence[str],
    coordinates: Mapping[str, xr.Variable],
    results: Mapping[str, NDArray[Any]],
    between: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
    unit: str | None = None,
) -> xr.Dataset:
    """Attractors along a parameter that goes up and down again.

    dims, coordinates : of the lines. unit : in which the parameter is shown.
    results : by names of `RAMP_VARIABLES`, and `vibration_end`, of the shape (*lines, direction, values).
    between : by names of `BETWEEN_VARIABLES`, of the shape (*lines, values).
    """
    row = PARAMETERS[along]
    ahead = {"units": row.units, "long_name": row.long_name, "axis_spacing": "linear"}
    more = {
        along: shown_in(xr.Variable((along,), values, ahead, {"_FillValue": None}), unit),
        "direction": xr.Variable(("direction",), np.array(["up", "down"]), {"long_name": "direction of the ramp"}),
    }
    shape = (*dims, "direction", along)
    variables = {name: variable_of(declared, shape, results[name]) for name, declared in RAMP_VARIABLES.items()}
    ends = {"units": row.units, "long_name": "where vibration ends, between this value and the next of the ramp"}
    variables["vibration_end"] = shown_in(xr.Variable(shape, results["vibration_end"], ends), unit)
    for name, declared in BETWEEN_VARIABLES.items():
        variables[name] = variable_of(declared, (*dims, along), between[name])
    return xr.Dataset(variables, dict(coordinates) | more, dict(attributes))
