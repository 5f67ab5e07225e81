"""A page that needs no server: everything it can answer is computed beforehand, and in the one file."""

from dataclasses import replace
from heapq import heappop, heappush
from itertools import product
from math import prod
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.events import Tap
from bokeh.models import Column, ColumnDataSource, Select
from bokeh.resources import INLINE
from numpy.typing import NDArray

from stickslip._version import __version__
from stickslip.config.model import Axis, Range
from stickslip.engine import stop_flag
from stickslip.plots import pages
from stickslip.vocabulary.display_units import spoken
from stickslip_explore import maps, page
from stickslip_explore.html import cell_html, legend_html, numbers_html, part, place_words, simulate_command
from stickslip_explore.maps import MapPicture
from stickslip_explore.motions import Motion, motions_of
from stickslip_explore.view import Sides, Source, View, cell_of_view, config_of, first_view, is_listed, labels_of

MOST: Sides = (160, 200)  # pixels; the file is to be sent
CELLS: Sides = (10, 14)  # whose motions are in it
SHEETS = 8  # maps in a page, of all points of what is no side
_SAMPLES, _FEW = 600, 80  # of a motion: at most; so few that none is left out
_DEVIATION = 2e-3  # of the range of what is drawn: less than a pixel
_DRAWN = ("displacement", "velocity", "friction_coefficient")
_SOURCES = ("stick", "sliding", "cycle", "curve", "steady", "blank")
_NEAREST = "the nearest cell whose motion is in this page"


def write_page(source: Source, target: Path) -> Path:
    """Write the page into a file that ends in .html, or into a folder, under the name of what is explored; its path."""
    if target.suffix.lower() not in (".html", ".htm"):
        target = target / f"{Path(source.name.rstrip('/')).stem}.html"
    target.parent.mkdir(parents=True, exist_ok=True)
    return pages.write_page(target, page_html(source))


def page_html(source: Source) -> str:
    """The page as one HTML document, scripts included. Of where the file lies it says nothing: it is to be sent."""
    source = replace(source, name=PurePath(source.name).name)
    whole, (title, points) = page.Page(source), _points(source)
    sheets = [_sheet(source, view, len(points)) for _, view in points]
    pictures, data = sheets[0]
    first = pictures["regime"]
    whole.show_map(first)
    about = part("about", __version__, len(sheets), " x ".join(map(str, first.shades.shape)), len(data["cells"]),
                 source.name)  # fmt: skip
    below = page.words("below", about + part("yaml", config_of(source, points[0][1], MOST).to_yaml()))
    document = Document()
    controls = _controls(whole, title, [label for label, _ in points], pictures, [data for _, data in sheets])
    whole.fill(document, [controls, *whole.roots, below], (*source.notes, *left_out(source)))
    return str(
        file_html(document, INLINE, document.title, template=document.template,
                  template_variables=document.template_variables)
    )  # fmt: skip


def left_out(source: Source) -> list[str]:
    """The axes of which such a page has one point only, in words."""
    plane, offered = first_view(source).plane, _offered(source)
    fixed = [axis for axis in source.axes.values() if axis.name not in plane and axis not in offered and axis.size > 1]
    return [
        f"{spoken(axis.name)} is held at {labels_of(source, axis)[_fixed_at(axis)]}: the other {axis.size - 1} points "
        "are not in this page"
        for axis in fixed
    ]


def _offered(source: Source) -> list[Axis]:
    """The axes that are no sides and of which the page has all points: as many as fit, the innermost first."""
    plane, offered = first_view(source).plane, list[Axis]()
    for axis in reversed(tuple(source.axes.values())):
        if axis.name not in plane and axis.size > 1 and axis.size * prod(other.size for other in offered) <= SHEETS:
            offered.insert(0, axis)
    return offered


def _fixed_at(axis: Axis) -> int:
    """The point of an axis where nobody chose another."""
    return axis.size // 2 if isinstance(axis, Range) else 0


def _points(source: Source) -> tuple[str, list[tuple[str, View]]]:
    """The choice besides the sides: its title, and its points as names and views."""
    view, offered = first_view(source), _offered(source)
    points = []
    for places in product(*(range(axis.size) for axis in offered)):
        at = list(zip(offered, places, strict=True))
        listed = {axis.name: i for axis, i in at if is_listed(axis)}
        values = {axis.name: float(axis.points()[i]) for axis, i in at if isinstance(axis, Range)}
        label = ", ".join(labels_of(source, axis)[i] for axis, i in at)
        points.append((label, replace(view, points=listed, values=values)))
    return ", ".join(spoken(axis.name) for axis in offered), points


def _sheet(source: Source, view: View, count: int) -> tuple[dict[str, MapPicture], dict[str, Any]]:
    """The map of a view, one of `count`: its pictures by variable, and with its borders and cells, for `page.js`.

    With many maps each has fewer pixels and fewer motions.
    """
    most, cells = (_share(sides, room / count) for sides, room in ((MOST, 2.0), (CELLS, 1.3)))
    if source.computed is not None and {*view.plane, *view.values} <= set(source.axes):
        dataset: Any = maps.read(source, view)
    else:
        dataset = maps.computed(config_of(source, view, most), stop_flag())
    pictures = {name: maps.picture(dataset, replace(view, variable=name), most) for name, _ in maps.variables(dataset)}
    first = pictures["regime"]
    return pictures, {
        "pictures": {
            name: {"shades": shown.shades, "legend": legend_html(shown), "palette": shown.palette,
                   "regions": page.regions_of(shown)}
            for name, shown in pictures.items()
        },
        "columns": page.columns_of(first), "meta": page.meta_of(first),
        "cells": [_cell(source, view, first, i, j) for i, j in _places(first, cells)],
    }  # fmt: skip


def _share(sides: Sides, share: float) -> Sides:
    """Sides of a share of an area, none above 1."""
    rows, columns = (max(1, int(length * min(1.0, share) ** 0.5)) for length in sides)
    return rows, columns


def _places(shown: MapPicture, cells: Sides) -> list[tuple[int, int]]:
    """The pixels whose motions are in the page: spread evenly; of listed points all, where they are not too many."""
    rows, columns = (
        np.unique(((np.arange(n := min(most, length)) + 0.5) * length / n).astype(int))
        for most, length in zip(cells, shown.shades.shape, strict=True)
    )
    return [(int(i), int(j)) for i in rows for j in columns]


def _cell(source: Source, view: View, shown: MapPicture, i: int, j: int) -> dict[str, Any]:
    """The words and curves of the cell of a pixel, for `page.js`."""
    at = {shown.y.name: shown.y.at(i), shown.x.name: shown.x.at(j)}
    motions = motions_of(cell_of_view(source, view, at), source.options)
    drawn = page.cell_data(motions, {line: _thinned(motion) for line, motion in motions.motions.items()})
    light = {name: {key: np.asarray(v, np.float32) for key, v in drawn["data"][name].items()} for name in _SOURCES}
    command = part("command", simulate_command(source, view, at, motions))
    return drawn | {
        "x": float(shown.x.centres[j]), "y": float(shown.y.centres[i]), "data": light,
        "words": cell_html(motions, place_words(shown, at), at, _NEAREST),
        "numbers": numbers_html(motions.motions, shown.units) + command,
    }  # fmt: skip


def _thinned(motion: Motion) -> Motion:
    """A motion with the samples without which its lines would look different."""
    if motion.time.size <= _FEW:
        return motion
    lines = np.stack([motion.time, *(motion.samples[name] for name in _DRAWN)])
    at = essential(lines, _DEVIATION, _SAMPLES)
    return replace(motion, time=motion.time[at], samples={name: v[at] for name, v in motion.samples.items()})


def essential(lines: NDArray[np.float64], deviation: float, most: int) -> NDArray[np.intp]:
    """Positions of `most` samples that lines (rows, samples) over the first row need to deviate by less than a share of
    the range of each row (Ramer, Douglas and Peucker)."""
    spans = np.ptp(lines, axis=1)
    scaled = lines / np.where(spans > 0, spans, 1.0)[:, np.newaxis]
    places, waiting = [0, lines.shape[1] - 1], [_worst(scaled, 0, lines.shape[1] - 1)]
    while waiting and len(places) < most:
        away, at, first, last = heappop(waiting)
        if -away <= deviation:
            break
        places.append(at)
        for low, high in ((first, at), (at, last)):
            if high - low > 1:
                heappush(waiting, _worst(scaled, low, high))
    return np.sort(np.array(places, np.intp))


def _worst(lines: NDArray[np.float64], first: int, last: int) -> tuple[float, int, int, int]:
    """By how much (negative) and where a straight line between two samples is farthest from those between."""
    along = lines[0, first : last + 1]
    share = (along - along[0]) / (along[-1] - along[0]) if along[-1] > along[0] else np.linspace(0.0, 1.0, along.size)
    straight = lines[1:, first, np.newaxis] + share * (lines[1:, last] - lines[1:, first])[:, np.newaxis]
    away = np.abs(lines[1:, first : last + 1] - straight).max(axis=0)
    at = int(away.argmax())
    return -float(away[at]), first + at, first, last


def _controls(
    whole: page.Page, title: str, labels: list[str], pictures: dict[str, MapPicture], sheets: list[dict[str, Any]]
) -> Column:
    """The choice of the variable, and of the point; and the clicks, which draw the nearest cell that has a motion."""
    wide: dict[str, Any] = {"stylesheets": [page.WIDGETS], "sizing_mode": "stretch_width"}
    variable = Select(title="colours show", options=[(name, shown.title) for name, shown in pictures.items()],
                      value="regime", name="variable", **wide)  # fmt: skip
    point = Select(title=title, options=[(str(i), label) for i, label in enumerate(labels)], value="0", name="point",
                   visible=len(labels) > 1, **wide)  # fmt: skip
    given = {
        "sheets": ColumnDataSource({}, name="sheets", tags=sheets),
        "variable": variable, "point": point, "mapper": whole.map.mapper, "cells": whole.map.cells,
        "regions": whole.map.regions, "legend": whole.legend, "columns": whole.map.columns,
        "mark": whole.map.mark, "belt": whole.cell.belt, "plots": whole.cell.plots,
        "sources": {name: whole.cell.sources[name] for name in _SOURCES},
        "cell_words": whole.cell_words, "numbers": whole.numbers,
    }  # fmt: skip
    variable.js_on_change("value", page.calling("paint", **given))
    point.js_on_change("value", page.calling("turn", **given))
    whole.map.plot.js_on_event(Tap, page.calling("click", **given))
    return Column(children=[point, variable], name="controls", sizing_mode="stretch_width")
