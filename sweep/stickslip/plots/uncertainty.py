"""Plots of scatter: the probability of a regime over the axes, and which uncertain quantity decides."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import NDArray

from stickslip.dataset.display import MapAxis
from stickslip.dataset.selection import check_dataset
from stickslip.errors import PlotError
from stickslip.plots.fixed_values import fixed_note
from stickslip.plots.layout import Figure, annotate, apply, entitle
from stickslip.plots.maps import plot_map
from stickslip.plots.options import PLAIN, Look
from stickslip.plots.palette import BLACK, FLAG_COLOURS, GREY, ORANGE, SKY, look_of, regime_label
from stickslip.vocabulary.display_units import spoken

Floats = NDArray[np.float64]

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
    annotate(figure, fixed_note(ds))
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
    ax.legend(frameon=False, fontsize="small")


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
    upper.set_ylabel(f"probability of {regime_label(state)}")
    upper.legend(frameon=False, fontsize="small")
    if lower:
        _index_lines(lower[0], ds, x)
    apply(x, upper, "x")
    (lower[0] if lower else upper).set_xlabel(x.title)
    annotate(figure, fixed_note(ds))
    entitle(figure, upper, title)
    return figure


def _index_lines(ax: Axes, ds: xr.Dataset, x: MapAxis) -> None:
    """The total index of every quantity over the axis; nothing where the regime is certain."""
    for i, name in enumerate(ds["quantity"].values):
        of_quantity = ds.sel(quantity=name)
        look = look_of(i) | {"markersize": 4, "linewidth": 1.0, "capsize": 2}
        value, error = of_quantity["sobol_total"].values, _ERRORS * of_quantity["sobol_total_error"].values
        ax.errorbar(x.centres, value, error, label=spoken(str(name)), **look)
    ax.set(ylabel="total Sobol index", ylim=(-0.05, 1.3), yticks=np.linspace(0, 1, 6))
    ax.legend(frameon=False, fontsize="small", loc="upper center", ncols=min(4, ds.sizes["quantity"]))
