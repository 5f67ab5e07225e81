"""The problems of a document, collected with their places, and hints about mistakes that are easy to make in YAML."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, NamedTuple, get_args

from pydantic import ValidationError

from stickslip.config.sections import REFUSED, AnySection, Section
from stickslip.config.yaml import Document
from stickslip.errors import MOST_PROBLEMS, ConfigError, Path, Place, Problem, visible
from stickslip.vocabulary.quantities import listed, suggest

_LONGEST_TEXT = 60  # characters of what is quoted in a message
_WITHOUT_TEXT = {dict: "a mapping", list: "a list", type(None): "nothing"}
_ENDS = ("low", "high")
_EXPECTED = {"tuple_type": "a list", "string_type": "a text", "dict_type": "a mapping"}  # pydantic's own errors


class Finding(NamedTuple):
    """One inconsistency: the value at `path` does not fit the rest.

    got : what was found, where that is not the value itself: of uncertain quantities, the worst of their draws.
    """

    path: Path
    expected: str
    hint: str
    got: str | None = None


class ProblemCollector:
    """The problems of one document; a reader is one that also returns what is right.

    in_full : whether messages quote mappings and lists, which of a file would be long.
    """

    def __init__(self, document: Document, in_full: bool = False) -> None:
        self.document, self._in_full = document, in_full
        self.problems = list(document.problems)
        self.meant: set[str] = set()  # keys that misspelt ones were probably meant to be

    def raise_any(self) -> None:
        """Raise ConfigError if there is a problem."""
        if self.problems:
            raise ConfigError(self.document.name, self.problems)

    def add(self, path: Path, message: str, hint: str | None = None, at_key: bool = False) -> None:
        """Note a problem with the value at `path`, or with its key."""
        path = self._written(path)
        self.problems.append(Problem(self.document.in_file(path), message, self._place(path, at_key), hint))
        if len(self.problems) >= MOST_PROBLEMS:
            self.raise_any()

    def refuse(self, path: Path, expected: str, hint: str | None = None, kind: str | None = None) -> None:
        """Note that the value at `path` is not what was expected; `kind` says what it is instead."""
        instead = f" ({kind})" if kind else ""
        self.add(path, f"got {self.text(path)}{instead}, expected {expected}", hint)

    def add_finding(self, finding: Finding) -> None:
        """Note a rule that is broken."""
        got = finding.got or self.text(finding.path)
        self.add(finding.path, f"got {got}, expected {finding.expected}", finding.hint)

    def mapping(self, value: object, path: Path, expected: str) -> dict[str, Any]:
        """`value` if it is a mapping, else an empty one; nothing at all is one, but not as a whole document."""
        if isinstance(value, dict):
            return value
        if value is not None or not path:
            self.refuse(path, f"a mapping with {expected}")
        return {}

    def read(self, model: type[AnySection], path: Path, data: object) -> AnySection | None:
        """The model of the data at `path`; None, and problems, if something is wrong with it."""
        try:
            return model.model_validate(data)
        except ValidationError as error:
            self._refuse_all(error, model, path)
            return None

    def section_of(self, model: type[AnySection], path: Path, data: object) -> AnySection:
        """The section at `path`, of what of it is right; the rest becomes problems."""
        try:
            return model.model_validate(data)
        except ValidationError as error:
            bad = self._refuse_all(error, model, path)
        known = data if isinstance(data, dict) else {}
        try:
            return model.model_validate({key: value for key, value in known.items() if key not in bad})
        except ValidationError:  # what was left out is missed by the rest; it is reported already
            return model()

    def _refuse_all(self, error: ValidationError, model: type[Section], path: Path) -> set[str | int]:
        """Note the errors of pydantic, misspelt keys before those they were meant to be; return the wrong keys."""
        details = sorted(error.errors(include_url=False), key=lambda detail: detail["type"] != "extra_forbidden")
        for detail in details:
            where, context = (*path, *detail["loc"]), detail.get("ctx", {})
            around = model_at(model, detail["loc"][:-1])
            if detail["type"] == REFUSED:
                self.refuse(where, context["expected"], context["hint"], context["kind"])
            elif detail["type"] == "extra_forbidden":
                self.unknown_key(where, around.model_fields)
            elif detail["type"] != "missing":
                self.refuse(where, _EXPECTED.get(detail["type"], detail["msg"]))
            elif where[-1] not in self.meant:  # else it is there under another word
                keys = [key for key, field in around.model_fields.items() if field.is_required() and key != "name"]
                meaning = around.model_fields[str(where[-1])].description
                self.add(where, f"missing, expected {meaning or listed(keys, 'and')}")
        return {detail["loc"][0] for detail in details if detail["loc"]}

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
        if near := suggest(str(path[-1]), known):
            self.meant.add(near)
            hint = f"did you mean {near}?"
        if any(problem.path == path[:-1] and problem.place == self._place(path, True)
               and problem.message.startswith("got the key ") for problem in self.problems):  # fmt: skip
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
                if isinstance(value, dict) and key not in value:
                    return "its default"
                value = value[key]
            text = ("" if self._in_full else _WITHOUT_TEXT.get(type(value), "")) or repr(value)
            if isinstance(value, list) and len(value) == 2 and not any(isinstance(item, dict | list) for item in value):
                text = f"[{value[0]}, {value[1]}]"  # a range
        return text if len(text) <= _LONGEST_TEXT else f"{text[:_LONGEST_TEXT]}..."

    def _place(self, path: Path, at_key: bool = False) -> Place | None:
        """The position of `path`; where it does not exist, that of what is around it."""
        document = self.document
        if at_key and path in document.keys:
            return document.keys[path]
        if path in document.values:
            return document.values[path]
        return document.keys.get(path[:-1]) or (self._place(path[:-1]) if path else None)

    def _written(self, path: Path) -> Path:
        """`path` as it is in the file, where `mass: [1, 2]` may stand for `mass: {values: [1, 2]}`, `x` for `[x]`, and
        `[0, 1]` for `{low: 0, high: 1}`."""
        value, written = self.document.data, []
        for key in path:
            inside = isinstance(value, dict) and key in value
            if (key == "values" and not inside) or (isinstance(key, int) and isinstance(value, str)):
                continue
            if isinstance(value, list) and key in _ENDS:
                key = _ENDS.index(str(key))
            written.append(key)
            value = value[key] if inside or (isinstance(value, list) and isinstance(key, int)) else None
        return tuple(written)


def model_at(model: type[Section], keys: Path) -> type[Section]:
    """The model in which the keys end that lead into another one."""
    for key in keys:
        field = model.model_fields.get(str(key))
        types = (field.annotation, *get_args(field.annotation)) if field else ()
        model = next((kind for kind in types if isinstance(kind, type) and issubclass(kind, Section)), model)
    return model
