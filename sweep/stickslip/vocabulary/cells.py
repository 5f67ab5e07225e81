"""Cells over named dimensions: what every study is asked about.

Cells are numbered with the last dimension running fastest. Those of a configuration (`config/grid.py`) may be more than
memory holds: their parameters are computed for the range that is asked for. Those that people list
(`dataset/build.py`) are arrays.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.models import LAWS, MODELS, Rule, coefficients_of, laws_with, model_of
from stickslip.vocabulary.models.model import Scales
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import MEASURED, OF_EXTENSIONS, PARAMETERS, PARAMETERS_OF, listed, or_meant

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Parameters = dict[str, Floats]  # of some cells, in SI, by names of `PARAMETERS`: arrays of one length
_LARGEST = 1e300  # of whole numbers that are floats
_NAMES = (*PARAMETERS, *OF_EXTENSIONS)


@dataclass(frozen=True, eq=False)
class Coordinate:
    """One quantity along one dimension.

    values : in SI, one per point; NaN where the quantity is absent. spacing : "linear", "log" or "values" (a list).
    labels : names of the points; with them the dimension is indexed by names, not by values.
    """

    name: str
    dim: str
    values: Floats
    units: str
    long_name: str
    spacing: str
    labels: tuple[str, ...] | None = None


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells over named dimensions; `cells[start:stop]` are the parameters of a range of them.

    dims, shape : names and lengths of the dimensions, outermost first. No dimensions: one cell.
    fixed : quantities that are equal in all cells, in SI, NaN for absent ones. along : those that vary along one
        dimension, with its number. listed : those that vary from cell to cell, flat.
    measured : of `MEASURED`, equal in all cells while others of the curve vary, so that its parameters follow cell by
    cell.
    coords : the axes of a configuration. written_in : by quantity, the unit in which results show it.
    labelled : makes the coordinates of cells that people list.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    along: Mapping[str, tuple[int, Floats]] = field(default_factory=dict)
    listed: Parameters = field(default_factory=dict)
    measured: Mapping[str, float] = field(default_factory=dict)
    coords: tuple[Coordinate, ...] = ()
    written_in: Mapping[str, str] = field(default_factory=dict)
    labelled: Callable[[], dict[str, xr.Variable]] | None = None

    @classmethod
    def of(cls, parameters: Parameters) -> Cells:
        """A list of cells along one dimension."""
        return cls(("cell",), (parameters["mass"].size,), listed=parameters)

    @property
    def size(self) -> int:
        """Number of cells."""
        return prod(self.shape)

    def __getitem__(self, part: slice) -> Parameters:
        """The parameters of a range of cells.

        Returns every name of `PARAMETERS`, and those of extensions that are given, in SI. Raises IndexError
        for cells that there are not.
        """
        start, stop = part.start or 0, self.size if part.stop is None else part.stop
        if not 0 <= start <= stop <= self.size:
            raise IndexError(f"cells {start} to {stop} of {self.size}")
        if self._is_list:
            whole = start == 0 and stop == self.size
            return dict(self.listed) if whole else {name: values[start:stop] for name, values in self.listed.items()}
        return self.take(np.arange(start, stop, dtype=np.int64))

    def take(self, numbers: NDArray[Any], **changed: Floats) -> Parameters:
        """The parameters of the cells of these numbers, in any order, some quantities being others."""
        points = np.unravel_index(numbers, self.shape) if self.along else ()
        known = {name: np.full(numbers.size, value) for name, value in (*self.fixed.items(), *self.measured.items())}
        known |= {name: values[points[dimension]] for name, (dimension, values) in self.along.items()}
        known |= {name: values[numbers] for name, values in self.listed.items()}
        return parameters_of(known | changed)

    def pick(self, numbers: NDArray[np.int64]) -> Cells:
        """The cells of these numbers, as a list."""
        points = np.unravel_index(numbers, self.shape) if self.along else ()
        listed = {name: values[points[dimension]] for name, (dimension, values) in self.along.items()}
        listed |= {name: values[numbers] for name, values in self.listed.items()}
        return Cells(("cell",), (numbers.size,), self.fixed, listed=listed, measured=self.measured)

    def without(self, *names: str) -> Cells:
        """The cells with these quantities left open; `take` is to be given them."""
        labelled = self.labelled
        return replace(
            self,
            fixed={name: value for name, value in self.fixed.items() if name not in names},
            listed={name: values for name, values in self.listed.items() if name not in names},
            labelled=labelled and (lambda: {name: v for name, v in labelled().items() if name not in names}),
        )

    @property
    def _is_list(self) -> bool:
        return not (self.fixed or self.along or self.measured or MEASURED.keys() & self.listed.keys())


def parameters_of(quantities: Mapping[str, Floats]) -> Parameters:
    """The parameters of cells whose quantities these are; of a curve they follow from what is measured of it."""
    known = dict(quantities)
    for model in MODELS:
        known = model.completed(known)
    return {name: known[name] for name in _NAMES if name in known}


def taken(cells: Parameters, which: NDArray[Any] | slice) -> Parameters:
    """The cells of these numbers, of this mask or in this range."""
    return {name: values[which] for name, values in cells.items()}


# --- lists of cells as people give them -------------------------------------------------------------------------------


def as_cells(given: Mapping[str, Any] | xr.Dataset, contact: str = "stribeck") -> Parameters:
    """Every parameter that cells of a law have, as float64 arrays, all of one length.

    given : numbers or arrays in SI by parameter name, or texts with units, broadcast against each other and flattened;
        of a Dataset, the variables and coordinates that carry names of parameters. contact : one of `models.LAWS`.
    Raises TypeError for names or values of the wrong kind, ValueError for missing or impossible values.
    """
    named, model = {**coefficients_of(contact), **named_values(given)}, model_of(contact)
    known = PARAMETERS_OF[model]
    check_names(named, known)
    if missing := [row for name, row in known.items() if name not in named and row.default is None]:
        raise ValueError(f"{missing[0].name} is missing ({missing[0].long_name}, {missing[0].units})")
    arrays = {name: _checked(row, named[name]) if name in named else np.array(row.default, np.float64)
              for name, row in known.items()}  # fmt: skip
    rules = _of_cells(model.rules.get(contact, ()))
    # numbers are quicker than arrays of one
    plain = {name: values if values.ndim else values.item() for name, values in arrays.items()}
    try:
        shape = np.broadcast_shapes(*{value.shape for value in arrays.values()})
    except ValueError:
        sizes = ", ".join(f"{name} {value.shape}" for name, value in arrays.items() if value.ndim)
        raise ValueError(f"the parameters do not fit together; their shapes are {sizes}") from None
    cells = {name: (values if values.shape == shape else np.broadcast_to(values, shape)).reshape(-1)
             for name, values in arrays.items()}  # fmt: skip
    for rule in rules:
        if rule.breaks(plain):
            i = int(np.argmax(rule.is_broken(rule.margin(cells), cells)))
            cell = {name: float(values[i]) for name, values in cells.items()}
            expected = rule.expected(cell)
            raise ValueError(f"{rule.name}[{i}]: got {cell[rule.name]:g}, expected {expected}: {rule.why}")
    return cells


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


def named_values(given: Mapping[str, Any] | xr.Dataset) -> dict[str, Any]:
    """Values by name; xarray is known where there is a Dataset."""
    xarray = sys.modules.get("xarray")
    if not (xarray and isinstance(given, xarray.Dataset)):
        return dict(given)  # type: ignore[arg-type]
    names = [str(name) for name in given.variables if name in PARAMETERS]
    return dict(zip(names, xarray.broadcast(*(given[name] for name in names)), strict=True))


def check_names(named: Iterable[str], known: Mapping[str, Parameter] = PARAMETERS) -> None:
    """Raises TypeError for a name of no parameter."""
    for name in (name for name in named if name not in known):
        if len(laws := laws_with(str(name))) < len(laws_with("mass")):
            shipped = [law for law in laws if law in LAWS]
            raise TypeError(f"{name!r} is not a parameter of cells of this law, but of {listed(shipped)}")
        hint = or_meant(str(name), known, otherwise=f"; known are {', '.join(known)}")
        raise TypeError(f"{name!r} is not a parameter of a cell{hint}")


def _checked(parameter: Parameter, value: Any) -> NDArray[np.float64]:
    """The values of a parameter in SI, within its bounds. NaN is allowed only where it means "absent"."""
    if type(value) in (float, int) and abs(value) < _LARGEST and parameter.allows(value):
        return np.array(value, np.float64)  # what most give, which the rest takes a moment to find out
    values = numbers_of(parameter, value)
    wrong = ~np.asarray(parameter.allows(values))
    if wrong.any():
        place = tuple(np.argwhere(wrong)[0])
        raise ValueError(f"{parameter.name}{_at(place)}: got {values[place]:g}, expected {parameter.expected}")
    return values


def numbers_of(parameter: Parameter, value: Any) -> NDArray[np.float64]:
    """The values of a parameter in SI, whatever holds them. Raises TypeError for what is no number, ValueError for
    another unit."""
    unit, inside = units.said_by(value), units.without_unit(value)
    expected = "a number or an array of numbers"
    if parameter.units != "1":
        expected += f" in {parameter.units}, or texts such as {units.example(parameter.units)!r}"
    if has_missing(inside):
        raise TypeError(f"{parameter.name}: got masked or missing values, expected {expected}; "
                        "leave these cells out, or fill them")  # fmt: skip
    mixed = isinstance(inside, list | tuple) and any(isinstance(item, str) for item in inside)
    try:
        array = np.asarray(inside, object if mixed else None)
    except (ValueError, TypeError):  # lists of different lengths, or of quantities
        raise TypeError(f"{parameter.name}: got {value!r}, expected {expected}") from None
    if array.dtype.kind in "iuf":
        return _in_si(parameter, array, unit)
    numbers = np.empty(array.shape)  # of which some are texts with units of their own, or words such as `none`
    try:
        items = units.each_with_unit(array.ravel().tolist(), parameter.units if unit is None else "1")
    except QuantityError as error:
        raise ValueError(f"{parameter.name}: got {value!r}, expected {error.expected}") from None
    for place, item in zip(np.ndindex(array.shape), items, strict=True):
        if isinstance(item, bool) or not isinstance(item, int | float | str):
            raise TypeError(f"{parameter.name}: got {value!r}, expected {expected}")
        try:
            is_text = isinstance(item, str)
            numbers[place] = parameter.read(item) if is_text else _in_si(parameter, np.array(item), unit)
        except QuantityError as error:
            instead = f" ({error.kind})" if error.kind else ""
            raise ValueError(f"{parameter.name}{_at(place)}: got {item!r}{instead}, {error}") from None
        except OverflowError:
            raise ValueError(f"{parameter.name}{_at(place)}: got {item!r}, expected {parameter.expected}") from None
    return numbers


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


def _at(place: Iterable[Any]) -> str:
    """A place in an array as one writes it; nothing for a single number."""
    inside = ", ".join(map(str, place))
    return f"[{inside}]" if inside else ""


def scales_of(given: Mapping[str, ArrayLike]) -> Scales:
    """The scales of cells of which some quantities are given, in SI: the others are at their defaults, or NaN.

    Mass, stiffness and load of an oscillator are asked of `Scales` alone: further parameters may add to them.
    """
    cells = {name: given.get(name, np.nan if row.default is None else row.default) for name, row in PARAMETERS.items()}
    return Scales({name: np.asarray(value, np.float64) for name, value in cells.items()})
