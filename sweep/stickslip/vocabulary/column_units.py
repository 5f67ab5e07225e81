"""Units in the headings of tables, as instruments and people spell them: ``mm per second``, ``mm.s-1``, ``mm/Sek``.

Stricter than `units.py` about symbols: only those below are units of a column, so that a stray word is never one
(pint knows c, t and mu), and nobody measures in Mm/s, which is a slip for mm/s.
"""

import re
from functools import lru_cache

from stickslip.errors import QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.unit_suggestions import SPELLED, suggest_unit

_SYMBOLS = frozenset(
    "m dm cm mm µm μm um nm km in ft s ms µs μs us min h N kN daN dN cN mN µN μN uN kgf gf lbf gravity Hz kHz".split()
)
_WORD = re.compile(r"[^\W\d_]+")
_NAME = re.compile(r"[^\W\d_]+|[°%Ω]")
_BRACED = re.compile(r"(?:\^|\*\*)?[({]\s*([-+]?\d)\s*[)}]")  # s^(-1), s^{-1}
_TOGETHER = re.compile(r"(?<![^\W\d_])([kdcmµμun]?m|in)s(?=(?:\^|\*\*)?-)")  # mms-1, ms-2
_POINT = re.compile(r"(?<=[^\W_])\s*\.\s*(?=[^\W\d_])")  # mm.s-1
_KINDS = ("m s-1", "s", "N", "m", "m s-2")


def column_unit(text: str, of: str) -> str:
    """A unit as a heading spells it, as `units.si_value` reads it.

    Parameters
    ----------
    text : str
        What stands in the brackets, or behind the name.
    of : str
        The SI units of the column, such as ``m s-1``.

    Returns
    -------
    str
        The unit in plain symbols: ``mm/s``.

    Raises
    ------
    QuantityError
        Where this is no unit, or one of something else.
    """
    plain = _in_symbols(text)
    if of == "m s-2" and plain in ("g", "gn"):  # of accelerometers; no mass is meant in such a column
        plain = "gravity"
    strange, wrong = _strange(plain), _wrong(plain, of)
    if not strange and wrong is None:
        return plain
    meant = suggest_unit(plain, lambda other: not _strange(other) and _wrong(other, of) is None) if strange else None
    unknown = f"no unit is called '{strange[0]}'" if strange else f"'{text}' is not a unit"
    hint = f"{text} is a unit of {wrong.kind}" if wrong and wrong.kind else unknown
    raise QuantityError(f"the unit of {units.kind(of)}", f"did you mean {meant}?" if meant else hint,
                        wrong.kind if wrong else None)  # fmt: skip


@lru_cache(maxsize=4096)
def is_column_unit(text: str, of: str = "") -> bool:
    """True for a unit of a column in these SI units; of any that a table may have where they are not given."""
    for kind in (of,) if of else _KINDS:
        try:
            column_unit(text, kind)
        except QuantityError:
            continue
        return bool(text)
    return False


def _in_symbols(text: str) -> str:
    """A unit with its words replaced by symbols, and powers and products as `units.py` reads them."""
    plain = _BRACED.sub(r"^\1", text.translate(units.AS_TYPED).replace("_", " ").strip().rstrip("."))
    plain = _WORD.sub(lambda word: SPELLED.get(word[0].lower(), word[0]), plain)
    plain = _TOGETHER.sub(r"\1 s", _POINT.sub(" ", plain))
    return " ".join(re.sub(r"\s*/\s*", "/", plain).split())


def _strange(plain: str) -> list[str]:
    """The names in a unit that are no units of columns."""
    return [name for name in _NAME.findall(plain) if name not in _SYMBOLS]


def _wrong(plain: str, of: str) -> QuantityError | None:
    """Why a unit is none of this kind."""
    try:
        units.si_value(f"1 {plain}", of)
    except QuantityError as error:
        return error
    return None
