"""Distances to borders as a labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.build import variable_of
from stickslip.vocabulary.quantities import SEARCHABLE
from stickslip.vocabulary.results import MARGIN_VARIABLES, VARIABLES, Variable

SIDES = ("below", "above")
ON_SIDES = {"border": False, "border_width": False, "beyond": True, "proposed": False, "checked": True}  # flags: True


def margin_dataset(
    parameters: Sequence[str],
    dims: Sequence[str],
    shape: Sequence[int],
    coordinates: Mapping[str, xr.Variable],
    table: Mapping[str, NDArray[Any]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """The margins of cells.

    dims, shape, coordinates : of the cells. table : `regime`, and by names of `MARGIN_VARIABLES` followed by that of a
    parameter, what was found, each (cells,); those of `ON_SIDES` followed by a side as well, which becomes a dimension.
    """
    declared = {"regime": VARIABLES["regime"]}
    declared |= {name: _of(row, None) for name, row in MARGIN_VARIABLES.items()}
    declared |= {f"{name}_{p}": _of(row, p) for name, row in MARGIN_VARIABLES.items() for p in parameters}
    both = {f"{kind}_{p}": np.stack([table[f"{kind}_{p}_{side}"] for side in SIDES], axis=-1)
            for p in parameters for kind in ON_SIDES}  # fmt: skip
    single = {name: values for name, values in table.items() if name in declared and name not in both}
    variables = {}
    for name, values in (single | both).items():
        more = () if values.ndim == 1 else ("side",)
        variables[name] = variable_of(declared[name], (*dims, *more), values.reshape((*shape, *values.shape[1:])))
    side = xr.Variable("side", np.asarray(SIDES, str), {"long_name": "side of the value on which the border lies"})
    return xr.Dataset(variables, dict(coordinates) | {"side": side}, dict(attributes))


def _of(row: Variable, parameter: str | None) -> Variable:
    """A row for one parameter: its unit where the row has that of a parameter, and its long name."""
    if row.units == "flag":
        row = replace(row, name="regime", units="1")
    if parameter is None:
        return row
    about = SEARCHABLE[parameter]
    units = about.units if row.units == "parameter" else row.units
    return replace(row, units=units, long_name=f"{row.long_name}: {about.long_name}")
