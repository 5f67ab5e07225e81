"""Borders of regimes as a labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import variable_of
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import BORDER_VARIABLES


def border_dataset(
    along: str,
    dims: Sequence[str],
    shape: Sequence[int],
    coordinates: Mapping[str, xr.Variable],
    results: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """The borders along a parameter.

    dims, shape, coordinates : of the lines. results : by names of `BORDER_VARIABLES`, each (lines,) or (lines, n);
    the latter get the dimension ``crossing``.
    """
    row, variables = SEARCHABLE[along], {}
    for name, declared in BORDER_VARIABLES.items():
        values = results[name]
        more = () if values.ndim == 1 else ("crossing",)
        if name in ("border", "border_width"):
            declared = replace(declared, units=row.units, long_name=f"{declared.long_name}: {row.long_name}")
        variables[name] = variable_of(declared, (*dims, *more), values.reshape((*shape, *values.shape[1:])))
    return xr.Dataset(variables, dict(coordinates), dict(attributes))
