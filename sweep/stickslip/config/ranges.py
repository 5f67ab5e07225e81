"""Several values of one quantity, as a file or a call gives them."""

from typing import Any

from stickslip.config.sections import finite, refused
from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter, Variable


def each_with_unit(row: Parameter | Variable, given: Any) -> Any:
    """Values of a row of the vocabulary, as `units.each_with_unit` has them."""
    try:
        return units.each_with_unit(given, row.units)
    except QuantityError as error:
        raise refused(error.expected) from None


def interval(row: Parameter, value: object) -> tuple[float, float]:
    """Both ends of a range of a row of the vocabulary, in SI and in order."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise refused("a list of two values, the lower end first")
    low, high = (finite(row, end) for end in each_with_unit(row, value))
    if not low < high:
        raise refused("the lower end first and the upper above it", "swap the ends" if low > high else None)
    return low, high
