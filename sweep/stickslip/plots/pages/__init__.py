"""Pages: self-contained HTML files, without network or scripts, to read, to send and to print.

Their parts come from the templates in `page.html`, which escape all text; what goes out is HTML.
"""

import os
import re
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader
from matplotlib.figure import Figure

from stickslip.files.targets import check_target, replaced
from stickslip.plots.layout import fit
from stickslip.plots.palette import VERMILLION

_DOTS = 200  # per inch
_MADE_BY = {"computed": "date_created", "by": "source", "with": "software"}  # attributes of a dataset
_TEMPLATE = Environment(
    loader=PackageLoader("stickslip", "plots/pages"), autoescape=True, trim_blocks=True, keep_trailing_newline=True
).get_template("page.html")


class Section(NamedTuple):
    """A part of a page: its heading, plain text, and what is in it, HTML."""

    heading: str
    html: str


class Column(NamedTuple):
    """The head of a column: its name, the unit below it; text stands at the left, numbers at the right."""

    name: str
    unit: str = ""
    is_text: bool = False


class Cell(NamedTuple):
    """A cell of a table that looks different: the class in the style sheet."""

    text: str
    kind: str


def page(
    title: str, summary: str, sections: Sequence[Section | tuple[str, str]], *, warnings: Sequence[str] = (),
    style: str = "",
) -> str:  # fmt: skip
    """A page as text. title, summary : plain text. warnings : as `warning` makes them. style : more CSS."""
    return _TEMPLATE.render(
        title=title, summary=summary, sections=sections, warnings=warnings, style=style, red=VERMILLION
    )


def write_page(path: str | os.PathLike[str], text: str) -> Path:
    """Write a page, replacing `path` only once it is whole. Raises StoreError."""
    check_target(path, "page")
    with replaced(path) as temporary:
        temporary.write_bytes(text.encode(errors="backslashreplace"))
    return Path(path)


# --- parts ------------------------------------------------------------------------------------------------------------


def _part(macro: str, *arguments: Any) -> str:
    """A part as the template has it; no Markup, to which adding plain HTML would escape that."""
    return str(getattr(_TEMPLATE.module, macro)(*arguments)).strip("\n")


def paragraph(text: str) -> str:
    """A paragraph of plain text."""
    return _part("paragraph", text)


def warning(text: str, label: str = "Warning") -> str:
    """A warning, as stands above the sections."""
    return _part("warning", text.removesuffix("."), label)


def legend(text: str, entries: Iterable[tuple[str, str]]) -> str:
    """A line of plain text with entries, each of a class of the style sheet."""
    return _part("legend", text, entries)


def details(sections: Iterable[tuple[str, str]]) -> str:
    """Headings and HTML in small print, from a new sheet on."""
    return _part("details", sections)


def terms(pairs: Iterable[tuple[str, str]], kind: str = "") -> str:
    """A list of terms and what they mean. kind : "short" or "names" for short and long terms, "two" for two columns."""
    return _part("terms", pairs, kind)


def table(columns: Sequence[Column], rows: Iterable[Sequence[str | Cell]]) -> str:
    """A table that scrolls sideways where it is too wide; the first cell of a row is its heading."""
    kinds = ["text" if column.is_text else "" for column in columns]
    cells = ([cell if isinstance(cell, Cell) else (cell, kind) for cell, kind in zip(row, kinds, strict=True)]
             for row in rows)  # fmt: skip
    return _part("table", columns, cells)


def embedded(figure: Figure, alt: str, *, caption: str = "") -> str:
    """A plot embedded in the page, with its alternative text. caption : below it, unless empty."""
    png = BytesIO()
    fit(figure)
    figure.savefig(png, format="png", dpi=_DOTS)
    width, height = (round(96 * inches) for inches in figure.get_size_inches())
    return _part("figure", b64encode(png.getvalue()).decode("ascii"), width, height, alt, caption)


def side_by_side(*figures: str) -> str:
    """Figures beside each other where there is room."""
    return f'<div class="maps">{"".join(figures)}</div>'


def provenance(attributes: Mapping[Any, Any]) -> str:
    """When, by what and with what a dataset was computed, from its attributes."""
    return terms(((word, str(attributes.get(key, "not known"))) for word, key in _MADE_BY.items()), "short")


def configuration(text: str) -> str:
    """A configuration, to be read and to be copied; lists of plain values on one line (no text breaks a line)."""
    return _part("configuration", re.sub(r"\[\n[^\[\]{}]*\]", lambda part: re.sub(r"\n\s*", " ", part[0]), text))
