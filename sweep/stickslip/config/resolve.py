"""The step between reading a document and checking it: keys of extensions in place of which other things stand.

`uncertain: {explained: felt.nc}` stands for draws, say. Whoever owns such a key puts in what it stands for, once; what
is checked then names no file that is still to be read.
"""

from collections.abc import Sequence
from typing import Any

from stickslip import extensions
from stickslip.config.yaml import Document


def resolved(document: Document) -> Document:
    """The document, with what keys of extensions stand for. Raises ConfigError."""
    for extension in extensions.installed():
        done = set()
        for pattern, place in extension.resolvers.items():
            if place not in done and _has(document.data, pattern.split(".")):
                done.add(place)
                document = extensions.imported(place)(document)
    return document


def keys_in(data: Any) -> set[str]:
    """The keys of mappings in plain data, at any depth: what was written, and not filled in."""
    inner = data.values() if isinstance(data, dict) else data if isinstance(data, list) else ()
    return {*(data if isinstance(data, dict) else ())}.union(*map(keys_in, inner))


def _has(value: Any, path: Sequence[str]) -> bool:
    """True if there is something at a path, of which `*` is any key of a mapping, or any number of a list."""
    if not path:
        return True
    key, *rest = path
    if key == "*":
        inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
        return any(_has(one, rest) for one in inner)
    return isinstance(value, dict) and key in value and _has(value[key], rest)
