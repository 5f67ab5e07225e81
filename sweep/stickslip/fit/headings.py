"""What the columns of a table of points are, by their headings: what people and their instruments call things.

A heading is a name with the unit behind it, in brackets (`v [mm/s]`, `v / (mm/s)`) or bare (`v in mm/s`, `v, mm/s`).
Names are compared without regard to case, hyphens and underscores.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from stickslip.errors import QuantityError
from stickslip.vocabulary import units

_WORDS = {  # by the name of a column in the vocabulary
    "speed": (
        "speed", "velocity", "v", "w", "v rel", "vrel", "sliding speed", "sliding velocity", "slip speed",
        "slip velocity", "relative speed", "relative velocity", "mean speed", "geschwindigkeit", "gleitgeschwindigkeit",
    ),
    "time": (
        "time", "t", "waiting time", "wait", "hold time", "dwell time", "dwell", "contact time", "zeit", "wartezeit",
        "haltezeit",
    ),
    "mu": (
        "mu", "\N{GREEK SMALL LETTER MU}", "cof", "friction", "friction coefficient", "coefficient of friction",
        "friction coeff", "friction coeff.", "coeff. of friction", "cof mean", "mean cof", "mu mean", "traction",
        "traction coefficient", "static friction", "static friction coefficient", "mu s", "mu static",
        "reibwert", "reibzahl", "reibungszahl", "reibungskoeffizient", "reibkoeffizient",
    ),
    "sigma": ("sigma", "\N{GREEK SMALL LETTER SIGMA}", "sd", "std", "stdev", "std dev", "standard deviation"),
}  # fmt: skip
_SPEEDS = ("speed", "velocity", "geschwindigkeit")
MATERIAL_WORDS = ("material", "lubricant", "sample", "specimen", "grease", "oil", "schmierstoff", "probe")
_NOT_FRICTION = frozenset(
    (
        "temperature", "temp", "load", "normal load", "force", "normal force", "friction force", "torque", "pressure",
        "humidity", "rh", "cycle", "cycles", "cycle number", "stroke", "distance", "sliding distance", "position",
        "number", "no", "no.", "nr", "nr.", "#", "n", "index", "point", "step", "line", "row", "date", "comment",
        "remark", "remarks", "operator", "time", "speed", "slide roll ratio", "srr", "viscosity", "wear",
        "acceleration", "last", "normalkraft", "kraft", "temperatur", "zeit", "datum", "bemerkung",
    )
)  # fmt: skip
_BRACKETS = re.compile(r"(.*?)\s*(?:/\s*)?(?:\[([^\[\]]*)\]|\(([^()]*)\))")
_BARE = re.compile(r"(.*?)(?:\s+in\s+|\s*/\s+|\s*,\s*|\s+|_)([^\s,]+)", re.IGNORECASE)
_PURE = ("", "1", "-")  # how people write "no unit"


@dataclass(frozen=True)
class Heading:
    """A heading in parts. text : all of it. name : without the unit. unit : as written, or nothing."""

    text: str
    name: str
    unit: str

    def is_called(self, word: str) -> bool:
        """Whether people mean this column by a word: all of the heading, or its name."""
        return plain(word) in (plain(self.text), plain(self.name))

    def is_pure(self) -> bool:
        """Whether what stands here has no unit."""
        return self.unit in _PURE

    def may_be_friction(self) -> bool:
        """Whether a column with this heading may be that of a material: it has no unit and no other meaning."""
        return bool(self.text) and self.is_pure() and plain(self.name) not in _NOT_FRICTION


def heading(text: str, known: Collection[str]) -> Heading:
    """A heading in parts. known : names of the columns there may be, of which a bare unit is told apart."""
    match = _BRACKETS.fullmatch(text)
    if match is not None:
        unit = str(match[2] if match[2] is not None else match[3]).strip()
        if match[2] is not None or _is_unit(unit) or unit in _PURE:
            return Heading(text, match[1].strip(), unit.replace("\N{SUPERSCRIPT TWO}", "2"))
        return Heading(text, text, "")  # COF (dry)
    if meant(text, known) is None and (bare := _BARE.fullmatch(text)) is not None:
        name = meant(bare[1], known)
        if name in ("speed", "time") and _is_unit(bare[2]):
            return Heading(text, bare[1].strip(), bare[2])
        if "speed" in known and holds_speed(bare[1]) and _is_unit_of_speed(bare[2]):
            return Heading(text, bare[1].strip(" ,/"), bare[2])
    return Heading(text, text.strip(), "")


def meant(word: str, known: Collection[str]) -> str | None:
    """Which of the columns `known` people mean by a word; None if none."""
    name = plain(word)
    return next((column for column in known if name == plain(column) or name in _WORDS.get(column, ())), None)


def holds_speed(name: str) -> bool:
    """Whether a speed is meant by one of the words of a longer heading: `Sliding speed v`, `Prüfgeschwindigkeit`."""
    return any(word.strip("().,;").endswith(_SPEEDS) for word in plain(name).split())


def words_for(known: Collection[str]) -> Iterator[str]:
    """Every name of some columns."""
    for column in known:
        yield from dict.fromkeys((column, *_WORDS.get(column, ())))


def plain(word: str) -> str:
    """A name as it is compared."""
    return " ".join(word.casefold().replace("_", " ").replace("-", " ").strip(" :").split())


def _is_unit(text: str) -> bool:
    """Whether a text is a unit of something."""
    try:
        units.si_value(f"1 {text}", "m s-1")
    except QuantityError as error:
        return error.found is not None
    return True


def _is_unit_of_speed(text: str) -> bool:
    try:
        return units.si_value(f"1 {text}", "m s-1") > 0
    except QuantityError:
        return False
