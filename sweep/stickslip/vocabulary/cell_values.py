"""Lists of cells as people give them: checked, completed with defaults, and of one length."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.beyond import beyond_the_model
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.curve import broken_bounds
from stickslip.vocabulary.laws import NO_MINIMUM, rise_to_a_maximum
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.suggest import suggest

if TYPE_CHECKING:
    import xarray as xr

_FEW = 4096  # cells; so many are laid out in a table, which is quicker than broadcasting but takes its memory
_BETWEEN = ("a1", "a3", "mu_static", "mu_stop")  # bounds of each other
_WHY = {
    "a3": ("at least -a1", "mu_start = a1 + a3 is the static friction, which is not negative"),
    "mu_static": ("at least mu_start = a1 + a3", "less would neither stick nor slip"),
    "mu_stop": ("at most mu_start = a1 + a3", "friction ends no higher than it starts"),
}
_PLAIN = (float, int)  # what most give, which takes NumPy a moment to find out
_DEFAULTS = {name: np.array(row.default) for name, row in PARAMETERS.items() if row.default is not None}


def as_cells(given: Mapping[str, Any] | xr.Dataset, law: str = "stribeck") -> Parameters:
    """Every parameter of `PARAMETERS` as a float64 array, all of one length.

    given : numbers or arrays in SI by parameter name, or texts with units, broadcast against each other and flattened;
        of a Dataset, the variables and coordinates that carry names of parameters. law : one of `vocabulary.laws.LAWS`.
    Raises TypeError for names or values of the wrong kind, ValueError for missing or impossible values.
    """
    named = _named(given)
    check_names(named)
    arrays = {}
    for name, parameter in PARAMETERS.items():
        if name in named:
            arrays[name] = _numbers(parameter, named[name])
        elif parameter.default is None:
            raise ValueError(f"{name} is missing ({parameter.long_name}, {parameter.units})")
        else:
            arrays[name] = _DEFAULTS[name]
    if all(arrays[name].ndim == 0 for name in _BETWEEN) and _fit_together(*(arrays[name].item() for name in _BETWEEN)):
        return _of_one_length(arrays)
    cells = _of_one_length(arrays)
    _check_between(cells, law)
    return cells


def _of_one_length(arrays: dict[str, NDArray[np.float64]]) -> Parameters:
    """The arrays broadcast against each other, and flattened."""
    shape = _common_shape(arrays)
    if (size := prod(shape)) > _FEW:
        return {
            name: (value if value.shape == shape else np.broadcast_to(value, shape)).reshape(-1)
            for name, value in arrays.items()
        }
    table = np.empty((len(arrays), *shape))
    for row, value in enumerate(arrays.values()):
        table[row] = value
    return dict(zip(arrays, table.reshape(len(arrays), size), strict=True))


def _common_shape(arrays: dict[str, NDArray[np.float64]]) -> tuple[int, ...]:
    shapes = {value.shape for value in arrays.values()} - {()}
    if len(shapes) < 2:
        return next(iter(shapes), ())
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        found = ", ".join(f"{name} {value.shape}" for name, value in arrays.items() if value.ndim)
        raise ValueError(f"the parameters do not fit together; their shapes are {found}") from None


def impossible(cells: Parameters) -> NDArray[np.bool_]:
    """A mask of the cells that `as_cells` would refuse: a parameter out of its bounds, or two that do not fit."""
    allowed = [np.asarray(row.allows(cells[name])) for name, row in PARAMETERS.items()]
    with np.errstate(invalid="ignore"):
        return np.asarray(~np.logical_and.reduce(allowed) | np.logical_or.reduce([*_broken(cells).values()]))


def _broken(cells: Parameters) -> dict[str, Any]:
    bounds = {name: cells[name] for name in ("a1", "mu_static", "mu_stop")}
    return broken_bounds(cells["a1"] + cells["a3"], **bounds)


def _named(given: Mapping[str, Any] | xr.Dataset) -> dict[str, Any]:
    """Values by name; xarray is known where there is a Dataset."""
    xarray = sys.modules.get("xarray")
    return _from_dataset(given) if xarray and isinstance(given, xarray.Dataset) else dict(given)  # type: ignore[arg-type]


def _from_dataset(ds: xr.Dataset) -> dict[str, Any]:
    import xarray as xr

    names = [str(name) for name in ds.variables if name in PARAMETERS]
    return dict(zip(names, xr.broadcast(*(ds[name] for name in names)), strict=True))


def check_names(named: Iterable[str]) -> None:
    """Raises TypeError for a name of no parameter."""
    for name in named:
        if name not in PARAMETERS:
            near = suggest(str(name), PARAMETERS)
            if sentence := beyond_the_model(str(name)):
                raise TypeError(f"{name!r} is not a parameter of a cell; {sentence}")
            hint = f"; did you mean {near!r}?" if near else f"; known are {', '.join(PARAMETERS)}"
            raise TypeError(f"{name!r} is not a parameter of a cell{hint}")


def _numbers(parameter: Parameter, value: Any) -> NDArray[np.float64]:
    """The values of a parameter in SI, checked."""
    if type(value) in _PLAIN and parameter.allows(value):
        with suppress(OverflowError):  # a whole number of hundreds of digits
            return np.array(value, np.float64)
    numbers = numbers_of(parameter, value)
    _check_range(parameter, numbers)
    return numbers


def numbers_of(parameter: Parameter, value: Any) -> NDArray[np.float64]:
    """The values of a parameter in SI, whatever holds them. Raises TypeError for what is no number, ValueError for
    another unit."""
    unit, inside = units.said_by(value), units.without_unit(value)
    if has_missing(inside):
        raise TypeError(f"{parameter.name}: got masked or missing values, expected {_expected(parameter)}; "
                        "leave these cells out, or fill them")  # fmt: skip
    try:
        array = np.asarray(inside)
    except ValueError:  # lists of different lengths, or of quantities
        raise TypeError(f"{parameter.name}: got {value!r}, expected {_expected(parameter)}") from None
    if array.dtype.kind in "iuf":
        return _in_si(parameter, array, unit)
    return _from_texts(parameter, array, value, unit)


def has_missing(values: Any) -> bool:
    """Return whether values are masked (NumPy) or missing (NA of pandas). NaN is neither."""
    if isinstance(values, np.ma.MaskedArray):
        return bool(np.ma.getmaskarray(values).any())
    if isinstance(values, list | tuple):
        return any(isinstance(one, list | tuple | np.ma.MaskedArray) and has_missing(one) for one in values)
    if isinstance(getattr(values, "dtype", np.dtype(float)), np.dtype):
        return False
    return bool((values.isna() if hasattr(values, "isna") else values.isnull()).any())  # a dtype of pandas


def _in_si(parameter: Parameter, values: NDArray[Any], unit: str | None) -> NDArray[np.float64]:
    """Numbers with the unit that their array says it has, as new ones in SI. Raises ValueError for a unit of others."""
    numbers = values.astype(np.float64)
    if unit is None or unit == parameter.units:
        return numbers
    try:
        return units.si_array(numbers, unit, parameter.units)
    except QuantityError as error:
        found = f" ({error.found})" if error.found else ""
        raise ValueError(f"{parameter.name}: got the units {unit!r}{found}, {error}") from None


def _from_texts(parameter: Parameter, array: NDArray[Any], value: Any, unit: str | None) -> NDArray[np.float64]:
    """Values of which some are texts with units of their own, or words such as `none`."""
    numbers = np.empty(array.shape)
    for place, item in np.ndenumerate(array):
        plain = item.item() if isinstance(item, np.generic) else item
        if isinstance(plain, bool) or not isinstance(plain, int | float | str):
            raise TypeError(f"{parameter.name}: got {value!r}, expected {_expected(parameter)}")
        try:
            is_text = isinstance(plain, str)
            numbers[place] = parameter.read(plain) if is_text else _in_si(parameter, np.array(plain), unit)
        except QuantityError as error:
            found = f" ({error.found})" if error.found else ""
            raise ValueError(f"{parameter.name}{_at(place)}: got {plain!r}{found}, {error}") from None
        except OverflowError:
            raise ValueError(f"{parameter.name}{_at(place)}: got {plain!r}, expected {parameter.expected}") from None
    return numbers


def _expected(parameter: Parameter) -> str:
    if parameter.units == "1":
        return "a number or an array of numbers"
    example = units.example(parameter.units)
    return f"a number or an array of numbers in {parameter.units}, or texts such as {example!r}"


def _check_range(parameter: Parameter, values: NDArray[np.float64]) -> None:
    """NaN is allowed only where it means "absent" (its own default)."""
    wrong = ~np.asarray(parameter.allows(values))
    if wrong.any():
        found = values[wrong][0] if values.ndim else values
        place = _at(np.argwhere(wrong)[0]) if values.ndim else ""
        raise ValueError(f"{parameter.name}{place}: got {found:g}, expected {parameter.expected}")


def _at(place: Iterable[Any]) -> str:
    """A place in an array as one writes it; nothing for a single number."""
    inside = ", ".join(map(str, place))
    return f"[{inside}]" if inside else ""


def _fit_together(a1: float, a3: float, mu_static: float, mu_stop: float) -> bool:
    """Return whether `_check_between` passes numbers that are the same in all cells."""
    if a3 < 0.0 and mu_stop == mu_stop:  # the curve may have no minimum
        return False
    return not any(broken_bounds(a1 + a3, a1=a1, mu_static=mu_static, mu_stop=mu_stop).values())


def _check_between(cells: Parameters, law: str) -> None:
    """Raise ValueError unless 0 <= mu_start, mu_stop <= mu_start <= mu_static, as in configurations."""
    for name, broken in _broken(cells).items():
        if broken.any():
            i = int(np.argmax(broken))
            bound, why = _WHY[name]
            limit = -cells["a1"][i] if name == "a3" else cells["a1"][i] + cells["a3"][i]
            raise ValueError(f"{name}[{i}]: got {cells[name][i]:g}, expected {bound} = {limit:g}: {why}")
    undefined = (rise_to_a_maximum(law, cells) > 0.0) & ~np.isnan(cells["mu_stop"])
    if undefined.any():
        i = int(np.argmax(undefined))
        curve = ", ".join(f"{name} = {cells[name][i]:g}" for name in ("a2", "a3", "a4"))
        raise ValueError(f"mu_stop[{i}]: got {cells['mu_stop'][i]:g}, expected none with {curve}: {NO_MINIMUM}")
