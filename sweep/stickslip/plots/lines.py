"""Trajectories with their phase portraits; the probability of a regime, with what decides it."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from stickslip.dataset.display import MapAxis, unit_of
from stickslip.dataset.display import title as array_title
from stickslip.dataset.selection import check_dataset
from stickslip.errors import PlotError
from stickslip.plots.layout import BESIDE, Figure, apply, entitle, fixed_note, labelled, legend, shade, wrapped
from stickslip.plots.maps import plot_map
from stickslip.plots.marks import PLAIN, Look
from stickslip.plots.palette import BLACK, BLUE, FLAG_COLOURS, GREY, ORANGE, SKY, VERMILLION, look_of, regime_label
from stickslip.vocabulary.display_units import quantity, spoken
from stickslip.vocabulary.quantities import MODES, PARAMETERS

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

    named = {name: wrapped(array_title(ds[name], unit), BESIDE) for name, unit in units.items()}
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


# --- probabilities ----------------------------------------------------------------------------------------------------

_ERRORS = 2.0  # standard errors to either side that are drawn: 92 % of cases with eight scramblings, 95 % with many
_LOG_BELOW = 1e-3  # a probability as small as this is drawn on a logarithmic axis


def plot_probability(
    ds: xr.Dataset, state: str = "stick_slip", *, title: str | None = None, look: Look = PLAIN
) -> Figure:
    """The probability of a regime: bars for one cell, a line with its band over one axis, a map over more.

    Beside or below it, if they were computed, the Sobol indices of the uncertain quantities. look : of maps.
    Raises PlotError.
    """
    check_dataset(ds)
    if "probability" not in ds or state not in ds.get("state", []):
        raise PlotError(f"holds no probability of {state}: it needs a result of a configuration with uncertain inputs")
    title = str(ds.attrs.get("title", "")) if title is None else title
    dims = [dim for dim in ds["probability"].dims if dim != "state"]
    if not dims and "levels" in ds:
        raise PlotError("nothing to draw: the probability of one rare event is a number")
    if not dims:
        return _cell(ds, state, title)
    of_state = ds.sel(state=state)
    if len(dims) == 1:
        return _line(of_state, state, title)
    named = of_state["probability"].assign_attrs(long_name=f"probability of {regime_label(state)}")
    return plot_map(of_state.assign(probability=named), "probability", title=title, look=look)


def _cell(ds: xr.Dataset, state: str, title: str) -> Figure:
    """Bars of the regimes that may occur, and of the indices."""
    with_indices = "sobol_total" in ds and bool(ds["sobol_total"].sel(state=state).notnull().any())
    figure = Figure(figsize=(9.6 if with_indices else 5.6, 3.6), layout="constrained")
    left, *right = figure.subplots(1, 1 + with_indices, squeeze=False)[0]
    shown = [str(name) for name in ds["state"].values if float(ds["probability_high"].sel(state=name)) > 0]
    for place, name in enumerate(shown):
        of_state = ds.sel(state=name)
        value, error = float(of_state["probability"]), float(of_state["probability_error"])
        low, high = float(of_state["probability_low"]), float(of_state["probability_high"])
        colour = FLAG_COLOURS["regime"][name]
        left.barh(place, value, color=colour, edgecolor=BLACK, linewidth=0.6)
        if high > low:
            left.barh(place, high - low, left=low, height=0.3, color=GREY, edgecolor=BLACK, hatch="///", linewidth=0.6)
        left.errorbar(value, place, xerr=_ERRORS * error, color=BLACK, capsize=4)
        left.annotate(
            f"{value:.4g}", (1.0, place), xytext=(4, 0), textcoords="offset points", va="center", fontsize="small"
        )
    left.set_yticks(range(len(shown)), labels=[regime_label(name) for name in shown])
    left.invert_yaxis()
    left.set(xlim=(0, 1), xlabel=f"probability (bars: ± {_ERRORS:g} standard errors)")
    if right:
        _index_bars(right[0], ds.sel(state=state), state)
    legend(figure, labelled(*right), fixed_note(ds))
    entitle(figure, left, title, above_all=True)
    return figure


def _index_bars(ax: Axes, ds: xr.Dataset, state: str) -> None:
    """First-order and total index of every quantity."""
    names = [spoken(str(name)) for name in ds["quantity"].values]
    places = np.arange(len(names))
    for shift, which, label, colour, hatch in (
        (-0.2, "sobol_first", "by itself (first order)", SKY, ""),
        (0.2, "sobol_total", "with others (total)", ORANGE, "//"),
    ):
        value, error = ds[which].values, _ERRORS * ds[f"{which}_error"].values
        look: dict[str, Any] = {"color": colour, "edgecolor": BLACK, "linewidth": 0.6, "hatch": hatch}
        ax.barh(places + shift, value, 0.38, label=label, **look)
        ax.errorbar(value, places + shift, xerr=error, fmt="none", color=BLACK, capsize=3)
    ax.set_yticks(places, labels=names)
    ax.invert_yaxis()
    ax.set(
        xlim=(min(0.0, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1])), xlabel=f"Sobol index of {regime_label(state)}"
    )


def _line(ds: xr.Dataset, state: str, title: str) -> Figure:
    """Probability over one axis, with what is uncertain about it; below it the total indices."""
    x = MapAxis(ds, ds["probability"].dims[0])
    with_indices = "sobol_total" in ds and bool(ds["sobol_total"].notnull().any())
    figure = Figure(figsize=(7.6, 6.4 if with_indices else 4.2), layout="constrained")
    upper, *lower = figure.subplots(1 + with_indices, sharex=True, squeeze=False)[:, 0]
    value, error = ds["probability"].values, ds["probability_error"].values
    bounded = "probability_low" in ds  # which one number per simulation is not
    low, high = (ds[f"probability_{end}"].values if bounded else value for end in ("low", "high"))
    if (high > low).any():
        upper.fill_between(x.centres, low, high, color=GREY, label="bounds: unresolved or failed draws")
    band: dict[str, Any] = {"color": FLAG_COLOURS["regime"][state], "alpha": 0.4, "linewidth": 0}
    upper.fill_between(x.centres, np.maximum(value - _ERRORS * error, 0.0), value + _ERRORS * error,
                       label=f"± {_ERRORS:g} standard errors", **band)  # fmt: skip
    upper.plot(x.centres, value, color=BLACK, linewidth=1.0, marker="." if x.length < 40 else "")
    positive = value[value > 0]
    if positive.size and positive.min() < _LOG_BELOW and "levels" in ds:
        upper.set_yscale("log")
    else:
        upper.set_ylim(-0.02, 1.02)
    upper.set_ylabel(f"probability of\n{regime_label(state)}")
    if lower:
        _index_lines(lower[0], ds, x)
    apply(x, upper, "x")
    (lower[0] if lower else upper).set_xlabel(x.title)
    legend(figure, labelled(upper, *lower), fixed_note(ds))
    entitle(figure, upper, title)
    return figure


def _index_lines(ax: Axes, ds: xr.Dataset, x: MapAxis) -> None:
    """The total index of every quantity over the axis; nothing where the regime is certain."""
    for i, name in enumerate(ds["quantity"].values):
        of_quantity = ds.sel(quantity=name)
        look = look_of(i) | {"markersize": 4, "linewidth": 1.0, "capsize": 2}
        value, error = of_quantity["sobol_total"].values, _ERRORS * of_quantity["sobol_total_error"].values
        ax.errorbar(x.centres, value, error, label=spoken(str(name)), **look)
    ax.set(ylabel="total\nSobol index", ylim=(-0.05, 1.05))
