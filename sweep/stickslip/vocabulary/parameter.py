"""Numbers that people give: names, units, bounds, and reading them; and what comes out."""

import math
from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Any, TypeVar

from stickslip.errors import QuantityError
from stickslip.vocabulary import units

NAN = float("nan")

# The largest magnitudes that are plausible, in SI. Sliding contacts reach 30 m/s in brakes; friction falls within
# millimetres per second, and within a metre per second at most. Rubber on rough ground and clean metals in vacuum have
# more friction.
SPEED, FALL, FRICTION = 30.0, 1.0, 1.5


@dataclass(frozen=True)
class Parameter:
    """One row of the tables: an input of a cell, a setting, a column of a file; in SI.

    long_name : what it is, for datasets, schema and help. section : of the configuration, where it has one.
    default : what holds when nothing is said; None: it must be given; NaN: "absent".
    above, at_least, at_most : bounds; `above` itself is not allowed. whole : only whole numbers.
    word : what people write for NaN. absent : what holds then.
    plausible : the largest magnitude of a number without a unit that is taken as given.
    synonyms : what others call it, words between spaces; they are suggested from, never read.
    """

    name: str
    units: str
    long_name: str
    section: str
    _: KW_ONLY
    default: float | None = None
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    whole: bool = False
    word: str | None = None
    absent: str | None = None
    plausible: float | None = None
    synonyms: str = ""

    @property
    def may_be_absent(self) -> bool:
        """True if NaN is a value."""
        return self.default is not None and math.isnan(self.default)

    @property
    def expected(self) -> str:
        """The allowed values: ``a mass above 0 kg``, ``a whole number from 1 to 64``, with the word for NaN."""
        kind = "a whole number" if self.whole else units.kind(self.units)
        bounds = self.bounds
        if self.at_least is not None and self.at_most is not None:
            bounds = f"from {_spelled(self.at_least)} to {_spelled(self.at_most)}"
        if not bounds:
            kind, bounds = "a finite number", "" if self.units == "1" else "in"
        return f"{kind} {bounds} {units.spelled(self.units)}".rstrip() + self.otherwise

    @property
    def bounds(self) -> str:
        """The bounds in words, without unit; nothing where there are none."""
        bounds = (("above", self.above), ("of at least", self.at_least), ("of at most", self.at_most))
        return " and ".join(f"{words} {_spelled(bound)}" for words, bound in bounds if bound is not None)

    @property
    def otherwise(self) -> str:
        """The word for NaN, as the end of a sentence."""
        return f", or {self.word}" if self.word else ""

    def allows(self, values: Any) -> Any:
        """True where a number, or a number of an array, is within the bounds; NaN is if it may be absent."""
        allowed = abs(values) < math.inf
        if self.above is not None:
            allowed &= values > self.above
        if self.at_least is not None:
            allowed &= values >= self.at_least
        if self.at_most is not None:
            allowed &= values <= self.at_most
        return allowed | (values != values) if self.may_be_absent else allowed

    def read(self, value: object) -> float:
        """A number in SI within the bounds from a number, a text with a unit, or the word for NaN.

        Raises QuantityError.
        """
        if self.word is not None and value == self.word:
            return NAN
        if self.whole:
            if isinstance(value, bool) or not isinstance(value, int | float) or not self.allows(value):
                raise QuantityError(self.expected)
            if value != int(value):
                raise QuantityError(self.expected)
            return int(value)
        try:
            number = units.si_value(value, self.units)
        except QuantityError as error:
            raise QuantityError(error.expected + self.otherwise, error.hint, error.kind) from None
        if not self.allows(number):
            raise QuantityError(self.expected)
        return number

    def written(self, value: float) -> float | str:
        """A value as `read` takes it: the word for NaN."""
        return self.word if self.word is not None and math.isnan(value) else value

    def range_text(self, ends: tuple[float, float]) -> str:
        """`0.01 to 1.2 m/s`."""
        return f"{ends[0]:.6g} to {ends[1]:.6g} {units.spelled(self.units)}".rstrip()

    def setting(self, value: float) -> str:
        """A value as a setting: its shortest exact spelling in SI with its unit, or the word for its absence."""
        written = self.written(value)
        if isinstance(written, str):
            return written
        return repr(written) if self.units == "1" else str(self.in_file(written))

    def in_file(self, value: float) -> float | str:
        """A number in SI as a file may have it beside numbers in other units: with its unit, if it has one."""
        return value if self.units == "1" else f"{value!r} {units.spelled(self.units)}"


@dataclass(frozen=True)
class Variable:
    """One output per cell.

    when : "always"; "regime" for those that are known with the regime, however the motion goes on; or "full" for those
        that only a run to the horizon (early_stop=False) defines.
    comment : what the long name does not say, or nothing. dims : of the result of a study, beyond those of its cells.
    units : "parameter" stands for those of the parameter of a study, "flag" for those of a regime.
    """

    name: str
    units: str
    long_name: str
    when: str = "always"
    comment: str = ""
    dims: tuple[str, ...] = ()


Row = TypeVar("Row", Parameter, Variable)


def table(*rows: Row) -> dict[str, Row]:
    """Rows by name."""
    return {row.name: row for row in rows}


def of_section(section: str, rows: Iterable[Parameter]) -> dict[str, Parameter]:
    """Those rows of a table that stand in a section of the configuration."""
    return table(*(row for row in rows if row.section == section))


def _spelled(bound: float) -> str:
    return str(bound) if isinstance(bound, int) else f"{bound:g}"
