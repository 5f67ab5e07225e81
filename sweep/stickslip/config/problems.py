"""The problems of a document, collected with their places, and hints about mistakes that are easy to make in YAML."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from stickslip.config.yaml import Document, hint_about_decimals
from stickslip.errors import MOST_PROBLEMS, ConfigError, Path, Place, Problem, visible
from stickslip.vocabulary.suggest import listed, nearest, suggest

_LONGEST_TEXT = 60  # characters of what is quoted in a message
_WITHOUT_TEXT = {dict: "a mapping", list: "a list", type(None): "nothing"}
_GLUED = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(\s*[:=]\s*)(\S.*)")  # mass:0.2, mass = 0.2


class Suggestion(NamedTuple):
    """The key that an unknown one was probably meant to be, if it is one that is known, and the next step."""

    key: str | None
    hint: str


class ProblemCollector:
    """The problems of one document; a reader is one that also returns what is right."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.problems = list(document.problems)
        self.meant: set[str] = set()  # keys that misspelt ones were probably meant to be

    def raise_any(self) -> None:
        """Raise ConfigError if there is a problem."""
        if self.problems:
            raise ConfigError(self.document.name, self.problems)

    def add(self, path: Path, message: str, hint: str | None = None, at_key: bool = False) -> None:
        """Note a problem with the value at `path`, or with its key."""
        path = self._written(path)
        self.problems.append(Problem(path, message, self._place(path, at_key), hint))
        if len(self.problems) >= MOST_PROBLEMS:
            self.raise_any()

    def refuse(self, path: Path, expected: str, hint: str | None = None, found: str | None = None) -> None:
        """Note that the value at `path` is not what was expected; `found` says what kind of quantity it is."""
        kind = f" ({found})" if found else ""
        self.add(path, f"got {self.text(path)}{kind}, expected {expected}", hint)

    def mapping(self, value: object, path: Path, expected: str, hint: str | None = None) -> dict[str, Any]:
        """`value` if it is a mapping, else an empty one; nothing at all is one, but not as a whole document."""
        if isinstance(value, dict):
            return value
        if value is not None or not path:
            self.refuse(path, f"a mapping with {expected}", hint)
        return {}

    def known_keys(self, data: Mapping[str, Any], path: Path, known: Collection[str]) -> dict[str, Any]:
        """`data` without keys that are not `known`, each of which is a problem."""
        for key in data:
            if key not in known:
                self.unknown_key((*path, key), known)
        return {key: value for key, value in data.items() if key in known}

    def keys_of(self, value: object, path: Path, known: Collection[str]) -> dict[str, Any]:
        """The mapping `value` without keys that are not `known`; whatever is wrong with it is a problem."""
        return self.known_keys(self.mapping(value, path, f"the keys {listed(known)}"), path, known)

    def unknown_key(self, path: Path, known: Collection[str], what: str = "key", hint: str | None = None) -> None:
        """Note that the last key of `path` is none of those `known`."""
        if suggestion := _suggested(str(path[-1]), self._around(path), known):
            self.meant |= {suggestion.key} if suggestion.key else set()
            hint = suggestion.hint
        if any(problem.path == path[:-1] and problem.place == self._place(path, True) for problem in self.problems):
            return  # that it is no word is noted already
        self.add(path, f"unknown {what}, expected {listed(known)}", hint, at_key=True)

    def is_text(self, value: object, path: Path, what: str) -> bool:
        """True if a value is a text that a screen can show; if not, that is noted."""
        is_filled = isinstance(value, str) and bool(value.strip())
        if is_filled and visible(str(value)) == value:
            return True
        hint = "put it in quotes" if isinstance(value, int | float) else None
        self.refuse(path, f"{what} without control characters" if is_filled else what, hint)
        return False

    def line(self, path: Path) -> str:
        """` on line 7`, ` by --set mass=1`, or nothing for plain data."""
        place = self.document.keys.get(path)
        if place is None:
            return ""
        return f" by {place.option}" if place.option else f" on line {place.line}"

    def text(self, path: Path) -> str:
        """The value at `path`, as it was written."""
        path = self._written(path)
        text = self.document.texts.get(path)
        if text is None:
            value = self.document.data
            for key in path:
                value = value[key]
            text = _WITHOUT_TEXT.get(type(value)) or repr(value)
            if isinstance(value, list) and len(value) == 2 and not any(isinstance(one, dict | list) for one in value):
                text = f"[{value[0]}, {value[1]}]"  # a range
        return text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]}..."

    def _around(self, path: Path) -> dict[str, Any]:
        """The mapping in which the key at the end of `path` stands."""
        value = self.document.data
        for key in path[:-1]:
            value = value[key]
        return value if isinstance(value, dict) else {}

    def _place(self, path: Path, at_key: bool = False) -> Place | None:
        """The position of `path`; where it does not exist, that of what is around it."""
        document = self.document
        if at_key and path in document.keys:
            return document.keys[path]
        if path in document.values:
            return document.values[path]
        return document.keys.get(path[:-1]) or (self._place(path[:-1]) if path else None)

    def _written(self, path: Path) -> Path:
        """`path` as it is in the file, where `mass: [1, 2]` may stand for `mass: {values: [1, 2]}`, `x` for `[x]`."""
        value, written = self.document.data, []
        for key in path:
            if (key == "values" and isinstance(value, list)) or (isinstance(key, int) and isinstance(value, str)):
                continue
            written.append(key)
            inside = isinstance(value, dict) and key in value or isinstance(value, list) and isinstance(key, int)
            value = value[key] if inside else None
        return tuple(written)


def _suggested(key: str, entries: dict[str, Any], known: Collection[str]) -> Suggestion | None:
    """The key that an unknown one was probably meant to be; `entries` is the mapping it stands in."""
    if entries.get(key) is None:
        if glued := _GLUED.fullmatch(key):
            name, sign, value = glued.groups()
            if ours := name if name in known else nearest(name, known):
                lacks = "a space after the colon" if ":" in sign else "a colon and a space instead of ="
                return Suggestion(ours, f"write {lacks}: {ours}: {value}")
        if hint := hint_about_decimals(key, entries):
            return Suggestion(None, hint)
    near = suggest(key, known)
    return Suggestion(near, f"did you mean {near}?") if near else None
