"""Figures 6 and 9: the stiffness of the rig, on the plain and on the modified curve."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from article.plotting import SERIES, axes_of, belt_line, blank_plot, in_words, legend, name_axes, shade_sticks
from article.recipe import (
    STICK_SLIP,
    Cell,
    Findings,
    Made,
    border_of_tendency,
    cell,
    configuration,
    labelled,
    stick_slip_border,
    traces,
)
from stickslip.api.cells import evaluate
from stickslip.api.runs import run
from stickslip.plots.palette import BLACK, BLUE, GREY, VERMILLION
from stickslip.vocabulary.quantities import REGIMES

_STIFFNESS = "stiffness (N/m)"


# --- Figure 6 ---------------------------------------------------------------------------------------------------------


def figure_6() -> Made:
    """Plain curve: the friction force over time at three stiffnesses; frequency and amplitudes over five decades."""
    config = configuration("fig6")
    ds, belt, drawn = run(config), 0.1, (1.0, 10.0, 100.0)
    some: dict[str, Cell] = {f"{k:g} N/m": cell(config, stiffness=k, belt_speed=belt) for k in drawn}
    trace = traces(some, "spring", 20.0, 4001)
    later = trace.isel(time=trace["time"].values >= 11.0)
    ds = ds.assign(displacement_amplitude=_half_stroke(ds), friction_swing=_friction_swing(ds))

    made = blank_plot(10.0, 5.2, "Figure 6: influence of the stiffness, plain Stribeck curve")
    ((left, right),) = made.subfigures(1, 2, squeeze=False, width_ratios=[1.15, 1])
    table = axes_of(left, len(some), 2, sharex=True, sharey="col")
    for row, (label, colour) in enumerate(zip(some, SERIES, strict=False)):
        one = later.sel(spring=label)
        for ax, name in zip(table[row], ("displacement", "friction_coefficient"), strict=True):
            ax.plot(one["time"], one[name], color=colour, linewidth=1.1)
            shade_sticks(ax, one)
            ax.margins(x=0)
        name_axes(table[row, 0], None, f"k = {label}\ndisplacement (m)")
        name_axes(table[row, 1], None, "friction coefficient")
    for ax in table[-1]:
        ax.set_xlabel("time (s)")
    _draw_trends(axes_of(right, 3, 1, sharex=True)[:, 0].tolist(), ds)

    at_belt = ds.sel(belt_speed=belt)
    findings: Findings = {"cells": float(ds["regime"].size),
                          "share_stick_slip": float((ds["regime"] == STICK_SLIP).mean()),
                          "decades": float(np.log10(ds["stiffness"].max() / ds["stiffness"].min()))}  # fmt: skip
    for k in (1.0, 1000.0, 10000.0):
        near = at_belt.sel(stiffness=k, method="nearest")
        for name in ("frequency", "displacement_amplitude", "friction_swing"):
            findings[f"{name}_k{k:g}"] = float(near[name])
    return Made(made, labelled(_together(ds, trace), "Figure 6: stiffness, plain curve", ["fig6"], findings), findings)


def _half_stroke(ds: xr.Dataset) -> xr.DataArray:
    """Half the way between the turning points of the mass."""
    stroke: xr.DataArray = (ds["spring_force_max"] - ds["spring_force_min"]) / ds["stiffness"] / 2
    return stroke.assign_attrs(units="m", long_name="amplitude of the displacement")


def _friction_swing(ds: xr.Dataset) -> xr.DataArray:
    """Rise of the friction coefficient during a stick phase: from the spring force at re-stick to break-away.

    While it sticks at a constant belt speed nothing accelerates, so friction balances spring and damper.
    """
    start = ds["a1"] + ds["a3"]
    stuck = ds["stiffness"] * ds["restick_displacement"] + ds["damping"] * ds["belt_speed"]
    swing: xr.DataArray = start - stuck / ds["normal_load"]
    return swing.assign_attrs(units="1", long_name="rise of the friction coefficient while sticking")


def _draw_trends(table: list[Axes], ds: xr.Dataset) -> None:
    """Frequency, amplitude of the displacement, and rise of the friction force, over stiffness."""
    names = (
        ("frequency", "frequency (Hz)"),
        ("displacement_amplitude", "amplitude of\ndisplacement (m)"),
        ("friction_swing", "rise of friction\nwhile sticking (N)"),
    )
    for ax, (name, words) in zip(table, names, strict=True):
        for speed, colour in zip(ds["belt_speed"].values, SERIES, strict=True):
            line = ds[name].sel(belt_speed=speed).where(ds["regime"].sel(belt_speed=speed) == STICK_SLIP)
            draw = ax.semilogx if name == "friction_swing" else ax.loglog
            draw(ds["stiffness"], line, color=colour, linewidth=1.3, label=f"{speed:g} m/s")
        name_axes(ax, None, words)
    name_axes(table[-1], _STIFFNESS, None)
    legend(table[0], title="belt speed", title_fontsize="small", ncols=2)


def _together(ds: xr.Dataset, trace: xr.Dataset) -> xr.Dataset:
    """A map and the trajectories of some of its cells, these with names that start with `trace_`."""
    names = ["displacement", "velocity", "relative_speed", "friction_coefficient", "spring_force", "mode"]
    plain = trace[names].rename({name: f"trace_{name}" for name in names})
    return ds.merge(plain.drop_vars([name for name in plain.coords if name not in plain.dims]))


# --- Figure 9 ---------------------------------------------------------------------------------------------------------


def figure_9() -> Made:
    """Modified curve: traces at three stiffnesses, mu_reversal and tendency over stiffness, the transition."""
    config = configuration("fig9")
    ds, p, drawn = run(config), cell(config), (10.0, 30.0, 100.0)
    some: dict[str, Cell] = {f"{k:g} N/m": {**p, "stiffness": k} for k in drawn}
    trace = traces(some, "spring", 16.0, 4001)
    regimes = {k: REGIMES[int(evaluate(one)["regime"][0])] for k, one in zip(drawn, some.values(), strict=True)}
    findings = {f"regime_k{k:g}": regime for k, regime in regimes.items()} | _transition(p)

    made = blank_plot(9.2, 6.0, "Figure 9: influence of the stiffness, modified Stribeck curve")
    (upper,), (lower,) = made.subfigures(2, 1, squeeze=False, height_ratios=[1.0, 1.15])
    table = axes_of(upper, 1, len(some), sharey="row")
    for ax, label, k, colour in zip(table[0], some, drawn, SERIES, strict=False):
        one = trace.sel(spring=label)
        ax.plot(one["time"], one["velocity"], color=colour, linewidth=1.1)
        shade_sticks(ax, one)
        belt_line(ax, p["belt_speed"])
        ax.margins(x=0)
        ax.set_title(f"k = {label}: {in_words(regimes[k])}", fontsize="medium")
        name_axes(ax, "time (s)", "velocity (m/s)" if k == drawn[0] else None)
    legend(table[0, -1], loc="lower right")
    _draw_causes(axes_of(lower, 2, 1, sharex=True)[:, 0].tolist(), ds, findings, drawn)
    data = labelled(_together(ds, trace), "Figure 9: stiffness, modified curve", ["fig9"], findings)
    return Made(made, data, findings)


def _transition(p: Cell) -> Findings:
    """The stiffness where stick-slip ends, that where the tendency is zero, and what mu_reversal does between."""
    rest = {name: value for name, value in p.items() if name != "stiffness"}

    def occurred(name: str, stiffness: float) -> float:
        return float(evaluate({**rest, "stiffness": stiffness}, rtol=1e-8)[name][0])

    ends = float(stick_slip_border(rest, "stiffness", (30.0, 100.0))[0])
    zero = border_of_tendency(rest, "stiffness", (30.0, 100.0))
    plain: dict[str, Any] = {**rest, "mu_stop": float("nan"), "stiffness": np.geomspace(1.0, 1000.0, 61)}
    plain_share = float((evaluate(plain)["regime"] == STICK_SLIP).mean())
    start = p["a1"] + p["a3"]
    return {
        "transition_stiffness": ends,
        "stiffness_of_zero_tendency": zero,
        "tendency_at_transition": occurred("tendency", ends),
        "tendency_at_transition_over_drop": occurred("tendency", ends) / (start - occurred("mu_reversal", ends)),
        "mu_reversal_k1": occurred("mu_reversal", 1.0),
        "mu_reversal_k30": occurred("mu_reversal", 30.0),
        "mu_reversal_k100": occurred("mu_reversal", 100.0),
        "plain_share_stick_slip": plain_share,
    }


def _draw_causes(table: list[Axes], ds: xr.Dataset, findings: Findings, drawn: tuple[float, ...]) -> None:
    """mu_reversal and the tendency over stiffness, in the colour of what happens there."""
    sticking = ds["regime"].values == STICK_SLIP
    stiffness = ds["stiffness"].values
    for ax, name, words in zip(table, ("mu_reversal", "tendency"), (r"$\mu_{reversal}$", "tendency"), strict=True):
        for inside, colour, label in ((sticking, VERMILLION, "stick-slip"), (~sticking, BLUE, "no stick-slip")):
            values = np.where(inside, ds[name].values, np.nan)
            ax.semilogx(stiffness, values, color=colour, linewidth=2, label=label)
        ax.axvline(float(findings["transition_stiffness"]), color=BLACK, linewidth=1,
                   label=f"stick-slip ends at {float(findings['transition_stiffness']):.1f} N/m")  # fmt: skip
        for k in drawn:
            ax.axvline(k, color=GREY, linewidth=0.9, linestyle="dotted", zorder=0)
        ax.margins(x=0)
        name_axes(ax, None, words)
    zero = float(findings["stiffness_of_zero_tendency"])
    table[1].axhline(0.0, color=BLACK, linewidth=0.8, linestyle="dashed")
    table[1].plot([zero], [0.0], color=BLACK, marker="o", markersize=4, linestyle="none",
                  label=f"tendency 0 at {zero:.1f} N/m")  # fmt: skip
    name_axes(table[1], _STIFFNESS, None)
    legend(table[1], loc="upper right")
