"""The page of a result: its pictures, and what one needs to read them without the program."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from stickslip.config.yaml import parse_yaml
from stickslip.dataset.axis import MapAxis
from stickslip.dataset.coarse import chunks
from stickslip.dataset.display import unit_of
from stickslip.dataset.summary import BAD_REGIMES, Share, codes, shares, summary
from stickslip.errors import ConfigError, PlotError
from stickslip.pages.frame import Section, page
from stickslip.pages.parts import Cell, Column, configuration, embedded, paragraph, provenance, table, terms, warning
from stickslip.plots import plot_map, plot_result
from stickslip.plots.held import held_fixed
from stickslip.plots.look import PLAIN, Look
from stickslip.plots.palette import FLAG_COLOURS
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES, STATUSES, flag_label

_OF_MAPS = (
    "acceleration_level_a",
    "regime",
    "period",
    "damping_ratio",
)  # variables whose pictures are on the page of a map
_SAME_AGAIN = "; saved as a file, it gives the same result again"
_BESIDE = ("_error", "_low", "_high", "_width")
_MOST_BORDERS = 300  # in the table of a page
_MOST_POINTS = 12  # of an axis that are all named
# Attributes that say where a dataset comes from, not what was found in it.
_COMMON = {
    "Conventions", "title", "source", "history", "references", "date_created", "software", "configuration",
    "institution", "incomplete",
}  # fmt: skip
_LINEAR = "where the damping ratio of steady sliding is 0 (below it any disturbance grows) and 1 (above it none swings)"
_SWATCH = """\
.regime::before { content: ''; display: inline-block; width: .8em; height: .8em; margin-right: .5em;
  border: 1px solid #000; vertical-align: -.05em; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
th.regime { text-align: left; }"""
_OBSERVED = ("settling_observed", "too_slow_to_tell")  # ends that are seen, not proven


class Drawn(NamedTuple):
    """A picture of a page: what it shows, and the figure, or nothing where `said` is the reason for its absence."""

    said: str
    figure: Figure | None = None


def drawn_of(ds: xr.Dataset, look: Look = PLAIN, title: str | None = None) -> list[Drawn]:
    """The pictures of a result that is no set of borders over a map, or of a part that fits.

    look : of maps. title : of all, unless None.
    """
    kinds = {"probability": "probability", "direction": "ramp", "settling_share": "share that settles"}
    if kind := next((said for name, said in kinds.items() if name in ds or name in ds.dims), None):
        return [_tried(kind, lambda: plot_result(ds, look=look, title=title))]
    names = [name for name in _OF_MAPS if name in ds.data_vars] or [str(name) for name in ds.data_vars][:1]
    names += [str(name) for name in ds.data_vars if str(name).startswith("margin_")]
    return [
        _tried(str(ds[name].attrs.get("long_name", name)), lambda name=name: plot_map(ds, name, look=look, title=title))
        for name in names
    ]


def _tried(said: str, draw: Any) -> Drawn:
    try:
        return Drawn(said, draw())
    except PlotError as error:
        return Drawn(f"{said}: {error}")


def result_page(ds: xr.Dataset, drawn: Sequence[Drawn], title: str | None = None) -> str:
    """The page of a map, of borders, attractors or probabilities, as text.

    drawn : its pictures (`drawn_of`). title : that of the dataset, unless given.
    """
    sections = [Section("The pictures" if len(drawn) > 1 else "The picture", _pictures(drawn))] if drawn else []
    is_map = "regime" in ds.data_vars and "direction" not in ds.dims
    found = summary(ds) if is_map else {}
    if is_map:
        sections.append(Section("Shares of the regimes", _shares(found)))
        sections.append(Section("Cells that are not decided", _undecided(ds, found)))
    if "border" in ds.data_vars and "crossing" in ds["border"].dims:
        sections.append(Section("The borders", _borders(ds)))
    if told := {name: value for name, value in ds.attrs.items() if name not in _COMMON and isinstance(value, str)}:
        sections.append(Section("What was found", terms((_spoken(name), value) for name, value in told.items())))
    sections.append(Section("What varies, and what is held fixed", _quantities(ds)))
    sections.append(Section("What the words mean", _words(ds, found)))
    sections.append(Section("How exact the numbers are", _accuracy(ds)))
    again = paragraph(f"The full configuration, in SI{_SAME_AGAIN if 'direction' not in ds.dims else ''}:")
    text = configuration(str(ds.attrs.get("configuration", "not known")))
    sections.append(Section("Where this comes from", provenance(ds.attrs) + again + text))
    heading = str(ds.attrs.get("title", "")) if title is None else title
    return page(heading, _summary(ds, found), sections, warnings=_warnings(ds, found), style=_style())


def _summary(ds: xr.Dataset, found: dict[str, Share]) -> str:
    """`57,600 cells: spring stiffness (240) × belt speed (240). 50.0 % stick-slip, ...`."""
    name = next((name for name in ("regime", "probability", "settling_share", "border") if name in ds), None)
    sizes = {str(dim): ds.sizes[dim] for dim in (ds[name].dims if name else ()) if dim not in ("state", "crossing")}
    over = " × ".join(f"{dim.replace('_', ' ')} ({size:,})" for dim, size in sizes.items())
    count = int(np.prod(list(sizes.values()))) if sizes else 1
    what = "lines" if name == "border" else "cells"
    told = f"{count:,} {what}: {over}." if sizes else ""
    parts = [f"{share.fraction:.1%} {_label(regime)}" for regime, share in found.items()]
    return f"{told} {', '.join(parts)}{'.' if parts else ''}".strip()


def _label(regime: str) -> str:
    return flag_label(regime).replace("stick_slip", "stick-slip").replace("not_computed", "not computed")


def _spoken(name: str) -> str:
    return name.replace("_", " ")


def _warnings(ds: xr.Dataset, found: dict[str, Share]) -> list[str]:
    """What keeps the result from being whole."""
    told = []
    if missing := ds.attrs.get("incomplete"):
        told.append(warning(f"The result is incomplete: {missing}"))
    if bad := sum(found[name].cells for name in BAD_REGIMES if name in found):
        told.append(warning(f"{bad:,} cell{'s are' if bad > 1 else ' is'} not decided; the reasons are below"))
    return told


def _style() -> str:
    """Swatches of the regimes in front of their names."""
    rules = [_SWATCH]
    rules += [f".is-{name}::before {{ background: {colour}; }}" for name, colour in FLAG_COLOURS["regime"].items()]
    return "\n".join(rules) + "\n"


def _pictures(drawn: Sequence[Drawn]) -> str:
    return "\n".join(
        paragraph(said) if figure is None else embedded(figure, said, caption=said) for said, figure in drawn
    )


def _borders(ds: xr.Dataset) -> str:
    """Where the regime changes along each line, and between which regimes; and lines without a border."""
    border = ds["border"].transpose(..., "crossing")
    axes, unit = [MapAxis(ds, dim, plain=True) for dim in border.dims[:-1]], unit_of(ds["border"])
    rows: list[list[str | Cell]] = []
    for place in np.ndindex(border.shape[:-1]):
        where: list[str | Cell] = [axis.text(i) for axis, i in zip(axes, place, strict=True)]
        line = ds.isel(dict(zip(border.dims[:-1], place, strict=True)))
        found = [line.isel(crossing=int(i)) for i in np.flatnonzero(np.isfinite(line["border"].values))]
        for one in found:
            below, above = (REGIMES[int(one[name])] for name in ("regime_below", "regime_above"))
            width = f"{unit.of(float(one['border_width'])):.2g} {unit.name}"
            rows.append([*where, unit.text(float(one["border"])), _swatched(below), _swatched(above), width])
        if not found:
            rows.append([*where, "none: one regime throughout", "", "", ""])
        if len(rows) >= _MOST_BORDERS:
            break
    columns = [*(Column(_title(axis), is_text=True) for axis in axes), Column(_spoken(_along(ds)), is_text=True),
               Column("below it", is_text=True), Column("above it", is_text=True), Column("known within")]  # fmt: skip
    short = len(rows) >= _MOST_BORDERS
    return table(columns, rows) + (paragraph(f"Only the first {len(rows)} are listed.") if short else "")


def _along(ds: xr.Dataset) -> str:
    return str(ds.attrs.get("border_parameter", "border"))


def _swatched(name: str) -> Cell:
    return Cell(_label(name), f"regime is-{name}")


def _shares(found: dict[str, Share]) -> str:
    columns = Column("regime", is_text=True), Column("cells"), Column("share")
    rows: list[list[str | Cell]] = [
        [Cell(_label(name), f"regime is-{name}"), f"{share.cells:,}", f"{share.fraction:.2%}"]
        for name, share in found.items()
    ]
    return table(columns, rows)


def _undecided(ds: xr.Dataset, found: dict[str, Share]) -> str:
    """How many cells have no regime, by the reason."""
    bad = [REGIMES.index(name) for name in BAD_REGIMES if name in found]
    if not bad:
        return paragraph("None: every cell has a regime.")
    if "status" not in ds.data_vars:
        return paragraph("The reasons were not stored (variable status).")
    counts = np.zeros(256, np.int64)
    for chunk in chunks(ds["regime"]):
        open_cells = np.isin(codes(ds["regime"].isel(chunk)), bad)
        counts += np.bincount(codes(ds["status"].isel(chunk))[open_cells], minlength=256)
    reasons = shares({STATUSES[code]: int(counts[code]) for code in range(len(STATUSES))})
    rows = [[name.replace("_", " "), f"{share.cells:,}", STATUS_MESSAGES[name]] for name, share in reasons.items()]
    columns = Column("reason", is_text=True), Column("cells"), Column("what it means", is_text=True)
    return table(columns, rows)


def _quantities(ds: xr.Dataset) -> str:
    """Axes with their ends, then what is equal in all cells, in the units in which the configuration was written."""
    dims = {dim: MapAxis(ds, dim, plain=True) for dim in ds.dims if dim not in ("state", "quantity", "quantile",
            "crossing", "line", "node", "direction")}  # fmt: skip
    varied = [(_title(axis), _range(axis)) for axis in dims.values()]
    fixed = [(name, value.replace("$^{", "^").replace("}$", "")) for name, value in held_fixed(ds)]
    return terms([*varied, *fixed], "two")


def _title(axis: MapAxis) -> str:
    return axis.title.partition(" (")[0]


def _range(axis: MapAxis) -> str:
    """`0.01 m/s to 1.2 m/s, 240 points`, or the points themselves where they are few or have names."""
    if axis.length <= _MOST_POINTS:
        return "; ".join(axis.text(i) for i in range(axis.length))
    spacing = ", logarithmic" if axis.is_log else ""
    return f"{axis.text(0)} to {axis.text(axis.length - 1)}, {axis.length:,} points{spacing}"


def _words(ds: xr.Dataset, found: dict[str, Share]) -> str:
    """Regimes that occur or may occur, and variables."""
    may_occur = [str(name) for name in ds["state"].values] if "state" in ds.coords else REGIMES[1:6]
    told = [(_label(name), REGIME_MESSAGES[name]) for name in REGIMES if name in (found or may_occur)]
    names = [str(name) for name in ds.data_vars if not _is_beside(str(name)) and ds[name].attrs.get("long_name")]
    told += [(_spoken(name), _meaning(ds, name)) for name in names if not found or name in _OF_MAPS[2:]]
    told += [(_spoken(name), _meaning(ds, name)) for name in names if name.startswith("margin_")]
    if found and "damping_ratio" in ds.data_vars:
        told.append(("borders (linear)", _LINEAR))
    return terms(told)


def _is_beside(name: str) -> bool:
    """Whether a variable stands beside another one: its error, its bounds, its statistics."""
    return name.endswith(_BESIDE) or name.startswith(("mean_", "quantile_", "count_"))


def _meaning(ds: xr.Dataset, name: str) -> str:
    attributes = ds[name].attrs
    comment = "" if "flag_values" in attributes or "flag_masks" in attributes else attributes.get("comment", "")
    return "; ".join(filter(None, [str(attributes.get("long_name", name)), str(comment)]))


def _accuracy(ds: xr.Dataset) -> str:
    return terms(_exact(ds))


def _exact(ds: xr.Dataset) -> Iterator[tuple[str, str]]:
    solver = _solver(ds)
    rtol = solver.get("rtol")
    if rtol is not None:
        meaning = "each step keeps its error below it, in units of the load over the stiffness"
        yield "relative tolerance", f"{rtol:g}: {meaning}"
    horizon = solver.get("horizon")
    yield "horizon", "none: a cell ends when its regime is certain" if horizon is None else f"{horizon:g} s"
    if "regime" in ds.data_vars and "status" in ds.data_vars:
        counts = np.zeros(256, np.int64)
        for chunk in chunks(ds["status"]):
            counts += np.bincount(codes(ds["status"].isel(chunk)), minlength=256)
        seen = int(sum(counts[STATUSES.index(name)] for name in _OBSERVED))
        yield "proven", "all regimes" if not seen else f"all regimes but {seen:,}, which were observed"
    if "regime" not in ds.data_vars or "direction" in ds.dims:
        return
    meaning = "a border between regimes lies within the width of a cell"
    yield "edges", f"{meaning}; stickslip border and stickslip contours find it exactly"


def _solver(ds: xr.Dataset) -> dict[str, Any]:
    """The section solver of the configuration, as far as it can be read."""
    try:
        data = parse_yaml(str(ds.attrs.get("configuration", ""))).data
    except ConfigError:
        return {}
    found = data.get("solver") if isinstance(data, dict) else None
    return found if isinstance(found, dict) else {}
