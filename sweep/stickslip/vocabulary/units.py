"""Quantities: a number in SI, or a text with a unit such as "10 mm/s".

Pint knows the units, behind a guard that is stricter than its parser, which reads "1,5 mm" as 15 mm: this module splits
number and unit itself and asks pint for single unit names only. The plainest units are a table here, which says what
pint says: importing pint and reading its registry take longer than a map of many thousand cells.

Units are spelled as in `quantities.py` ("m s-1").
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache
from tokenize import TokenError
from typing import TYPE_CHECKING, Any

from stickslip.errors import QuantityError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_LONGEST = 60  # characters of a quantity; more is nonsense, and Fraction would compute with them all
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?(?![\d.])"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*", re.ASCII | re.DOTALL)
_FACTOR = re.compile(r"\s*([*/·]?)\s*([A-Za-zµμΩ°%]+)(?:(?:\^|\*\*)?([-+]?[0-9])(?![0-9.]))?")

AS_TYPED = str.maketrans({  # what keyboards and word processors put for plain characters
    "\u00a0": " ", "\u2009": " ", "\u202f": " ", "\u2212": "-", "\u2011": "-", "\u2013": "-", "\u22c5": "·",
    "\u2219": "·", "\u2215": "/", "\u2044": "/", "⁻": "-", "⁰": "0", "¹": "1", "²": "2", "³": "3", "⁴": "4",
})  # fmt: skip

_POWERED = re.compile(r"(.*?)(-?\d+)?", re.DOTALL)  # a name and its power, in the units of `quantities.py`
# pint.UndefinedUnitError is the first; nan and inf are others
_NO_UNIT = (AttributeError, ValueError, OverflowError, KeyError, AssertionError, TokenError)

_KINDS = {  # by unit: what such a quantity is, and how one writes it
    "kg": ("a mass", "250 g"),
    "N m-1": ("a stiffness", "5 N/mm"),
    "N s m-1": ("a damping coefficient", "0.5 N s/m"),
    "N": ("a force", "10 N"),
    "m s-1": ("a speed", "10 mm/s"),
    "s m-1": ("a slope over speed", "0.1 s/m"),
    "m": ("a length", "10 mm"),
    "s": ("a time", "2 min"),
    "m s-2": ("an acceleration", "50 mm/s2"),
    "s-1": ("a frequency", "2 kHz"),
}
_MICRO, _MILLI, _CENTI = Fraction(1, 10**6), Fraction(1, 1000), Fraction(1, 100)
_ONE, _KILO = Fraction(1), Fraction(1000)
_PLAIN = {  # in SI base units: the factor; powers of metre, kilogram and second
    "m": (_ONE, (1, 0, 0)), "cm": (_CENTI, (1, 0, 0)), "mm": (_MILLI, (1, 0, 0)), "km": (_KILO, (1, 0, 0)),
    "g": (_MILLI, (0, 1, 0)), "kg": (_ONE, (0, 1, 0)), "s": (_ONE, (0, 0, 1)), "ms": (_MILLI, (0, 0, 1)),
    "N": (_ONE, (1, 1, -2)), "kN": (_KILO, (1, 1, -2)), "Hz": (_ONE, (0, 0, -1)), "kHz": (_KILO, (0, 0, -1)),
    "µm": (_MICRO, (1, 0, 0)), "µs": (_MICRO, (0, 0, 1)),
}  # fmt: skip
_OTHER_KINDS = {  # what else people may write by mistake
    "m2": "an area", "Pa": "a pressure", "J": "an energy or a torque", "W": "a power", "kg s": "a mass times a time",
    "K": "a temperature",
}  # fmt: skip


def si_value(value: object, units: str) -> float:
    """`value` as a finite number in the SI `units`.

    value : a number, which is SI already, or a text of a decimal number and a unit. A quantity without unit ("1") is
    a number, never a text. The result is the double nearest to what was written ("0.7 mm" is 0.0007).
    Raises QuantityError.
    """
    if isinstance(value, str):
        return _from_text(value, units)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise QuantityError(expected(units))
    try:
        number = float(value)
    except OverflowError:  # an integer of hundreds of digits
        number = math.inf
    if not math.isfinite(number):
        raise QuantityError(f"a finite number in {spelled(units)}".removesuffix(" in "))
    return number


def said_by(array: Any) -> str | None:
    """The unit that an array says it has: that of a quantity of Pint, also inside a DataArray, or `units` among the
    attributes of the latter; None if it says nothing.
    """
    if (quantity := _quantity_in(array)) is not None:
        return f"{quantity.units:~C}"
    unit = getattr(array, "attrs", {}).get("units")
    return None if unit is None else str(unit)


def without_unit(array: Any) -> Any:
    """The numbers of a quantity of Pint, also inside a DataArray; anything else as it is."""
    quantity = _quantity_in(array)
    return array if quantity is None else quantity.magnitude


def _quantity_in(array: Any) -> Any:
    """The quantity of Pint that a value is, or holds; None for others."""
    inside = array.data if hasattr(array, "attrs") and hasattr(array, "data") else array
    return inside if hasattr(inside, "magnitude") and hasattr(inside, "units") else None


def si_array(values: NDArray[np.float64], unit: str, units: str) -> NDArray[np.float64]:
    """Numbers in `unit`, as people write it, in the SI `units`. Raises QuantityError.

    A decimal fraction of a unit divides, so that 0.7 mm is the double nearest to 0.0007.
    """
    if units == "1":
        if unit not in ("", "1"):
            raise QuantityError(expected(units))
        return values
    factor = _factor(unit, units)
    return values * float(factor.numerator) / float(factor.denominator)


def expected(units: str) -> str:
    """The text to write for a quantity of these units: ``a speed such as '10 mm/s' or a number in m/s``."""
    if units == "1":
        return "a number (without unit)"
    if units not in _KINDS:  # of a file of others
        return f"a number in {spelled(units)}"
    kind, example = _KINDS[units]
    return f"{kind} such as '{example}' or a number in {spelled(units)}"


def kind(units: str) -> str:
    """The kind of a quantity of these units: ``a speed``."""
    return "a number" if units == "1" else _KINDS[units][0]


def example(units: str) -> str:
    """A text that is such a quantity: ``10 mm/s``. KeyError for "1", which is never a text."""
    return _KINDS[units][1]


def spelled(units: str) -> str:
    """Units for people: ``m s-1`` becomes ``m/s``; nothing for pure numbers."""
    if units == "1":
        return ""
    over: list[str] = []
    under: list[str] = []
    for name, power in _factors(units):
        (over if power > 0 else under).append(name + (str(abs(power)) if abs(power) != 1 else ""))
    return "/".join([" ".join(over) or "1", *under])


def unit_in(text: str) -> str | None:
    """The unit in a text of a number and a unit, as it is written; None where there is none."""
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    return (match[2] or None) if match else None


def factor(unit: str, units: str) -> float:
    """The factor that takes a number in `unit` to the SI `units`. Raises QuantityError."""
    return float(_factor(unit, units))


def _from_text(text: str, units: str) -> float:
    text = text.translate(AS_TYPED)
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
    if match is None:
        missing = f"the number is missing: '1 {text.strip()}'" if _fits(text.strip(), units) else None
        raise QuantityError(expected(units), missing)
    number, unit = match.groups()
    if unit.startswith(","):
        raise QuantityError(expected(units), "write a decimal point, not a comma")
    if not unit or units == "1":
        hint = "leave the unit out: this quantity has none" if unit else f"remove the quotes: {number}"
        raise QuantityError(expected(units), f"write {float(number) / 100:g}" if unit == "%" else hint)
    try:
        factor = _factor(unit, units)
    except QuantityError as error:
        if meant := suggest_unit(unit, lambda other: _fits(other, units)):
            raise QuantityError(error.expected, f"did you mean '{number} {meant}'?", error.kind) from None
        raise
    try:
        return float(Fraction(number) * factor)
    except OverflowError:
        raise QuantityError(f"a finite number in {spelled(units)}".removesuffix(" in ")) from None


# --- units ------------------------------------------------------------------------------------------------------------


def _factors(units: str) -> list[tuple[str, int]]:
    """Units of `quantities.py` as names with powers: ``m s-1`` is m to the 1, s to the -1."""
    matches = (_POWERED.fullmatch(word) for word in units.split())
    return [(match[1], int(match[2] or 1)) for match in matches if match]


@lru_cache(maxsize=256)  # lists hold thousands of values in one unit
def _factor(unit: str, units: str) -> Fraction:
    """The exact factor that takes a number in `unit`, as people write it, to the SI `units`."""
    if units not in _KINDS and not all(_is_known(name) for name, _ in _factors(units)):  # in a file of others
        raise QuantityError(expected(units), f"'{units}' is no unit that is known")
    powers = _written_factors(unit, units)
    plain, target = _plain_product(powers), _plain_product(_factors(units))
    if plain and target and plain[1] == target[1]:
        return plain[0] / target[0]
    try:
        written = _product(_all_units(), powers)
    except _NO_UNIT:
        unknown = next(name for name, _ in powers if not _is_known(name))
        raise QuantityError(expected(units), f"no unit is called '{unknown}'") from None
    declared = _product(_all_units(), _factors(units))
    if written.dimensionality != declared.dimensionality:
        raise QuantityError(expected(units), kind=_kind_of(written))
    import pint

    try:
        return Fraction(_all_units().Quantity(Fraction(1), written).to(declared).magnitude)
    except pint.PintError:  # a temperature that cancels, say: its scale has an offset
        raise QuantityError(expected(units), f"'{unit}' is not a plain multiple of {spelled(units)}") from None


def _plain_product(powers: list[tuple[str, int]]) -> tuple[Fraction, tuple[int, ...]] | None:
    """Factor and base units of names with powers; None if one of them is not among the plainest."""
    if any(name not in _PLAIN for name, _ in powers):
        return None
    factor, base = _ONE, tuple[int, ...]((0, 0, 0))
    for name, power in powers:
        size, of = _PLAIN[name]
        factor, base = factor * size**power, tuple(n + power * m for n, m in zip(base, of, strict=True))
    return factor, base


def _written_factors(unit: str, units: str) -> list[tuple[str, int]]:
    """Names and powers in a unit as people write it: factors separated by ``*``, ``/`` or a space."""
    factors, position = [], 0
    while position < len(unit):
        match = _FACTOR.match(unit, position)
        if match is None:
            raise QuantityError(expected(units), f"'{unit}' is not a unit")
        operator, name, power = match.groups()
        factors.append((name, int(power or 1) * (-1 if operator == "/" else 1)))
        position = match.end()
    return factors


def _fits(unit: str, units: str) -> bool:
    try:
        _factor(unit, units)
    except QuantityError:
        return False
    return True


@lru_cache(maxsize=1)
def _all_units() -> Any:
    """Pint's units. Fractions keep conversions exact, so that "0.7 mm" is the double nearest to 0.0007."""
    import pint

    return pint.UnitRegistry(non_int_type=Fraction)


def _is_known(name: str) -> bool:
    try:
        _all_units().Unit(name)
    except _NO_UNIT:
        return False
    return name.isalpha()


def _product(registry: Any, powers: list[tuple[str, int]]) -> Any:
    """The pint unit of names with powers."""
    unit = registry.Unit("")
    for name, power in powers:
        unit = unit * registry.Unit(name) ** power
    return unit


def _kind_of(unit: Any) -> str:
    """The kind of a pint unit, in words."""
    kinds = {units: kind for units, (kind, _) in _KINDS.items()} | _OTHER_KINDS
    for units, words in kinds.items():
        if _product(_all_units(), _factors(units)).dimensionality == unit.dimensionality:
            return words.split(" ", 1)[1]
    if unit.dimensionless:
        return "pure number"
    return " ".join(name + (f"^{power}" if power != 1 else "") for name, power in unit.dimensionality.items())


# --- several values of one quantity -----------------------------------------------------------------------------------


def each_with_unit(given: Any, units: str) -> Any:
    """Values of a quantity in a list or a mapping, where a number without a unit takes that of the next one.

    So [-5, 5 mm/s] is what it reads as. 0 needs none. Raises QuantityError for a number
    that lacks its unit after others that have one.
    """
    if isinstance(given, Mapping):
        return dict(zip(given, each_with_unit([*given.values()], units), strict=True))
    if units == "1" or not isinstance(given, list | tuple):
        return given
    known = [_unit_in_text(value, units) if isinstance(value, str) else None for value in given]
    if not any(known):
        return given
    values, unit = [*given], ""
    for i, value in reversed([*enumerate(values)]):
        unit = known[i] or unit
        if isinstance(value, int | float) and not isinstance(value, bool) and 0 < abs(value) < math.inf:
            if not unit:
                raise QuantityError(f"a unit with {value:g} as well, since others have one")
            values[i] = f"{value} {unit}"
    return values


@lru_cache(maxsize=4096)
def _unit_in_text(text: str, units: str) -> str | None:
    """The unit in a text, if it is one of these quantities."""
    unit = unit_in(text.translate(AS_TYPED))
    return unit if unit and _fits(unit, units) else None


def ends_of(name: str, text: str) -> tuple[float | str, float | str]:
    """The ends of "5..60 mm/s", where the lower one has the unit of the upper one. Raises ValueError."""
    parts = [part.strip() for part in text.split("..")]
    if len(parts) != 2 or not all(parts) or parts[1].startswith(".") or parts[0].endswith("."):
        raise ValueError(f"{name}: got {text!r}, expected a range such as '5..60 mm/s', with two dots between its ends")
    low, high = parts
    unit = high.lstrip("+-.0123456789eE ")
    if is_number(low) and unit:
        return f"{low} {unit}", high
    if is_number(high) and not is_number(low):
        raise ValueError(f"{name}: got {text!r}, whose upper end has no unit; write it as well")
    return float(low) if is_number(low) else low, float(high) if is_number(high) else high


def number_or_text(text: str) -> float | str:
    """A number, in SI, or a text with a unit."""
    return float(text) if is_number(text) else text


def is_number(value: float | str) -> bool:
    """True for a finite number, also as text."""
    try:
        return not isinstance(value, bool) and math.isfinite(float(value))
    except ValueError:
        return False


# --- units as people write them by mistake ----------------------------------------------------------------------------

_COMMON = "kg g mg N kN mN m cm mm µm s ms min h Hz kHz Pa MPa J".split()
SPELLED = {  # words for units, which headings of tables may have
    word: symbol
    for symbol, words in {
        "/": "per pro par",
        "s": "sec secs sek second seconds sekunde sekunden seconde secondes",
        "min": "min mins minute minutes minuten",
        "h": "hour hours stunde stunden heure heures hr hrs",
        "m": "meter meters metre metres metern mètre mètres",
        "cm": "centimeter centimeters centimetre centimetres zentimeter centimètre centimètres",
        "mm": "millimeter millimeters millimetre millimetres millimetern millimètre millimètres",
        "µm": "micrometer micrometers micrometre micrometres micron microns mikrometer micromètre micromètres",
        "km": "kilometer kilometers kilometre kilometres kilomètre kilomètres",
        "in": "inch inches zoll pouce pouces",
        "kg": "kilogram kilograms kilo kgs",
        "g": "gram grams",
        "N": "newton newtons",
        "kN": "kilonewton kilonewtons",
        "mN": "millinewton millinewtons",
        "Hz": "hertz",
    }.items()
    for word in words.split()
}
_MEANT = SPELLED | {word.lower(): word for word in _COMMON} | {"n": "N"}
_WORD = re.compile(r"[A-Za-zµμ]+")
_MOST = 40  # characters; a longer unit is nonsense


def suggest_unit(unit: str, fits: Callable[[str], bool]) -> str | None:
    """The unit that was probably meant: words and capitals as symbols, spaces where none belong; None if none fits.

    fits : whether a unit is understood, and of the right kind.
    """
    if len(unit) > _MOST or not _WORD.match(unit):
        return None
    plain = _WORD.sub(_respelled, re.sub(r"\s+per\s+", "/", unit).rstrip(".,;"))
    tried = (plain, plain.replace(" ", ""), re.sub(r"[\s*·.\-]+", "/", plain), re.sub(r"[\s^]?\d", "", plain))
    return next((text for text in tried if text not in ("", unit) and fits(text)), None)


def _respelled(match: re.Match[str]) -> str:
    """One unit as it is spelled, or two that were written together with a space between them."""
    word = match[0]
    if word in _COMMON or word.lower() in _MEANT:
        return word if word in _COMMON else _MEANT[word.lower()]
    places = range(len(word) - 1, 0, -1)  # mms is mm s rather than m ms
    pairs = (f"{word[:i]} {word[i:]}" for i in places if word[:i] in _COMMON and word[i:] in _COMMON)
    return next(pairs, word)
