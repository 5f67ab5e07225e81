"""What to do about mistakes that are easy to make in YAML: what a key, a list or a line was probably meant to be."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any, NamedTuple

from stickslip.vocabulary.synonyms import meant
from stickslip.vocabulary.words import nearest

_GLUED = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(\s*[:=]\s*)(\S.*)")  # a1:0.2, a1 = 0.2
_AFTER_COMMA = re.compile(r"[0-9]+(?:[eE][-+]?[0-9]+)?(?:\s*[A-Za-zµμ%].*)?")  # 5 kg, of 1,5 kg
_DECIMALS = "a decimal comma? inside {} a comma ends the entry; "


class Meant(NamedTuple):
    """The key that was meant, if it is one that is known, and the next step."""

    key: str | None
    hint: str


def for_key(key: str, entries: dict[str, Any], known: Collection[str]) -> Meant | None:
    """What an unknown key was probably meant to be; `entries` is the mapping it stands in."""
    if (glued := _GLUED.fullmatch(key)) and entries.get(key) is None:
        name, sign, value = glued.groups()
        if ours := name if name in known else nearest(name, known):
            lacks = "a space after the colon" if ":" in sign else "a colon and a space instead of ="
            return Meant(ours, f"write {lacks}: {ours}: {value}")
    if entries.get(key) is None and (hint := for_decimals(key, entries)):
        return Meant(None, hint)
    if near := meant(key, known):
        return Meant(near, f"did you mean {near}?")
    return None


def for_decimals(key: str, entries: dict[str, Any]) -> str | None:
    """What to write if `key` is what follows the comma of the value before it: ``{mass: 1,5 kg}``."""
    names = list(entries)
    before = names[: names.index(key)] if key in names else names
    if not before or not _AFTER_COMMA.fullmatch(key):
        return None
    whole = entries[before[-1]]
    if isinstance(whole, bool) or not isinstance(whole, int):
        return None
    return _DECIMALS.format("braces") + f"write {before[-1]}: {whole}.{key}"


def for_list(values: object) -> str | None:
    """What to write if a list was meant to have decimal commas: ``[1,5 mm, 2,5 mm]`` has numbers and texts in turn."""
    if not isinstance(values, list) or len(values) < 2 or len(values) % 2:
        return None
    pairs = list(zip(values[::2], values[1::2], strict=True))
    if not all(type(whole) is int and _AFTER_COMMA.fullmatch(str(rest)) for whole, rest in pairs):
        return None
    if not any(isinstance(rest, str) for _, rest in pairs):
        return None
    return _DECIMALS.format("brackets") + f"write [{', '.join(f'{whole}.{rest}' for whole, rest in pairs)}]"


# --- YAML that is none ------------------------------------------------------------------------------------------------

_QUOTED = "in double quotes a backslash begins an escape: use single quotes, or / in paths"
_COLON = "a text that contains ': ' needs quotes; or the indentation is off"
_KIND = "the indentation, or the kind, differs from the lines above: a list has '- ', a mapping 'key: '"
_BY_MESSAGE = (  # the first that the message of the parser contains
    ("'\\t'", "indent with spaces, not with tabs"),
    ("escape", _QUOTED),
    ("quoted scalar", "the quote that opens on line {context} is not closed"),
    ("cannot start any token", "a text that begins with {character} needs quotes"),
    ("found '}'", "one closing brace too many"),
    ("found ']'", "one closing bracket too many"),
    ("found '<scalar>', while parsing a block", "an apostrophe inside single quotes is written twice, 'it''s'"),
    ("found '?'", _KIND),
    ("found '<block mapping start>'", "the line is indented further, or less, than its neighbours"),
    ("found '-'", _KIND),
    ("found '<stream end>'", "the brace or bracket that opens on line {context} is not closed"),
)  # fmt: skip


def for_syntax(message: str, lines: list[str], line: int, column: int, context: int | None) -> str | None:
    """What to do about a text that is no YAML.

    message : of the parser. lines : of the text. line, column : where it gave up. context : the line in which what it
    was reading began. All count from 1.
    """
    here = lines[line - 1] if 0 < line <= len(lines) else ""
    if message.startswith("expected ',' or"):
        if context is not None and context < line:
            sign = "bracket" if "']'" in message else "brace"
            return f"the {sign} that opens on line {context} is not closed"
        return "a comma is missing between two entries; a text that contains ': ' needs quotes"
    if "could not find expected ':'" in message or "mapping values are not allowed" in message:
        began = [number for number in (context, line, line - 1) if number and 0 < number <= len(lines)]
        return next(filter(None, (_about_colon(lines[number - 1], number) for number in began)), _COLON)
    character = repr(here[column - 1]) if 0 < column <= len(here) else "this"
    for part, hint in _BY_MESSAGE:
        if part in message:
            return hint.format(context=context or line, character=character) if "{" in hint else hint
    return None


def _about_colon(line: str, number: int) -> str | None:
    """What is wrong with the colon of a line that should have one."""
    text = line.partition(" #")[0].strip()
    glued = re.fullmatch(r"([A-Za-z_][A-Za-z0-9_]*):(\S+)", text)
    if glued and not glued[2].startswith("//"):
        return f"line {number} lacks a space after the colon: {glued[1]}: {glued[2]}"
    if equals := re.fullmatch(r"([A-Za-z_][A-Za-z0-9_]*)\s*=\s*(.+)", text):
        return f"line {number} has = for a colon and a space: {equals[1]}: {equals[2]}"
    if bare := re.match(r"([A-Za-z_][A-Za-z0-9_]*)(\s*\{.*)?$", text):
        return f"line {number} lacks a colon: {bare[1]}:{bare[2] or ''}"
    return None
