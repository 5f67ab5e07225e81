"""Plots of records: force on the left axis, acceleration on the right, several records over or beside each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from stickslip.dataset.axis import title
from stickslip.dataset.display import si_unit
from stickslip.plots.layout import Figure
from stickslip.plots.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION
from stickslip.rig.quantities import SIGNALS
from stickslip.rig.records.record import force_of
from stickslip.rig.records.sampling import Floats, gaps_of
from stickslip.rig.risk import RPN_NAME, number_text

SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)  # of records, in this order
LIGHTS = {"green": GREEN, "yellow": ORANGE, "red": VERMILLION, "unknown": GREY}
_PIXELS = 3000  # across; more samples than that are plotted as the range of each pixel
_LEGEND = 130  # characters across the figure
_ROOM = 2.2  # times its range: the right axis, so that the acceleration leaves the force readable
_IN_A_ROW = 4  # records beside each other


def plot_records(
    records: Mapping[str, xr.Dataset],
    *,
    beside: bool = False,
    numbers: Mapping[str, float] | None = None,
    heading: str = "",
    window: tuple[float, float] | None = None,
) -> Figure:
    """Force and acceleration of records over time, by name.

    One record is drawn as in the article: force in colour, acceleration black. Of several, the acceleration has the
    colour of the force, thin. beside : each in a panel of its own, instead of over each other. numbers : the model RPN
    of each, "?" for NaN. window : part of each record to draw, s since its start. Gaps are left blank.
    """
    parts = [_part(record, window) for record in records.values()]
    rated = {name: f"{name}: {number_text(number)}" for name, number in (numbers or {}).items()}
    looks = [rated.get(name, name) for name in records]
    columns = min(_IN_A_ROW, len(parts)) if beside else 1
    rows = -(-len(parts) // columns) if beside else 1
    figure = Figure(figsize=(10.0, 1.2 + 3.6 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharey=True, squeeze=False).ravel().tolist()
    twins = [panel.twinx() for panel in panels]
    handles = []
    for i, (name, part) in enumerate(zip(map(_plain, looks), parts, strict=True)):
        name += " (shaded: no samples)" * bool(gaps_of(part["time"].values).size)
        force, acceleration = panels[i * beside], twins[i * beside]
        colour = SERIES[i % len(SERIES)]
        _draw(force, part, force_of(part), color=colour, linewidth=1.3)
        thin = {"color": BLACK, "linewidth": 0.7} if len(parts) == 1 else {"color": colour, "linewidth": 0.5}
        _draw(acceleration, part, part["acceleration"].values, alpha=0.55, **thin)
        if beside:
            force.set_title(name, fontsize="medium")
        handles.append(Line2D([], [], color=colour, label=name))
    for panel in panels[len(parts) :]:
        panel.set_axis_off()
    _name_axes(panels, twins, parts[0], columns)
    _share_zero(panels[0], twins)
    if numbers and beside:
        figure.supxlabel(f"in titles: {RPN_NAME}", fontsize="small")
    if not beside:
        longest_name = max(len(str(handle.get_label())) for handle in handles)
        in_a_row = max(1, min(4, len(handles), _LEGEND // (longest_name + 8)))
        legend = figure.legend(handles=handles, loc="outside lower center", ncols=in_a_row, frameon=False)
        legend.set_title(RPN_NAME if numbers else "")
    if heading:
        figure.suptitle(heading, fontsize="large")
    return figure


def _plain(label: str) -> str:
    """A label as it is: not left out of the legend for a leading underscore."""
    return f" {label}" if label.startswith("_") else label


def _part(record: xr.Dataset, window: tuple[float, float] | None) -> xr.Dataset:
    """The samples to draw; the attribute `start` is when the record starts."""
    record = record.assign_attrs(start=float(record["time"][0]))
    if window is None:
        return record
    since = (record["time"] - record.attrs["start"]).values
    inside = (since >= window[0]) & (since <= window[1])
    return record.isel(time=inside) if inside.sum() > 1 else record


def _draw(ax: Axes, record: xr.Dataset, values: Floats, **looks: Any) -> None:
    """A line since the start, broken at gaps; of more samples than pixels, the smallest and largest of each pixel."""
    time = record["time"].values - record.attrs["start"]
    gaps = gaps_of(time)
    for piece in np.split(np.arange(time.size), gaps + 1):
        x, y, block = time[piece], values[piece], time.size // _PIXELS
        if block > 2:
            whole = max(1, x.size // block)
            edges = np.linspace(0, x.size, whole, endpoint=False).astype(np.intp)
            x = np.repeat(x[edges], 2)
            y = np.stack([np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges)], axis=1).ravel()
        ax.plot(x, y, **looks)
    for gap in gaps.tolist():
        ax.axvspan(time[gap], time[gap + 1], color=looks["color"], alpha=0.12, linewidth=0)


def _name_axes(panels: Sequence[Axes], twins: Sequence[Axes], record: xr.Dataset, columns: int) -> None:
    """The names and ticks of the axes: force at the left of a row, acceleration at its right."""
    name = "spring_force" if "spring_force" in record else "friction_force"
    label = title(record[name], si_unit(record[name]))
    force = f"force as the rig measures it ({SIGNALS[name].units})" if name == "spring_force" else label
    for i, (panel, twin) in enumerate(zip(panels, twins, strict=True)):
        panel.set_zorder(twin.get_zorder() + 1)  # forces are drawn over accelerations
        panel.patch.set_visible(False)
        panel.set_xlabel("time since the start (s)")
        panel.margins(x=0.01)
        if i % columns == 0:
            panel.set_ylabel(force)
        last = i % columns == columns - 1
        twin.tick_params(labelright=last)
        if last:
            twin.set_ylabel(title(record["acceleration"], si_unit(record["acceleration"])))


def _share_zero(force_axis: Axes, acceleration_axes: Sequence[Axes]) -> None:
    """Zero at the same height on all axes, as much room above as the force takes, and room around the acceleration."""
    low, high = force_axis.get_ylim()
    largest = max(abs(end) for axis in acceleration_axes for end in axis.get_ylim()) or 1.0
    height = max(-low, high, 1e-30)
    low, high = min(low, -height / _ROOM), max(high, height / _ROOM)  # the acceleration swings to both sides
    scale = _ROOM * largest / height
    force_axis.set_ylim(low, high)
    for axis in acceleration_axes:
        axis.set_ylim(low * scale, high * scale)
