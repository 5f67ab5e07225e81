"""Pages: self-contained HTML files, without network or scripts, to read, to send and to print; and that of a result.

Their parts come from the templates in `page.html`, which escape all text; what goes out is HTML. The page of a result
has its pictures, and what one needs to read them without the program.
"""

import os
import re
from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from io import BytesIO
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import xarray as xr
from jinja2 import Environment, PackageLoader
from matplotlib.figure import Figure

from stickslip.config.studies import Regime, ReportTable, Study, result_class
from stickslip.config.yaml import section_in
from stickslip.dataset.coarse import BAD_REGIMES, Share, summary, survey
from stickslip.dataset.display import MapAxis
from stickslip.errors import PlotError
from stickslip.files.targets import check_target, replaced
from stickslip.plots import plot_map, plot_result, subject
from stickslip.plots.layout import fixed_values
from stickslip.plots.marks import PLAIN, Look
from stickslip.plots.palette import FLAG_COLOURS, VERMILLION, regime_label
from stickslip.vocabulary.quantities import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES

_DOTS = 200  # per inch
_MADE_BY = {"computed": "date_created", "by": "source", "with": "software"}  # attributes of a dataset
_TEMPLATE = Environment(
    loader=PackageLoader("stickslip", "plots"), autoescape=True, trim_blocks=True, keep_trailing_newline=True
).get_template("page.html")


class PageSection(NamedTuple):
    """A part of a page: its heading, plain text, and what is in it, HTML."""

    heading: str
    html: str


class Column(NamedTuple):
    """The head of a column: its name, the unit below it; text stands at the left, numbers at the right."""

    name: str
    unit: str = ""
    is_text: bool = False


class PageCell(NamedTuple):
    """A cell of a table that looks different: the class in the style sheet."""

    text: str
    kind: str


def page(
    title: str, summary: str, sections: Sequence[PageSection | tuple[str, str]], *, warnings: Sequence[str] = (),
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


def details(sections: Iterable[tuple[str, str]]) -> str:
    """Headings and HTML in small print, from a new sheet on."""
    return _part("details", sections)


def terms(pairs: Iterable[tuple[str, str]], kind: str = "") -> str:
    """A list of terms and what they mean. kind : "short" or "names" for short and long terms, "two" for two columns."""
    return _part("terms", pairs, kind)


def table(columns: Sequence[Column], rows: Iterable[Sequence[str | PageCell]]) -> str:
    """A table that scrolls sideways where it is too wide; the first cell of a row is its heading."""
    kinds = ["text" if column.is_text else "" for column in columns]
    cells = ([cell if isinstance(cell, PageCell) else (cell, kind) for cell, kind in zip(row, kinds, strict=True)]
             for row in rows)  # fmt: skip
    return _part("table", columns, cells)


def embedded(figure: Figure, alt: str, *, caption: str = "") -> str:
    """A plot embedded in the page, with its alternative text. caption : below it, unless empty."""
    png = BytesIO()
    figure.savefig(png, format="png", dpi=_DOTS)
    width, height = (round(96 * inches) for inches in figure.get_size_inches())
    return _part("figure", b64encode(png.getvalue()).decode("ascii"), width, height, alt, caption)


def provenance(attributes: Mapping[Any, Any]) -> str:
    """When, by what and with what a dataset was computed, from its attributes."""
    return terms(((word, str(attributes.get(key, "not known"))) for word, key in _MADE_BY.items()), "short")


def configuration(text: str) -> str:
    """A configuration, to be read and to be copied; lists of plain values on one line (no text breaks a line)."""
    return _part("configuration", re.sub(r"\[\n[^\[\]{}]*\]", lambda part: re.sub(r"\n\s*", " ", part[0]), text))


_OF_MAPS = ("regime", "period", "damping_ratio")  # whose pictures are on the page of a map
_BESIDE = ("_error", "_low", "_high", "_width")
_MOST_ROWS = 300  # of the table of a study
_MOST_POINTS = 12  # of an axis that are all named
# Attributes that say where a dataset comes from, not what was found in it.
_COMMON = {
    "Conventions", "title", "source", "history", "references", "date_created", "software", "configuration",
    "institution", "incomplete", "result",
}  # fmt: skip
_LINEAR = "where the damping ratio of steady sliding is 0 (below it any disturbance grows) and 1 (above it none swings)"
_STYLE = """\
.regime::before { content: ''; display: inline-block; width: .8em; height: .8em; margin-right: .5em;
  border: 1px solid #000; vertical-align: -.05em; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
th.regime { text-align: left; }
""" + "".join(f".is-{name}::before {{ background: {colour}; }}\n" for name, colour in FLAG_COLOURS["regime"].items())


class Picture(NamedTuple):
    """A picture of a page: what it shows, and the figure; None where the caption is the reason for its absence."""

    caption: str
    figure: Figure | None = None


def pictures_of(ds: xr.Dataset, look: Look = PLAIN, title: str | None = None) -> list[Picture]:
    """The pictures of a result that is not drawn over a map, or of a part that fits.

    look : of maps. title : of all, unless None.
    """

    def picture(caption: str, draw: Callable[[], Figure]) -> Picture:
        try:
            return Picture(caption, draw())
        except PlotError as error:
            return Picture(f"{caption}: {error}")

    study = result_class(ds)
    if study and study.caption:
        return [picture(study.caption, partial(plot_result, ds, look=look, title=title))]
    names = [name for name in dict.fromkeys((subject(ds), *_OF_MAPS)) if name in ds.data_vars]
    names = names or [str(name) for name in ds.data_vars][:1]
    names += study.mapped(ds) if study else ()
    return [
        picture(str(ds[name].attrs.get("long_name", name)), partial(plot_map, ds, name, look=look, title=title))
        for name in names
    ]


def result_page(ds: xr.Dataset, pictures: Sequence[Picture], title: str | None = None) -> str:
    """The page of a map, or of the result of a study, as text.

    pictures : its pictures (`pictures_of`). title : that of the dataset, unless given.
    """
    study, regimes = result_class(ds), summary(ds) if _is_of_cells(ds) else None
    sections = []
    if pictures:
        shown = [paragraph(text) if plot is None else embedded(plot, text, caption=text) for text, plot in pictures]
        sections.append(PageSection("The pictures" if len(pictures) > 1 else "The picture", "\n".join(shown)))
    if regimes is not None:
        sections.append(PageSection("Regimes of the cells, and how they were found", _regimes(ds)))
    if study and (own_table := study.table(ds)):
        sections.append(PageSection(own_table.title, _table_of(own_table)))
    own = {name: value for name, value in ds.attrs.items() if name not in _COMMON and getattr(value, "ndim", 0) == 0}
    if own:
        rest = ((_spoken(name), v if isinstance(v, str) else f"{v:.10g}") for name, v in own.items())
        sections.append(PageSection("What was found", terms(rest)))
    text = str(ds.attrs.get("configuration", "not known"))
    is_whole = not (isinstance(study, type) and issubclass(study, Study)) or f"\n{study.section.key}:" in text
    again = "; saved as a file, it gives the same result again" if is_whole else ""
    origin = provenance(ds.attrs) + paragraph(f"The full configuration, in SI{again}:")
    sections += [
        PageSection("What varies, and what is held fixed", _quantities(ds)),
        PageSection("What the words mean", _words(ds, regimes or {})),
        PageSection("How exact the numbers are", terms(_accuracy(ds))),
        PageSection("Where this comes from", origin + configuration(text)),
    ]
    heading = str(ds.attrs.get("title", "")) if title is None else title
    summed = _summary(ds, regimes or {})
    return page(heading, summed, sections, warnings=_warnings(ds, regimes or {}), style=_STYLE)


def _summary(ds: xr.Dataset, regimes: Mapping[str, Share]) -> str:
    """`57,600 cells: spring stiffness (240) × belt speed (240). 50.0 % stick-slip, ...`."""
    study, own = result_class(ds), _own_dims(ds)
    name = "regime" if "regime" in ds else subject(ds)
    sizes = {str(dim): ds.sizes[dim] for dim in (ds[name].dims if name in ds else ()) if dim not in own}
    over = " × ".join(f"{_spoken(dim)} ({size:,})" for dim, size in sizes.items())
    count = prod(sizes.values())
    text = f"{count:,} {study.places if study else 'cells'}: {over}." if sizes else ""
    parts = ", ".join(f"{share.fraction:.1%} {regime_label(regime)}" for regime, share in regimes.items())
    return f"{text} {parts}{'.' if parts else ''}".strip()


def _swatch(regime: str) -> PageCell:
    return PageCell(regime_label(regime), f"regime is-{regime}")


def _spoken(name: str) -> str:
    return name.replace("_", " ")


def _warnings(ds: xr.Dataset, regimes: Mapping[str, Share]) -> list[str]:
    texts = []
    if missing := ds.attrs.get("incomplete"):
        texts.append(warning(f"The result is incomplete: {missing}"))
    if bad := sum(regimes[name].cells for name in BAD_REGIMES if name in regimes):
        texts.append(warning(f"{bad:,} cell{'s are' if bad > 1 else ' is'} not decided; the reasons are below"))
    return texts


def _table_of(given: ReportTable) -> str:
    """The table of a study, as far as a page takes it."""
    rows = [[_swatch(cell) if isinstance(cell, Regime) else cell for cell in row]
            for row in islice(given.rows, _MOST_ROWS)]  # fmt: skip
    columns = [*(Column(name, is_text=True) for name in given.words), *map(Column, given.numbers)]
    short = paragraph(f"Only the first {len(rows)} are listed.") if len(rows) == _MOST_ROWS else ""
    return table(columns, rows) + short


def _is_of_cells(ds: xr.Dataset) -> bool:
    """True if there is one regime per cell."""
    return "regime" in ds.data_vars and not _own_dims(ds) & set(map(str, ds["regime"].dims))


def _own_dims(ds: xr.Dataset) -> set[str]:
    study = result_class(ds)
    return study.own_dims() if study else set()


def _regimes(ds: xr.Dataset) -> str:
    """Table of the cells by regime and status."""
    counts = survey(ds, limit=0).counts
    total = sum(counts.values())
    rows = [(_swatch(regime), f"{cells:,}", f"{cells / total:.2%}", STATUS_MESSAGES.get(status, status))
            for (regime, status), cells in counts.items()]  # fmt: skip
    columns = Column("regime", is_text=True), Column("cells"), Column("share"), Column("status", is_text=True)
    return table(columns, rows)


def _quantities(ds: xr.Dataset) -> str:
    """Axes with their ends, then what is equal in all cells, in the units in which the configuration was written."""
    axes = [MapAxis(ds, dim, plain=True) for dim in ds.dims if dim not in _own_dims(ds)]
    fixed = [(name, value.replace("$^{", "^").replace("}$", "")) for name, value in fixed_values(ds)]
    return terms([*((axis.name, _range(axis)) for axis in axes), *fixed], "two")


def _range(axis: MapAxis) -> str:
    """`0.01 m/s to 1.2 m/s, 240 points`, or the points themselves where they are few or have names."""
    if axis.length <= _MOST_POINTS:
        return "; ".join(axis.text(i) for i in range(axis.length))
    spacing = ", logarithmic" if axis.is_log else ""
    return f"{axis.text(0)} to {axis.text(axis.length - 1)}, {axis.length:,} points{spacing}"


def _words(ds: xr.Dataset, regimes: Mapping[str, Share]) -> str:
    """Regimes that occur or may occur, and variables that do not stand beside another one (errors, bounds, ...)."""
    study = result_class(ds)
    may_occur = [str(name) for name in ds["state"].values] if "state" in ds.coords else REGIMES[1:6]
    rows = [(regime_label(name), REGIME_MESSAGES[name]) for name in REGIMES if name in (regimes or may_occur)]
    names = [
        name for name in map(str, ds.data_vars)
        if ds[name].attrs.get("long_name") and not name.endswith(_BESIDE)
        and not name.startswith(("mean_", "quantile_", "count_"))
    ]  # fmt: skip
    rows += [(_spoken(name), _meaning(ds, name)) for name in names if not regimes or name in _OF_MAPS[2:]]
    rows += [(_spoken(name), _meaning(ds, name)) for name in (study.mapped(ds) if study else ())]
    if regimes and "damping_ratio" in ds.data_vars:
        rows.append(("borders (linear)", _LINEAR))
    return terms(rows)


def _meaning(ds: xr.Dataset, name: str) -> str:
    attributes = ds[name].attrs
    comment = "" if "flag_values" in attributes or "flag_masks" in attributes else attributes.get("comment", "")
    return "; ".join(filter(None, [str(attributes.get("long_name", name)), str(comment)]))


def _accuracy(ds: xr.Dataset) -> Iterator[tuple[str, str]]:
    solver = section_in(str(ds.attrs.get("configuration", "")), "solver")
    rtol, horizon = solver.get("rtol"), solver.get("horizon")
    if rtol is not None:
        meaning = "each step keeps its error below it, in units of the load over the stiffness"
        yield "relative tolerance", f"{rtol:g}: {meaning}"
    yield "horizon", "none: a cell ends when its regime is certain" if horizon is None else f"{horizon:g} s"
    if _is_of_cells(ds):
        meaning = "a border between regimes lies within the width of a cell"
        yield "edges", f"{meaning}; stickslip border and stickslip contours find it exactly"
