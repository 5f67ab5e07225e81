"""Equation (3): how well the sign of the tendency predicts the regime.

The tendency S = mu_start - 2 mu_reversal + mu_stop takes mu_reversal as it occurred: the friction where the first slip
reversed. The article puts the border of stick-slip at S = 0. Two figures: maps, and a wide range of parameters with
the true border. S is exact where the decelerating branch mirrors the accelerating one (`mirror_error`).
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from article.curves import friction
from article.plotting import axes_of, blank_plot, in_words, name_axes, tick_values, write_table
from article.recipe import (
    STICK_SLIP,
    Findings,
    Floats,
    Made,
    cell,
    configuration,
    labelled,
    stick_slip_border,
)
from stickslip.api.cells import evaluate
from stickslip.api.runs import run
from stickslip.plots.layout import Figure as Plot
from stickslip.plots.palette import BLACK, paint
from stickslip.theory import tendency
from stickslip.vocabulary.quantities import REGIMES

_V_REVERSAL = 0.34  # m/s, minimum of the curves of both configurations
_RULED_OUT = tuple(REGIMES.index(name) for name in ("not_computed", "stuck", "unresolved", "failed"))


def figure_maps() -> Made:
    """The tendency beside the simulated regime over mu_reversal and mu_stop, one column per belt speed."""
    config = configuration("eq3")
    ds = _judged(run(config))
    speeds = ds["belt_speed"].values
    heading = r"Eq. (3): tendency (above) and simulated regime (below), $\mu_{start}$ = 1.3, k = 1 N/m"
    made = blank_plot(11.0, 6.2, heading)
    table = axes_of(made, 2, len(speeds), sharex=True, sharey=True)
    painted = paint("regime", ds["regime"].values)
    bound = float(np.ceil(10 * np.abs(ds["tendency"]).max()) / 10)
    for (above, below), speed in zip(table.T, speeds, strict=True):
        panel = ds.sel(belt_speed=speed)
        x, y = panel["mu_stop"].values, panel["mu_reversal_of_curve"].values
        colours = above.contourf(x, y, panel["tendency"].values, levels=np.linspace(-bound, bound, 21), cmap="RdBu_r")
        below.pcolormesh(x, y, panel["regime"].values, cmap=painted.colours, norm=painted.norm, shading="nearest",
                         rasterized=True)  # fmt: skip
        for ax in (above, below):
            ax.contour(x, y, panel["tendency"].values, levels=[0.0], colors=BLACK, linewidths=1.4)
        share = 100 * float(panel["predicted"].sum() / panel["decided"].sum())
        above.set_title(f"belt {speed:g} m/s\nsign right in {share:.1f} % of cells", fontsize="medium")
        name_axes(below, r"$\mu_{stop}$", None)
    for ax in table[:, 0]:
        name_axes(ax, None, r"minimum of the curve $\mu_{min}$")
    made.colorbar(colours, ax=table[0].tolist(), label="tendency", pad=0.01)
    _regime_legend(made, painted.flags or {})
    findings = _shares(ds)
    for speed in speeds:
        findings[f"share_predicted_v{speed:g}".replace(".", "_")] = _shares(ds.sel(belt_speed=speed))["share_predicted"]
    return Made(made, labelled(ds, "Eq. (3): tendency and regime", ["eq3"], findings), findings)


def _regime_legend(made: Plot, flags: dict[str, str]) -> None:
    """Legend of the regimes that occur, and of the line of zero tendency."""
    handles = [Patch(facecolor=colour, edgecolor=BLACK, linewidth=0.5, label=in_words(name))
               for name, colour in flags.items()]  # fmt: skip
    zero = Line2D([], [], color=BLACK, linewidth=1.4, label="tendency 0")
    made.legend(handles=[*handles, zero], loc="outside lower center", ncols=len(handles) + 1, frameon=False,
                fontsize="small")  # fmt: skip


def _judged(ds: xr.Dataset) -> xr.Dataset:
    """`ds` with `decided` (regime known, tendency defined) and `predicted` (its sign tells the regime)."""
    decided = ~ds["regime"].isin(_RULED_OUT) & np.isfinite(ds["tendency"])
    right = (ds["tendency"] > 0) == (ds["regime"] == STICK_SLIP)
    return ds.assign(
        decided=decided.astype(np.int8).assign_attrs(units="1", long_name="regime known and tendency defined"),
        predicted=(right & decided).astype(np.int8).assign_attrs(units="1", long_name="sign of tendency tells regime"),
    )


def _shares(ds: xr.Dataset) -> Findings:
    """Share of decided cells predicted, of stick-slip missed among stick-slip, of false alarms among the others.

    `oscillates` counts sustained vibration without sticking as stick-slip. `below_min` and `past_min` are the cells
    whose slip stays below the minimum of the curve and those whose slip goes through its rising branch.
    """
    regime, alarm = ds["regime"].values, ds["tendency"].values > 0
    decided, sticks, right = ds["decided"].values == 1, regime == STICK_SLIP, ds["predicted"].values == 1
    oscillates = sticks | (regime == REGIMES.index("sustained"))
    past = ds["slip_speed_max"].values > _V_REVERSAL
    false = alarm & decided & ~sticks
    shares = {
        "share_predicted": right[decided],
        "share_stick_slip": sticks[decided],
        "share_missed": (~alarm)[decided & sticks],
        "share_false_alarm": alarm[decided & ~sticks],
        "share_predicted_oscillates": (alarm == oscillates)[decided],
        "share_predicted_below_min": right[decided & ~past],
        "share_predicted_past_min": right[decided & past],
        "share_of_false_alarms_past_min": past[false],
    }
    found: Findings = {"cells": float(decided.size), "undecided": float((~decided).sum())}
    return found | {name: float(part.mean()) if part.size else float("nan") for name, part in shares.items()}


# --- a wide range -----------------------------------------------------------------------------------------------------


def figure_box() -> Made:
    """Share predicted over a wide range, and the tendency at the true border, by belt speed and stiffness."""
    config = configuration("eq3_box")
    ds = _judged(run(config))
    inner = [dim for dim in ds["regime"].dims if dim not in ("belt_speed", "stiffness")]
    share = (ds["predicted"].sum(inner) / ds["decided"].sum(inner)).assign_attrs(
        units="1", long_name="share of cells whose regime the sign of the tendency tells"
    )
    speeds, stiffness = ds["belt_speed"].values, ds["stiffness"].values
    true = border_tendency(speeds, stiffness)

    made = blank_plot(11.0, 3.9, "Eq. (3) over a wide range of parameters, by belt speed and stiffness")
    ((left, right),) = axes_of(made, 1, 2)
    _table(left, 100 * share.values, "{:.0f}", "viridis", (50.0, 100.0), "share of cells with the right sign (%)", made)
    _table(right, true, "{:+.2f}", "RdBu_r", (-0.9, 0.9), "tendency where stick-slip begins / drop", made)
    for ax in (left, right):
        tick_values(ax, stiffness, speeds)
        name_axes(ax, "stiffness (N/m), mass 1 kg", "belt speed (m/s)")
        ax.tick_params(axis="x", labelsize="small")
    right.set_ylabel("")
    findings = _shares(ds) | _summary(share, true, speeds, stiffness)
    true_attrs = {"units": "1", "long_name": "tendency at the true border over mu_start - mu_reversal"}
    data = ds.assign(share_predicted=share, border_tendency=(("belt_speed", "stiffness"), true, true_attrs))
    return Made(made, labelled(data, "Eq. (3) over a wide range of parameters", ["eq3_box"], findings), findings)


def _summary(share: xr.DataArray, true: Floats, speeds: Floats, stiffness: Floats) -> Findings:
    """The best and the worst combination, the extremes of the true border, and the exact case."""
    worst, best = (np.unravel_index(int(pick(share.values)), share.shape) for pick in (np.argmin, np.argmax))
    low, high = (np.unravel_index(int(pick(true)), true.shape) for pick in (np.argmin, np.argmax))
    found: Findings = {}
    for name, place, table in (
        ("worst_share", worst, share.values), ("best_share", best, share.values),
        ("border_lowest", low, true), ("border_highest", high, true),
    ):  # fmt: skip
        found |= {name: float(table[place]), f"{name}_belt_speed": float(speeds[place[0]]),
                  f"{name}_stiffness": float(stiffness[place[1]])}  # fmt: skip
    for speed, row in zip(speeds, true, strict=True):
        found |= {f"border_v{speed:g}_k{k:g}": float(value) for k, value in zip(stiffness, row, strict=True)}
    return found | {f"mirror_error_a4_{a4:g}": mirror_error(a4) for a4 in (1.0, 10.0)}


def border_tendency(speeds: Floats, stiffness: Floats) -> Floats:
    """Tendency over drop (mu_start - mu_reversal as it occurred) where stick-slip begins as mu_stop rises.

    The curve is that of Figure 2, m = N = 1. Returns (speeds, stiffness); Eq. (3) expects 0.
    """
    p = cell(configuration("fig8"))
    v, k = (table.ravel() for table in np.meshgrid(speeds, stiffness, indexing="ij"))
    some = {name: value for name, value in p.items() if name != "mu_stop"} | {"belt_speed": v, "stiffness": k}
    return _tendency_at_border(some, mu_start=p["a1"] + p["a3"]).reshape(len(speeds), len(stiffness))


def _tendency_at_border(some: dict[str, Floats | float], mu_start: float, rtol: float = 1e-7) -> Floats:
    stop = stick_slip_border(some, "mu_stop", (0.2 * mu_start, mu_start), rtol=rtol, tolerance=1e-8)
    occurred = evaluate({**some, "mu_stop": stop}, rtol=rtol)["mu_reversal"].values
    return np.asarray(tendency(mu_start, occurred, stop) / (mu_start - occurred), np.float64)


def mirror_error(a4: float, slope: float = 0.5) -> float:
    """The same for a curve that falls almost straight, S(w) = slope a4 exp(-w/a4), so that the line mirrors it.

    What remains goes with 1/a4, the curvature: for mirror images Eq. (3) is exact (belt 0.05 m/s, m = k = N = 1).
    """
    curve = {"a1": 0.0, "a2": 0.0, "a3": slope * a4, "a4": a4}
    some = {**cell(configuration("fig8")), **curve, "belt_speed": 0.05}
    del some["mu_stop"]
    start = float(friction(0.0, curve))
    return float(_tendency_at_border(dict(some), start, 1e-9)[0])


def _table(
    ax: Axes, values: Floats, form: str, colours: str, bounds: tuple[float, float], words: str, made: Plot
) -> None:
    """A table of numbers on colours."""
    image = ax.imshow(values, cmap=colours, vmin=bounds[0], vmax=bounds[1], aspect="auto", origin="lower")
    red, green, blue, _ = np.moveaxis(image.to_rgba(values), -1, 0)
    write_table(ax, np.round(values, 2) + 0.0, form, 0.299 * red + 0.587 * green + 0.114 * blue < 0.5)
    ax.set_title(words, fontsize="medium")
    made.colorbar(image, ax=ax, pad=0.02)
