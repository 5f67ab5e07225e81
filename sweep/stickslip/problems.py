"""What is wrong with a person's input, said so that they can put it right.

A `Problem` is one thing that is wrong and where it stands; a `ConfigError` carries all of them at once.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

Path = tuple[str | int, ...]
MOST_PROBLEMS = 200  # nobody reads more, and looking for more in a file of nonsense takes minutes
_LONGEST_KEY = 60  # characters


class Place(NamedTuple):
    """Where something stands in a text; line and column count from 1."""

    line: int
    column: int


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    path : keys that lead to it, outermost first; empty for the text as a whole.
    message : what was found and what was expected.
    place : None if the input has no lines (plain data instead of a file).
    hint : the next step, where one helps.
    """

    path: Path
    message: str
    place: Place | None = None
    hint: str | None = None

    def text(self, source: str) -> str:
        """`FILE:LINE:COL: key.path: message`, with the hint on a line of its own; `source` is the name of the file."""
        where = source if self.place is None else f"{source}:{self.place.line}:{self.place.column}"
        parts = [where, *([dotted(self.path)] if self.path else []), self.message]
        return _printable(": ".join(parts)) + (f"\n  hint: {_printable(self.hint)}" if self.hint else "")


class ConfigError(ValueError):
    """A configuration that cannot be used; `problems` lists everything that is wrong with it, in the order of the file.

    `source` is the name of the file, or of the text in angle brackets.
    """

    def __init__(self, source: str, problems: Iterable[Problem]) -> None:
        self.source = source
        self.problems = tuple(sorted(problems, key=lambda p: p.place or (0, 0)))
        super().__init__(source, self.problems)  # these are what pickling calls __init__ with

    def __str__(self) -> str:
        return "\n".join(problem.text(self.source) for problem in self.problems)


def dotted(path: Path) -> str:
    """A path as people write it: ``axes.mass.values[2]``; keys that are not plain words stand in quotes."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{_word(key)}" for key in path).removeprefix(".")


def _word(key: str) -> str:
    short = key if len(key) <= _LONGEST_KEY else f"{key[:_LONGEST_KEY]}..."
    return short if short.isprintable() else repr(short)


def _printable(text: str) -> str:
    """The text with characters that a terminal might obey written out."""
    return text if text.isprintable() else "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def nearest(word: str, words: Iterable[str]) -> str | None:
    """The one of `words` that `word` was probably meant to be, if any comes close."""
    known = list(words)
    found = difflib.get_close_matches(word.lower().replace("-", "_").replace(" ", "_"), known, 1, 0.6)
    return found[0] if found else None


def listed(words: Iterable[str], last: str = "or") -> str:
    """Words in a row: ``a, b or c``."""
    *first, final = words
    return f"{', '.join(first)} {last} {final}" if first else final
