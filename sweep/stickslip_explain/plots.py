"""Plots of explanations: regimes over the axes, where laws disagree, and quantities before and after observations."""

from collections.abc import Iterator, Sequence
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from stickslip.config.yaml import section_in
from stickslip.dataset.display import MapAxis, unit_of
from stickslip.errors import PlotError
from stickslip.plots.layout import Figure, annotate, apply, entitle
from stickslip.plots.palette import BLACK, GREY, SKY, WHITE, regime_label
from stickslip.vocabulary.display_units import spoken
from stickslip.vocabulary.flags import VIBRATING

_COLUMNS = 3  # of quantities side by side
_BINS = 30
_HALF = 0.5


def plot_explained(ds: xr.Dataset, state: str = "stick_slip", *, title: str | None = None) -> Figure:
    """What explains observations: above, over the axes, the probability of a regime and where likely laws disagree
    about it, with the observations; below each quantity before and after. Raises PlotError.
    """
    names = [str(name) for name in ds["quantity"].values] if "quantity" in ds.coords else []
    if not names:
        raise PlotError("no population is computed yet, so there is nothing to draw")
    if "probability" in ds and state not in ds["state"].values:
        raise PlotError(f"holds no probability of {state}")
    maps = [name for name in ("probability", "disagreement") if name in ds]
    dims = [dim for dim in (ds["probability"].dims if maps else ()) if dim != "state"]
    if len(dims) > 2:
        raise PlotError(f"drawn over at most two axes, and there are {len(dims)}: select values of {dims[0]}")
    rows = ceil(len(names) / _COLUMNS)
    figure = Figure(figsize=(9.6, (3.8 if maps else 0.0) + 1.9 * rows + 0.4), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=[3.8, 1.9 * rows]) if maps else [figure]
    for ax, name in zip(parts[0].subplots(1, len(maps), squeeze=False)[0] if maps else (), maps, strict=True):
        if name == "probability":
            _over_axes(ax, ds, ds[name].sel(state=state), dims, f"probability of {regime_label(state)}")
        else:
            _over_axes(ax, ds, ds[name], dims, "largest difference between laws")
    below = list(parts[-1].subplots(rows, min(_COLUMNS, len(names)), squeeze=False).flat)
    for ax, name in zip(below, names, strict=False):
        _before_and_after(ax, ds, name)
    for ax in below[len(names) :]:
        ax.remove()
    note = "bars: draws given the observations; grey: 90 % of what was possible before"
    annotate(figure, [f"{note}; filled marks: observed to vibrate; open ones: quiet" if dims else note])
    title = str(ds.attrs.get("title", "")) if title is None else title
    entitle(figure, parts[0].axes[0], title, above_all=True)
    return figure


def _over_axes(ax: Axes, ds: xr.Dataset, values: xr.DataArray, dims: Sequence[Any], label: str) -> None:
    """A number from 0 to 1 over one or two axes, with the observations that have a place there."""
    if len(dims) == 1:
        x = MapAxis(ds, dims[0])
        ax.plot(x.centres, values.values, color=BLACK)
        ax.set(ylim=(-0.02, 1.02), ylabel=label, xlabel=x.title)
        apply(x, ax, "x")
        return
    y, x = (MapAxis(ds, dim) for dim in dims)
    drawn = ax.pcolormesh(x.edges, y.edges, values.transpose(*dims).values, vmin=0, vmax=1, rasterized=True)
    if float(values.min()) < _HALF < float(values.max()):
        ax.contour(x.centres, y.centres, values.transpose(*dims).values, [_HALF], colors=WHITE, linewidths=1.0)
    apply(x, ax, "x")
    apply(y, ax, "y")
    ax.set(xlabel=x.title, ylabel=y.title)
    for at_x, at_y, vibrates in _observed(ds, [x.dim, y.dim]):
        ax.plot(x.unit.of(at_x), y.unit.of(at_y), "o", markersize=7, markeredgecolor=BLACK, markeredgewidth=1.5,
                markerfacecolor=BLACK if vibrates else WHITE, clip_on=False)  # fmt: skip
    ax.set_title(label, fontsize="medium")
    figure: Any = ax.figure
    bar = figure.colorbar(drawn, ax=ax)
    bar.ax.set_yticks(np.linspace(0, 1, 6))


def _observed(ds: xr.Dataset, dims: Sequence[Any]) -> Iterator[tuple[float, float, bool]]:
    """Places of observations along two axes, and whether they vibrate; none of those that are elsewhere."""
    for seen in section_in(str(ds.attrs.get("configuration", "")), "explain").get("observed", ()):
        if all(str(dim) in seen for dim in dims) and seen.get("regime"):
            yield float(seen[str(dims[0])]), float(seen[str(dims[-1])]), bool({*seen["regime"]} & {*VIBRATING})


def _before_and_after(ax: Axes, ds: xr.Dataset, name: str) -> None:
    """The draws of a quantity over what was possible before."""
    draws = ds[f"posterior_{name}"]
    unit = unit_of(draws)
    values, (low, _, high) = unit.of(draws.values), unit.of(ds[f"prior_interval_{name}"].values)
    ends = min(values.min(), low), max(np.quantile(values, 0.999), high)
    ax.axvspan(low, high, color=GREY, alpha=0.5, linewidth=0)
    ax.hist(values, bins=np.linspace(*ends, _BINS + 1).tolist(), color=SKY, edgecolor=BLACK, linewidth=0.4)
    ax.set(yticks=[], xlim=ends, xlabel=f"{spoken(name)}{f' ({unit.printed})' if unit.printed else ''}")
    ax.xaxis.set_major_locator(MaxNLocator(5))


def plot_information(ds: xr.Dataset, *, title: str | None = None) -> Figure:
    """The expected information of an observation over one or two axes, with the proposals in their order."""
    dims = list(ds["information"].dims)
    figure = Figure(figsize=(7.6, 4.6), layout="constrained")
    ax = figure.subplots()
    x = MapAxis(ds, dims[-1])
    if len(dims) == 1:
        ax.plot(x.centres, ds["information"].values, color=BLACK)
        heights = ds["proposed_information"].values
        ax.set(ylabel="expected information (bits)", ylim=(0, None))
    else:
        y = MapAxis(ds, dims[0])
        drawn = ax.pcolormesh(x.edges, y.edges, ds["information"].values, vmin=0, rasterized=True)
        figure.colorbar(drawn, ax=ax, label="expected information of an observation (bits)")
        apply(y, ax, "y")
        ax.set_ylabel(y.title)
        heights = y.unit.of(ds[f"proposed_{dims[0]}"].values)
    apply(x, ax, "x")
    ax.set_xlabel(x.title)
    for number, (at, height) in enumerate(zip(x.unit.of(ds[f"proposed_{dims[-1]}"].values), heights, strict=True), 1):
        ax.annotate(str(number), (at, height), ha="center", va="center", fontsize="small", annotation_clip=False,
                    bbox={"boxstyle": "circle", "facecolor": WHITE, "edgecolor": BLACK})  # fmt: skip
    annotate(figure, ["numbers: the best places to measure next, in their order"])
    entitle(figure, ax, str(ds.attrs.get("title", "")) if title is None else title)
    return figure
