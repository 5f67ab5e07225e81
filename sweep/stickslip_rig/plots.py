"""Plots of a rig: records over time, friction over slip speed, and a test matrix as a heat map."""

from collections.abc import Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from stickslip.dataset import display
from stickslip.dataset.display import MapAxis
from stickslip.errors import PlotError
from stickslip.plots import palette
from stickslip.plots.layout import Figure, entitle, legend
from stickslip.plots.maps import hatch_cells
from stickslip.plots.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION
from stickslip_rig.evaluation import test_names
from stickslip_rig.quantities import RPN_NAME, SIGNALS
from stickslip_rig.records import force_of
from stickslip_rig.risk import BANDS, UNDEFINED, rpn_text
from stickslip_rig.signals import Floats, gaps_of

SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)  # of records, in this order
LIGHTS = {"unknown": GREY, "green": GREEN, "yellow": ORANGE, "red": VERMILLION}  # in the order of codes
MEANINGS = {  # the article's, page 4
    "unknown": "?: not known",
    "green": "1–3: low noise, no stick-slip",
    "yellow": "4–5: noise and stick-slip can occur",
    "red": "6–10: bad noise and stick-slip",
}
RPN, BAND = "model_rpn", "model_rpn_band"
_PIXELS = 3000  # across; more samples than that are plotted as the range of each pixel
_ROOM = 2.2  # times its range: the right axis, so that the acceleration leaves the force readable
_CELL = (0.46, 0.29)  # inches: width and height of a cell where there is room
_LARGEST = (10.0, 10.5)  # inches: of all cells together
_AROUND = (2.6, 2.2)  # inches: names, title and legend
_MOST_NAMED = 40  # points along an axis
_MOST_WRITTEN = (25, 40)  # columns and rows of cells that numbers fit into
_BRANCHES: dict[str, dict[str, Any]] = {  # directions of the slip speed
    "rising": {"linestyle": "-"},
    "falling": {"linestyle": "--", "markerfacecolor": "none"},
}
_HATCH = "////"  # of red cells, whose colour is as dark as green


def plot_records(
    records: Mapping[str, xr.Dataset],
    *,
    numbers: Mapping[str, float] | None = None,
    heading: str = "",
    window: tuple[float, float] | None = None,
) -> Figure:
    """Plot force and acceleration of records, by name, over time.

    One record is drawn as in the article: force in colour, acceleration black. Of several, the acceleration has the
    colour of the force, thin. Gaps are left blank.

    numbers : the model RPN of each, "?" for NaN. heading : of the figure. window : part of each record to draw, s
    since its start.
    """
    parts = [_part(record, window) for record in records.values()]
    figure = Figure(figsize=(10.0, 4.8), layout="constrained")
    panel = figure.subplots()
    twin, handles = panel.twinx(), []
    for i, (name, part) in enumerate(zip(records, parts, strict=True)):
        label = f"{name}: {rpn_text(numbers[name])}" if numbers and name in numbers else name
        label += " (shaded: no samples)" * bool(gaps_of(part["time"].values).size)
        colour = SERIES[i % len(SERIES)]
        _draw(panel, part, force_of(part), color=colour, linewidth=1.3)
        if "acceleration" in part:
            thin = {"color": BLACK, "linewidth": 0.7} if len(parts) == 1 else {"color": colour, "linewidth": 0.5}
            _draw(twin, part, part["acceleration"].values, alpha=0.55, **thin)
        # what begins with _ would be hidden from the legend
        handles.append(Line2D([], [], color=colour, label=f" {label}" if label.startswith("_") else label))
    _name_axes(panel, twin, parts)
    note = f"after the names: {RPN_NAME}" if numbers else None
    legend(figure, handles, [note])
    if heading:
        entitle(figure, panel, heading, above_all=True)
    return figure


def _part(record: xr.Dataset, window: tuple[float, float] | None) -> xr.Dataset:
    """The samples to draw; the attribute `start` is when the record starts."""
    record = record.assign_attrs(start=float(record["time"][0]))
    if window is None:
        return record
    since = (record["time"] - record.attrs["start"]).values
    inside = (since >= window[0]) & (since <= window[1])
    return record.isel(time=inside) if inside.sum() > 1 else record


def _draw(ax: Axes, record: xr.Dataset, values: Floats, **style: Any) -> None:
    """A line since the start, broken at gaps; of more samples than pixels, the smallest and largest of each pixel."""
    time = record["time"].values - record.attrs["start"]
    gaps = gaps_of(time)
    for piece in np.split(np.arange(time.size), gaps + 1):
        x, y, block = time[piece], values[piece], time.size // _PIXELS
        if block > 2:
            edges = np.arange(0, x.size, block)
            x = np.repeat(x[edges], 2)
            y = np.stack([np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)], axis=1).ravel()
        ax.plot(x, y, **style)
    for gap in gaps.tolist():
        ax.axvspan(time[gap], time[gap + 1], color=style["color"], alpha=0.12, linewidth=0)


def _name_axes(panel: Axes, twin: Axes, parts: Sequence[xr.Dataset]) -> None:
    """Force at the left, acceleration, if recorded, at the right, zero in the middle of both."""
    signal = next(parts[0][name] for name in SIGNALS if name in parts[0])
    shown = next((part["acceleration"] for part in parts if "acceleration" in part), None)
    height, swing = (max(map(abs, ax.get_ylim())) for ax in (panel, twin))
    panel.set_zorder(twin.get_zorder() + 1)  # forces are drawn over accelerations
    panel.patch.set_visible(False)
    panel.set(xlabel="time since the start (s)", ylim=(-height, height))
    panel.margins(x=0.01)
    panel.set_ylabel(display.title(signal, display.si_unit(signal)))
    twin.set_visible(shown is not None)
    twin.set_ylim(-_ROOM * swing, _ROOM * swing)
    if shown is not None:
        twin.set_ylabel(display.title(shown, display.si_unit(shown)))


# --- friction -------------------------------------------------------------------------------------------------------


def plot_friction(ds: xr.Dataset) -> Figure:
    """Friction over slip speed of records (`friction_table`): full while it rises, dashed and empty while it falls.

    Raises PlotError where no record tells any.
    """
    if not int(ds["slips_used"].max()):
        raise PlotError("nothing to draw: no record has slips that tell friction")
    figure = Figure(figsize=(6.3, 3.54), layout="constrained")
    ax, names, handles = figure.add_subplot(), ds["record"].values.tolist(), []
    for i, name in enumerate(names):
        look: dict[str, Any] = {key: palette.look_of(i)[key] for key in ("color", "marker")} | {"markersize": 4}
        handles.append(Line2D([], [], label=name, **look))
        for direction, style in _BRANCHES.items():
            points = ds.isel(record=i).sel(direction=direction)
            speed, sigma = 1e3 * points["slip_speed"].values, points["friction_sigma"].values
            ax.errorbar(speed, points["friction"].values, 1.96 * sigma, linewidth=0.9, **look, **style)
    ax.set(xlabel="slip speed (mm/s)", ylabel="friction coefficient", ylim=(0.0, None))
    ways = [Line2D([], [], color=BLACK, marker="o", markersize=4, label=label, **style)
            for label, style in zip(("slip speed rises", "falls"), _BRANCHES.values(), strict=True)]  # fmt: skip
    legend(figure, [*(handles if len(names) > 1 else ()), *ways])
    entitle(figure, ax, names[0] if len(names) == 1 else str(ds.attrs["title"]))
    return figure


# --- matrices ---------------------------------------------------------------------------------------------------------


def plot_matrix(ds: xr.Dataset) -> Figure:
    """Plot the model RPN of every test of a matrix as a heat map, like the table of a printed test report.

    The first half of the dimensions run down the rows, the others along the columns, the last of each fastest. Cells
    have the colours of the traffic light, red hatched, and "?" where the number is not known. Numbers are left out
    where cells are too small for them. Raises PlotError for no matrix, and for no tests.
    """
    if RPN not in ds or not ds[RPN].size:
        raise PlotError(f"nothing to draw: no {RPN} of a test matrix")
    along = [MapAxis(ds, dim) for dim in ds[RPN].dims]
    half = (len(along) + 1) // 2
    rows, columns = along[:half], along[half:]
    shape = (prod(axis.length for axis in rows), prod(axis.length for axis in columns))
    across, down = (min(each * n, most) for each, n, most in zip(_CELL, reversed(shape), _LARGEST, strict=True))
    figure = Figure(figsize=(across + _AROUND[0], down + _AROUND[1]), layout="constrained")
    ax = figure.add_subplot()
    bands = ds[BAND].values.reshape(shape)
    colours, norm = ListedColormap(list(LIGHTS.values())), BoundaryNorm(np.arange(len(LIGHTS) + 1) - 0.5, len(LIGHTS))
    ax.pcolormesh(bands, cmap=colours, norm=norm, edgecolors="white")
    edges = (np.arange(length + 1.0) for length in reversed(shape))
    hatch_cells(ax, bands == list(LIGHTS).index("red"), _HATCH, LIGHTS["red"], *edges)
    has_room = shape[0] <= _MOST_WRITTEN[1] and shape[1] <= _MOST_WRITTEN[0]
    for (i, j), band in np.ndenumerate(bands if has_room else bands[:0]):
        box = {"facecolor": colours(norm(band)), "edgecolor": "none", "boxstyle": "square,pad=0.1"}
        text = rpn_text(float(ds[RPN].values.reshape(shape)[i, j]))
        ax.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize="x-small", bbox=box)
    for tick_axis, names, rotation in ((ax.yaxis, rows, 0), (ax.xaxis, columns, 90)):
        points = test_names(ds.assign_attrs(title=""), [axis.dim for axis in names])
        step = -(-len(points) // _MOST_NAMED)
        tick_axis.set_ticks(np.arange(len(points))[::step] + 0.5, points[::step], rotation=rotation)
        tick_axis.set_label_text(", ".join(axis.name for axis in names))
    ax.set(xlim=(0, shape[1]), ylim=(shape[0], 0))
    ax.spines[:].set_visible(False)
    ax.tick_params(length=0, labelsize="small")
    shown = [name for name in LIGHTS if name in BANDS or (bands == UNDEFINED).any()]
    handles = [Patch(facecolor=LIGHTS[name], edgecolor=palette.ink(LIGHTS[name]), linewidth=0.0, label=MEANINGS[name],
                     hatch=_HATCH if name == "red" else None) for name in shown]  # fmt: skip
    legend(figure, handles, [RPN_NAME, None if has_room else "the cells are too small for numbers"])
    entitle(figure, ax, str(ds.attrs.get("title", "")), above_all=True)
    return figure
