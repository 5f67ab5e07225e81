"""`--set key=value`: what a command line puts into the tree of a configuration before it is checked."""

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

from stickslip.config.yaml import Document, parse_yaml
from stickslip.errors import ConfigError, Path, Place, dotted

_KEY = re.compile(r"[^.\[\]\s]+(?:\[\d+\])*(?:\.[^.\[\]\s]+(?:\[\d+\])*)*")
_STEP = re.compile(r"([^.\[\]]+)|\[(\d+)\]")


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
            raise ConfigError.of(document.name, _why_not(value, path[:i], key), hint, place=given.place, path=path)
        if i < len(path) - 1:
            value = value[key]
    return value


def _why_not(value: Any, path: Path, key: str | int) -> str:
    if isinstance(value, dict) and isinstance(key, str):
        return f"{dotted((*path, key))} is not there, so it cannot be removed"
    kind = "a list" if isinstance(value, list) else "a mapping" if isinstance(value, dict) else f"{value!r}"
    size = f" of {len(value)}, counted from 0" if isinstance(value, list) and isinstance(key, int) else ""
    return f"{dotted(path)} is {kind}{size}, and has no {f'[{key}]' if isinstance(key, int) else f'key {key}'}"
