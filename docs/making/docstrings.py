"""Docstrings as they are written here, made into reStructuredText for autodoc.

They are plain text: paragraphs, lines `name : what it is` whose continuations are indented, code in single backticks,
and examples, indented paragraphs. A public name in backticks becomes a link.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module
from itertools import chain
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx


_CODE = re.compile(r"``([^`]+)``|`([^`]+)`")
_ITEM = re.compile(r"(\w+(?:, \w+)*) : (.*)", re.DOTALL)
_NEXT_ITEM = re.compile(r"(?<=[.;)]) (?=\w+(?:, \w+)* : )")
_MARKUP = re.compile(r"([\\*|_`])")


def as_rst(lines: list[str], links: dict[str, str]) -> list[str]:
    """The lines of a docstring in reStructuredText. links : by name, the whole name of what a reader may look up."""
    found = []
    for paragraph in re.split(r"\n\s*\n", "\n".join(lines).strip("\n")):
        if paragraph.startswith(" "):
            found += ["::", "", *("    " + line for line in paragraph.split("\n")), ""]
            continue
        for part in chain.from_iterable(map(_NEXT_ITEM.split, _parts(paragraph))):
            item = _ITEM.fullmatch(part)
            found += [f"* **{item[1]}** : {_inline(item[2], links)}" if item else _inline(part, links), ""]
    return found


def _parts(paragraph: str) -> Iterator[str]:
    """Items and prose, each as one line: an item ends where the next begins, or where its indentation does."""
    part: list[str] = []
    for line in paragraph.split("\n"):
        returns = part and not line.startswith(" ") and (_ITEM.match(line) or part[-1].startswith(" "))
        if returns:
            yield _joined(part)
            part = []
        part.append(line)
    yield _joined(part)


def _joined(lines: list[str]) -> str:
    return " ".join(map(str.strip, lines))


def _inline(text: str, links: dict[str, str]) -> str:
    """Code and links as such, and everything else as it stands."""
    found, end = "", 0
    for code in _CODE.finditer(text):
        name = code[1] or code[2]
        known = links.get(name.removeprefix("stickslip."))
        found += _MARKUP.sub(r"\\\1", text[end : code.start()])
        found += f":py:obj:`{name} <{known}>`" if known else f"``{name}``"
        end = code.end()
    return found + _MARKUP.sub(r"\\\1", text[end:])


def public_names(modules: list[str]) -> dict[str, str]:
    """Where each public function and class is found, by its name and by that with its module; the first one counts."""
    found: dict[str, str] = {}
    for module in modules:
        for name in import_module(module).__all__:
            whole = f"{module}.{name}"
            found.setdefault(name, whole)
            found[whole.removeprefix("stickslip.")] = whole
    return found


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.add_config_value("public_modules", [], "env")
    links: dict[str, str] = {}

    def formatted(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
        links.update({} if links else public_names(app.config.public_modules))
        lines[:] = as_rst(lines, {short: whole for short, whole in links.items() if callable(_found(whole))})

    app.connect("autodoc-process-docstring", formatted)
    return {"parallel_read_safe": True}


def _found(whole: str) -> object:
    module, _, name = whole.rpartition(".")
    return getattr(import_module(module), name)
