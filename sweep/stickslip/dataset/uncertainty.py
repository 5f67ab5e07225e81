"""Probabilities of regimes, the spread of metrics and Sobol indices as a labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import grid_coordinates, variable_of
from stickslip.vocabulary.results import STATISTICS, UNCERTAIN_VARIABLES, VARIABLES, Variable

if TYPE_CHECKING:
    from stickslip.vocabulary.cells import Cells

_NO_FILL = {"_FillValue": None}
_SCALAR = ("undecided", "levels", "evaluations")  # one number per cell; others are per state


def uncertain_dataset(
    grid: Cells,
    states: Sequence[str],
    quantities: Sequence[str],
    quantiles: Sequence[float],
    results: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """What the draws of every cell say.

    results : by names of `UNCERTAIN_VARIABLES`, and of metrics (``mean_period``, ``quantile_period_error``, ...); the
    first dimension is that of the cells, further ones are ``state``, ``quantity`` or ``quantile``.
    """
    variables = {}
    for name, values in results.items():
        declared, more = _declared(name)
        variables[name] = variable_of(declared, (*grid.dims, *more), values.reshape((*grid.shape, *values.shape[1:])))
    coordinates = grid_coordinates(grid)
    coordinates["state"] = xr.Variable("state", np.asarray(states, str), {"long_name": "regime"})
    used = {dim for variable in variables.values() for dim in variable.dims}
    if "quantity" in used:
        names = {"long_name": "uncertain quantity"}
        coordinates["quantity"] = xr.Variable("quantity", np.asarray(quantities, str), names)
    if "quantile" in used:
        what = {"units": "1", "long_name": "share of the draws below the quantile"}
        coordinates["quantile"] = xr.Variable("quantile", np.asarray(quantiles, np.float64), what, _NO_FILL)
    return xr.Dataset(variables, coordinates, dict(attributes))


def _declared(name: str) -> tuple[Variable, tuple[str, ...]]:
    """The declaration of a result, and its dimensions besides those of the axes."""
    if name in UNCERTAIN_VARIABLES:
        dims = () if name in _SCALAR else ("state", "quantity") if name.startswith("sobol") else ("state",)
        return UNCERTAIN_VARIABLES[name], dims
    statistic, _, metric = name.removesuffix("_error").partition("_")
    key = f"{statistic}_error" if name.endswith("_error") else statistic
    of = VARIABLES[metric]
    units = "1" if statistic == "count" else of.units
    comment = "among the draws that have it" if statistic != "count" else ""
    declared = Variable(name, units, f"{STATISTICS[key]}: {of.long_name}", comment=comment)
    return declared, ("quantile",) if statistic == "quantile" else ()
