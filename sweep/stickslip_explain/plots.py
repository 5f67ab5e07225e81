"""Plots: what explains observations, where to measure next, and what is quiet."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from stickslip.config.yaml import section_in
from stickslip.dataset.display import MapAxis, plane_names, unit_of
from stickslip.dataset.selection import selected
from stickslip.errors import PlotError
from stickslip.plots.layout import Figure, annotate, apply, entitle, legend
from stickslip.plots.maps import plot_map
from stickslip.plots.marks import PLAIN, Look
from stickslip.plots.palette import BLACK, GREY, SKY, WHITE, regime_label
from stickslip.vocabulary.display_units import spoken
from stickslip.vocabulary.quantities import VERDICTS, VIBRATING

_COLUMNS = 3  # of quantities side by side
_BINS = 30


def plot_explained(ds: xr.Dataset, state: str = "stick_slip", *, title: str | None = None) -> Figure:
    """The probability of a regime over the axes, with the observations and where likely laws disagree; below each
    quantity before and after. Raises PlotError."""
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
            values, label = ds[name].sel(state=state), f"probability of {regime_label(state)}"
        else:
            values, label = ds[name], "largest difference between laws"
        x, y = _over_axes(ax, ds, values, dims, label)
        if y is not None:
            if float(values.min()) < 0.5 < float(values.max()):
                ax.contour(x.centres, y.centres, values.transpose(*dims).values, [0.5], colors=WHITE, linewidths=1.0)
            _observations(ax, ds, x, y)
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


def _over_axes(
    ax: Axes, ds: xr.Dataset, values: xr.DataArray, dims: Sequence[Any], label: str, most: float | None = 1.0
) -> tuple[MapAxis, MapAxis | None]:
    """A number from 0 to `most` over one or two axes, which are returned: x, and y if there is one."""
    x = MapAxis(ds, dims[-1])
    apply(x, ax, "x")
    ax.set_xlabel(x.title)
    if len(dims) == 1:
        ax.plot(x.centres, values.values, color=BLACK)
        ax.set(ylim=(0, most and 1.02 * most), ylabel=label)
        return x, None
    y = MapAxis(ds, dims[0])
    drawn = ax.pcolormesh(x.edges, y.edges, values.transpose(*dims).values, vmin=0, vmax=most, rasterized=True)
    apply(y, ax, "y")
    ax.set_ylabel(y.title)
    ax.set_title(label, fontsize="medium")
    figure: Any = ax.figure
    figure.colorbar(drawn, ax=ax)
    return x, y


def _observations(ax: Axes, ds: xr.Dataset, x: MapAxis, y: MapAxis) -> None:
    """Marks at the places of observations along two axes, filled where it vibrates; none of those elsewhere."""
    dims = (str(x.dim), str(y.dim))
    for seen in section_in(str(ds.attrs.get("configuration", "")), "explain").get("observed", ()):
        if all(dim in seen for dim in dims) and seen.get("regime"):
            vibrates = bool({*seen["regime"]} & {*VIBRATING})
            at_x, at_y = (axis.unit.of(float(seen[dim])) for axis, dim in zip((x, y), dims, strict=True))
            ax.plot(at_x, at_y, "o", markersize=7, markeredgecolor=BLACK, markeredgewidth=1.5,
                    markerfacecolor=BLACK if vibrates else WHITE, clip_on=False)  # fmt: skip


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
    x, y = _over_axes(ax, ds, ds["information"], dims, "expected information (bits)", most=None)
    places = ds[f"proposed_{dims[0]}"].values
    heights = ds["proposed_information"].values if y is None else y.unit.of(places)
    for number, (at, height) in enumerate(zip(x.unit.of(ds[f"proposed_{dims[-1]}"].values), heights, strict=True), 1):
        ax.annotate(str(number), (at, height), ha="center", va="center", fontsize="small", annotation_clip=False,
                    bbox={"boxstyle": "circle", "facecolor": WHITE, "edgecolor": BLACK})  # fmt: skip
    annotate(figure, ["numbers: the best places to measure next, in their order"])
    entitle(figure, ax, str(ds.attrs.get("title", "")) if title is None else title, above_all=True)
    return figure


# --- goals ------------------------------------------------------------------------------------------------------------


_MAP = "quiet_probability"
_RING: dict[str, Any] = {"marker": "o", "markersize": 7, "markerfacecolor": "white", "markeredgecolor": "black",
                         "markeredgewidth": 1.6, "linestyle": "none", "zorder": 5}  # fmt: skip
_END: dict[str, Any] = _RING | {"marker": "D", "markersize": 4.5, "markeredgewidth": 1.2}


def plot_goal(ds: xr.Dataset, select: Mapping[str, Any], *, title: str | None = None, look: Look = PLAIN) -> Figure:
    """The probability of being quiet over the plane of each panel, the borders of the goal, a ring at what the panel
    has, and diamonds at the nearest changes of the verdict. Raises PlotError."""
    if title is None:
        title = "\n".join(filter(None, (str(ds.attrs.get("title", "")), str(ds.attrs.get("goal", "")))))
    look = replace(look, limits={_MAP: (0.0, 1.0), **look.limits})
    lines = _lines(ds)
    figure = plot_map(ds, _MAP, select=select, borders=False, lines=lines, title=title, look=look)
    part, _ = selected(ds, select)
    *outer, y, x = map(str, ds[_MAP].dims)
    outer = [dim for dim in outer if dim in part["verdict"].dims]
    panels = np.ndindex(*(part.sizes[dim] for dim in outer))
    for ax, place in zip(figure.axes, panels, strict=False):
        panel = part.isel(dict(zip(outer, place, strict=True)))
        _marks(ax, panel, y, x)
    if not figure.legends:
        return figure
    handles, notes = figure.entries
    if part[f"here_{x}"].notnull().any() and part[f"here_{y}"].notnull().any():
        marked = ("as it is", _RING), ("nearest change", _END)
        handles = [*handles, *(Line2D([], [], label=label, **look) for label, look in marked)]
    legend(figure, handles, notes)
    return figure


def _lines(ds: xr.Dataset) -> xr.Dataset:
    """The borders of what is quiet as those of a map with the dimensions of the panels: without those of what cells
    cannot be."""
    impossible = VERDICTS.index("impossible")
    possible = (ds["verdict_left"].values != impossible) & (ds["verdict_right"].values != impossible)
    nodes = np.repeat(possible, ds["node_count"].values)
    lines = ds.drop_dims([dim for dim in ds.dims if dim not in ("line", "node")]).isel(line=possible, node=nodes)
    dims = [str(dim) for dim in ds["verdict"].dims]
    places = np.unravel_index(lines["panel"].values, ds["verdict"].shape) if dims else ()
    beside = {
        dim: ("line", ds[dim].values[at] if dim in ds.coords else at) for dim, at in zip(dims, places, strict=True)
    }
    names = {name: name.removeprefix("border_") for name in plane_names(ds)}
    lines = lines.rename(names).assign_coords(beside)
    lines["geometry"].attrs["node_coordinates"] = " ".join(names.values())
    return lines


def _marks(ax: Axes, panel: xr.Dataset, y: str, x: str) -> None:
    """A ring at what a panel has, and a line from there to each nearest change."""
    here, units = (float(panel[f"here_{x}"]), float(panel[f"here_{y}"])), (unit_of(panel[x]), unit_of(panel[y]))
    if not np.isfinite(here).all():
        return
    ends = [(float(panel[f"alone_{x}"]), here[1]), (here[0], float(panel[f"alone_{y}"])),
            (float(panel[f"together_{x}"]), float(panel[f"together_{y}"]))]  # fmt: skip
    for end in ends:
        if np.isfinite(end).all():
            way = [unit.of(np.array(pair)) for unit, pair in zip(units, zip(here, end, strict=True), strict=True)]
            ax.plot(*way, color="black", linewidth=2.2, zorder=4)
            ax.plot(*way, color="white", linewidth=1.0, zorder=4)
            ax.plot(*(pair[1:] for pair in way), **_END)
    ax.plot(*(unit.of(value) for unit, value in zip(units, here, strict=True)), **_RING)
