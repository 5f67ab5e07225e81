"""Plots of friction from records: over slip speed, and its tendency to stick-slip over the stiffness of springs."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from stickslip.errors import PlotError
from stickslip.plots.layout import Figure, entitle, legend
from stickslip.plots.palette import BLACK, BLUE, SKY, VERMILLION, look_of
from stickslip.vocabulary.quantities import REGIMES
from stickslip_materials.fit import fit_curve

_SIZE = (6.3, 3.54)  # inches: 16 cm x 9 cm
_DENSE, _ROOM = 120, 1.5  # places along the stiffness, and the factor by which they reach beyond the springs
_STYLES: dict[str, dict[str, Any]] = {
    "rising": {"linestyle": "-"},
    "falling": {"linestyle": "--", "markerfacecolor": "none"},
}
_MOST_NAMED = 8  # springs
_ALIKE = ("mass", "damping", "normal_load", "drive_speed")  # conditions that records over springs share


def plot_friction(ds: xr.Dataset) -> Figure:
    """Friction over slip speed of records (`friction_table`): full while it rises, dashed and empty while it falls.

    Raises PlotError where no record tells any.
    """
    if not int(ds["slips_used"].max()):
        raise PlotError("nothing to draw: no record has slips that tell friction")
    figure = Figure(figsize=_SIZE, layout="constrained")
    ax, names, handles = figure.add_subplot(), ds["record"].values.tolist(), []
    for i, name in enumerate(names):
        look: dict[str, Any] = {key: look_of(i)[key] for key in ("color", "marker")} | {"markersize": 4}
        handles.append(Line2D([], [], label=name, **look))
        for direction, style in _STYLES.items():
            points = ds.isel(record=i).sel(direction=direction)
            speed, sigma = 1e3 * points["slip_speed"].values, points["friction_sigma"].values
            ax.errorbar(speed, points["friction"].values, 1.96 * sigma, linewidth=0.9, **look, **style)
    ax.set(xlabel="slip speed (mm/s)", ylabel="friction coefficient", ylim=(0.0, None))
    ways = [Line2D([], [], color=BLACK, marker="o", markersize=4, label=label, **style)
            for label, style in zip(("slip speed rises", "falls"), _STYLES.values(), strict=True)]  # fmt: skip
    legend(figure, [*(handles if len(names) > 1 else ()), *ways])
    entitle(figure, ax, names[0] if len(names) == 1 else str(ds.attrs["title"]))
    return figure


def plot_over_stiffness(ds: xr.Dataset) -> Figure:
    """The tendency, Eq. (3) of the article, over the stiffness: as measured, and as the curve of all records has it.

    ds : as of `friction_table`, of records that differ in their spring alone. Raises PlotError.
    """
    stiffness, tendency = ds["stiffness"].values / 1e3, ds["tendency"].values
    seen = np.isfinite(tendency)
    if np.unique(stiffness).size < 2 or not seen.any():
        raise PlotError(
            "nothing to draw over the stiffness: expected two springs or more, and a record with a tendency"
        )
    figure = Figure(figsize=_SIZE, layout="constrained")
    ax = figure.add_subplot()
    half = (ds["tendency_high"] - ds["tendency"]).values
    ax.errorbar(stiffness[seen], tendency[seen], half[seen], fmt="o", color=BLUE, markersize=5, capsize=3, zorder=3)
    ax.plot(stiffness[~seen], np.full((~seen).sum(), 0.04), "x", color=VERMILLION, transform=ax.get_xaxis_transform())
    ax.axhline(0.0, color=BLACK, linestyle="dotted", linewidth=1.2)
    ax.set(xscale="log", xlim=(stiffness.min() / _ROOM, stiffness.max() * _ROOM))
    ax.set(xlabel="stiffness of the spring (N/mm)", ylabel="tendency, Eq. (3)")
    springs = np.unique(stiffness.round(6))
    springs = springs[:: -(-springs.size // _MOST_NAMED)]
    ax.set_xticks(springs, [f"{spring:.3g}" for spring in springs])
    ax.minorticks_off()
    handles = [Line2D([], [], color=BLUE, marker="o", linestyle="none", label="measured, 95 % interval")]
    handles += [Line2D([], [], color=VERMILLION, marker="x", linestyle="none", label="not told")] * bool((~seen).any())
    handles += [Line2D([], [], color=BLACK, linestyle="dotted", label="Eq. (3): stick-slip above")]
    legend(figure, [*handles, *_draw_theory(ax, ds)])
    entitle(figure, ax, "Tendency to stick-slip over the stiffness")
    return figure


def _draw_theory(ax: Axes, ds: xr.Dataset) -> list[Line2D | Patch]:
    """The tendency and the regime of the curve that all records follow, where these differ in the spring alone."""
    from stickslip import border, evaluate

    given = {name: np.unique(ds[name].values) if name in ds.coords else np.zeros(1) for name in _ALIKE}
    if any(values.size > 1 for values in given.values()) or np.isnan(ds["mu_stop"]).all():
        return []
    rising = ds.sel(direction="rising")
    points = [rising[name].values.ravel() for name in ("slip_speed", "friction", "friction_sigma")]
    curve = fit_curve(*(values[np.isfinite(points[2])] for values in points))
    weight = (ds["mu_stop_high"] - ds["mu_stop_low"]).values ** -2.0
    stop = float(np.nansum(ds["mu_stop"] * weight) / np.nansum(weight))
    cells = {name: float(values[0]) for name, values in given.items() if name != "drive_speed"}
    cells |= {"belt_speed": float(given["drive_speed"][0]), "mu_stop": min(stop, curve.mu_start)}
    cells |= {name: getattr(curve, name) for name in ("a1", "a2", "a3", "a4")}
    low, high = (1e3 * end for end in ax.get_xlim())
    springs = np.geomspace(low, high, _DENSE)
    theory = evaluate({**cells, "stiffness": springs})
    reversal = curve.predict(theory["slip_speed_max"].values)
    ax.plot(springs / 1e3, curve.mu_start - 2.0 * reversal + stop, color=BLACK, linewidth=1.2)
    handles: list[Line2D | Patch] = [Line2D([], [], color=BLACK, linewidth=1.2, label="by the curve of all records")]
    borders = border(cells, "stiffness", (low, high))
    places = np.append(borders["border"].values.ravel() / 1e3, high / 1e3)
    for i, regime in enumerate(borders["regime_above"].values.ravel()):
        if regime != REGIMES.index("stick_slip"):
            ax.axvspan(places[i], places[i + 1], facecolor=SKY, alpha=0.35, edgecolor=BLACK, hatch="..", linewidth=0.0)
            ax.axvline(places[i], color=BLACK, linewidth=0.8)
    return [*handles, Patch(facecolor=SKY, alpha=0.35, hatch="..", label="no stick-slip by that curve")]
