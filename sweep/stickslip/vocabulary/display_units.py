"""Units for people: 5 N/mm rather than 5000 N/m, 250 g rather than 0.25 kg; or that somebody wrote.

The only table of such units. Files, Python and all computation are in SI.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from typing import TYPE_CHECKING, Any

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import ArrayLike

DISPLAY = "display_units"  # attribute of coordinates and variables, which are SI: the unit in which they are shown
_SYMBOLS = ("mu_", "v_", "D_")  # how names begin that are symbols, not words
_CUSTOMARY = {  # by unit in SI: from which magnitude on, in SI, another one is used, how large it is, and its name
    "kg": ((1e-6, 1e-6, "mg"), (1e-3, 1e-3, "g"), (1.0, 1.0, ""), (1e3, 1e3, "t")),
    "N m-1": ((0.0, 1.0, ""), (100.0, 1e3, "N/mm"), (1e6, 1e6, "kN/mm")),
    "N s m-1": ((0.0, 1.0, ""), (1e3, 1e3, "N s/mm")),
    "N": ((1e-3, 1e-3, "mN"), (1.0, 1.0, ""), (1e3, 1e3, "kN"), (1e6, 1e6, "MN")),
    "m s-1": ((0.0, 1e-6, "µm/s"), (1e-3, 1e-3, "mm/s"), (1.0, 1.0, "")),
    "m": ((0.0, 1e-6, "µm"), (1e-4, 1e-3, "mm"), (1.0, 1.0, "")),
    "s": ((0.0, 1e-6, "µs"), (1e-3, 1e-3, "ms"), (1.0, 1.0, ""), (120.0, 60.0, "min"), (7200.0, 3600.0, "h")),
    "J": ((0.0, 1e-6, "µJ"), (1e-3, 1e-3, "mJ"), (1.0, 1.0, "")),
    "m-1": ((0.0, 1e3, "1/mm"),),
    "s-1": ((0.0, 1.0, ""), (1e3, 1e3, "kHz"), (1e6, 1e6, "MHz")),
}
# By unit in SI: the one in which people of the field give most values, and often forget to write.
LIKELY = {"kg": "g", "m": "mm", "m s-1": "mm/s", "N m-1": "N/mm"}


@dataclass(frozen=True)
class Unit:
    """A unit of display. name : as people type it, nothing for pure numbers. size : what one of it is in SI."""

    name: str = ""
    size: float = 1.0

    def of(self, values: Any) -> Any:
        """Numbers in SI as numbers in this unit."""
        return values if self.size == 1.0 else values / self.size

    def to_si(self, values: Any) -> Any:
        """Numbers in this unit as numbers in SI."""
        return values if self.size == 1.0 else values * self.size

    def text(self, value: float, digits: int = 6) -> str:
        """A value in SI as text, with the unit as people type it."""
        return f"{self.of(value):.{digits}g} {self.name}".rstrip()


def unit_for(si: str, values: ArrayLike, written: str | None = None) -> Unit:
    """The unit for numbers in SI: the one they were written in, else the customary one for the largest of them."""
    import numpy as np  # here, since the command line needs the table alone

    if written is not None:
        return Unit(written, units.factor(written, si))
    sizes = np.abs(np.asarray(values, np.float64))
    return _customary_unit(si, float(np.max(sizes, where=np.isfinite(sizes), initial=0.0)))


def number(value: float, digits: int = 4) -> str:
    """A number with as many digits as are read at a glance; a dash where there is none."""
    if not isfinite(value):
        return "–" if value != value else ("∞" if value > 0 else "-∞")
    return f"{value:.{digits}g}"


def quantity(value: float, si: str) -> str:
    """A single value in SI, in the unit that suits it; a dash where there is none."""
    unit = _customary_unit(si, abs(value) if isfinite(value) else 0.0)
    return number(value) if value != value else f"{number(unit.of(value))} {unit.name}".rstrip()


def _customary_unit(si: str, magnitude: float) -> Unit:
    rows = [row for row in _CUSTOMARY.get(si, ()) if magnitude >= row[0]] if magnitude else []
    size, name = rows[-1][1:] if rows else (1.0, "")
    return Unit(name or ("Hz" if si == "s-1" else units.spelled(si)), size)


def spoken(name: str) -> str:
    """The name of a quantity as people write it: `belt speed`, but `mu_stop` as in a configuration."""
    return name if name.startswith(_SYMBOLS) else name.replace("_", " ")


# --- units that people wrote ------------------------------------------------------------------------------------------


def written_units(data: Any) -> dict[str, str]:
    """By quantity, the first unit it has in the plain data of a configuration that is right, as it is written there.

    A quantity is given in one place, its range may be in another (what is searched along a border, say). Plain numbers
    are SI, and in no unit of their own.
    """
    written: dict[str, str] = {}
    for name, value in _given(data):
        if name not in written and QUANTITIES[name].units != "1" and (unit := _first_unit(value)):
            written[name] = unit
    return written


def units_shown(ds: xr.Dataset) -> dict[str, str]:
    """The units that `written_units` read from what a result was computed from, as its file has them."""
    shown = {
        str(name): str(coordinate.attrs[DISPLAY])
        for name, coordinate in ds.coords.items()
        if DISPLAY in coordinate.attrs
    }
    along = ds.attrs.get("border_parameter")
    if along is not None and DISPLAY in ds["border"].attrs:
        shown[str(along)] = str(ds["border"].attrs[DISPLAY])
    return shown


def _given(data: Any) -> Iterator[tuple[str, Any]]:
    """Quantities by name with what is given for them, anywhere."""
    if isinstance(data, list | tuple):  # of observations
        for part in data:
            yield from _given(part)
    if not isinstance(data, Mapping):
        return
    for key, value in data.items():
        if key in QUANTITIES:
            yield key, value
        else:
            yield from _given(value)
    if data.get("along") in QUANTITIES:  # a border, whose range stands beside it
        yield data["along"], data.get("between")


def _first_unit(value: Any) -> str | None:
    """The first unit in a value, a list of values, or the values of a mapping."""
    if isinstance(value, str):
        return units.unit_in(value)
    inner = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return next((unit for part in inner if (unit := _first_unit(part))), None)


# --- units in the headings of tables ----------------------------------------------------------------------------------

# As instruments and people spell them: ``mm per second``, ``mm.s-1``, ``mm/Sek``. Only the symbols below are units of a
# column, so that a stray word is never one (pint knows c, t and mu), and nobody measures in Mm/s, a slip for mm/s.
_OF_COLUMNS = frozenset(
    "m dm cm mm µm μm um nm km in ft s ms µs μs us min h N kN daN dN cN mN µN μN uN kgf gf lbf gravity Hz kHz".split()
)
GRAMS_FORCE = ("g", "grf", "gf")
_NAME = re.compile(r"[^\W\d_]+|[°%Ω]")
_BRACED = re.compile(r"(?:\^|\*\*)?[({]\s*([-+]?\d)\s*[)}]")  # s^(-1), s^{-1}
_TOGETHER = re.compile(r"(?<![^\W\d_])([kdcmµμun]?m|in)s(?=(?:\^|\*\*)?-)")  # mms-1, ms-2
_POINT = re.compile(r"(?<=[^\W_])\s*\.\s*(?=[^\W\d_])")  # mm.s-1
_COLUMNS = ("m s-1", "s", "N", "m", "m s-2")


def column_unit(text: str, of: str) -> str:
    """A unit as a heading spells it, in plain symbols: ``mm/s``. of : the SI units of the column, such as ``m s-1``.

    Raises QuantityError where this is no unit, or one of something else.
    """
    plain = _in_symbols(text)
    if of == "m s-2" and plain in ("g", "gn"):  # of accelerometers; no mass is meant in such a column
        plain = "gravity"
    if of == "N" and plain in GRAMS_FORCE:  # of load cells; no mass is meant in such a column
        plain = "gf"
    strange, wrong = _strange(plain), _wrong(plain, of)
    if not strange and wrong is None:
        return plain
    meant = (
        units.suggest_unit(plain, lambda other: not _strange(other) and _wrong(other, of) is None) if strange else None
    )
    unknown = f"no unit is called '{strange[0]}'" if strange else f"'{text}' is not a unit"
    hint = f"{text} is a unit of {wrong.kind}" if wrong and wrong.kind else unknown
    raise QuantityError(f"the unit of {units.kind(of)}", f"did you mean {meant}?" if meant else hint,
                        wrong.kind if wrong else None)  # fmt: skip


@lru_cache(maxsize=4096)
def is_column_unit(text: str, of: str = "") -> bool:
    """True for a unit of a column in these SI units; of any that a table may have where they are not given."""
    for kind in (of,) if of else _COLUMNS:
        try:
            column_unit(text, kind)
        except QuantityError:
            continue
        return bool(text)
    return False


def _in_symbols(text: str) -> str:
    """A unit with its words replaced by symbols, and powers and products as `units.py` reads them."""
    plain = _BRACED.sub(r"^\1", text.translate(units.AS_TYPED).replace("_", " ").strip().rstrip("."))
    plain = re.sub(r"[^\W\d_]+", lambda word: units.SPELLED.get(word[0].lower(), word[0]), plain)
    plain = _TOGETHER.sub(r"\1 s", _POINT.sub(" ", plain))
    return " ".join(re.sub(r"\s*/\s*", "/", plain).split())


def _strange(plain: str) -> list[str]:
    """The names in a unit that are no units of columns."""
    return [name for name in _NAME.findall(plain) if name not in _OF_COLUMNS]


def _wrong(plain: str, of: str) -> QuantityError | None:
    """Why a unit is none of this kind."""
    try:
        units.si_value(f"1 {plain}", of)
    except QuantityError as error:
        return error
    return None
