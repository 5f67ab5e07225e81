"""Figures 10, 11 and 19: static friction over the logarithm of the waiting time (hold time)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from article.curves import friction
from article.plotting import SERIES, axes_of, blank_plot, legend, name_axes
from article.recipe import Cell, Findings, Floats, Made, cell, cells, configuration, labelled, traces
from stickslip.api.runs import run
from stickslip.plots.palette import BLACK, BLUE, GREY, VERMILLION
from stickslip.theory import static_friction

if TYPE_CHECKING:  # measured friction is an extension, which figures but one do without
    from stickslip_materials.fit import AgeingFit, Ranking

_SCATTER, _REPETITIONS, _SEED = 0.015, 3, 19  # of a measurement, made up: standard deviation over the mean
_JUDGED_AFTER = 100.0  # s, the waiting time at which greases are compared


def breakaway_friction(ds: xr.Dataset) -> xr.DataArray:
    """What a rig measures as static friction: spring force at break-away over the load.

    The belt starts with the spring relaxed and the mass sticks, so the spring stretches by belt_speed breakaway_time.
    """
    force = ds["stiffness"] * ds["belt_speed"] * ds["breakaway_time"]
    measured: xr.DataArray = force / ds["normal_load"]
    return measured.assign_attrs(units="1", long_name="static friction coefficient, from the force at break-away")


def _law(time: Floats | float, p: Cell) -> Floats:
    """Static friction after `time` (s) in contact, by the law of the model."""
    return static_friction(time, p["a1"] + p["a3"], p["ageing_rate"], p["ageing_time"])


# --- Figure 10 --------------------------------------------------------------------------------------------------------


def figure_10() -> Made:
    """The real area of contact after short and long waiting, drawn on a made-up rough profile."""
    p = cell(configuration("fig11"))
    times, share_at_once = (0.0, 1000.0), 0.12
    shares = share_at_once * _law(np.array(times), p) / _law(0.0, p)
    x = np.linspace(0.0, 1.0, 1201)
    random = np.random.default_rng(4)
    profile = sum(
        random.uniform(0.3, 1.0) / n * np.sin(2 * np.pi * (n * x + random.uniform())) for n in range(5, 40)
    ) * np.ones_like(x)

    made = blank_plot(7.6, 3.8, "Figure 10: real area of contact (profile made up, growth from the model)")
    heights = [float(np.quantile(profile, 1 - share)) for share in shares]
    for ax, time, share, height in zip(axes_of(made, 2, 1, sharex=True)[:, 0], times, shares, heights, strict=True):
        top = profile.max() + 0.35
        ax.fill_between(x, profile.min() - 0.3, np.minimum(profile, height), color=GREY, linewidth=0)
        ax.fill_between(x, height, top, color=BLUE, alpha=0.35, linewidth=0)
        touching = (profile >= height).tolist()
        ax.fill_between(x, height - 0.06, height + 0.06, where=touching, color=VERMILLION, linewidth=0)
        words = "at once" if time == 0 else f"after {time:g} s"
        ax.set_ylabel(f"{words}\n{share / share_at_once:.2f} times the area", fontsize="small")
        ax.set(xticks=[], yticks=[], xlim=(0, 1), ylim=(profile.min() - 0.3, top))
    findings: Findings = {"area_ratio_1000s": float(shares[1] / shares[0])}
    waits = np.geomspace(0.01, 1e4, 61)
    ratio = _law(waits, p) / _law(0.0, p)
    data = xr.Dataset(
        {"area_ratio": ("time", ratio, {"units": "1", "long_name": "real area of contact over that at once"})},
        {"time": ("time", waits, {"units": "s", "long_name": "waiting time"})},
    )
    return Made(made, labelled(data, "Figure 10: real area of contact", ["fig11"], findings), findings)


# --- Figure 11 --------------------------------------------------------------------------------------------------------


def figure_11() -> Made:
    """Static friction measured at break-away over the waiting time, beside the law."""
    config = configuration("fig11")
    ds, p = run(config), cell(config)
    waits, measured = ds["contact_time"].values, breakaway_friction(ds)
    off = measured.values - _law(waits + ds["breakaway_time"].values, p)
    long = waits >= 10 * p["ageing_time"]
    slope, level = np.polyfit(np.log10(waits[long]), measured.values[long], 1)

    made = blank_plot(7.6, 4.2, "Figure 11: static friction over the waiting time (illustrative numbers)")
    ((ax,),) = axes_of(made, 1, 1)
    points = {"color": BLUE, "marker": "o", "markersize": 4, "linestyle": "none"}
    ax.semilogx(waits, measured, label="force at break-away / load", **points)
    ax.semilogx(waits, _law(waits, p), color=VERMILLION, linewidth=1.6, zorder=1,
                label=r"$\mu_{static} + \beta\,\log_{10}(1 + t/t_0)$")  # fmt: skip
    ax.semilogx(waits, level + slope * np.log10(waits), color=BLACK, linewidth=0.9, linestyle="dashed", zorder=0,
                label=f"straight line: {slope:.4f} per decade")  # fmt: skip
    ax.axvline(p["ageing_time"], color=GREY, linestyle="dotted", label=f"$t_0$ = {p['ageing_time']:g} s")
    ax.set_ylim(bottom=0.95 * float(measured.min()))
    name_axes(ax, "waiting time (s)", "static friction coefficient")
    legend(ax, loc="upper left")
    findings: Findings = {
        "ageing_rate": p["ageing_rate"],
        "slope_per_decade": float(slope),
        "off_line_max": float(np.abs(measured.values[long] - level - slope * np.log10(waits[long])).max()),
        "off_law_max": float(np.abs(off).max()),
        "mu_after_10s": float(np.interp(10.0, waits, measured.values)),
        "mu_after_1000s": float(np.interp(1000.0, waits, measured.values)),
    }
    data = ds.assign(breakaway_friction=measured)
    return Made(made, labelled(data, "Figure 11: static friction over waiting time", ["fig11"], findings), findings)


# --- Figure 19 --------------------------------------------------------------------------------------------------------


def figure_19() -> Made:
    """Static friction of three greases, fitted and ranked, and the raw friction force of one waiting time."""
    from stickslip.fit import fit_ageing, rank

    config = configuration("fig19")
    ds, every = run(config), cells(config)
    names = [str(name) for name in ds["grease"].values]
    waits = ds["contact_time"].values
    points = _measurements(breakaway_friction(ds).transpose("grease", "contact_time").values)
    fits = {name: fit_ageing(np.repeat(waits, _REPETITIONS), points[i].ravel()) for i, name in enumerate(names)}
    order = rank(fits, at=_JUDGED_AFTER)
    at_300 = {name: cell(config, i * waits.size + 2) for i, name in enumerate(names)}
    raw = traces(at_300, "grease", 0.16, 2001)

    made = blank_plot(7.6, 6.4, "Figure 19: static friction of three greases (illustrative numbers)")
    (upper,), (lower,) = axes_of(made, 2, 1, height_ratios=[1.5, 1])
    for i, (name, colour) in enumerate(zip(names, SERIES, strict=False)):
        _draw_fit(upper, fits[name], waits, points[i], colour, name)
        dynamic = float(friction(at_300[name]["belt_speed"], at_300[name]))
        upper.plot([1.0], [dynamic], color=colour, marker="s", markersize=5, linestyle="none")
        lower.plot(raw["time"], raw["friction_coefficient"].sel(grease=name), color=colour, linewidth=1.2)
    upper.set_xscale("log")
    words = "waiting time (s); squares: dynamic friction, at 1 s as in the article"
    name_axes(upper, words, "static friction coefficient")
    name_axes(lower, "time since the belt starts, after 300 s of waiting (s)", "friction coefficient")
    lower.margins(x=0)
    legend(upper, loc="upper left")
    findings = _ranked(fits, order, {n: every["ageing_rate"][i * waits.size] for i, n in enumerate(names)})
    attributes = {"units": "1", "long_name": "static friction coefficient, with a scatter that is made up"}
    repeated = xr.Variable(("grease", "contact_time", "repetition"), points, attributes)
    forces = raw["friction_coefficient"].reset_coords(drop=True).assign_attrs(comment="after 300 s of waiting")
    data = ds.assign(measured=repeated, friction_coefficient=forces)
    return Made(made, labelled(data, "Figure 19: static friction of greases", ["fig19"], findings), findings)


def _measurements(exact: Floats) -> Floats:
    """`exact` (greases, waits) as a rig would repeat it, with a scatter: (greases, waits, repetitions)."""
    random = np.random.default_rng(_SEED)
    return np.asarray(exact[..., np.newaxis] * (1 + _SCATTER * random.standard_normal((*exact.shape, _REPETITIONS))))


def _draw_fit(ax: Axes, fit: AgeingFit, waits: Floats, points: Floats, colour: str, name: str) -> None:
    """Points measured, and the fit with its slope."""
    slope = f"{fit.beta:.3f} [{fit.interval['beta'][0]:.3f}, {fit.interval['beta'][1]:.3f}]"
    ax.plot(np.repeat(waits, points.shape[-1]), points.ravel(), color=colour, marker="o", markersize=3.5,
            linestyle="none", alpha=0.7)  # fmt: skip
    times = np.geomspace(1.0, 2 * waits.max(), 50)
    ax.plot(times, fit.predict(times), color=colour, linewidth=1.5, label=f"{name}: {slope} per decade")


def _ranked(fits: dict[str, AgeingFit], order: Ranking, true: dict[str, float]) -> Findings:
    """Levels, slopes with their intervals, and which grease is best by each."""
    found: Findings = {
        "best_by_level": order.by_level[0].name,
        "best_by_slope": order.by_slope[0].name,
        "judged_after": order.at,
    }
    for name, fit in fits.items():
        key = name.split()[-1]
        found |= {f"level_{key}": float(fit.predict(order.at)), f"slope_{key}": fit.beta,
                  f"slope_{key}_low": fit.interval["beta"][0], f"slope_{key}_high": fit.interval["beta"][1],
                  f"ageing_rate_{key}": float(true[name])}  # fmt: skip
    return found
