"""Lists of cells as people give them: checked, completed with defaults, and of one length."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.synonyms import meant

if TYPE_CHECKING:
    import xarray as xr

Cells = dict[str, NDArray[np.float64]]
_ROUNDING = 1e-12  # relative; 0.1 + 0.2 is above 0.3
_FEW = 4096  # cells; so many are laid out in a table, which is quicker than broadcasting but takes its memory
_DEFAULTS = {name: np.array(row.default) for name, row in PARAMETERS.items() if row.default is not None}


def as_cells(given: Mapping[str, Any] | xr.Dataset) -> Cells:
    """Every parameter of `PARAMETERS` as a float64 array, all of one length.

    given : numbers or arrays in SI by parameter name, broadcast against each other and flattened; of a Dataset, the
        variables and coordinates that carry names of parameters.
    Raises TypeError for names or values of the wrong kind, ValueError for missing or impossible values.
    """
    named = _named(given)
    _check_names(named)
    arrays = {name: _numbers(name, value) for name, value in named.items()}
    for name, parameter in PARAMETERS.items():
        if name in arrays:
            _check_range(parameter, arrays[name])
        elif parameter.default is None:
            raise ValueError(f"{name} is missing ({parameter.long_name}, {parameter.units})")
        else:
            arrays[name] = _DEFAULTS[name]
    cells = _of_one_length({name: arrays[name] for name in PARAMETERS})
    _check_between(cells)
    return cells


def _of_one_length(arrays: dict[str, NDArray[np.float64]]) -> Cells:
    """The arrays broadcast against each other, and flattened."""
    try:
        shape = np.broadcast_shapes(*{value.shape for value in arrays.values()})
    except ValueError:
        shapes = ", ".join(f"{name} {value.shape}" for name, value in arrays.items() if value.ndim)
        raise ValueError(f"the parameters do not fit together; their shapes are {shapes}") from None
    if (size := prod(shape)) > _FEW:
        return {name: np.broadcast_to(value, shape).reshape(-1) for name, value in arrays.items()}
    table = np.empty((len(arrays), *shape))
    for row, value in enumerate(arrays.values()):
        table[row] = value
    return dict(zip(arrays, table.reshape(-1, size), strict=True))


def impossible(cells: Cells) -> NDArray[np.bool_]:
    """Which cells `as_cells` would refuse: a parameter out of its bounds, or two that do not fit together."""
    allowed = [np.asarray(row.allows(cells[name])) for name, row in PARAMETERS.items()]
    mu_start = cells["a1"] + cells["a3"]
    slack = np.abs(mu_start) * _ROUNDING
    with np.errstate(invalid="ignore"):
        wrong = (mu_start < -_ROUNDING * cells["a1"]) | (cells["mu_static"] < mu_start - slack)
        return np.asarray(~np.logical_and.reduce(allowed) | wrong | (cells["mu_stop"] > mu_start + slack))


def _named(given: Mapping[str, Any] | xr.Dataset) -> dict[str, Any]:
    """Values by name; xarray is known where there is a Dataset."""
    xarray = sys.modules.get("xarray")
    return _from_dataset(given) if xarray and isinstance(given, xarray.Dataset) else dict(given)  # type: ignore[arg-type]


def _from_dataset(ds: xr.Dataset) -> dict[str, Any]:
    import xarray as xr

    names = [name for name in ds.variables if name in PARAMETERS]
    return {str(name): values.values for name, values in zip(names, xr.broadcast(*(ds[n] for n in names)), strict=True)}


def _check_names(named: Mapping[str, Any]) -> None:
    for name in named:
        if name not in PARAMETERS:
            near = meant(str(name), PARAMETERS)
            hint = f"; did you mean {near!r}?" if near else f"; known are {', '.join(PARAMETERS)}"
            raise TypeError(f"{name!r} is not a parameter of a cell{hint}")


def _numbers(name: str, value: Any) -> NDArray[np.float64]:
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name}: got {value!r}, expected a number or an array of numbers in {PARAMETERS[name].units}")
    return array.astype(np.float64)


def _check_range(parameter: Parameter, values: NDArray[np.float64]) -> None:
    """NaN is allowed only where it means "absent" (its own default)."""
    if values.ndim == 0 and parameter.allows(values.item()):
        return
    wrong = ~np.asarray(parameter.allows(values))
    if wrong.any():
        place = "" if values.ndim == 0 else f"[{', '.join(map(str, np.argwhere(wrong)[0]))}]"
        found = values[wrong][0] if values.ndim else values
        raise ValueError(f"{parameter.name}{place}: got {found:g}, expected {parameter.expected}")


def _check_between(cells: Cells) -> None:
    """0 <= mu_start, mu_stop <= mu_start <= mu_static, as in configurations; NaN is neither too large nor too
    small."""
    mu_start = cells["a1"] + cells["a3"]
    negative = mu_start < -_ROUNDING * cells["a1"]
    if negative.any():
        i = int(np.argmax(negative))
        found = f"a3[{i}]: got {cells['a3'][i]:g}, expected at least -a1 = {-cells['a1'][i]:g}"
        raise ValueError(f"{found}: mu_start = a1 + a3 is the static friction, which is not negative")
    allowed = np.abs(mu_start) * _ROUNDING
    for name, wrong, bound, why in (
        ("mu_static", cells["mu_static"] < mu_start - allowed, "at least", "less would neither stick nor slip"),
        ("mu_stop", cells["mu_stop"] > mu_start + allowed, "at most", "friction ends no higher than it starts"),
    ):
        if wrong.any():
            i = int(np.argmax(wrong))
            found = f"{name}[{i}]: got {cells[name][i]:g}, expected {bound} mu_start = a1 + a3 = {mu_start[i]:g}"
            raise ValueError(f"{found}: {why}")


def taken(cells: Cells, which: NDArray[Any]) -> Cells:
    """The cells of these numbers, or of this mask."""
    return {name: values[which] for name, values in cells.items()}
