"""Units as people write them by mistake, and what they were probably meant to be."""

import re
from collections.abc import Callable, Iterator

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
    """The unit that was probably meant; None if none comes close.

    fits : whether a unit is understood, and of the right kind.
    """
    if len(unit) > _MOST or not _WORD.match(unit):
        return None
    tried = dict.fromkeys(_rewritten(unit))
    return next((written for written in tried if written not in ("", unit) and fits(written)), None)


def _rewritten(unit: str) -> Iterator[str]:
    """A unit with one or two of the usual mistakes undone, the likeliest first."""
    spelled = _WORD.sub(lambda word: _respelled(word[0]), re.sub(r"\s+per\s+", "/", unit)).rstrip(".,;")
    spaced = re.sub(r"(?<=[A-Za-z0-9])[.\-](?=[A-Za-z])", " ", spelled)
    over, slash, under = spaced.partition("/")
    for text in (spelled, spaced):
        yield text
        yield text.replace(" ", "")  # m m
        yield re.sub(r"\s*(\^|\*\*)?[-+]?[0-9]", "", text)  # N/mm^2
    yield over + slash + under.replace(" ", "/").replace("*", "/")  # N/m m
    yield re.sub(r"[\s*·]+", "/", spaced)  # N mm for N/mm
    if slash:
        yield f"{under}/{over}"  # s/mm


def _respelled(word: str) -> str:
    """One unit as it is spelled, or two that were written together with a space between them."""
    if word in _COMMON:
        return word
    if word.lower() in _MEANT:
        return _MEANT[word.lower()]
    return next((" ".join(parts) for parts in _halves(word)), word)


def _halves(word: str) -> Iterator[tuple[str, str]]:
    """A word as two common units: Ns is N s."""
    places = range(len(word) - 1, 0, -1)  # mms is mm s rather than m ms
    return ((word[:i], word[i:]) for i in places if word[:i] in _COMMON and word[i:] in _COMMON)
