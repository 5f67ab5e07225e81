"""A configuration as HTML, for notebooks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES

_LONGEST = 80  # characters of a value


def as_html(resolved: Mapping[str, Any]) -> str:
    """A table of the plain data of a configuration (`Config.resolved`), a row for each key, with unit and meaning."""
    rows = [f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in _rows(resolved)]
    head = "<tr><th>section</th><th>key</th><th>value</th><th></th></tr>"
    return f"<b>{escape(str(resolved['title']))}</b><table>{head}{''.join(rows)}</table>"


def _rows(resolved: Mapping[str, Any]) -> Iterator[tuple[str, str, str, str]]:
    for section, keys in resolved.items():
        if not isinstance(keys, Mapping):
            continue
        for i, (key, value) in enumerate(keys.items()):
            row = QUANTITIES.get(key)
            unit = "" if row is None else units.spelled(row.units)
            yield section if i == 0 else "", key, _text(value, unit), "" if row is None else row.long_name


def _text(value: Any, unit: str = "") -> str:
    if isinstance(value, Mapping) and "start" in value:
        text = f"{value['start']:g} to {value['stop']:g} {unit}".rstrip()
        return f"{text}, {value['num']:,} values, {value['spacing']}"
    if isinstance(value, Mapping):
        value = value["values"] if set(value) == {"values"} else value
    if isinstance(value, float):
        return f"{value:.6g} {unit}".rstrip()
    text = f"{value} {unit if isinstance(value, list) else ''}".rstrip()
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
