"""YAML in, plain data out, with the place of every key and value; and what a command line puts into it.

What is read is YAML 1.2 with its core types: ``1e-3`` is a number, ``yes`` a word, ``017`` seventeen. Tags, anchors and
aliases are refused: a configuration is plain data, and with these YAML files can grow without bound when read.
"""

import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from ruamel.yaml import YAML, events
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.reader import ReaderError

from stickslip.errors import MOST_PROBLEMS, ConfigError, Path, Place, Problem, dotted
from stickslip.files.locations import CONFIGURATIONS, wrong_file_type

_LARGEST = 1_000_000  # bytes, which take seconds to read; a configuration has a few hundred
DEEPEST = 20  # levels; a configuration has four
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_WORDS = {word: None for word in ("", "~", "null", "Null", "NULL")} | {
    word: word.lower() == "true" for word in ("true", "True", "TRUE", "false", "False", "FALSE")
}
_KEY = re.compile(r"[^.\[\]\s]+(?:\[\d+\])*(?:\.[^.\[\]\s]+(?:\[\d+\])*)*")
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")

_BY_MESSAGE = (  # what the message of the parser contains
    ("'\\t'", "indent with spaces, not with tabs"),
    ("escape", "in double quotes a backslash begins an escape: use single quotes, or / in paths"),
    ("quoted scalar", "a quote is not closed"),
    ("cannot start any token", "a text that begins with this character needs quotes"),
    ("mapping values are not allowed", "a text that contains ': ' needs quotes"),
)


@dataclass
class Document:
    """The content of a file, with the place of every part.

    data : plain data: dict, list, str, int, float, bool, None.
    keys, values : place of each key and of each value, by path.
    texts : spelling of each scalar, by path, so that messages can show it as it was written ("1e400", not inf).
    problems : what is wrong but does not keep the rest from being read: repeated keys and keys that are not words.
    moved : where parts stand in the file that stand elsewhere in `data` (resolvers).
    """

    name: str
    data: Any = None
    keys: dict[Path, Place] = field(default_factory=dict)
    values: dict[Path, Place] = field(default_factory=dict)
    texts: dict[Path, str] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    moved: dict[Path, Path] = field(default_factory=dict)

    def in_file(self, path: Path) -> Path:
        """The path as it is in the file."""
        for length in range(len(path), 0, -1):
            if path[:length] in self.moved:
                return (*self.moved[path[:length]], *path[length:])
        return path

    def refused(self, path: Path, message: str, hint: str | None = None) -> ConfigError:
        """The error about the value at a path."""
        return ConfigError.of(self.name, message, hint, place=self.values.get(path), path=self.in_file(path))


def read_yaml(path: FilePath) -> Document:
    """The document in a file. Raises ConfigError if the file cannot be read or is not YAML."""
    name = str(path)
    if kind := wrong_file_type(path, CONFIGURATIONS):
        raise ConfigError.of(name, f"this is {kind[0]}, expected a configuration in YAML", kind[1])
    try:
        with path.open("rb") as file:
            raw = file.read(_LARGEST + 1)
    except FileNotFoundError:
        hint = "`stickslip init --list` names those that come with stickslip"
        raise ConfigError.of(name, "no such file", hint) from None
    except OSError as error:
        raise ConfigError.of(name, f"cannot be read: {error.strerror or error}") from None
    if len(raw) > _LARGEST:
        raise ConfigError.of(name, f"larger than {_LARGEST // 1_000_000} MB, expected a configuration in YAML")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        place = _place_in(raw[: error.start].decode("utf-8-sig"), error.start)
        message = f"byte 0x{raw[error.start]:02x} is not UTF-8 text"
        raise ConfigError.of(name, message, "save the file as UTF-8", place=place) from None
    return parse_yaml(text, name)


def parse_yaml(text: str, name: str = "<text>") -> Document:
    """The document in a text. Raises ConfigError, naming the text `name`, if it is not YAML or empty."""
    document = Document(name)
    try:
        _EventReader(document, iter(YAML(typ="safe", pure=True).parse(text))).build()
    except ReaderError as error:
        place = _place_in(text, error.position)
        message = f"character U+{ord(text[error.position]):04X} is not allowed in YAML"
        raise ConfigError.of(name, message, "a configuration is a text file", place=place) from None
    except MarkedYAMLError as error:
        raise ConfigError(name, [_syntax_problem(error)]) from None
    except YAMLError as error:
        raise ConfigError.of(name, f"not YAML: {error}") from None
    return document


def section_in(text: str, key: str) -> dict[str, Any]:
    """A section of the configuration that a result records, as far as it can be read; empty if it cannot."""
    try:
        data = parse_yaml(text).data
    except ConfigError:
        return {}
    section = data.get(key) if isinstance(data, dict) else None
    return section if isinstance(section, dict) else {}


def _place_in(text: str, position: int) -> Place:
    before = text[:position]
    return Place(before.count("\n") + 1, len(before) - before.rfind("\n"))


def _syntax_problem(error: MarkedYAMLError) -> Problem:
    """The error of ruamel.yaml, on one line."""
    mark = error.problem_mark or error.context_mark
    place = None if mark is None else Place(mark.line + 1, mark.column + 1)
    message = str(error.problem or error.context)
    if error.context and error.problem:
        message += f", {error.context}"
    if error.context and error.context_mark and error.context_mark.line != getattr(mark, "line", None):
        message += f" that begins on line {error.context_mark.line + 1}"
    hint = next((hint for part, hint in _BY_MESSAGE if part in message), None)
    return Problem((), f"not valid YAML: {message.replace('<stream end>', 'the end of the file')}", place, hint)


class _EventReader:
    """Turns the events of a YAML parser into plain data and places."""

    def __init__(self, document: Document, events: Iterator[Any]) -> None:
        self._document = document
        self._events = events

    def build(self) -> None:
        """Fill the document. Raises ConfigError for what a configuration may not use."""
        next(self._events)  # the stream starts
        if isinstance(next(self._events), events.StreamEndEvent):
            hint = "`stickslip init` writes a configuration to start from"
            raise ConfigError.of(self._document.name, "the file is empty", hint)
        self._document.data = self._value(next(self._events), ())
        next(self._events)  # the document ends
        event = next(self._events)
        if isinstance(event, events.DocumentStartEvent):
            raise self._refused(event, "a second document starts here, expected one", "remove the line '---'")

    def _value(self, event: Any, path: Path) -> Any:
        if isinstance(event, events.AliasEvent) or event.anchor is not None:
            sign = f"*{event.anchor}" if isinstance(event, events.AliasEvent) else f"&{event.anchor}"
            message = f"got the {'alias' if sign[0] == '*' else 'anchor'} {sign}, expected a value"
            raise self._refused(event, message, "write the value out wherever it is needed", path)
        if event.tag is not None:
            raise self._refused(event, f"got the tag {event.tag}, expected a plain value", "remove the tag", path)
        if len(path) > DEEPEST:
            raise self._refused(event, f"nested more than {DEEPEST} levels deep", None, path[:3])
        self._document.values[path] = _place(event)
        if isinstance(event, events.ScalarEvent) and not event.value and path in self._document.keys:
            self._document.values[path] = self._document.keys[path]  # ruamel.yaml says: on the next line
        if isinstance(event, events.MappingStartEvent):
            return self._mapping(path)
        if isinstance(event, events.SequenceStartEvent):
            return self._sequence(path)
        return self._scalar(event, path)

    def _mapping(self, path: Path) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        while not isinstance(event := next(self._events), events.MappingEndEvent):
            key = self._key(event, path)
            inner, place = (*path, key), _place(event)
            if key not in mapping:
                self._document.keys[inner] = place
                mapping[key] = self._value(next(self._events), inner)
                continue
            line = self._document.keys[inner].line
            message = f"given twice, first on line {line}, expected once"
            self._note(Problem(inner, message, place, "remove one of the two"))
            _EventReader(Document(self._document.name), self._events)._value(next(self._events), inner)  # read past it
        return mapping

    def _key(self, event: Any, path: Path) -> str:
        """A key, which must be a word."""
        if not isinstance(event, events.ScalarEvent) or event.tag is not None or event.anchor is not None:
            raise self._refused(event, "got a key that is not a plain word", None, path)
        text = str(event.value)
        if event.implicit[0] and not isinstance(_plain(text), str):
            message = f"got the key {text or '(nothing)'}, expected a word"
            self._note(Problem(path, message, _place(event)))
        return text

    def _sequence(self, path: Path) -> list[Any]:
        sequence: list[Any] = []
        while not isinstance(event := next(self._events), events.SequenceEndEvent):
            sequence.append(self._value(event, (*path, len(sequence))))
        return sequence

    def _scalar(self, event: Any, path: Path) -> Any:
        text = str(event.value)
        value = _plain(text) if event.implicit[0] else text
        self._document.texts[path] = repr(text) if isinstance(value, str) else text or "nothing"
        return value

    def _note(self, problem: Problem) -> None:
        """Keep a problem; raise all once there are too many."""
        self._document.problems.append(problem)
        if len(self._document.problems) >= MOST_PROBLEMS:
            raise ConfigError(self._document.name, self._document.problems)

    def _refused(self, event: Any, message: str, hint: str | None, path: Path = ()) -> ConfigError:
        return ConfigError.of(self._document.name, message, hint, place=_place(event), path=path)


def _place(event: Any) -> Place:
    return Place(event.start_mark.line + 1, event.start_mark.column + 1)


def _plain(text: str) -> Any:
    """The value of a word without quotes in the core schema of YAML 1.2."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text) and len(text) < 1000:  # int() refuses thousands of digits
        return int(text, 0) if text[:2] in ("0o", "0x") else int(text)
    if _FLOAT.fullmatch(text):
        return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
    return text


def write_yaml(plain: Any) -> str:
    """Plain data as YAML text, which `parse_yaml` reads."""
    writer = YAML(typ="safe", pure=True)
    writer.default_flow_style = None  # innermost lists and mappings on one line
    writer.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    writer.width = 2**20  # no line breaks inside values
    writer.allow_unicode = True
    text = io.StringIO()
    writer.dump(plain, text)
    return text.getvalue()


# --- `--set key=value` ------------------------------------------------------------------------------------------------


class Setting(NamedTuple):
    """A value for a key. option : as it was written on the command line, for messages. value : YAML; empty removes."""

    option: str
    key: str
    value: str

    @property
    def place(self) -> Place:
        """The option, which messages name in place of a line and a column."""
        return Place(0, 0, self.option)


def setting(text: str) -> Setting:
    """The setting `system.mass=200 g`. Raises ValueError."""
    key, equals, value = text.partition("=")
    if not equals or not _KEY.fullmatch(key.strip()):
        raise ValueError(f"got {text!r}, expected KEY=VALUE such as 'system.mass=200 g' or axes.belt_speed.num=50")
    return Setting(f"--set {text}", key.strip(), value.strip())


def overridden(document: Document, settings: Iterable[Setting]) -> Document:
    """The document with settings put in, one after the other; sections that are not there are made.

    Raises ConfigError for a key inside of what has no keys, and for a value that is not YAML.
    """
    for given in settings if isinstance(document.data, dict) else ():
        path: Path = tuple(int(number) if number else key for key, number in _STEP.findall(given.key))
        around = _around(document, path, given)
        for places in (document.keys, document.values, document.texts):
            for inner in [inner for inner in places if inner[: len(path)] == path]:
                del places[inner]
        if not given.value:
            del around[path[-1]]
            continue
        try:
            fragment = parse_yaml(given.value, document.name)
            problems = fragment.problems
        except ConfigError as error:
            problems = list(error.problems)
        for problem in problems:
            raise ConfigError.of(document.name, problem.message, problem.hint, place=given.place, path=path)
        around[path[-1]] = fragment.data
        document.keys |= {path: given.place} | {(*path, *inner): given.place for inner in fragment.keys}
        document.values |= {(*path, *inner): given.place for inner in fragment.values}
        document.texts |= {(*path, *inner): text for inner, text in fragment.texts.items()}
    return document


def _around(document: Document, path: Path, given: Setting) -> Any:
    """The mapping or list that the last key of `path` is to be set in, or removed from."""
    value: Any = document.data
    for i, key in enumerate(path):
        if isinstance(key, int):
            there = isinstance(value, list) and key < len(value)
        else:
            there = isinstance(value, dict) and key in value
            if isinstance(value, dict) and given.value and (not there or value[key] is None and path[i + 1 :]):
                value[key], there = {}, True
                document.keys[path[: i + 1]] = document.values[path[: i + 1]] = given.place
        if not there:
            hint = None if isinstance(value, dict) else f"--set {dotted(path[:i])}=... replaces all of it"
            size = f", a list of {len(value)} counted from 0," if isinstance(value, list) else ""
            message = f"{dotted(path[:i]) or 'the document'}{size} has no {f'[{key}]' if isinstance(key, int) else key}"
            raise ConfigError.of(document.name, message, hint, place=given.place, path=path)
        if i < len(path) - 1:
            value = value[key]
    return value
