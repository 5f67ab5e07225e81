"""The map and the four figures of a cell, drawn by Bokeh; what is drawn comes as arrays from the other files here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, LinearColorMapper, Range1d, Span
from bokeh.plotting import figure

from stickslip.explore.axes import lay_out, quiet
from stickslip.explore.borders import Line
from stickslip.explore.maps import Picture
from stickslip.explore.motions import CellMotions, Motion
from stickslip.explore.readable import Unit, unit_for
from stickslip.plots.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, VERMILLION

TOOLS = "box_zoom,pan,wheel_zoom,reset,save"
MARKS = ("cell", "A", "B")
LINES: dict[str, tuple[str, str, float]] = {  # by motion: colour, dash, width
    "stick": (BLUE, "solid", 1.6),
    "sliding": (ORANGE, "dashed", 1.6),
    "A": (GREEN, "solid", 1.3),
    "B": (PURPLE, "dashdot", 1.3),
}
_MARK_COLOURS = {"cell": "white", "A": GREEN, "B": PURPLE}
NOTHING: dict[str, Any] = {"x": [], "y": []}
_BLANK: dict[str, Any] = {"x": [0.0, 1.0], "y": [0.0, 1.0]}
NO_SAMPLES: dict[str, Any] = {"t": [], "x": [], "v": [], "w": [], "mu": []}
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
                self._look_at(shown)
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

    def _look_at(self, shown: Picture) -> None:
        for in_sight, (low, high) in ((self.plot.x_range, shown.x.ends), (self.plot.y_range, shown.y.ends)):
            in_sight.start, in_sight.end = low, high
            in_sight.reset_start, in_sight.reset_end = low, high

    def draw_borders(self, lines: Sequence[Line]) -> None:
        """Draw exact borders over it."""
        self.lines.data = lines_of(lines)

    def mark(self, places: Mapping[str, tuple[float, float]]) -> None:
        """Mark cells by the names of `MARKS`."""
        names = [name for name in MARKS if name in places]
        self.marks.data = {
            "x": [places[name][0] for name in names],
            "y": [places[name][1] for name in names],
            "name": ["" if name == "cell" else name for name in names],
            "colour": [_MARK_COLOURS[name] for name in names],
        }


@dataclass(frozen=True)
class Units:
    """In which the figures of a cell are drawn."""

    time: Unit
    length: Unit
    speed: Unit


def lines_of(lines: Sequence[Line]) -> dict[str, Any]:
    """Lines as columns of a source."""
    return {"xs": [x for x, _ in lines], "ys": [y for _, y in lines]}


def regions_of(shown: Picture) -> dict[str, Any]:
    """The names of flags in a picture as columns of a source."""
    names, x, y = zip(*shown.regions, strict=True) if shown.regions else ((), (), ())
    return {"x": list(x), "y": list(y), "name": list(names)}


class CellFigures:
    """Displacement and velocity over time, the phase portrait, and friction over relative speed."""

    def __init__(self) -> None:
        self.displacement = _figure("displacement")
        self.velocity = _figure("velocity", x_range=self.displacement.x_range)
        self.phase = _figure("phase")
        self.friction = _figure("friction")
        self.sources = {name: ColumnDataSource(NO_SAMPLES, name=f"motion_{name}") for name in LINES}
        self.cycle = ColumnDataSource({"x": [], "v": []}, name="unstable_cycle")
        self.curve = ColumnDataSource({"w": [], "mu": []}, name="friction_curve")
        self.steady = ColumnDataSource({"x": [], "v": []}, name="steady_sliding")
        self.blank = ColumnDataSource(_BLANK, name="blank")
        for plot in self.plots:  # what has no data has no range, of which the browser complains
            plot.scatter("x", "y", source=self.blank, fill_alpha=0.0, line_alpha=0.0)
        self.friction.line("w", "mu", source=self.curve, line_color=GREY, line_width=5)
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
        self.phase.line("x", "v", source=self.cycle, line_color=BLACK, line_dash="dotted", line_width=2.2)
        self.phase.scatter("x", "v", source=self.steady, size=8, marker="x", color=BLACK, line_width=2)
        self.belt = [Span(dimension="width", line_color=VERMILLION, line_dash="dashed") for _ in range(2)]
        for plot, line in zip((self.velocity, self.phase), self.belt, strict=True):
            line.visible = False
            plot.add_layout(line)

    @property
    def plots(self) -> tuple[figure, ...]:
        """All four."""
        return self.displacement, self.velocity, self.phase, self.friction

    def show(self, current: CellMotions | None, pinned: Mapping[str, CellMotions]) -> None:
        """Draw the motions of the cell that was clicked, and over them those from stick of the pinned ones."""
        drawn: dict[str, Motion] = {}
        if current is not None:
            drawn["stick"] = current.stick
            if current.sliding is not None:
                drawn["sliding"] = current.sliding
        drawn |= {name: one.stick for name, one in pinned.items()}
        units = units_of([motion for motion in drawn.values() if motion.samples])
        self._name_axes(units)
        for name, source in self.sources.items():
            source.data = data_of(drawn[name], units) if name in drawn else NO_SAMPLES
        self._surroundings(current, units)
        blank = NOTHING if drawn else _BLANK
        if blank != self.blank.data:
            self.blank.data = blank

    def _surroundings(self, current: CellMotions | None, units: Units) -> None:
        """Of the clicked cell: its friction curve, its unstable cycle, the speed of its belt, steady sliding."""
        data = surroundings(current, units)
        self.cycle.data, self.curve.data, self.steady.data = data["cycle"], data["curve"], data["steady"]
        for line in self.belt:
            line.visible = current is not None
            if current is not None:
                line.location = current.cell["belt_speed"] / units.speed.factor

    def _name_axes(self, units: Units) -> None:
        words = axis_words(units)
        for plot in self.plots:
            plot.xaxis.axis_label, plot.yaxis.axis_label = words[str(plot.name)]


def _figure(name: str, **ranges: Any) -> figure:
    plot = quiet(figure(tools=TOOLS, name=name, sizing_mode="stretch_both", min_height=150, **ranges))
    for axis in plot.xaxis:
        axis.ticker.desired_num_ticks = _TICKS
    return plot


def axis_words(units: Units) -> dict[str, tuple[str, str]]:
    """Titles of the axes, x and y, by figure."""
    time, length, speed = (unit.name for unit in (units.time, units.length, units.speed))
    return {
        "displacement": (f"time from break-away ({time})", f"displacement ({length})"),
        "velocity": (f"time from break-away ({time})", f"velocity ({speed})"),
        "phase": (f"displacement ({length})", f"velocity ({speed})"),
        "friction": (f"relative speed ({speed})", "friction coefficient"),
    }


def units_of(motions: Sequence[Motion]) -> Units:
    """The units that suit what is drawn."""

    def largest(name: str) -> list[float]:
        return [float(np.abs(motion.samples[name]).max()) for motion in motions]

    times = [float(np.ptp(motion.time)) for motion in motions]
    speeds = [*largest("velocity"), *largest("relative_speed")]
    time = unit_for("s", times)
    return Units(
        time if time.factor <= 1.0 else Unit(1.0, "s"),
        unit_for("m", largest("displacement")),
        unit_for("m s-1", speeds),
    )


def data_of(motion: Motion, units: Units) -> dict[str, Any]:
    """The samples of a motion as columns of a source."""
    if not motion.samples:
        return {name: np.zeros(0) for name in NO_SAMPLES}
    samples = motion.samples
    return {
        "t": motion.time / units.time.factor,
        "x": samples["displacement"] / units.length.factor,
        "v": samples["velocity"] / units.speed.factor,
        "w": samples["relative_speed"] / units.speed.factor,
        "mu": samples["friction_coefficient"],
    }


def surroundings(current: CellMotions | None, units: Units) -> dict[str, dict[str, Any]]:
    """What is drawn around the motions of a cell."""
    if current is None:
        return {"cycle": {"x": [], "v": []}, "curve": {"w": [], "mu": []}, "steady": {"x": [], "v": []}}
    loop, (w, mu) = current.cycle, current.curve
    cycle: dict[str, Any] = {"x": [], "v": []} if loop is None else {
        "x": loop.displacement / units.length.factor, "v": loop.velocity / units.speed.factor,
    }  # fmt: skip
    two_ways = any((one.samples["relative_speed"] < 0).any() for one in current.motions if one.samples)
    if two_ways or current.cell["belt_speed"] < 0:
        w, mu = np.concatenate([-w[::-1], [np.nan], w]), np.concatenate([-mu[::-1], [np.nan], mu])
    steady = [current.steady / units.length.factor] if isfinite(current.steady) else []
    curve = {"w": w / units.speed.factor, "mu": mu}
    return {"cycle": cycle, "curve": curve, "steady": {"x": steady, "v": [0.0] * len(steady)}}
