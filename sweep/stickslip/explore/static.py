"""A page that needs no server: everything it can answer is computed beforehand, and in the one file."""

from __future__ import annotations

from dataclasses import replace
from heapq import heappop, heappush
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.events import Tap
from bokeh.models import Column, CustomJS, Select
from bokeh.resources import INLINE
from numpy.typing import NDArray

from stickslip._version import __version__
from stickslip.config.pick import cell_of
from stickslip.engine import stop_flag
from stickslip.explore import maps
from stickslip.explore.borders import border_lines
from stickslip.explore.figures import NO_SAMPLES, NOTHING, axis_words, data_of, regions_of, surroundings, units_of
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, Motion, motions_of
from stickslip.explore.page import WIDGETS, Page, columns_of, template, template_variables, words
from stickslip.explore.subject import Subject
from stickslip.explore.told import cell_html, legend_html, numbers_html, place_words, simulate_command
from stickslip.explore.view import View, cell_config, config_of, first_view, is_as_opened
from stickslip.files.atomic import replaced

MOST: tuple[int, int] = (160, 200)  # pixels; the file is to be sent
CELLS: tuple[int, int] = (10, 14)  # whose motions are kept
_SAMPLES, _FEW = 600, 80  # of a motion: at most; so few that none is left out
_DEVIATION = 2e-3  # of the range of what is drawn: less than a pixel
_DRAWN = ("displacement", "velocity", "friction_coefficient")
_MOVED = ("stick", "sliding")

_NEAREST = '<span class="note">the nearest cell whose motion is in this page</span>'

_VARY = """
const one = pictures[this.value]
mapper.palette = one.palette
cells.data = {...cells.data, image: [one.shades]}
regions.data = one.regions
legend.text = one.legend
"""
_CLICK = """
const meta = columns.tags[0]
const [wide, high] = [meta.x.high - meta.x.low, meta.y.high - meta.y.low]
if (cb_obj.x < meta.x.low || cb_obj.x > meta.x.high || cb_obj.y < meta.y.low || cb_obj.y > meta.y.high) return
let nearest = null, least = Infinity
for (const one of found) {
  const away = ((one.x - cb_obj.x)/wide)**2 + ((one.y - cb_obj.y)/high)**2
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
    view, page = first_view(subject), Page(subject)
    pictures = _pictures(subject, view)
    first = pictures["regime"]
    page.show_map(first)
    config = config_of(subject, view, MOST)
    page.map.draw_borders(border_lines(config, first, stop_flag()) or [])
    found = [_kept(subject, view, first, i, j) for i, j in _places(first)]
    _let_click(page, found)
    below = words("below", _about(subject, len(found), first, config.to_yaml()))
    roots = [_variables(page, pictures), *page.roots, below]
    document = Document()
    with document.models.freeze():
        for root in roots:
            document.add_root(root)
    names = [str(root.name) for root in roots]
    return str(
        file_html(document, INLINE, f"{subject.config.title} - stickslip", template=template(),
                  template_variables=template_variables(subject, names))
    )  # fmt: skip


def _pictures(subject: Subject, view: View) -> dict[str, Picture]:
    """The map in every variable."""
    if subject.computed is not None and is_as_opened(subject, view):
        dataset: Any = maps.read(subject, view)
    else:
        dataset = maps.computed(config_of(subject, view, MOST), stop_flag())
    offered = [name for name, _ in maps.variables(dataset)]
    return {name: maps.picture(dataset, replace(view, variable=name), MOST) for name in offered}


def _places(shown: Picture) -> list[tuple[int, int]]:
    """The pixels whose motions are kept: spread evenly; of listed points all, where they are not too many."""
    rows, columns = (
        np.unique(((np.arange(n := min(most, length)) + 0.5) * length / n).astype(int))
        for most, length in zip(CELLS, shown.shades.shape, strict=True)
    )
    return [(int(i), int(j)) for i in rows for j in columns]


def _kept(subject: Subject, view: View, shown: Picture, i: int, j: int) -> dict[str, Any]:
    """What the page says and draws of the cell of a pixel."""
    at = {shown.y.name: shown.y.at(i), shown.x.name: shown.x.at(j)}
    motions = motions_of(cell_of(cell_config(subject, view, at)), subject.options)
    short = replace(motions, stick=_thinned(motions.stick),
                    sliding=None if motions.sliding is None else _thinned(motions.sliding))  # fmt: skip
    where = place_words(shown, at)
    command = f"<pre>{simulate_command(subject, view, at, motions)}</pre>"
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


def _let_click(page: Page, found: list[dict[str, Any]]) -> None:
    """Have a click draw the nearest of the cells that are kept."""
    cell = page.cell
    sources = {name: cell.sources[name] for name in _MOVED}
    sources |= {"cycle": cell.cycle, "curve": cell.curve, "steady": cell.steady, "blank": cell.blank}
    given = {
        "found": found, "columns": page.columns, "sources": sources, "marks": page.map.marks, "belt": cell.belt,
        "plots": {str(plot.name): plot for plot in cell.plots}, "cell_words": page.cell_words, "numbers": page.numbers,
    }  # fmt: skip
    page.map.plot.js_on_event(Tap, CustomJS(args=given, code=_CLICK))


def _variables(page: Page, pictures: dict[str, Picture]) -> Column:
    """The choice of the variable."""
    shown = {
        name: {
            "shades": one.shades,
            "legend": legend_html(one),
            "palette": page.map.palette_of(one),
            "regions": regions_of(one),
        }
        for name, one in pictures.items()
    }
    options = [(name, one.title) for name, one in pictures.items()]
    select = Select(title="colours show", options=options, value="regime", name="variable", stylesheets=[WIDGETS],
                    sizing_mode="stretch_width")  # fmt: skip
    args = {"pictures": shown, "mapper": page.map.mapper, "cells": page.map.cells, "legend": page.legend}
    args["regions"] = page.map.regions
    select.js_on_change("value", CustomJS(args=args, code=_VARY))
    return Column(children=[select], name="controls", sizing_mode="stretch_width")


def _about(subject: Subject, kept: int, shown: Picture, yaml: str) -> str:
    """What the page is, and what computes it again."""
    sides = f"{shown.shades.shape[0]} x {shown.shades.shape[1]}"
    return (
        f'<p class="note">Computed beforehand by stickslip {__version__}: {sides} cells, and the motions of {kept} of '
        "them. A click shows the nearest of these. Sliders, and the motion of any cell: "
        f"<code>stickslip explore {escape(subject.source)}</code></p>"
        f"<details><summary>the map as YAML</summary><pre>{escape(yaml)}</pre></details>"
    )
