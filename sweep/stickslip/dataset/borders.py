"""Borders of regimes as a labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import shown_in, variable_of
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import BORDER_VARIABLES


def border_dataset(
    along: str,
    dims: Sequence[str],
    shape: Sequence[int],
    coordinates: Mapping[str, xr.Variable],
    results: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
    unit: str | None = None,
) -> xr.Dataset:
    """The borders along a parameter.

    dims, shape, coordinates : of the lines. results : by names of `BORDER_VARIABLES`, each (lines,) or (lines, n);
    the latter get the dimension ``crossing``. unit : in which the parameter is shown.
    """
    row, variables = SEARCHABLE[along], {}
    for name, declared in BORDER_VARIABLES.items():
        values = results[name]
        more = () if values.ndim == 1 else ("crossing",)
        if name in ("border", "border_width"):
            declared = replace(declared, units=row.units, long_name=f"{declared.long_name}: {row.long_name}")
        variable = variable_of(declared, (*dims, *more), values.reshape((*shape, *values.shape[1:])))
        variables[name] = shown_in(variable, unit) if name in ("border", "border_width") else variable
    return xr.Dataset(variables, dict(coordinates), dict(attributes))
