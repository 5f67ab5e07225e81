"""Trajectories over time and their phase portraits."""

from typing import Any

import numpy as np
import xarray as xr

from stickslip.dataset.display import title as array_title
from stickslip.dataset.display import unit_of
from stickslip.dataset.selection import check_dataset
from stickslip.errors import PlotError
from stickslip.plots.layout import Figure, entitle, labelled, legend, shade
from stickslip.plots.palette import BLACK, BLUE, GREY, VERMILLION
from stickslip.vocabulary.display_units import quantity, spoken
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.results import MODES

_ALWAYS = ("mass", "stiffness", "normal_load", "belt_speed")  # of the parameters that a title names
_NAMED = (*_ALWAYS, "damping")  # the others where they are not 0


def plot_trace(ds: xr.Dataset, *, title: str | None = None) -> Figure:
    """A trajectory: displacement and velocity over time with the stick phases shaded, and the phase portrait.

    The line of the belt speed appears in the phase portrait only while that speed is constant. Raises PlotError.
    """
    check_dataset(ds)
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
    mass_line: dict[str, Any] = {"color": BLUE, "linewidth": 1.2, "label": "mass"}
    belt_line: dict[str, Any] = {"color": VERMILLION, "linewidth": 1.0, "linestyle": "dashed", "label": "belt"}
    stuck: dict[str, Any] = {"facecolor": GREY, "alpha": 0.45, "linewidth": 0, "label": "sticking"}

    upper.plot(time, displacement, **mass_line)
    lower.plot(time, velocity, **mass_line)
    lower.plot(time, belt, **belt_line)
    for ax in (upper, lower):
        shade(ax, np.append(time, time[-1]), sticks, stuck)
        ax.margins(x=0)
    phase.plot(displacement, velocity, **mass_line)
    phase.plot(displacement[:1], velocity[:1], color=BLACK, marker="o", markersize=4, linestyle="none", label="start")
    if np.ptp(belt) <= 1e-9 * np.abs(belt).max():
        phase.axhline(belt[0], zorder=0, **belt_line)

    named = {name: array_title(ds[name], unit) for name, unit in units.items()}
    upper.set_ylabel(named["displacement"])
    lower.set(xlabel=named["time"], ylabel=named["velocity"])
    phase.set(xlabel=named["displacement"], ylabel=named["velocity"])
    for ax in (upper, lower, phase):
        ax.ticklabel_format(style="sci", scilimits=(-3, 4), useMathText=True)
    legend(figure, labelled(lower, phase))
    entitle(figure, upper, _title(ds) if title is None else title, above_all=True)
    return figure


def _title(ds: xr.Dataset) -> str:
    """The title of the dataset, and below it the parameters of the cell."""
    parameters = {name: float(ds[name]) for name in _NAMED if name in ds.coords and ds[name].ndim == 0}
    words = [
        f"{spoken(name)} {quantity(value, PARAMETERS[name].units)}"
        for name, value in parameters.items() if value or name in _ALWAYS
    ]  # fmt: skip
    return "\n".join(filter(None, [str(ds.attrs.get("title", "")), ", ".join(words)]))
