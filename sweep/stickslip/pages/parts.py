"""What a page consists of, as HTML. All text that comes in is escaped here; what goes out is HTML."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from io import BytesIO
from typing import Any, NamedTuple

from matplotlib.figure import Figure

from stickslip.plots.page import fit

_DOTS = 200  # per inch
_MADE_BY = {"computed": "date_created", "by": "source", "with": "software"}  # attributes of a dataset


class Column(NamedTuple):
    """The head of a column: its name, the unit below it; text stands at the left, numbers at the right."""

    name: str
    unit: str = ""
    is_text: bool = False


class Cell(NamedTuple):
    """A cell of a table that looks different: the class in the style sheet."""

    text: str
    kind: str


def paragraph(text: str) -> str:
    """A paragraph of plain text."""
    return f"<p>{escape(text)}</p>"


def warning(text: str, label: str = "Warning") -> str:
    """A warning, as stands above the sections."""
    return f'<p class="warning"><strong>{escape(label)}.</strong> {escape(text.removesuffix("."))}.</p>'


def details(sections: Iterable[tuple[str, str]]) -> str:
    """Headings and HTML in small print, from a new sheet on."""
    parts = "\n".join(f"<h2>{escape(heading)}</h2>\n{html}" for heading, html in sections)
    return f'<div class="details">\n{parts}\n</div>'


def terms(pairs: Iterable[tuple[str, str]], kind: str = "") -> str:
    """A list of terms and what they mean. kind : "short" or "names" for short and long terms, "two" for two columns."""
    rows = "\n".join(f"<div><dt>{escape(term)}</dt><dd>{escape(said)}</dd></div>" for term, said in pairs)
    opened = f'<dl class="{kind}">' if kind else "<dl>"
    return f"{opened}\n{rows}\n</dl>"


def table(columns: Sequence[Column], rows: Iterable[Sequence[str | Cell]]) -> str:
    """A table that scrolls sideways where it is too wide; the first cell of a row is its heading."""
    head = "".join(_head(column) for column in columns)
    body = "\n".join(f"<tr>{_row(row, columns)}</tr>" for row in rows)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>'


def _head(column: Column) -> str:
    small = f"<br><small>{escape(column.unit)}</small>" if column.unit else ""
    kind = ' class="text"' if column.is_text else ""
    return f'<th scope="col"{kind}>{escape(column.name)}{small}</th>'


def _row(cells: Sequence[str | Cell], columns: Sequence[Column]) -> str:
    found = []
    for number, (cell, column) in enumerate(zip(cells, columns, strict=True)):
        text, kind = cell if isinstance(cell, Cell) else (cell, "text" if column.is_text else "")
        tag, scope = ("th", ' scope="row"') if number == 0 else ("td", "")
        of_class = f' class="{escape(kind)}"' if kind else ""
        found.append(f"<{tag}{scope}{of_class}>{escape(text)}</{tag}>")
    return "".join(found)


def embedded(figure: Figure, alt: str, *, caption: str = "") -> str:
    """A plot embedded in the page, with its alternative text. caption : below it, unless empty."""
    dots = BytesIO()
    fit(figure)
    figure.savefig(dots, format="png", dpi=_DOTS)
    width, height = (round(96 * inches) for inches in figure.get_size_inches())
    source = f"data:image/png;base64,{b64encode(dots.getvalue()).decode('ascii')}"
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f'<figure><img src="{source}" width="{width}" height="{height}" alt="{escape(alt)}">{below}</figure>'


def side_by_side(*figures: str) -> str:
    """Figures beside each other where there is room."""
    return f'<div class="maps">{"".join(figures)}</div>'


def provenance(attributes: Mapping[Any, Any]) -> str:
    """When, by what and with what a dataset was computed, from its attributes."""
    return terms(((word, str(attributes.get(key, "not known"))) for word, key in _MADE_BY.items()), "short")


def configuration(text: str) -> str:
    """A configuration, to be read and to be copied; lists of plain values on one line (no text breaks a line)."""
    short = re.sub(r"\[\n[^\[\]{}]*\]", lambda found: re.sub(r"\n\s*", " ", found[0]), text)
    return f'<pre id="configuration">{escape(short)}</pre>'
