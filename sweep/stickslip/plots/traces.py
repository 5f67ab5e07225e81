"""Trajectories over time, and their phase portraits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.dataset.axis import spoken
from stickslip.dataset.axis import title as array_title
from stickslip.dataset.display import unit_of
from stickslip.errors import PlotError
from stickslip.plots.figure import Figure
from stickslip.plots.page import entitle, legend
from stickslip.plots.palette import BLACK, BLUE, GREY, VERMILLION
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import customary
from stickslip.vocabulary.flags import MODES
from stickslip.vocabulary.quantities import PARAMETERS

_ALWAYS = ("mass", "stiffness", "normal_load", "belt_speed")  # of the parameters that a title names
_NAMED = (*_ALWAYS, "damping")  # the others where they are not 0


def plot_trace(ds: xr.Dataset, *, title: str | None = None) -> Figure:
    """A trajectory: displacement and velocity over time with the stick phases shaded, and the phase portrait.

    The line of the belt speed appears in the phase portrait only while that speed is constant. Raises PlotError.
    """
    if missing := {"displacement", "velocity", "relative_speed", "mode"} - set(ds.data_vars):
        raise PlotError(f"not a trajectory: no {', '.join(sorted(missing))}")
    names = "time", "displacement", "velocity"
    units = {name: unit_of(ds[name]) for name in names}
    time, displacement, velocity = (units[name].of(ds[name].values) for name in names)
    belt = units["velocity"].of(ds["relative_speed"].values) + velocity
    sticks = ds["mode"].values == MODES.index("stick")
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    places = figure.add_gridspec(2, 2, width_ratios=[3, 2])
    upper = figure.add_subplot(places[0, 0])
    lower = figure.add_subplot(places[1, 0], sharex=upper)
    phase = figure.add_subplot(places[:, 1])
    upper.tick_params(labelbottom=False)
    mass_line: dict[str, Any] = {"color": BLUE, "linewidth": 1.2}
    belt_line: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.0, "linestyle": "dashed"}
    shade: dict[str, Any] = {"facecolor": GREY, "alpha": 0.45, "linewidth": 0}
    start: dict[str, Any] = {"color": BLACK, "marker": "o", "markersize": 4, "linestyle": "none"}

    upper.plot(time, displacement, **mass_line)
    lower.plot(time, velocity, **mass_line)
    lower.plot(time, belt, **belt_line)
    for ax in (upper, lower):
        for begin, end in _spans(time, sticks):
            ax.axvspan(begin, end, zorder=0, **shade)
        ax.margins(x=0)
    phase.plot(displacement, velocity, **mass_line)
    phase.plot(displacement[:1], velocity[:1], **start)
    if np.ptp(belt) <= 1e-9 * np.abs(belt).max():
        phase.axhline(belt[0], zorder=0, **belt_line)

    named = {name: array_title(ds[name], unit) for name, unit in units.items()}
    upper.set_ylabel(named["displacement"])
    lower.set(xlabel=named["time"], ylabel=named["velocity"])
    phase.set(xlabel=named["displacement"], ylabel=named["velocity"])
    for ax in (upper, lower, phase):
        ax.ticklabel_format(style="sci", scilimits=(-3, 4), useMathText=True)
    handles: list[Artist] = [
        Line2D([], [], label="mass", **mass_line),
        Line2D([], [], label="belt", **belt_line),
        Line2D([], [], label="start", **start),
    ]
    if sticks.any():
        handles.append(Patch(label="sticking", **shade))
    legend(figure, handles, at_right=False)
    entitle(figure, upper, _title(ds) if title is None else title, above_all=True)
    return figure


def _title(ds: xr.Dataset) -> str:
    """The title of the dataset, and below it the parameters of the cell."""
    held = {name: float(ds[name]) for name in _NAMED if name in ds.coords and ds[name].ndim == 0}
    words = [f"{spoken(name)} {_quantity(name, value)}" for name, value in held.items() if value or name in _ALWAYS]
    return "\n".join(filter(None, [str(ds.attrs.get("title", "")), ", ".join(words)]))


def _quantity(name: str, value: float) -> str:
    """A parameter as people write it."""
    unit = PARAMETERS[name].units
    return customary(unit, value) or f"{value:.4g} {units.spelled(unit)}".rstrip()


def _spans(time: NDArray[np.float64], inside: NDArray[np.bool_]) -> Iterator[tuple[float, float]]:
    """Start and end of the intervals in which `inside` holds; an interval ends where the next sample begins."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    for first, past in zip(changes[::2], changes[1::2], strict=True):
        yield float(time[first]), float(time[min(past, len(time) - 1)])
