"""Beyond the article, its last sentence: friction while the specimen speeds up and slows down, over the rigidity of a
rig, by records of a simulated one; and Eq. (3) over random pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from article.recipe import STICK_SLIP, Findings, Floats, Made, labelled
from stickslip.api.cells import evaluate
from stickslip.api.studies import border
from stickslip.config.resolve import config_path
from stickslip.plots.layout import Figure, entitle, legend
from stickslip.plots.palette import BLACK, BLUE, SKY, VERMILLION
from stickslip.theory import reversal_speed, stribeck
from stickslip.vocabulary.models.stribeck import coefficients
from stickslip.vocabulary.quantities import REGIMES

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

_CONFIG = "rig/stiffness"
_OF_A_CELL = ("mass", "damping", "normal_load", "belt_speed", "a1", "a2", "a3", "a4", "mu_stop")
_DRAWN, _PAIRS, _SEED = 13_000, 10_000, 1
_DECIDED = ("stick_slip", "damped", "creep", "sustained")
_DAMPED = 0.05  # damping ratio
_DENSE, _ROOM = 120, 1.5  # places along the stiffness, and the factor by which they reach beyond the springs
_MOST_NAMED = 8  # springs
_ALIKE = ("mass", "damping", "normal_load", "drive_speed")  # conditions that records over springs share


def figure_springs() -> Made:
    """The tendency over the stiffness, measured on records and by the curve."""
    from stickslip import rig  # an extension, which other figures do without

    config = rig.load_rig(config_path(_CONFIG))
    tests = rig.RigTests(config)
    records = {test.name: test.record for test in tests.tests(range(tests.grid.size)) if test.record is not None}
    ds = rig.friction_table(records)
    cells = {name: float(values[0]) for name, values in tests.grid[:].items() if name != "stiffness"}
    known = {name: value for name, value in cells.items() if name in _OF_A_CELL}
    ends = border(known, "stiffness", (1e3, 1e6))["border"].values.ravel()
    theory = evaluate({**known, "stiffness": ds["stiffness"].values})
    curve = [cells[name] for name in ("a1", "a2", "a3", "a4")]
    expected = curve[0] + curve[2] - 2.0 * stribeck(theory["slip_speed_max"].values, *curve) + cells["mu_stop"]
    visible = np.isfinite(ds["tendency"].values)
    findings: Findings = {
        "springs": float(visible.size), "told": float(visible.sum()), "end": float(ends[-1]) / 1e3,
        "softest": float(ds["tendency"].values[visible][0]), "stiffest": float(ds["tendency"].values[visible][-1]),
        "error": float(np.abs(ds["tendency"].values - expected)[visible].max()),
        "half": float((ds["tendency_high"] - ds["tendency"]).values[visible].max()),
    }  # fmt: skip
    findings |= _random_pairs()
    return Made(_plot(ds), labelled(ds, "Springs from soft to stiff", [], findings), findings)


def _plot(ds: xr.Dataset) -> Figure:
    """The tendency, Eq. (3) of the article, over the stiffness: as measured, and as the curve of all records has it."""
    stiffness, tendency = ds["stiffness"].values / 1e3, ds["tendency"].values
    seen = np.isfinite(tendency)
    figure = Figure(figsize=(6.3, 3.54), layout="constrained")
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
    from stickslip_materials.fit import fit_curve

    given = {name: np.unique(ds[name].values) for name in _ALIKE}
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


def _random_pairs() -> Findings:
    """How often the sign of Eq. (3) tells the regime of random pairs on random rigs, and where it does not."""
    cells = _drawn()
    curve = [cells[name] for name in ("a1", "a2", "a3", "a4")]
    ds = evaluate(cells)
    known = np.isfinite(ds["tendency"].values) & ds["regime"].isin([REGIMES.index(name) for name in _DECIDED]).values
    chosen = np.flatnonzero(known)[:_PAIRS]
    place = stribeck(cells["belt_speed"], *curve) * cells["normal_load"] / cells["stiffness"]  # of steady sliding
    slid = evaluate({**cells, "displacement": 0.999 * place, "velocity": 0.0})["regime"].values[chosen] != STICK_SLIP
    alarm, sticks = ds["tendency"].values[chosen] > 0.0, ds["regime"].values[chosen] == STICK_SLIP
    past = (ds["slip_speed_max"].values > reversal_speed(*curve[1:]))[chosen]
    ratio = (cells["damping"] / (2.0 * np.sqrt(cells["mass"] * cells["stiffness"])))[chosen]
    right, bare, damped = alarm == sticks, ratio == 0.0, ratio > _DAMPED
    shares = {
        "right": right, "missed": (~alarm)[sticks], "false": alarm[~sticks], "past_of_false": past[alarm & ~sticks],
        "right_below_bare": right[~past & bare], "right_below_damped": right[~past & damped],
        "right_past": right[past], "coexist": slid[sticks],
    }  # fmt: skip
    return {"pairs": float(chosen.size)} | {name: float(part.mean()) for name, part in shares.items()}


def _drawn() -> dict[str, Floats]:
    """Cells over decades, half of them without a damper, with curves that a1 >= 0 allows."""
    random = np.random.default_rng(_SEED)

    def over(low: float, high: float) -> Floats:
        return np.asarray(low * (high / low) ** random.random(_DRAWN))

    cells = {"mass": over(0.01, 1.0), "stiffness": over(1e2, 1e6), "normal_load": over(1.0, 100.0),
             "belt_speed": over(1e-3, 0.5), "a4": over(1e-3, 0.1)}  # fmt: skip
    start, share, where = over(0.1, 1.0), random.uniform(0.4, 0.9, _DRAWN), random.uniform(3.0, 8.0, _DRAWN)
    curve = coefficients(start, share * start, where * cells["a4"], cells["a4"])
    stop = start * (share + (1.0 - share) * random.uniform(-1.5, 1.0, _DRAWN))
    ratio = np.where(random.random(_DRAWN) < 0.5, 0.0, over(1e-3, 0.3))
    cells |= dict(zip(("a1", "a2", "a3"), curve, strict=True), mu_stop=np.maximum(stop, 0.0))
    cells["damping"] = 2.0 * ratio * np.sqrt(cells["mass"] * cells["stiffness"])
    return {name: values[cells["a1"] >= 0.0] for name, values in cells.items()}
