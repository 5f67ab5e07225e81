"""Lists of cells as people give them: checked, completed with defaults, and of one length."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from functools import cache
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.beyond import beyond_the_model
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.models import LAWS, Rule, coefficients_of, laws_with, model_of
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS, PARAMETERS_OF
from stickslip.vocabulary.scales import Scales
from stickslip.vocabulary.suggest import listed, or_meant

if TYPE_CHECKING:
    import xarray as xr

_FEW = 4096  # cells; so many are laid out in a table, which is quicker than broadcasting but takes its memory
_PLAIN = (float, int)  # what most give, which takes NumPy a moment to find out
_DEFAULTS = {name: np.array(row.default) for name, row in PARAMETERS.items() if row.default is not None}


def as_cells(given: Mapping[str, Any] | xr.Dataset, law: str = "stribeck") -> Parameters:
    """Every parameter that cells of this law have, as float64 arrays, all of one length.

    given : numbers or arrays in SI by parameter name, or texts with units, broadcast against each other and flattened;
        of a Dataset, the variables and coordinates that carry names of parameters. law : one of `models.LAWS`.
    Raises TypeError for names or values of the wrong kind, ValueError for missing or impossible values.
    """
    named, model = {**coefficients_of(law), **named_values(given)}, model_of(law)
    known = PARAMETERS_OF[model]
    check_names(named, known)
    arrays = {}
    for name, parameter in known.items():
        if name in named:
            arrays[name] = _numbers(parameter, named[name])
        elif parameter.default is None:
            raise ValueError(f"{name} is missing ({parameter.long_name}, {parameter.units})")
        else:
            arrays[name] = _DEFAULTS[name]
    rules = _of_cells(model.rules.get(law, ()))
    plain: dict[str, Any] = dict(arrays)
    for name in _involved(rules):  # numbers are quicker than arrays of one
        if arrays[name].ndim == 0:
            plain[name] = arrays[name].item()
    cells = _of_one_length(arrays)
    if any(rule.breaks(plain) for rule in rules):
        _check_between(cells, rules)
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
        sizes = ", ".join(f"{name} {value.shape}" for name, value in arrays.items() if value.ndim)
        raise ValueError(f"the parameters do not fit together; their shapes are {sizes}") from None


def impossible(cells: Parameters, rules: tuple[Rule, ...]) -> NDArray[np.bool_]:
    """A mask of the cells that `as_cells` would refuse: a parameter out of its bounds, or two that do not fit."""
    allowed = [np.asarray(row.allows(cells[name])) for name, row in PARAMETERS.items() if name in cells]
    with np.errstate(invalid="ignore"):
        broken = [rule.is_broken(rule.margin(cells), cells) for rule in _of_cells(rules)]
        return np.asarray(~np.logical_and.reduce(allowed) | np.logical_or.reduce(broken))


@cache
def _of_cells(rules: tuple[Rule, ...]) -> tuple[Rule, ...]:
    """Those rules that are about parameters of cells alone."""
    return tuple(rule for rule in rules if rule.worse.keys() <= PARAMETERS.keys())


@cache
def _involved(rules: tuple[Rule, ...]) -> tuple[str, ...]:
    """The quantities that rules are about, each once."""
    return tuple(dict.fromkeys(name for rule in rules for name in rule.worse))


def named_values(given: Mapping[str, Any] | xr.Dataset) -> dict[str, Any]:
    """Values by name; xarray is known where there is a Dataset."""
    xarray = sys.modules.get("xarray")
    return _from_dataset(given) if xarray and isinstance(given, xarray.Dataset) else dict(given)  # type: ignore[arg-type]


def _from_dataset(ds: xr.Dataset) -> dict[str, Any]:
    import xarray as xr

    names = [str(name) for name in ds.variables if name in PARAMETERS]
    return dict(zip(names, xr.broadcast(*(ds[name] for name in names)), strict=True))


def check_names(named: Iterable[str], known: Mapping[str, Parameter] = PARAMETERS) -> None:
    """Raises TypeError for a name of no parameter."""
    for name in named:
        if name not in known:
            if sentence := beyond_the_model(str(name)):
                raise TypeError(f"{name!r} is not a parameter of a cell; {sentence}")
            if len(laws := laws_with(str(name))) < len(laws_with("mass")):
                shipped = [law for law in laws if law in LAWS]
                raise TypeError(f"{name!r} is not a parameter of cells of this law, but of {listed(shipped)}")
            hint = or_meant(str(name), known, otherwise=f"; known are {', '.join(known)}")
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
    mixed = isinstance(inside, list | tuple) and any(isinstance(item, str) for item in inside)
    try:
        array = np.asarray(inside, object if mixed else None)
    except (ValueError, TypeError):  # lists of different lengths, or of quantities
        raise TypeError(f"{parameter.name}: got {value!r}, expected {_expected(parameter)}") from None
    if array.dtype.kind in "iuf":
        return _in_si(parameter, array, unit)
    return _from_texts(parameter, array, value, unit)


def has_missing(values: Any) -> bool:
    """Return whether values are masked (NumPy) or missing (NA of pandas). NaN is neither."""
    if isinstance(values, np.ma.MaskedArray):
        return bool(np.ma.getmaskarray(values).any())
    if isinstance(values, list | tuple):
        return any(isinstance(item, list | tuple | np.ma.MaskedArray) and has_missing(item) for item in values)
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
        instead = f" ({error.kind})" if error.kind else ""
        raise ValueError(f"{parameter.name}: got the units {unit!r}{instead}, {error}") from None


def _from_texts(parameter: Parameter, array: NDArray[Any], value: Any, unit: str | None) -> NDArray[np.float64]:
    """Values of which some are texts with units of their own, or words such as `none`."""
    numbers = np.empty(array.shape)
    try:
        plain_items = iter(units.each_with_unit(array.ravel().tolist(), parameter.units if unit is None else "1"))
    except QuantityError as error:
        raise ValueError(f"{parameter.name}: got {value!r}, expected {error.expected}") from None
    for place in np.ndindex(array.shape):
        plain = next(plain_items)
        if isinstance(plain, bool) or not isinstance(plain, int | float | str):
            raise TypeError(f"{parameter.name}: got {value!r}, expected {_expected(parameter)}")
        try:
            is_text = isinstance(plain, str)
            numbers[place] = parameter.read(plain) if is_text else _in_si(parameter, np.array(plain), unit)
        except QuantityError as error:
            instead = f" ({error.kind})" if error.kind else ""
            raise ValueError(f"{parameter.name}{_at(place)}: got {plain!r}{instead}, {error}") from None
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
        first = values[wrong][0] if values.ndim else values
        place = _at(np.argwhere(wrong)[0]) if values.ndim else ""
        raise ValueError(f"{parameter.name}{place}: got {first:g}, expected {parameter.expected}")


def _at(place: Iterable[Any]) -> str:
    """A place in an array as one writes it; nothing for a single number."""
    inside = ", ".join(map(str, place))
    return f"[{inside}]" if inside else ""


def _check_between(cells: Parameters, rules: Iterable[Rule]) -> None:
    """Raise ValueError unless what must hold between the parameters of a cell holds, as in configurations."""
    for rule in rules:
        if (broken := rule.is_broken(rule.margin(cells), cells)).any():
            i = int(np.argmax(broken))
            cell = {name: float(values[i]) for name, values in cells.items()}
            expected = rule.expected(cell)
            raise ValueError(f"{rule.name}[{i}]: got {cell[rule.name]:g}, expected {expected}: {rule.why}")


def scales_of(given: Mapping[str, ArrayLike]) -> Scales:
    """The scales of cells of which some quantities are given, in SI: the others are at their defaults, or NaN.

    Mass, stiffness and load of an oscillator are asked of `Scales` alone: further parameters may add to them.
    """
    cells = dict.fromkeys(PARAMETERS, np.array(np.nan)) | _DEFAULTS
    return Scales(cells | {name: np.asarray(value, np.float64) for name, value in given.items() if name in cells})
