"""Plots of records: force on the left axis, acceleration on the right, several records over or beside each other."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from stickslip.dataset.axis import title
from stickslip.dataset.display import si_unit
from stickslip.plots.figure import Figure
from stickslip.plots.palette import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, VERMILLION
from stickslip.rig.quantities import SIGNALS
from stickslip.rig.records.record import force_of
from stickslip.rig.records.sampling import Floats
from stickslip.rig.risk import RPN_NAME

SERIES = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY)  # of records, in this order
LIGHTS = {"green": GREEN, "yellow": ORANGE, "red": VERMILLION, "unknown": GREY}
_GAP = 0.04  # of the longest record, between records beside each other
_PIXELS = 3000  # across; more samples than that are plotted as the range of each pixel
_LEGEND = 130  # characters across the figure
_ROOM = 2.2  # times its range: the right axis, so that the acceleration leaves the force readable


def plot_records(
    records: Mapping[str, xr.Dataset],
    *,
    shifted: bool = False,
    numbers: Mapping[str, int] | None = None,
    heading: str = "",
    window: tuple[float, float] | None = None,
) -> Figure:
    """Force and acceleration of records over time, by name.

    One record is drawn as in the article: force in colour, acceleration black. Of several, the acceleration has the
    colour of the force, thin. shifted : beside each other along the axis of time, instead of over each other.
    numbers : the model RPN of each, for the legend. window : part of each record to draw, s since its start.
    """
    parts = {name: _part(record, window) for name, record in records.items()}
    figure = Figure(figsize=(10.0, 4.8), layout="constrained")
    force_axis = figure.add_subplot()
    acceleration_axis = force_axis.twinx()
    force_axis.set_zorder(acceleration_axis.get_zorder() + 1)  # forces are drawn over accelerations
    force_axis.patch.set_visible(False)
    offset, longest = 0.0, max(float(np.ptp(part["time"].values)) for part in parts.values())
    handles = []
    for i, (name, part) in enumerate(parts.items()):
        colour = SERIES[i % len(SERIES)]
        time = part["time"].values - part["time"].values[0]
        shift = offset if shifted else (0.0 if window is None else window[0])
        _draw(force_axis, time + shift, force_of(part), color=colour, linewidth=1.3)
        thin = {"color": BLACK, "linewidth": 0.7} if len(parts) == 1 else {"color": colour, "linewidth": 0.5}
        _draw(acceleration_axis, time + shift, part["acceleration"].values, alpha=0.55, **thin)
        offset += float(np.ptp(time)) + _GAP * longest
        number = (numbers or {}).get(name)
        handles.append(Line2D([], [], color=colour, label=_plain(name if number is None else f"{name}: {number}")))
    first = next(iter(parts.values()))
    _name_axes(force_axis, acceleration_axis, first, shifted)
    _share_zero(force_axis, acceleration_axis)
    longest_name = max(len(str(handle.get_label())) for handle in handles)
    columns = max(1, min(4, len(handles), _LEGEND // (longest_name + 8)))
    legend = figure.legend(handles=handles, loc="outside lower center", ncols=columns, frameon=False)
    if numbers:
        legend.set_title(RPN_NAME)
    if heading:
        figure.suptitle(heading, fontsize="large")
    return figure


def _plain(label: str) -> str:
    """A label as it is: not left out of the legend for a leading underscore."""
    return f" {label}" if label.startswith("_") else label


def _part(record: xr.Dataset, window: tuple[float, float] | None) -> xr.Dataset:
    if window is None:
        return record
    since = record["time"] - record["time"][0]
    inside = ((since >= window[0]) & (since <= window[1])).values
    return record.isel(time=inside) if inside.sum() > 1 else record


def _draw(ax: Axes, time: Floats, values: Floats, **looks: object) -> None:
    """A line; of more samples than pixels, the smallest and largest of each pixel."""
    block = time.size // _PIXELS
    if block > 2:
        whole = time.size // block * block
        rows = values[:whole].reshape(-1, block)
        time = np.repeat(time[:whole:block], 2)
        values = np.stack([rows.min(axis=1), rows.max(axis=1)], axis=1).ravel()
    ax.plot(time, values, **looks)  # type: ignore[arg-type]


def _name_axes(force_axis: Axes, acceleration_axis: Axes, record: xr.Dataset, shifted: bool) -> None:
    name = "spring_force" if "spring_force" in record else "friction_force"
    unit = SIGNALS[name].units
    force_axis.set_ylabel(
        f"force as the rig measures it ({unit})"
        if name == "spring_force"
        else title(record[name], si_unit(record[name]))
    )
    acceleration_axis.set_ylabel(title(record["acceleration"], si_unit(record["acceleration"])))
    force_axis.set_xlabel("time, records beside each other (s)" if shifted else "time since the start (s)")
    force_axis.margins(x=0.01)


def _share_zero(force_axis: Axes, acceleration_axis: Axes) -> None:
    """Zero at the same height on both axes, as much room above as the force takes, and room around the acceleration."""
    low, high = force_axis.get_ylim()
    largest = max(map(abs, acceleration_axis.get_ylim())) or 1.0
    height = max(-low, high, 1e-30)
    low, high = min(low, -height / _ROOM), max(high, height / _ROOM)  # the acceleration swings to both sides
    scale = _ROOM * largest / height
    force_axis.set_ylim(low, high)
    acceleration_axis.set_ylim(low * scale, high * scale)
