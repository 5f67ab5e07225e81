"""The map and the four figures of a cell, drawn by Bokeh; what is drawn comes as arrays from the other files here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from bokeh.models import (
    BasicTicker,
    BasicTickFormatter,
    ColumnDataSource,
    CustomJSTicker,
    CustomJSTickFormatter,
    FixedTicker,
    LinearColorMapper,
    PlainText,
    Plot,
    Range1d,
    Span,
)
from bokeh.models.axes import Axis
from bokeh.plotting import figure

from stickslip.explore.maps import Line, Picture, Side
from stickslip.explore.motions import CellMotions, Motion
from stickslip.plots.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION
from stickslip.vocabulary.display_units import Unit, unit_for

_MOST_LABELS = 16
_LONGEST = 40  # letters of all labels along x, beyond which they are written at a slant

# Places are logarithms to base 10. Decades; with less of them in sight multiples; then even steps of the value.
_LOG_TICKS = """
const [low, high] = [Math.min(cb_data.start, cb_data.end), Math.max(cb_data.start, cb_data.end)]
const span = high - low
const found = []
if (span < 0.5) {
  const [a, b] = [10**low, 10**high]
  const raw = (b - a)/6, unit = 10**Math.floor(Math.log10(raw))
  const step = unit*[1, 2, 5, 10].find((k) => unit*k >= raw)
  for (let v = Math.ceil(a/step)*step; v <= b; v += step) found.push(Math.log10(v))
  return found
}
const every = Math.max(1, Math.ceil(span/9))
const factors = span > 3 ? [1] : span > 1.2 ? [1, 2, 5] : [1, 2, 3, 4, 5, 7]
for (let k = Math.floor(low); k <= Math.ceil(high); k++) {
  if (k % every == 0) for (const f of factors) found.push(k + Math.log10(f))
}
return found.filter((t) => t >= low - 1e-9 && t <= high + 1e-9)
"""
_LOG_MINOR = """
const [low, high] = [Math.min(cb_data.start, cb_data.end), Math.max(cb_data.start, cb_data.end)]
if (high - low > 6 || high - low < 0.5) return []
const found = []
for (let k = Math.floor(low); k <= Math.ceil(high); k++) for (let f = 1; f < 10; f++) found.push(k + Math.log10(f))
return found.filter((t) => t >= low && t <= high)
"""
_LOG_WORDS = """
const value = Number((10**tick).toPrecision(4))
return value >= 1e6 || value < 1e-4 ? value.toExponential().replace("e+", "e") : value.toString()
"""
# What a slider or a scale shows: a value in its unit, from its place; what is smaller than `least` came of rounding.
_PLACE_WORDS = """
const value = Number((log ? 10**tick : Math.abs(tick) < least ? 0 : tick).toPrecision(4))
return `${value} ${unit}`.trim()
"""


def quiet(plot: figure) -> figure:
    """A figure without the logo and with what all of them have in common."""
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    plot.min_border_right = 12
    plot.xgrid.grid_line_color = plot.ygrid.grid_line_color = "#e8e8e8"
    for axis in plot.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "12px"
        axis.axis_label_standoff = 4
        axis.major_label_text_font_size = "11px"
    return plot


def lay_out(plot: Plot, side: Side, which: str) -> None:
    """Give a side of a map its title and ticks; `which` is "x" or "y"."""
    (axis,) = plot.below if which == "x" else plot.left
    assert isinstance(axis, Axis)
    axis.axis_label = PlainText(text=side.title)  # a string would be searched for formulas
    axis.major_label_overrides = {}
    axis.major_label_orientation = "horizontal"
    if side.kind == "listed":
        _name_points(axis, side, which)
    elif side.kind == "log":
        axis.ticker = CustomJSTicker(major_code=_LOG_TICKS, minor_code=_LOG_MINOR)
        axis.formatter = CustomJSTickFormatter(code=_LOG_WORDS)
    else:
        axis.ticker, axis.formatter = BasicTicker(), BasicTickFormatter()


def _name_points(axis: Axis, side: Side, which: str) -> None:
    """Ticks at listed points, under their names."""
    step = -(-len(side.labels) // _MOST_LABELS)
    shown = range(0, len(side.labels), step)
    axis.ticker = FixedTicker(ticks=[*shown])
    axis.formatter = BasicTickFormatter()
    axis.major_label_overrides = {i: PlainText(text=side.labels[i]) for i in shown}
    if which == "x" and sum(len(side.labels[i]) for i in shown) > _LONGEST:
        axis.major_label_orientation = 0.6


def place_format(log: bool, unit: str, least: float) -> CustomJSTickFormatter:
    """Places on a slider as values in their unit. least : what is closer to zero is zero."""
    return CustomJSTickFormatter(code=_PLACE_WORDS, args={"log": log, "unit": unit, "least": least})


TOOLS = "box_zoom,pan,wheel_zoom,reset,save"
LINES: dict[str, tuple[str, str, float]] = {  # by motion: colour, dash, width
    "stick": (BLUE, "solid", 1.6),
    "sliding": (ORANGE, "dashed", 1.6),
    "A": (GREEN, "solid", 1.3),
    "B": (PURPLE, "dashdot", 1.3),
}
_MARKS = {"cell": "white", "A": GREEN, "B": PURPLE}
_NO_SAMPLES: dict[str, Any] = {"t": [], "x": [], "v": [], "w": [], "mu": []}
_NAMES = {"cycle": "unstable_cycle", "curve": "friction_curve", "steady": "steady_sliding", "blank": "blank"}
_SHADES = 256
_TICKS = 5  # along x: there is room for no more in a narrow window


class MapFigure:
    """The map: shades, exact borders, the cells that were chosen."""

    def __init__(self) -> None:
        self.plot = quiet(
            figure(tools=TOOLS, active_drag="box_zoom", x_range=Range1d(0, 1), y_range=Range1d(0, 1), name="map",
                   sizing_mode="stretch_both", min_height=280)
        )  # fmt: skip
        self.plot.grid.visible = False
        self.cells = ColumnDataSource({"image": [], "x": [], "y": [], "dw": [], "dh": []}, name="map_cells")
        self.lines = ColumnDataSource({"xs": [], "ys": []}, name="map_borders")
        self.marks = ColumnDataSource({"x": [], "y": [], "name": [], "colour": []}, name="map_marks")
        self.mapper = LinearColorMapper(palette=["#ffffff"] * _SHADES, low=-0.5, high=_SHADES - 0.5)
        self.plot.image("image", x="x", y="y", dw="dw", dh="dh", source=self.cells, color_mapper=self.mapper)
        self.plot.multi_line("xs", "ys", source=self.lines, line_color="black", line_width=3.4, line_join="round")
        self.plot.multi_line("xs", "ys", source=self.lines, line_color="white", line_width=1.7, line_join="round")
        self.regions = ColumnDataSource({"x": [], "y": [], "name": []}, name="map_regions")
        self.plot.text("x", "y", "name", source=self.regions, text_align="center", text_baseline="middle",
                       text_font_size="12px", text_color="black", background_fill_color="white",
                       background_fill_alpha=0.55, padding=2, border_radius=3)  # fmt: skip
        self.plot.scatter("x", "y", source=self.marks, size=13, marker="circle", fill_color="colour",
                          line_color="black", line_width=1.8)  # fmt: skip
        self.plot.text("x", "y", "name", source=self.marks, x_offset=9, y_offset=-7, text_color="black",
                       text_font_size="13px", text_font_style="bold", background_fill_color="white",
                       background_fill_alpha=0.75)  # fmt: skip
        self._sides: tuple[Any, ...] = ()

    def show(self, shown: Picture) -> None:
        """Draw a picture. What is in sight stays so as long as the sides are the same."""
        described = (shown.x.name, shown.x.kind, shown.x.unit, shown.y.name, shown.y.kind, shown.y.unit)
        if described != self._sides:
            document = self.plot.document
            with nullcontext() if document is None else document.models.freeze():  # else it counts them at each change
                lay_out(self.plot, shown.x, "x")
                lay_out(self.plot, shown.y, "y")
                for in_sight, (low, high) in ((self.plot.x_range, shown.x.ends), (self.plot.y_range, shown.y.ends)):
                    in_sight.update(start=low, end=high, reset_start=low, reset_end=high)
            self._sides = described
        palette = self.palette_of(shown)
        if palette != self.mapper.palette:
            self.mapper.palette = palette
        (left, right), (low, high) = shown.x.ends, shown.y.ends
        self.cells.data = {
            "image": [shown.shades], "x": [left], "y": [low], "dw": [right - left], "dh": [high - low],
        }  # fmt: skip
        self.regions.data = regions_of(shown)

    @staticmethod
    def palette_of(shown: Picture) -> list[str]:
        """The colours of a picture, as many as the mapper has."""
        return [*shown.palette, *(["#000000"] * (_SHADES - len(shown.palette)))]

    def draw_borders(self, lines: Sequence[Line]) -> None:
        """Draw exact borders over it."""
        self.lines.data = lines_of(lines)

    def mark(self, places: Mapping[str, tuple[float, float]]) -> None:
        """Mark cells by the names of `_MARKS`."""
        names = [name for name in _MARKS if name in places]
        self.marks.data = {
            "x": [places[name][0] for name in names],
            "y": [places[name][1] for name in names],
            "name": ["" if name == "cell" else name for name in names],
            "colour": [_MARKS[name] for name in names],
        }


def lines_of(lines: Sequence[Line]) -> dict[str, Any]:
    """Lines as columns of a source."""
    return {"xs": [x for x, _ in lines], "ys": [y for _, y in lines]}


def regions_of(shown: Picture) -> dict[str, Any]:
    """The names of flags in a picture as columns of a source."""
    names, x, y = zip(*shown.regions, strict=True) if shown.regions else ((), (), ())
    return {"x": list(x), "y": list(y), "name": list(names)}


# --- a cell -----------------------------------------------------------------------------------------------------------


class CellFigures:
    """Displacement and velocity over time, the phase portrait, and friction over relative speed."""

    def __init__(self) -> None:
        self.displacement = _figure("displacement")
        self.velocity = _figure("velocity", x_range=self.displacement.x_range)
        self.phase = _figure("phase")
        self.friction = _figure("friction")
        self.plots = self.displacement, self.velocity, self.phase, self.friction
        data = cell_data(None, {}, Units())
        self.sources = {name: ColumnDataSource(data[name], name=_NAMES.get(name, f"motion_{name}")) for name in data}
        for plot in self.plots:  # what has no data has no range, of which the browser complains
            plot.scatter("x", "y", source=self.sources["blank"], fill_alpha=0.0, line_alpha=0.0)
        self.friction.line("w", "mu", source=self.sources["curve"], line_color=GREY, line_width=5)
        over = (
            (self.displacement, "t", "x"),
            (self.velocity, "t", "v"),
            (self.phase, "x", "v"),
            (self.friction, "w", "mu"),
        )
        for name in reversed(LINES):  # the motion from stick on top
            colour, dash, width = LINES[name]
            for plot, x, y in over:
                plot.line(x, y, source=self.sources[name], line_color=colour, line_dash=dash, line_width=width)
        self.phase.line("x", "v", source=self.sources["cycle"], line_color=BLACK, line_dash="dotted", line_width=2.2)
        self.phase.scatter("x", "v", source=self.sources["steady"], size=8, marker="x", color=BLACK, line_width=2)
        self.belt = [
            Span(dimension="width", line_color=VERMILLION, line_dash="dashed", visible=False) for _ in range(2)
        ]
        for plot, line in zip((self.velocity, self.phase), self.belt, strict=True):
            plot.add_layout(line)

    def show(self, current: CellMotions | None, pinned: Mapping[str, CellMotions]) -> None:
        """Draw the motions of the cell that was clicked, and over them those from stick of the pinned ones."""
        motions = motions_by_line(current, pinned)
        units = units_of([motion for motion in motions.values() if motion.samples])
        words = axis_words(units)
        for plot in self.plots:
            plot.xaxis.axis_label, plot.yaxis.axis_label = words[str(plot.name)]
        for name, data in cell_data(current, motions, units).items():
            if name != "blank" or data != self.sources[name].data:
                self.sources[name].data = data
        for line in self.belt:
            line.visible = current is not None
            if current is not None:
                line.location = current.cell["belt_speed"] / units.speed.size


def _figure(name: str, **ranges: Any) -> figure:
    plot = quiet(figure(tools=TOOLS, name=name, sizing_mode="stretch_both", min_height=150, **ranges))
    for axis in plot.xaxis:
        axis.ticker.desired_num_ticks = _TICKS
    return plot


@dataclass(frozen=True)
class Units:
    """In which the figures of a cell are drawn."""

    time: Unit = Unit("s")
    length: Unit = Unit("m")
    speed: Unit = Unit("m/s")


def units_of(motions: Sequence[Motion]) -> Units:
    """The units that suit what is drawn."""

    def largest(name: str) -> list[float]:
        return [float(np.abs(motion.samples[name]).max()) for motion in motions]

    time = unit_for("s", [float(np.ptp(motion.time)) for motion in motions])
    speeds = [*largest("velocity"), *largest("relative_speed")]
    return Units(
        time if time.size <= 1.0 else Unit("s"),
        unit_for("m", largest("displacement")),
        unit_for("m s-1", speeds),
    )


def axis_words(units: Units) -> dict[str, tuple[str, str]]:
    """Titles of the axes, x and y, by figure."""
    time, length, speed = (unit.name for unit in (units.time, units.length, units.speed))
    return {
        "displacement": (f"time from break-away ({time})", f"displacement ({length})"),
        "velocity": (f"time from break-away ({time})", f"velocity ({speed})"),
        "phase": (f"displacement ({length})", f"velocity ({speed})"),
        "friction": (f"relative speed ({speed})", "friction coefficient"),
    }


def motions_by_line(current: CellMotions | None, pinned: Mapping[str, CellMotions]) -> dict[str, Motion]:
    """The motions that are drawn, by the names of `LINES`: both of a cell, and those from stick of pinned ones."""
    own = {} if current is None else dict(zip(("stick", "sliding"), current.motions, strict=False))
    return own | {name: motions.stick for name, motions in pinned.items()}


def cell_data(current: CellMotions | None, motions: Mapping[str, Motion], units: Units) -> dict[str, dict[str, Any]]:
    """The columns of all sources: of each line in `LINES`, and of what surrounds the motions of the current cell."""
    data = {name: _samples(motions[name], units) if name in motions else _NO_SAMPLES for name in LINES}
    data["blank"] = {"x": [], "y": []} if motions else {"x": [0.0, 1.0], "y": [0.0, 1.0]}
    data |= {"cycle": {"x": [], "v": []}, "curve": {"w": [], "mu": []}, "steady": {"x": [], "v": []}}
    if current is None:
        return data
    loop, (w, mu) = current.cycle, current.curve
    if loop is not None:
        data["cycle"] = {"x": loop.displacement / units.length.size, "v": loop.velocity / units.speed.size}
    two_ways = any((one.samples["relative_speed"] < 0).any() for one in current.motions if one.samples)
    if two_ways or current.cell["belt_speed"] < 0:
        w, mu = np.concatenate([-w[::-1], [np.nan], w]), np.concatenate([-mu[::-1], [np.nan], mu])
    data["curve"] = {"w": w / units.speed.size, "mu": mu}
    if isfinite(current.steady):
        data["steady"] = {"x": [current.steady / units.length.size], "v": [0.0]}
    return data


def _samples(motion: Motion, units: Units) -> dict[str, Any]:
    samples = motion.samples
    if not samples:
        return {name: np.zeros(0) for name in _NO_SAMPLES}
    return {
        "t": motion.time / units.time.size,
        "x": samples["displacement"] / units.length.size,
        "v": samples["velocity"] / units.speed.size,
        "w": samples["relative_speed"] / units.speed.size,
        "mu": samples["friction_coefficient"],
    }
