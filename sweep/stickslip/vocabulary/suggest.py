"""Words in messages: the one that was probably meant, and several in a row.

Symbols of formulas and the field's other words for our quantities are never read, since a file should say the same to
everyone; messages name ours.
"""

import difflib
from collections.abc import Iterable

from stickslip.vocabulary.quantities import QUANTITIES


def suggest(word: str, among: Iterable[str]) -> str | None:
    """The word `among` the possible ones that was probably meant: a synonym, or one that is spelled much like it."""
    known = list(among)
    return synonym_of(word, known) or nearest(word, known)


def did_you_mean(word: str, among: Iterable[str]) -> str | None:
    """The question `did you mean mass?` about a word that is none `among` the possible ones; None if none is near."""
    near = suggest(word, among)
    return f"did you mean {near}?" if near else None


def or_meant(word: str, among: Iterable[str], before: str = "; ", otherwise: str = "") -> str:
    """The end of a message about such a word: `; did you mean mass?`, or `otherwise`."""
    question = did_you_mean(word, among)
    return f"{before}{question}" if question else otherwise


def synonym_of(word: str, among: Iterable[str]) -> str | None:
    """Our quantity for what somebody else calls `word`, if it is `among` those that are possible."""
    known, spelled = set(among), word.strip().lower().replace("-", "_").replace(" ", "_")
    rows = (row for name, row in QUANTITIES.items() if name in known)
    return next((row.name for row in rows if spelled in row.synonyms.lower().split()), None)


def nearest(word: str, among: Iterable[str]) -> str | None:
    """The word that is spelled most like `word`, if any comes close."""
    known, spelled = [other for other in among if other != word], word.lower().replace("-", "_").replace(" ", "_")
    if swapped := [other for other in known if sorted(other) == sorted(spelled)]:  # strokse is strokes, not stroke
        return swapped[0]
    if whole := [other for other in known if spelled in other.split("_")]:  # belt is belt_speed rather than delta
        return whole[0]
    close = difflib.get_close_matches(spelled, known, 1, 0.6)
    return close[0] if close else None


def listed(words: Iterable[str], last: str = "or") -> str:
    """Words in a row: ``a, b or c``."""
    *first, final = words
    return f"{', '.join(first)} {last} {final}" if first else final
