"""Units as people write them by mistake, and what they were probably meant to be."""

import re
from collections.abc import Callable

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
