"""A page that needs no server: everything it can answer is computed beforehand, and in the one file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from heapq import heappop, heappush
from html import escape
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.events import Tap
from bokeh.models import Column, ColumnDataSource, CustomJS, Select
from bokeh.resources import INLINE
from numpy.typing import NDArray

from stickslip._version import __version__
from stickslip.config.model import Axis, Range
from stickslip.config.select import cell_of
from stickslip.dataset.axis import spoken
from stickslip.engine import stop_flag
from stickslip.explore import maps, scripts
from stickslip.explore.borders import Line, border_lines
from stickslip.explore.figures import (
    NO_SAMPLES,
    NOTHING,
    axis_words,
    data_of,
    lines_of,
    regions_of,
    surroundings,
    units_of,
)
from stickslip.explore.knobs import is_listed, labels_of
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, Motion, motions_of
from stickslip.explore.page import WIDGETS, Page, columns_data, columns_of, template, template_variables, words
from stickslip.explore.subject import Subject
from stickslip.explore.told import cell_html, legend_html, numbers_html, place_words, simulate_command
from stickslip.explore.view import Sides, View, cell_config, config_of, first_view
from stickslip.files.atomic import replaced

MOST: Sides = (160, 200)  # pixels; the file is to be sent
CELLS: Sides = (10, 14)  # whose motions are kept
SHEETS = 8  # maps in a page, of all points of what is no side
_SAMPLES, _FEW = 600, 80  # of a motion: at most; so few that none is left out
_DEVIATION = 2e-3  # of the range of what is drawn: less than a pixel
_DRAWN = ("displacement", "velocity", "friction_coefficient")
_MOVED = ("stick", "sliding")

_NEAREST = '<span class="note">the nearest cell whose motion is in this page</span>'

_PAINT = """
const sheet = sheets.tags[Number(point.value)], one = sheet.pictures[variable.value]
mapper.palette = one.palette
cells.data = {...cells.data, image: [one.shades]}
regions.data = one.regions
legend.text = one.legend
"""
_DRAW = """
let nearest = null, least = Infinity
for (const one of sheet.found) {
  const away = ((one.x - at.x)/wide)**2 + ((one.y - at.y)/high)**2
  if (away < least) { least = away; nearest = one }
}
for (const [name, source] of Object.entries(sources)) source.data = nearest.data[name]
marks.data = {x: [nearest.x], y: [nearest.y], name: [""], colour: ["white"]}
for (const [plot, [x, y]] of Object.entries(nearest.axes)) {
  plots[plot].below[0].axis_label = x
  plots[plot].left[0].axis_label = y
}
for (const line of belt) { line.location = nearest.belt; line.visible = true }
cell_words.text = nearest.words
numbers.text = nearest.numbers
"""
_SIZE = """
const meta = columns.tags[0]
const [wide, high] = [meta.x.high - meta.x.low, meta.y.high - meta.y.low]
"""
_CLICK = f"""{_SIZE}
const sheet = sheets.tags[Number(point.value)], at = cb_obj
if (at.x < meta.x.low || at.x > meta.x.high || at.y < meta.y.low || at.y > meta.y.high) return
{_DRAW}"""
_TURN = f"""{_PAINT}
columns.data = sheet.columns
columns.tags = [sheet.meta]
lines.data = sheet.lines
if (marks.data.x.length == 0) return
{_SIZE}
const at = {{x: marks.data.x[0], y: marks.data.y[0]}}
{_DRAW}"""


@dataclass(frozen=True, eq=False)
class _Sheet:
    """The map where what is no side of it is at one point: its pictures by variable, its borders, the kept cells."""

    label: str
    pictures: dict[str, Picture]
    lines: list[Line]
    found: list[dict[str, Any]]

    @property
    def first(self) -> Picture:
        """The regimes."""
        return self.pictures["regime"]


def write_page(subject: Subject, target: Path) -> Path:
    """Write the page into a file that ends in .html, or into a folder, under the name of what is explored; its path."""
    if target.suffix.lower() not in (".html", ".htm"):
        target = target / f"{Path(subject.source.rstrip('/')).stem}.html"
    text = page_html(subject)
    target.parent.mkdir(parents=True, exist_ok=True)
    with replaced(target) as partial:
        partial.write_text(text, encoding="utf-8")
    return target


def page_html(subject: Subject) -> str:
    """The page as one HTML document, scripts included."""
    page, (title, points) = Page(subject), _points(subject)
    sheets = [_sheet(subject, label, view, len(points)) for label, view in points]
    first = sheets[0]
    page.show_map(first.first)
    page.map.draw_borders(first.lines)
    below = words("below", _about(subject, first, len(sheets), config_of(subject, points[0][1], MOST).to_yaml()))
    roots = [_controls(page, title, sheets), *page.roots, below]
    document = Document()
    with document.models.freeze():
        for root in roots:
            document.add_root(root)
    names = [str(root.name) for root in roots]
    told = replace(subject, notes=(*subject.notes, *left_out(subject)))
    return str(
        file_html(document, INLINE, f"{subject.config.title} - stickslip", template=template(),
                  template_variables=template_variables(told, names))
    )  # fmt: skip


def left_out(subject: Subject) -> list[str]:
    """What such a page has one point of only, in words."""
    plane = first_view(subject).plane
    held = [axis for axis in subject.axes.values() if axis.name not in plane and axis not in _offered(subject)]
    return [
        f"{spoken(axis.name)} is held at {labels_of(subject, axis)[_held_at(axis)]}: the other {axis.size - 1} points "
        "are not in this page"
        for axis in held
        if axis.size > 1
    ]


def _offered(subject: Subject) -> list[Axis]:
    """The axes that are no sides and of which the page has all points: as many as fit, the innermost first."""
    plane, found = first_view(subject).plane, list[Axis]()
    for axis in reversed(tuple(subject.axes.values())):
        if axis.name not in plane and axis.size > 1 and axis.size * prod(one.size for one in found) <= SHEETS:
            found.insert(0, axis)
    return found


def _held_at(axis: Axis) -> int:
    """The point at which an axis is held where nobody chose another."""
    return axis.size // 2 if isinstance(axis, Range) else 0


def _points(subject: Subject) -> tuple[str, list[tuple[str, View]]]:
    """What can be chosen besides the sides, as a title, and its points: names and views."""
    view, offered = first_view(subject), _offered(subject)
    found = []
    for places in product(*(range(axis.size) for axis in offered)):
        at = dict(zip((axis.name for axis in offered), places, strict=True))
        points = {axis.name: at[axis.name] for axis in offered if is_listed(axis)}
        values = {axis.name: float(axis.points()[at[axis.name]]) for axis in offered if isinstance(axis, Range)}
        label = ", ".join(labels_of(subject, axis)[at[axis.name]] for axis in offered)
        found.append((label, replace(view, points=points, values=values)))
    return ", ".join(spoken(axis.name) for axis in offered), found


def _sheet(subject: Subject, label: str, view: View, count: int) -> _Sheet:
    """The map of a view, one of `count`: with many of them each has fewer pixels and fewer motions."""
    most, cells = (_share(sides, room / count) for sides, room in ((MOST, 2.0), (CELLS, 1.3)))
    pictures = _pictures(subject, view, most)
    first = pictures["regime"]
    lines = border_lines(config_of(subject, view, most), first, stop_flag()) or []
    found = [_kept(subject, view, first, i, j) for i, j in _places(first, cells)]
    return _Sheet(label, pictures, lines, found)


def _share(sides: Sides, share: float) -> Sides:
    """Sides of a share of an area, none above 1."""
    rows, columns = (max(1, int(length * min(1.0, share) ** 0.5)) for length in sides)
    return rows, columns


def _pictures(subject: Subject, view: View, most: Sides) -> dict[str, Picture]:
    """The map in every variable."""
    if subject.computed is not None and {*view.plane, *view.values} <= set(subject.axes):
        dataset: Any = maps.read(subject, view)
    else:
        dataset = maps.computed(config_of(subject, view, most), stop_flag())
    offered = [name for name, _ in maps.variables(dataset)]
    return {name: maps.picture(dataset, replace(view, variable=name), most) for name in offered}


def _places(shown: Picture, cells: Sides) -> list[tuple[int, int]]:
    """The pixels whose motions are kept: spread evenly; of listed points all, where they are not too many."""
    rows, columns = (
        np.unique(((np.arange(n := min(most, length)) + 0.5) * length / n).astype(int))
        for most, length in zip(cells, shown.shades.shape, strict=True)
    )
    return [(int(i), int(j)) for i in rows for j in columns]


def _kept(subject: Subject, view: View, shown: Picture, i: int, j: int) -> dict[str, Any]:
    """What the page says and draws of the cell of a pixel."""
    at = {shown.y.name: shown.y.at(i), shown.x.name: shown.x.at(j)}
    motions = motions_of(cell_of(cell_config(subject, view, at)), subject.options)
    short = replace(motions, stick=_thinned(motions.stick),
                    sliding=None if motions.sliding is None else _thinned(motions.sliding))  # fmt: skip
    where = place_words(shown, at)
    command = f"<pre>{escape(simulate_command(subject, view, at, motions))}</pre>"
    return {
        "x": float(shown.x.centres[j]), "y": float(shown.y.centres[i]), **_drawn(short),
        "words": f"{cell_html(motions, where, at)}<br>{_NEAREST}",
        "numbers": numbers_html(columns_of(motions, {}), shown.units) + command,
    }  # fmt: skip


def _drawn(motions: CellMotions) -> dict[str, Any]:
    """What the figures show of a cell, for the script."""
    units = units_of([one for one in motions.motions if one.samples])
    lines = dict(zip(_MOVED, motions.motions, strict=False))
    around = surroundings(motions, units)
    data: dict[str, Any] = {name: NO_SAMPLES for name in _MOVED} | around
    data["blank"] = NOTHING
    data |= {name: data_of(motion, units) for name, motion in lines.items()}
    light = {name: {key: np.asarray(values, np.float32) for key, values in one.items()} for name, one in data.items()}
    axes = {name: list(words) for name, words in axis_words(units).items()}
    return {"data": light, "axes": axes, "belt": motions.cell["belt_speed"] / units.speed.factor}


def _thinned(motion: Motion) -> Motion:
    """A motion with the samples without which its lines would look different."""
    if motion.time.size <= _FEW:
        return motion
    lines = np.stack([motion.time, *(motion.samples[name] for name in _DRAWN)])
    kept = essential(lines, _DEVIATION, _SAMPLES)
    return replace(motion, time=motion.time[kept], samples={name: v[kept] for name, v in motion.samples.items()})


def essential(lines: NDArray[np.float64], deviation: float, most: int) -> NDArray[np.intp]:
    """Positions of the samples that lines over the first row, straight between them, need (Ramer, Douglas and Peucker).

    lines : (rows, samples). deviation : allowed, over the range of each row. The worst ones come first, up to `most`.
    """
    spans = np.ptp(lines, axis=1)
    scaled = lines / np.where(spans > 0, spans, 1.0)[:, np.newaxis]
    kept, waiting = [0, lines.shape[1] - 1], [_worst(scaled, 0, lines.shape[1] - 1)]
    while waiting and len(kept) < most:
        away, at, first, last = heappop(waiting)
        if -away <= deviation:
            break
        kept.append(at)
        for low, high in ((first, at), (at, last)):
            if high - low > 1:
                heappush(waiting, _worst(scaled, low, high))
    return np.sort(np.array(kept, np.intp))


def _worst(lines: NDArray[np.float64], first: int, last: int) -> tuple[float, int, int, int]:
    """By how much (negative) and where a straight line between two samples is farthest from those between."""
    along = lines[0, first : last + 1]
    share = (along - along[0]) / (along[-1] - along[0]) if along[-1] > along[0] else np.linspace(0.0, 1.0, along.size)
    straight = lines[1:, first, np.newaxis] + share * (lines[1:, last] - lines[1:, first])[:, np.newaxis]
    away = np.abs(lines[1:, first : last + 1] - straight).max(axis=0)
    at = int(away.argmax())
    return -float(away[at]), first + at, first, last


def _controls(page: Page, title: str, sheets: list[_Sheet]) -> Column:
    """The choice of the variable, and of the point; and the clicks, which draw the nearest of the cells kept."""
    named = [(name, one.title) for name, one in sheets[0].pictures.items()]
    variable = Select(title="colours show", options=named, value="regime", name="variable", stylesheets=[WIDGETS],
                      sizing_mode="stretch_width")  # fmt: skip
    labels = [(str(i), sheet.label) for i, sheet in enumerate(sheets)]
    point = Select(title=title, options=labels, value="0", name="point", stylesheets=[WIDGETS],
                   sizing_mode="stretch_width", visible=len(sheets) > 1)  # fmt: skip
    cell, told = page.cell, ColumnDataSource({}, name="sheets", tags=[_told(page, sheet) for sheet in sheets])
    sources = {name: cell.sources[name] for name in _MOVED}
    sources |= {"cycle": cell.cycle, "curve": cell.curve, "steady": cell.steady, "blank": cell.blank}
    given = {
        "sheets": told, "variable": variable, "point": point,
        "mapper": page.map.mapper, "cells": page.map.cells, "regions": page.map.regions, "legend": page.legend,
        "lines": page.map.lines, "columns": page.columns, "sources": sources, "marks": page.map.marks,
        "belt": cell.belt, "plots": {str(plot.name): plot for plot in cell.plots}, "cell_words": page.cell_words,
        "numbers": page.numbers,
    }  # fmt: skip
    variable.js_on_change("value", CustomJS(args=given, code=_PAINT))
    point.js_on_change("value", CustomJS(args=given, code=_TURN))
    page.map.plot.js_on_event(Tap, CustomJS(args=given, code=_CLICK))
    return Column(children=[point, variable], name="controls", sizing_mode="stretch_width")


def _told(page: Page, sheet: _Sheet) -> dict[str, Any]:
    """A sheet, for the scripts."""
    pictures = {
        name: {
            "shades": one.shades,
            "legend": legend_html(one),
            "palette": page.map.palette_of(one),
            "regions": regions_of(one),
        }
        for name, one in sheet.pictures.items()
    }
    return {
        "pictures": pictures, "found": sheet.found, "lines": lines_of(sheet.lines),
        "columns": columns_data(sheet.first), "meta": scripts.meta_of(sheet.first),
    }  # fmt: skip


def _about(subject: Subject, first: _Sheet, count: int, yaml: str) -> str:
    """What the page is, and what computes it again."""
    sides = f"{first.first.shades.shape[0]} x {first.first.shades.shape[1]}"
    maps_told = "" if count == 1 else f"{count} maps of "
    return (
        f'<p class="note">Computed beforehand by stickslip {__version__}: {maps_told}{sides} cells, and the motions of '
        f"{len(first.found)} of them. A click shows the nearest of these. Sliders, and the motion of any cell: "
        f"<code>stickslip explore {escape(subject.source)}</code></p>"
        f"<details><summary>the map as YAML</summary><pre>{escape(yaml)}</pre></details>"
    )
