"""Figures 2 and 7: friction curves, and what the branches of Figure 2 mean for the regime."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from article.plotting import SERIES, axes_of, blank_plot, legend, mark, name_axes
from article.recipe import (
    Cell,
    Findings,
    Floats,
    Made,
    cell,
    cells,
    configuration,
    labelled,
    stick_slip_border,
)
from stickslip.api.runs import run
from stickslip.dataset.display import MapAxis
from stickslip.plots.maps import hatch
from stickslip.plots.palette import BLACK, BLUE, GREY, VERMILLION, paint
from stickslip.theory import reversal_speed, stribeck, tendency


def friction(w: ArrayLike, p: Cell) -> Floats:
    """Friction coefficient at the slip speed w (m/s) >= 0, while it increases."""
    return stribeck(w, p["a1"], p["a2"], p["a3"], p["a4"])


def transition(p: Cell) -> tuple[float, float]:
    """The transition point v(mu_min) (m/s) and mu_min."""
    speed = float(reversal_speed(p["a2"], p["a3"], p["a4"]))
    return speed, float(friction(speed, p))


def line(w: ArrayLike, p: Cell, reversal: float) -> Floats:
    """Friction while slowing down, Eq. (2a): straight from S(reversal) at the speed `reversal` to (0, mu_stop)."""
    turned = float(friction(reversal, p))
    return np.asarray(p["mu_stop"] + (turned - p["mu_stop"]) / reversal * np.asarray(w, np.float64), np.float64)


def draw_branches(ax: Axes, p: Cell, fastest: float) -> None:
    """The Stribeck curve up to a speed, its declining branch in one colour, its rising branch in another."""
    turn, least = transition(p)
    for start, stop, colour, words in (
        (0.0, turn, VERMILLION, "declining branch"),
        (turn, fastest, BLUE, "rising branch"),
    ):
        w = np.linspace(start, stop, 300)
        ax.plot(w, friction(w, p), color=colour, linewidth=2, label=words)
    ax.axvline(turn, color=GREY, linewidth=0.9, linestyle="dotted", zorder=0)
    mark(ax, turn, least, rf"$v(\mu_{{min}})$ = {turn:.4f} m/s, $\mu_{{min}}$ = {least:.4f}", (-20, -18))
    ax.set_ylim(bottom=least - 0.03)
    name_axes(ax, "slip speed (m/s)", "friction coefficient")


_TOLERANCE = 1e-5  # the closer to the border, the longer a motion takes to decide


# --- Figure 2 ---------------------------------------------------------------------------------------------------------


def figure_2() -> Made:
    """The curve with its transition point, and below it the regime over the belt speed, from two starts."""
    config = configuration("fig2")
    ds = run(config)
    p = cell(config)
    turn, least = transition(p)
    findings: Findings = {"mu_start": float(friction(0.0, p)), "v_min": turn, "mu_min": least}
    findings |= _edges(cells(config), turn, ds.sizes["belt_speed"])

    made = blank_plot(7.6, 5.4, "Figure 2: Stribeck curve, and the regimes on its branches")
    (curve,), (map_,) = axes_of(made, 2, 1, sharex=True, height_ratios=[3, 1])
    draw_branches(curve, p, float(ds["belt_speed"].max()))
    curve.set_xlabel("")
    legend(curve, loc="upper center")
    _draw_regimes(map_, ds)
    map_.axvline(turn, color=BLACK, linewidth=0.9, linestyle="dotted")
    name_axes(map_, "slip speed of the curve, belt speed of the regimes (m/s)", "start")
    w = np.linspace(0.0, float(ds["belt_speed"].max()), 601)
    data = ds.assign_coords(slip_speed=("slip_speed", w, {"units": "m s-1", "long_name": "slip speed"}))
    named = {"units": "1", "long_name": "friction coefficient of the curve"}
    data["curve"] = ("slip_speed", friction(w, p), named)
    return Made(made, labelled(data, "Figure 2: Stribeck curve", ["fig2"], findings), findings)


def _edges(every: Mapping[str, Floats], turn: float, speeds: int) -> Findings:
    """Highest belt speed of stick-slip, started from sticking and from close to steady sliding."""
    found: Findings = {}
    for position, start in ((0, "sticking"), (speeds, "sliding")):
        one = {name: float(values[position]) for name, values in every.items() if name != "belt_speed"}
        edge = float(stick_slip_border(one, "belt_speed", (0.2, 1.2), rtol=1e-6, tolerance=_TOLERANCE)[0])
        found |= {f"edge_from_{start}": edge, f"edge_from_{start}_over_v_min": edge / turn}
    return found


def _draw_regimes(ax: Axes, ds: xr.Dataset) -> None:
    """A strip of regimes over the belt speed for each start."""
    painted, speed = paint("regime", ds["regime"].values), MapAxis(ds, "belt_speed")
    for row, regimes in enumerate(ds["regime"].values):
        edges, cells = np.array([row - 0.4, row + 0.4]), regimes[np.newaxis]
        ax.pcolormesh(speed.edges, edges, cells, cmap=painted.colours, norm=painted.norm)
        hatch(ax, "regime", cells, speed.edges, edges)
    ax.set_yticks(range(ds.sizes["start"]), labels=[str(start) for start in ds["start"].values])
    ax.tick_params(axis="y", length=0)
    ax.set_ylim(-0.6, ds.sizes["start"] - 0.4)
    ax.legend(handles=painted.handles(), loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize="small")


# --- Figure 7 ---------------------------------------------------------------------------------------------------------


def figure_7() -> Made:
    """Possible curves during deceleration, from the minimum of the curve and from an earlier reversal."""
    config = configuration("fig8")
    every = cells(config)
    p = cell(config)
    turn, least = transition(p)
    fastest, early = 0.6, 0.15
    w = np.linspace(0.0, fastest, 601)
    stops = every["mu_stop"]
    down = np.array([np.where(w < turn, line(w, {**p, "mu_stop": stop}, turn), friction(w, p)) for stop in stops])

    made = blank_plot(7.6, 4.2, "Figure 7: possible Stribeck curves during deceleration")
    ((ax,),) = axes_of(made, 1, 1)
    ax.plot(w, friction(w, p), color=BLACK, linewidth=2, label="speeding up; slowing down above the minimum")
    for number, (stop, values, colour) in enumerate(zip(stops, down, SERIES, strict=False), 1):
        below = w <= turn
        words = rf"slowing down to $\mu_{{stop{number}}}$ = {stop:.4g}"
        ax.plot(w[below], values[below], color=colour, linewidth=2, label=words)
        short = w[w <= early]
        ax.plot(short, line(short, {**p, "mu_stop": stop}, early), color=colour, linewidth=1, linestyle="dashed")
    mark(ax, turn, least, r"reversal at the minimum: $\mu_{reversal}$" + f" = {least:.4f}", (6, -16))
    mark(ax, early, float(friction(early, p)), "earlier reversal (dashed): the line starts there", (8, 6))
    name_axes(ax, "slip speed (m/s)", "friction coefficient")
    legend(ax, loc="upper right")

    findings: Findings = {"mu_reversal": least, "v_reversal": turn}
    tendencies = tendency(friction(0.0, p), least, stops)
    findings |= {f"tendency_{i}": float(value) for i, value in enumerate(tendencies, 1)}
    data = xr.Dataset(
        {
            "curve": ("slip_speed", friction(w, p), {"units": "1", "long_name": "friction coefficient, speeding up"}),
            "deceleration": (
                ("mu_stop", "slip_speed"),
                down,
                {"units": "1", "long_name": "friction coefficient, slowing down from above the minimum"},
            ),
        },
        {
            "slip_speed": ("slip_speed", w, {"units": "m s-1", "long_name": "slip speed"}),
            "mu_stop": ("mu_stop", stops, {"units": "1", "long_name": "friction coefficient at the end of slip"}),
        },
    )
    return Made(made, labelled(data, "Figure 7: curves during deceleration", ["fig8"], findings), findings)
