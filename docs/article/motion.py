"""Figures 3, 4, 5 and 8: motion over time, and along the friction curve."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from article.curves import friction, line, transition
from article.plotting import SERIES, axes_of, belt_line, blank_plot, in_words, legend, name_axes, shade_sticks
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
    traces,
    trajectory,
)
from stickslip.api.runs import run
from stickslip.plots.palette import BLACK, BLUE, FLAG_COLOURS, GREY
from stickslip.vocabulary.quantities import MODES, REGIMES

_SPEED = "speed (m/s)"


def _cells_by_label(every: Mapping[str, Floats], labels: list[str]) -> dict[str, Cell]:
    """One cell per label."""
    return {label: {name: float(values[i]) for name, values in every.items()} for i, label in enumerate(labels)}


def _regimes(ds: xr.Dataset) -> list[str]:
    return [REGIMES[i] for i in np.ravel(ds["regime"].values)]


# --- Figure 3 ---------------------------------------------------------------------------------------------------------


def figure_3() -> Made:
    """Displacement and velocity in the stick-slip regime, stick phases shaded."""
    config = configuration("fig3")
    ds, p = run(config), cell(config)
    trace = trajectory(p, 35.0, 3501)
    sticking = trace["mode"].values == MODES.index("stick")
    off_belt = np.abs(trace["relative_speed"].values[sticking]).max()

    made = blank_plot(7.6, 4.8, "Figure 3: displacement and velocity in the stick-slip regime")
    (upper,), (lower,) = axes_of(made, 2, 1, sharex=True)
    for ax, name in ((upper, "displacement"), (lower, "velocity")):
        ax.plot(trace["time"], trace[name], color=BLUE, linewidth=1.4)
        shade_sticks(ax, trace)
        ax.margins(x=0)
    belt_line(lower, p["belt_speed"])
    name_axes(upper, None, "displacement s (m)")
    name_axes(lower, trace["time"], "velocity v (m/s)")
    legend(lower, loc="lower left")

    names = ("breakaway_time", "period", "frequency", "stick_fraction", "slip_speed_max")
    findings: Findings = {"regime": _regimes(ds)[0]} | {name: float(ds[name]) for name in names}
    findings |= {"velocity_min": float(trace["velocity"].min()), "relative_speed_in_stick": float(off_belt)}
    return Made(made, labelled(trace, "Figure 3: motion in stick-slip", ["fig3"], findings), findings)


# --- Figure 4 ---------------------------------------------------------------------------------------------------------


def figure_4() -> Made:
    """The passage through the curve at two belt speeds below the transition point, and the slip speed over time."""
    config = configuration("fig4")
    ds, every, p = run(config), cells(config), cell(config)
    speeds = every["belt_speed"]
    some = _cells_by_label(every, [f"{speed:g} m/s" for speed in speeds])
    trace = traces(some, "belt", 52.0, 9001)
    turn, _ = transition(p)
    top = ds["slip_speed_max"].values

    made = blank_plot(9.6, 4.6, r"Figure 4: passage through the Stribeck curve, $v_{belt1} < v_{belt2} < v(\mu_{min})$")
    places = made.add_gridspec(len(some), 2, width_ratios=[1.1, 1])
    passage = made.add_subplot(places[:, 0])
    w = np.linspace(0.0, 1.1 * max(top.max(), turn), 400)
    passage.plot(w, friction(w, p), color=GREY, linewidth=9, zorder=0, label="Stribeck curve")
    passage.axvline(turn, color=GREY, linestyle="dotted", linewidth=1.2, zorder=0, label=r"$v(\mu_{min})$")
    first = None
    for i, (colour, width) in enumerate(zip(SERIES[: len(some)], (4.5, 1.5), strict=True)):
        over_time = first = made.add_subplot(places[i, 1], sharex=first)
        _draw_passage(passage, over_time, trace.isel(belt=i), ds.isel(belt_speed=i), colour, width)
        over_time.axhline(turn, color=GREY, linestyle="dotted", linewidth=1.2, zorder=0)
        over_time.set_ylim(-0.03, 1.12 * top.max())
        name_axes(over_time, "time since break-away (s)" if i == len(some) - 1 else None, f"slip {_SPEED}")
    name_axes(passage, "slip speed (m/s)", "friction coefficient")
    legend(passage, loc="lower right")

    findings: Findings = {"v_min": turn}
    for i, (regime, speed) in enumerate(zip(_regimes(ds), speeds, strict=True), 1):
        fastest = float(top[i - 1])
        findings |= {f"regime_{i}": regime, f"belt_speed_{i}": float(speed), f"slip_speed_max_{i}": fastest,
                     f"overshoot_{i}": fastest / float(speed)}  # fmt: skip
    return Made(made, labelled(trace, "Figure 4: passage through the curve", ["fig4"], findings), findings)


def _draw_passage(passage: Axes, over_time: Axes, trace: xr.Dataset, ds: xr.Dataset, colour: str, width: float) -> None:
    """One cycle, from break-away to break-away: along the curve, and the slip speed over time."""
    start, period, speed = (float(value) for value in (ds["breakaway_time"], ds["period"], ds["belt_speed"]))
    time = trace["time"].values
    cycle = trace.isel(time=(time >= start - 0.2) & (time <= start + period))
    label = rf"belt {speed:g} m/s, slip up to {float(ds['slip_speed_max']):.3f} m/s"
    passage.plot(cycle["relative_speed"], cycle["friction_coefficient"], color=colour, linewidth=width, label=label)
    belt_line(passage, speed, along="y")
    later = trace.isel(time=(time >= start - 2) & (time <= start + 25)).assign_coords(time=lambda t: t["time"] - start)
    over_time.plot(later["time"], later["relative_speed"], color=colour, linewidth=1.4)
    belt_line(over_time, speed)
    over_time.set_title(f"belt {speed:g} m/s", fontsize="medium")
    shade_sticks(over_time, later)
    over_time.margins(x=0)


# --- Figure 5 ---------------------------------------------------------------------------------------------------------


def figure_5() -> Made:
    """Declining, flat and rising curves: stick-slip, oscillation (damped, if anything damps) and creep."""
    config = configuration("fig5")
    ds, every = run(config), cells(config)
    labels = [str(label) for label in ds["curve"].values]
    trace = traces(_cells_by_label(every, labels), "curve", 60.0, 3001)
    w = np.linspace(0.0, 0.6, 301)

    made = blank_plot(10.4, 4.9, "Figure 5: a flat or rising Stribeck curve cannot provoke stick-slip")
    table = axes_of(made, 2, len(labels), sharey="row", height_ratios=[1, 1.5])
    for i, label in enumerate(labels):
        one, regime = cell(config, i), _regimes(ds)[i]
        table[0, i].plot(w, friction(w, one), color=BLACK, linewidth=1.6)
        table[0, i].set_title(label, fontsize="medium")
        table[0, i].set_ylim(0.9, 1.9)
        table[1, i].plot(trace["time"], trace["velocity"].isel(curve=i), color=BLUE, linewidth=1.1)
        shade_sticks(table[1, i], trace.isel(curve=i))
        belt_line(table[1, i], one["belt_speed"])
        table[1, i].margins(x=0)
        frame = {"facecolor": FLAG_COLOURS["regime"][regime], "alpha": 0.45, "linewidth": 0, "pad": 2.5}
        table[1, i].set_title(in_words(regime), fontsize="medium", bbox=frame)
        name_axes(table[0, i], "slip " + _SPEED, "friction coefficient" if i == 0 else None)
        name_axes(table[1, i], "time (s)", "velocity (m/s)" if i == 0 else None)
    legend(table[1, -1], loc="lower right")

    findings: Findings = {}
    for i, label in enumerate(labels):
        key = label.replace(" ", "_")
        findings |= {f"regime_{key}": _regimes(ds)[i], f"damping_ratio_{key}": float(ds["damping_ratio"][i]),
                     f"crossings_{key}": float(ds["equilibrium_crossings"][i])}  # fmt: skip
    return Made(made, labelled(trace, "Figure 5: three kinds of curve", ["fig5"], findings), findings)


# --- Figure 8 ---------------------------------------------------------------------------------------------------------


def figure_8() -> Made:
    """Three values of mu_stop: stick-slip, damped vibration, stationary sliding soon."""
    config = configuration("fig8")
    ds, every, p = run(config), cells(config), cell(config)
    stops = every["mu_stop"]
    trace = traces(_cells_by_label(every, [f"mu_stop{i}" for i in range(1, len(stops) + 1)]), "curve", 60.0, 3001)
    turn, _ = transition(p)

    made = blank_plot(9.6, 5.2, r"Figure 8: influence of $\mu_{stop}$ on stick-slip")
    table = axes_of(made, 2, len(stops), sharex=True, sharey="row")
    for i, stop in enumerate(stops):
        words = in_words(_regimes(ds)[i])
        tendency = round(float(ds["tendency"][i]), 3) + 0.0  # no minus before zero
        table[0, i].set_title(
            rf"$\mu_{{stop{i + 1}}}$ = {stop:.4g}: {words}" + f"\ntendency {tendency:+.3f}", fontsize="medium"
        )
        for ax, name in ((table[0, i], "velocity"), (table[1, i], "friction_coefficient")):
            ax.plot(trace["time"], trace[name].isel(curve=i), color=SERIES[i], linewidth=1.2)
            shade_sticks(ax, trace.isel(curve=i))
            ax.margins(x=0)
        belt_line(table[0, i], p["belt_speed"])
        name_axes(table[0, i], None, "velocity (m/s)" if i == 0 else None)
        name_axes(table[1, i], "time (s)", "friction coefficient" if i == 0 else None)
    legend(table[0, -1], loc="lower right")

    one = {name: value for name, value in p.items() if name != "mu_stop"}
    findings: Findings = {"border_mu_stop": float(stick_slip_border(one, "mu_stop", (stops[1], stops[0]))[0])}
    for i, stop in enumerate(stops):
        findings |= {f"regime_{i + 1}": _regimes(ds)[i], f"mu_stop_{i + 1}": float(stop)}
        for name in ("tendency", "settling_time", "equilibrium_crossings"):
            findings[f"{name}_{i + 1}"] = float(ds[name][i])
        findings[f"line_error_{i + 1}"] = _off_line(trace.isel(curve=i), {**p, "mu_stop": float(stop)}, turn)
    return Made(made, labelled(trace, "Figure 8: influence of mu_stop", ["fig8"], findings), findings)


def _off_line(trace: xr.Dataset, p: Cell, turn: float) -> float:
    """Deviation of friction from the line of Eq. (2a) while the first slip decelerates below the minimum."""
    falls = np.flatnonzero(trace["mode"].values == MODES.index("fall"))
    first = falls[: int(np.argmax(np.append(np.diff(falls), 2) > 1)) + 1]
    part = trace.isel(time=first)
    return float(np.abs(part["friction_coefficient"].values - line(part["relative_speed"].values, p, turn)).max())
