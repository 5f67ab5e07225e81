"""The page: its map, the four figures of a cell and the words around them, drawn by Bokeh; `page.js` is its browser."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from importlib.resources import files
from math import isfinite
from typing import Any

import numpy as np
from bokeh import models
from bokeh.document import Document
from bokeh.events import MouseLeave, MouseMove
from bokeh.models.axes import Axis
from bokeh.plotting import figure

from stickslip.plots.palette import BLACK, GREY, VERMILLION
from stickslip.vocabulary.display_units import Unit, spoken, unit_for
from stickslip_explore.html import LINES, STYLE, legend_html, numbers_html, part
from stickslip_explore.maps import SHADES, MapPicture, MapSide
from stickslip_explore.motions import CellMotions, Motion
from stickslip_explore.view import Source

TOOLS = "box_zoom,pan,wheel_zoom,reset,save"
WIDGETS = ":host { font-size: 13px; --font-size: 13px; } .bk-slider-title, label { color: #1b1b1b; }"
_MOST_LABELS = 16
_LONGEST = 40  # letters of all labels along x, beyond which they are written at a slant
_TICKS = 5  # along x: there is room for no more in a narrow window
_FIGURES = {"displacement": ("t", "x"), "velocity": ("t", "v"), "phase": ("x", "v"), "friction": ("w", "mu")}
_COLUMNS = {"x": "displacement", "v": "velocity", "w": "relative_speed", "mu": "friction_coefficient"}  # of samples
_BESIDE = {"cycle": "xv", "curve": ("w", "mu"), "steady": "xv", "blank": "xy"}  # columns of what surrounds the motions
_NAMES = {"cycle": "unstable_cycle", "curve": "friction_curve", "steady": "steady_sliding", "blank": "blank"}


def calling(function: str, **given: Any) -> models.CustomJS:
    """A callback that runs in the browser: a function of `page.js`, given these models by name, and the event."""
    return models.CustomJS(args=given, code=f"stickslip.{function}({{{', '.join(given)}}}, cb_obj)")


def _figure(name: str, **more: Any) -> figure:
    """A figure without the logo and with what all of them have in common."""
    plot = figure(tools=TOOLS, name=name, sizing_mode="stretch_both", **more)
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


def _source(name: str, *columns: str) -> models.ColumnDataSource:
    return models.ColumnDataSource({column: [] for column in columns}, name=name)


# --- the map ----------------------------------------------------------------------------------------------------------


class MapFigure:
    """The map: shades, the cell that was chosen; the numbers of all pixels, for the pointer."""

    def __init__(self) -> None:
        self.plot = plot = _figure(
            "map", active_drag="box_zoom", x_range=models.Range1d(0, 1), y_range=models.Range1d(0, 1), min_height=280
        )
        plot.grid.visible = False
        self.cells = _source("map_cells", "image", "x", "y", "dw", "dh")
        self.mark = _source("map_mark", "x", "y")
        self.regions = _source("map_regions", "x", "y", "name")
        self.columns = _source("map_columns")
        self.mapper = models.LinearColorMapper(palette=["#ffffff"] * SHADES, low=-0.5, high=SHADES - 0.5)
        plot.image("image", x="x", y="y", dw="dw", dh="dh", source=self.cells, color_mapper=self.mapper)
        plot.text("x", "y", "name", source=self.regions, text_align="center", text_baseline="middle",
                  text_font_size="12px", text_color="black", background_fill_color="white",
                  background_fill_alpha=0.55, padding=2, border_radius=3)  # fmt: skip
        plot.scatter("x", "y", source=self.mark, size=13, marker="circle", fill_color="white", line_color="black",
                     line_width=1.8)  # fmt: skip
        plot.js_on_event(MouseMove, calling("read_out", columns=self.columns))
        plot.js_on_event(MouseLeave, calling("hide_readout"))
        self._sides: tuple[Any, ...] = ()

    def show(self, shown: MapPicture) -> None:
        """Draw a picture. What is in sight stays so as long as the sides are the same."""
        described = (shown.x.name, shown.x.kind, shown.x.unit, shown.y.name, shown.y.kind, shown.y.unit)
        if described != self._sides:
            document = self.plot.document
            with nullcontext() if document is None else document.models.freeze():  # else it counts them at each change
                _lay_out(self.plot, shown.x, "x")
                _lay_out(self.plot, shown.y, "y")
                for in_sight, (low, high) in ((self.plot.x_range, shown.x.ends), (self.plot.y_range, shown.y.ends)):
                    in_sight.update(start=low, end=high, reset_start=low, reset_end=high)
            self._sides = described
        if (palette := list(shown.palette)) != self.mapper.palette:
            self.mapper.palette = palette
        (left, right), (low, high) = shown.x.ends, shown.y.ends
        self.cells.data = {
            "image": [shown.shades], "x": [left], "y": [low], "dw": [right - left], "dh": [high - low],
        }  # fmt: skip
        self.regions.data = regions_of(shown)
        self.columns.data, self.columns.tags = columns_of(shown), [meta_of(shown)]


def regions_of(shown: MapPicture) -> dict[str, Any]:
    """The names of flags in a picture as columns of a source."""
    return {key: [region[i] for region in shown.regions] for i, key in enumerate(("name", "x", "y"))}


def columns_of(shown: MapPicture) -> dict[str, Any]:
    """The numbers of all pixels as columns of a source."""
    return {column.name: column.values.ravel() for column in shown.columns}


def meta_of(shown: MapPicture) -> dict[str, Any]:
    """Meaning of the columns of a picture, for the words under the pointer."""
    sides = {
        which: {
            "label": spoken(side.name), "low": side.ends[0], "high": side.ends[1], "n": len(side.centres),
            "log": side.kind == "log", "unit": side.unit.name, "labels": list(side.labels),
        }
        for which, side in (("x", shown.x), ("y", shown.y))
    }  # fmt: skip
    columns = [
        {"name": column.name, "label": column.label, "unit": column.unit.name, "names": list(column.names)}
        for column in shown.columns
    ]
    return {**sides, "columns": columns}


def _lay_out(plot: models.Plot, side: MapSide, which: str) -> None:
    """Give a side of a map its title and ticks; `which` is "x" or "y"."""
    (axis,) = plot.below if which == "x" else plot.left
    assert isinstance(axis, Axis)
    axis.axis_label = models.PlainText(text=side.title)  # a string would be searched for formulas
    axis.major_label_overrides = {}
    axis.major_label_orientation = "horizontal"
    axis.ticker, axis.formatter = models.BasicTicker(), models.BasicTickFormatter()
    if side.kind == "listed":
        shown = range(0, len(side.labels), -(-len(side.labels) // _MOST_LABELS))
        axis.ticker = models.FixedTicker(ticks=[*shown])
        axis.major_label_overrides = {i: models.PlainText(text=side.labels[i]) for i in shown}
        if which == "x" and sum(len(side.labels[i]) for i in shown) > _LONGEST:
            axis.major_label_orientation = 0.6
    elif side.kind == "log":
        axis.ticker = models.CustomJSTicker(
            major_code="return stickslip.log_ticks(cb_data)", minor_code="return stickslip.log_minor_ticks(cb_data)"
        )
        axis.formatter = models.CustomJSTickFormatter(code="return stickslip.log_label(tick)")


# --- a cell -----------------------------------------------------------------------------------------------------------


class CellFigures:
    """Displacement and velocity over time, the phase portrait, and friction over relative speed."""

    def __init__(self) -> None:
        plots = {name: _figure(name, min_height=150) for name in _FIGURES}
        plots["velocity"].x_range = plots["displacement"].x_range
        self.plots = plots
        blank = cell_data(None, {})
        self.sources = {name: models.ColumnDataSource(data, name=_NAMES.get(name, f"motion_{name}"))
                        for name, data in blank["data"].items()}  # fmt: skip
        for plot in plots.values():  # what has no data has no range, of which the browser complains
            plot.xaxis.ticker.desired_num_ticks = _TICKS
            plot.scatter("x", "y", source=self.sources["blank"], fill_alpha=0.0, line_alpha=0.0)
        plots["friction"].line("w", "mu", source=self.sources["curve"], line_color=GREY, line_width=5)
        for name in reversed(LINES):  # the motion from stick on top
            colour, dash, width = LINES[name]
            for plot, columns in zip(plots.values(), _FIGURES.values(), strict=True):
                plot.line(*columns, source=self.sources[name], line_color=colour, line_dash=dash, line_width=width)
        phase = plots["phase"]
        phase.line("x", "v", source=self.sources["cycle"], line_color=BLACK, line_dash="dotted", line_width=2.2)
        phase.scatter("x", "v", source=self.sources["steady"], size=8, marker="x", color=BLACK, line_width=2)
        self.belt = []
        for name in ("velocity", "phase"):
            self.belt.append(models.Span(dimension="width", line_color=VERMILLION, line_dash="dashed", visible=False))
            plots[name].add_layout(self.belt[-1])

    def draw(self, current: CellMotions | None) -> None:
        """Draw the motions of a cell, and what surrounds them."""
        drawn = cell_data(current, {} if current is None else current.motions)
        for name, plot in self.plots.items():
            plot.xaxis.axis_label, plot.yaxis.axis_label = drawn["titles"][name]
        for name, data in drawn["data"].items():
            self.sources[name].data = data
        for line in self.belt:
            line.location, line.visible = drawn["belt"], current is not None


def cell_data(current: CellMotions | None, motions: Mapping[str, Motion]) -> dict[str, Any]:
    """Of the figures of a cell and of motions by the names of `LINES`: `data` of all sources, `titles` of the axes by
    figure, the place of the `belt`."""
    units = _units([motion for motion in motions.values() if motion.samples])

    def scaled(**columns: Any) -> dict[str, Any]:
        return {column: values / units[column].size for column, values in columns.items()}

    data: dict[str, dict[str, Any]] = {name: {c: [] for c in ("t", *_COLUMNS)} for name in LINES}
    for name, motion in motions.items():
        if motion.samples:
            data[name] = scaled(t=motion.time, **{c: motion.samples[name] for c, name in _COLUMNS.items()})
    data |= {name: {column: [] for column in columns} for name, columns in _BESIDE.items()}
    if not motions:
        data["blank"] = {"x": [0.0, 1.0], "y": [0.0, 1.0]}
    if current is not None:
        (w, mu), belt = current.curve, current.cell["belt_speed"]
        slips = [motion.samples["relative_speed"] for motion in current.motions.values() if motion.samples]
        if belt < 0 or any((slip < 0).any() for slip in slips):
            w, mu = np.concatenate([-w[::-1], [np.nan], w]), np.concatenate([-mu[::-1], [np.nan], mu])
        data["curve"] = scaled(w=w, mu=mu)
        if (loop := current.cycle) is not None:
            data["cycle"] = scaled(x=loop.displacement, v=loop.velocity)
        if isfinite(current.steady):
            data["steady"] = {"x": [current.steady / units["x"].size], "v": [0.0]}
    named = {"t": "time from break-away"} | {c: name.replace("_", " ") for c, name in _COLUMNS.items()}
    titles = {c: f"{text} ({units[c].name})" if units[c].name else text for c, text in named.items()}
    return {
        "data": data, "titles": {name: [titles[x], titles[y]] for name, (x, y) in _FIGURES.items()},
        "belt": 0.0 if current is None else current.cell["belt_speed"] / units["v"].size,
    }  # fmt: skip


def _units(motions: Sequence[Motion]) -> dict[str, Unit]:
    """The units that suit what is drawn, by column."""

    def largest(name: str) -> list[float]:
        return [float(np.abs(motion.samples[name]).max()) for motion in motions]

    time = unit_for("s", [float(np.ptp(motion.time)) for motion in motions])
    speed = unit_for("m s-1", [*largest("velocity"), *largest("relative_speed")])
    return {
        "t": time if time.size <= 1.0 else Unit("s"), "x": unit_for("m", largest("displacement")),
        "v": speed, "w": speed, "mu": Unit(),
    }  # fmt: skip


# --- all of it --------------------------------------------------------------------------------------------------------


class Page:
    """All that is on the page but the widgets beside the map; its parts are named as their places in the template."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.map, self.cell = MapFigure(), CellFigures()
        self.legend, self.status = words("legend"), words("status")
        self.cell_words, self.numbers = words("cell_words"), words("numbers", numbers_html({}))
        self.reproduce, self.texts = words("reproduce"), models.ColumnDataSource({}, name="texts")
        self.texts.tags = [{"command": "", "yaml": ""}]

    @property
    def roots(self) -> list[models.UIElement]:
        """The models that are embedded in the template, by their names."""
        return [self.map.plot, *self.cell.plots.values(), self.legend, self.status, self.cell_words, self.numbers]

    def show_map(self, shown: MapPicture) -> None:
        """Draw a picture, with its legend and the numbers under the pointer."""
        self.map.show(shown)
        self.legend.text = legend_html(shown)

    def show_cell(self, current: CellMotions | None, text: str, units: Mapping[str, Unit]) -> None:
        """Draw the motions of the clicked cell, and say their numbers, in units by variable."""
        self.cell.draw(current)
        self.cell_words.text = text
        self.numbers.text = numbers_html({} if current is None else current.motions, units)

    def show_texts(self, **texts: str) -> None:
        """Show the command or the YAML that reproduces what is seen."""
        shown = self.texts.tags[0] | texts
        self.texts.tags = [shown]
        self.reproduce.text = part("reproduce", shown["command"], shown["yaml"])

    def fill(self, document: Document, roots: Sequence[models.UIElement], notes: Sequence[str]) -> None:
        """Give a document these roots, and what the template around them (`page.html`) has to know."""
        with document.models.freeze():  # each root would have all models counted again
            for root in roots:
                document.add_root(root)
        title = self.source.config.title
        document.template, script = (
            files("stickslip_explore").joinpath(name).read_text(encoding="utf-8") for name in ("page.html", "page.js")
        )
        document.title = f"{title} - stickslip"
        document.template_variables.update(
            heading=title or "Stick-slip explorer", source=self.source.name, notes="; ".join(notes), script=script,
            names=[str(root.name) for root in roots],
        )  # fmt: skip


def words(name: str, text: str = "") -> models.Div:
    """A place for words. What stands between dollars in them is no formula: MathJax would make links of `\\href`."""
    return models.Div(text=text, name=name, disable_math=True, sizing_mode="stretch_width", stylesheets=[STYLE])
