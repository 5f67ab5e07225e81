"""The page of a result: its pictures, and what one needs to read them without the program."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stickslip.config.yaml import parse_yaml
from stickslip.dataset.coarse import chunks
from stickslip.dataset.display import MapAxis, unit_of
from stickslip.dataset.summary import BAD_REGIMES, Share, codes, flag_counts, shares, summary
from stickslip.errors import ConfigError, PlotError
from stickslip.pages import (
    Cell,
    Column,
    Section,
    configuration,
    embedded,
    page,
    paragraph,
    provenance,
    table,
    terms,
    warning,
)
from stickslip.plots import kind_of, plot_map, plot_result
from stickslip.plots.fixed_values import fixed_values
from stickslip.plots.options import PLAIN, Look
from stickslip.plots.palette import FLAG_COLOURS, regime_label
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES, STATUSES

_OF_MAPS = ("acceleration_level_a", "regime", "period", "damping_ratio")  # whose pictures are on the page of a map
_KINDS = {"probability": "probability", "ramp": "ramp", "attractors": "share that settles"}  # of one picture
_BESIDE = ("_error", "_low", "_high", "_width")
_MOST_BORDERS = 300  # in the table of a page
_MOST_POINTS = 12  # of an axis that are all named
# Attributes that say where a dataset comes from, not what was found in it.
_COMMON = {
    "Conventions", "title", "source", "history", "references", "date_created", "software", "configuration",
    "institution", "incomplete",
}  # fmt: skip
_LINEAR = "where the damping ratio of steady sliding is 0 (below it any disturbance grows) and 1 (above it none swings)"
_STYLE = """\
.regime::before { content: ''; display: inline-block; width: .8em; height: .8em; margin-right: .5em;
  border: 1px solid #000; vertical-align: -.05em; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
th.regime { text-align: left; }
""" + "".join(f".is-{name}::before {{ background: {colour}; }}\n" for name, colour in FLAG_COLOURS["regime"].items())
_OBSERVED = ("settling_observed", "too_slow_to_tell")  # ends that are seen, not proven


class Picture(NamedTuple):
    """A picture of a page: what it shows, and the figure; None where the caption is the reason for its absence."""

    caption: str
    figure: Figure | None = None


def pictures_of(ds: xr.Dataset, look: Look = PLAIN, title: str | None = None) -> list[Picture]:
    """The pictures of a result that is no set of borders over a map, or of a part that fits.

    look : of maps. title : of all, unless None.
    """

    def picture(caption: str, draw: Callable[[], Figure]) -> Picture:
        try:
            return Picture(caption, draw())
        except PlotError as error:
            return Picture(f"{caption}: {error}")

    if caption := _KINDS.get(kind_of(ds)):
        return [picture(caption, partial(plot_result, ds, look=look, title=title))]
    names = [name for name in _OF_MAPS if name in ds.data_vars] or [str(name) for name in ds.data_vars][:1]
    names += [str(name) for name in ds.data_vars if str(name).startswith("margin_")]
    return [
        picture(str(ds[name].attrs.get("long_name", name)), partial(plot_map, ds, name, look=look, title=title))
        for name in names
    ]


def result_page(ds: xr.Dataset, pictures: Sequence[Picture], title: str | None = None) -> str:
    """The page of a map, of borders, attractors or probabilities, as text.

    pictures : its pictures (`pictures_of`). title : that of the dataset, unless given.
    """
    is_ramp = "direction" in ds.dims
    regimes = summary(ds) if "regime" in ds.data_vars and not is_ramp else None
    sections = []
    if pictures:
        shown = [paragraph(text) if plot is None else embedded(plot, text, caption=text) for text, plot in pictures]
        sections.append(Section("The pictures" if len(pictures) > 1 else "The picture", "\n".join(shown)))
    if regimes is not None:
        columns = Column("regime", is_text=True), Column("cells"), Column("share")
        rows = [(_swatch(name), f"{share.cells:,}", f"{share.fraction:.2%}") for name, share in regimes.items()]
        sections.append(Section("Shares of the regimes", table(columns, rows)))
        sections.append(Section("Cells that are not decided", _undecided(ds, regimes)))
    if "border" in ds.data_vars and "crossing" in ds["border"].dims:
        sections.append(Section("The borders", _borders(ds)))
    if own := {name: value for name, value in ds.attrs.items() if name not in _COMMON and isinstance(value, str)}:
        sections.append(Section("What was found", terms((_spoken(name), value) for name, value in own.items())))
    again = "" if is_ramp else "; saved as a file, it gives the same result again"
    origin = provenance(ds.attrs) + paragraph(f"The full configuration, in SI{again}:")
    sections += [
        Section("What varies, and what is held fixed", _quantities(ds)),
        Section("What the words mean", _words(ds, regimes or {})),
        Section("How exact the numbers are", terms(_accuracy(ds))),
        Section("Where this comes from", origin + configuration(str(ds.attrs.get("configuration", "not known")))),
    ]
    heading = str(ds.attrs.get("title", "")) if title is None else title
    summed = _summary(ds, regimes or {})
    return page(heading, summed, sections, warnings=_warnings(ds, regimes or {}), style=_STYLE)


def _summary(ds: xr.Dataset, regimes: Mapping[str, Share]) -> str:
    """`57,600 cells: spring stiffness (240) × belt speed (240). 50.0 % stick-slip, ...`."""
    name = next((name for name in ("regime", "probability", "settling_share", "border") if name in ds), None)
    sizes = {str(dim): ds.sizes[dim] for dim in (ds[name].dims if name else ()) if dim not in ("state", "crossing")}
    over = " × ".join(f"{_spoken(dim)} ({size:,})" for dim, size in sizes.items())
    count = int(np.prod(list(sizes.values())))
    text = f"{count:,} {'lines' if name == 'border' else 'cells'}: {over}." if sizes else ""
    parts = ", ".join(f"{share.fraction:.1%} {regime_label(regime)}" for regime, share in regimes.items())
    return f"{text} {parts}{'.' if parts else ''}".strip()


def _swatch(regime: str) -> Cell:
    return Cell(regime_label(regime), f"regime is-{regime}")


def _spoken(name: str) -> str:
    return name.replace("_", " ")


def _warnings(ds: xr.Dataset, regimes: Mapping[str, Share]) -> list[str]:
    """Reasons why the result is not whole."""
    texts = []
    if missing := ds.attrs.get("incomplete"):
        texts.append(warning(f"The result is incomplete: {missing}"))
    if bad := sum(regimes[name].cells for name in BAD_REGIMES if name in regimes):
        texts.append(warning(f"{bad:,} cell{'s are' if bad > 1 else ' is'} not decided; the reasons are below"))
    return texts


def _borders(ds: xr.Dataset) -> str:
    """Table of where the regime changes along each line, and between which regimes; and lines without a border."""
    border = ds["border"].transpose(..., "crossing")
    axes, unit = [MapAxis(ds, dim, plain=True) for dim in border.dims[:-1]], unit_of(ds["border"])
    rows: list[list[str | Cell]] = []
    for place in np.ndindex(border.shape[:-1]):
        where: list[str | Cell] = [axis.text(i) for axis, i in zip(axes, place, strict=True)]
        line = ds.isel(dict(zip(border.dims[:-1], place, strict=True)))
        crossings = [line.isel(crossing=int(i)) for i in np.flatnonzero(np.isfinite(line["border"].values))]
        for crossing in crossings:
            sides = (_swatch(REGIMES[int(crossing[name])]) for name in ("regime_below", "regime_above"))
            width = f"{unit.of(float(crossing['border_width'])):.2g} {unit.name}"
            rows.append([*where, unit.text(float(crossing["border"])), *sides, width])
        if not crossings:
            rows.append([*where, "none: one regime throughout", "", "", ""])
        if len(rows) >= _MOST_BORDERS:
            break
    along = _spoken(str(ds.attrs.get("border_parameter", "border")))
    names = [*map(_title, axes), along, "below it", "above it"]
    columns = [*(Column(name, is_text=True) for name in names), Column("known within")]
    short = paragraph(f"Only the first {len(rows)} are listed.") if len(rows) >= _MOST_BORDERS else ""
    return table(columns, rows) + short


def _undecided(ds: xr.Dataset, regimes: Mapping[str, Share]) -> str:
    """Table of cells without a regime, by the reason."""
    bad = [REGIMES.index(name) for name in BAD_REGIMES if name in regimes]
    if not bad:
        return paragraph("None: every cell has a regime.")
    if "status" not in ds.data_vars:
        return paragraph("The reasons were not stored (variable status).")
    counts = np.zeros(256, np.int64)
    for chunk in chunks(ds["regime"]):
        open_cells = np.isin(codes(ds["regime"].isel(chunk)), bad)
        counts += np.bincount(codes(ds["status"].isel(chunk))[open_cells], minlength=256)
    reasons = shares({STATUSES[code]: int(counts[code]) for code in range(len(STATUSES))})
    rows = [[_spoken(name), f"{share.cells:,}", STATUS_MESSAGES[name]] for name, share in reasons.items()]
    columns = Column("reason", is_text=True), Column("cells"), Column("what it means", is_text=True)
    return table(columns, rows)


def _quantities(ds: xr.Dataset) -> str:
    """Axes with their ends, then what is equal in all cells, in the units in which the configuration was written."""
    axes = [MapAxis(ds, dim, plain=True) for dim in ds.dims if dim not in ("state", "quantity", "quantile",
            "crossing", "line", "node", "direction")]  # fmt: skip
    fixed = [(name, value.replace("$^{", "^").replace("}$", "")) for name, value in fixed_values(ds)]
    return terms([*((_title(axis), _range(axis)) for axis in axes), *fixed], "two")


def _title(axis: MapAxis) -> str:
    return axis.title.partition(" (")[0]


def _range(axis: MapAxis) -> str:
    """`0.01 m/s to 1.2 m/s, 240 points`, or the points themselves where they are few or have names."""
    if axis.length <= _MOST_POINTS:
        return "; ".join(axis.text(i) for i in range(axis.length))
    spacing = ", logarithmic" if axis.is_log else ""
    return f"{axis.text(0)} to {axis.text(axis.length - 1)}, {axis.length:,} points{spacing}"


def _words(ds: xr.Dataset, regimes: Mapping[str, Share]) -> str:
    """Regimes that occur or may occur, and variables that do not stand beside another one (errors, bounds, ...)."""
    may_occur = [str(name) for name in ds["state"].values] if "state" in ds.coords else REGIMES[1:6]
    rows = [(regime_label(name), REGIME_MESSAGES[name]) for name in REGIMES if name in (regimes or may_occur)]
    names = [
        name for name in map(str, ds.data_vars)
        if ds[name].attrs.get("long_name") and not name.endswith(_BESIDE)
        and not name.startswith(("mean_", "quantile_", "count_"))
    ]  # fmt: skip
    rows += [(_spoken(name), _meaning(ds, name)) for name in names if not regimes or name in _OF_MAPS[2:]]
    rows += [(_spoken(name), _meaning(ds, name)) for name in names if name.startswith("margin_")]
    if regimes and "damping_ratio" in ds.data_vars:
        rows.append(("borders (linear)", _LINEAR))
    return terms(rows)


def _meaning(ds: xr.Dataset, name: str) -> str:
    attributes = ds[name].attrs
    comment = "" if "flag_values" in attributes or "flag_masks" in attributes else attributes.get("comment", "")
    return "; ".join(filter(None, [str(attributes.get("long_name", name)), str(comment)]))


def _accuracy(ds: xr.Dataset) -> Iterator[tuple[str, str]]:
    solver = _solver(ds)
    rtol, horizon = solver.get("rtol"), solver.get("horizon")
    if rtol is not None:
        meaning = "each step keeps its error below it, in units of the load over the stiffness"
        yield "relative tolerance", f"{rtol:g}: {meaning}"
    yield "horizon", "none: a cell ends when its regime is certain" if horizon is None else f"{horizon:g} s"
    if "regime" in ds.data_vars and "status" in ds.data_vars:
        counts = flag_counts(ds["status"])
        seen = sum(counts[name] for name in _OBSERVED)
        yield "proven", "all regimes" if not seen else f"all regimes but {seen:,}, which were observed"
    if "regime" in ds.data_vars and "direction" not in ds.dims:
        meaning = "a border between regimes lies within the width of a cell"
        yield "edges", f"{meaning}; stickslip border and stickslip contours find it exactly"


def _solver(ds: xr.Dataset) -> dict[str, Any]:
    """The section solver of the configuration, as far as it can be read."""
    try:
        data = parse_yaml(str(ds.attrs.get("configuration", ""))).data
    except ConfigError:
        return {}
    solver = data.get("solver") if isinstance(data, dict) else None
    return solver if isinstance(solver, dict) else {}
