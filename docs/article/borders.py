"""What becomes of "stick-slip occurs solely in the declining branch": exact borders, and what depends on the start."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from article.recipe import STICK_SLIP, Findings, Floats, Made, cell, configuration, labelled
from stickslip.api.runs import run
from stickslip.config.model import Config
from stickslip.plots import plot_attractors, plot_map
from stickslip.plots.layout import Figure as Plot
from stickslip.plots.palette import BLACK
from stickslip.theory import loss_of_stability, reversal_speed, stick_slip_limit

_SOFT, _STIFF = 0.001, 1000.0  # N/m, what the sentences name


def figure_borders() -> Made:
    """The map over stiffness and belt speed, its exact borders, and the band in which steady sliding is stable too."""
    config = configuration("borders")
    lines, cells = run(config), run(config.model_copy(update={"study": None}))
    stiffness, ends = lines["stiffness"].values, end_of_stick_slip(lines)
    declining, stable_from = _speeds(config)
    made = plot_map(cells, lines=lines, title="Where stick-slip ends, started from sticking")
    _shade_band(made, made.axes[0], stiffness, stable_from, ends)

    one = cell(config)
    curve = [one[name] for name in ("a2", "a3", "a4", "damping", "normal_load")]
    soft, stiff = (int(np.argmin(np.abs(stiffness - k))) for k in (_SOFT, _STIFF))
    findings: Findings = {
        "lines": float(ends.size), "v_min": declining,
        "stiffness_soft": float(stiffness[soft]), "end_soft": float(ends[soft]),
        "end_soft_over_v_min": float(ends[soft] / declining),
        "stiffness_stiff": float(stiffness[stiff]), "end_stiff": float(ends[stiff]),
        "end_stiff_over_v_min": float(ends[stiff] / declining), "limit": float(stick_slip_limit(*curve)),
        "width": float(np.nanmax(lines["border_width"].values[:, 0] / ends)),
    }  # fmt: skip
    return Made(made, labelled(lines, "Exact borders on the plain curve", ["borders"], findings), findings)


def end_of_stick_slip(lines: xr.Dataset) -> Floats:
    """Where stick-slip ends on each line. Raises ValueError unless it ends once."""
    ends = lines["regime_below"].values == STICK_SLIP
    if (ends.sum(axis=1) != 1).any():
        raise ValueError("expected one end of stick-slip on every line")
    return np.asarray(lines["border"].values[ends], np.float64)


def _speeds(config: Config) -> tuple[float, float]:
    """The minimum of the curve, and the belt speed from which steady sliding is stable; without damper they agree."""
    p = cell(config)
    stable = loss_of_stability(p["a2"], p["a3"], p["a4"], p["damping"], p["normal_load"])
    return float(reversal_speed(p["a2"], p["a3"], p["a4"])), float(stable)


def _shade_band(made: Plot, ax: Axes, stiffness: Floats, low: float, high: Floats) -> None:
    """Hatch the cells in which stick-slip and steady sliding coexist."""
    ax.fill_betweenx(stiffness, low, np.maximum(high, low), facecolor="none", edgecolor=BLACK, hatch="///", linewidth=0)
    shown = made.legends[0]
    handles: list[Any] = [one for one in shown.legend_handles if one is not None]
    for handle, text in zip(handles, shown.get_texts(), strict=True):
        handle.set_label(text.get_text())
    shown.remove()
    band = Patch(facecolor="none", edgecolor=BLACK, hatch="///", linewidth=0, label="steady sliding is stable too")
    made.legend(handles=[*handles, band], loc="outside right upper", frameon=False, fontsize="small")


def figure_basins() -> Made:
    """The share of starting states that settle, and the critical shock, over the belt speed."""
    config = configuration("basins")
    ds = run(config)
    made = plot_attractors(ds, title="Which starting states settle, and which shock ends steady sliding")
    speed, share = ds["belt_speed"].values, ds["settling_share"].values
    stable_from = _speeds(config)[1]
    both = (share > 0) & np.isfinite(ds["critical_shock"].values)
    last = int(np.flatnonzero(both)[-1])
    at = int(np.argmin(np.abs(speed - 0.5)))
    findings: Findings = {
        "stable_from": stable_from, "both_from": float(speed[both][0]), "both_to": float(speed[last]),
        "belt_speed": float(speed[at]), "share": float(share[at]), "shock": float(ds["critical_shock"][at]),
        "unstable_amplitude": float(ds["unstable_velocity_amplitude"][at]), "share_last": float(share[last]),
        "shock_last": float(ds["critical_shock"][last]),
    }  # fmt: skip
    return Made(made, labelled(ds, "Attractors on the plain curve", ["basins"], findings), findings)
