"""Texts that a spreadsheet would run as formulas when it opens a table, made inert, and read back.

What counts as such is the list of OWASP on CSV injection: a text that begins with = + - @, also in their wide forms, or
with a tab or the end of a line. A program that splits at another separator sees the text behind it as a cell as well.
"""

from __future__ import annotations

import re

_STARTS = r"[ ]*[=+\-@＝＋－＠\t\r\n]"  # noqa: RUF001 (the wide forms)
_LIVE = re.compile(rf"^(?='*{_STARTS})|(?<=[;,\t])(?='*[ ]*[=@])")
_INERT = re.compile(rf"^'(?='*{_STARTS})|(?<=[;,\t])'(?='*[ ]*[=@])")


def is_live(text: str) -> bool:
    """Whether a spreadsheet may take a text for a formula. A number is a number."""
    return bool(_LIVE.search(text)) and not _is_number(text)


def inert(text: str) -> str:
    """The text as a cell of CSV that is no formula: with an apostrophe in front, which Excel shows and `as_written`
    takes away."""
    return _LIVE.sub("'", text) if is_live(text) else text


def as_written(text: str) -> str:
    """The text that `inert` was given."""
    return _INERT.sub("", text) if "'" in text else text


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return text == text.strip()
