"""Words in messages: the one that was probably meant, and several in a row."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(word: str, words: Iterable[str]) -> str | None:
    """The one of `words` that `word` was probably meant to be, if any comes close."""
    known, spelled = list(words), word.lower().replace("-", "_").replace(" ", "_")
    if swapped := [one for one in known if sorted(one) == sorted(spelled)]:  # strokse is strokes rather than stroke
        return swapped[0]
    if whole := [one for one in known if spelled in one.split("_")]:  # belt is belt_speed rather than delta
        return whole[0]
    found = difflib.get_close_matches(spelled, known, 1, 0.6)
    return found[0] if found else None


def listed(words: Iterable[str], last: str = "or") -> str:
    """Words in a row: ``a, b or c``."""
    *first, final = words
    return f"{', '.join(first)} {last} {final}" if first else final
