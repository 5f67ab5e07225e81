"""What the scatter of the measured points leaves open: borders of drawn curves, intervals, and what to measure next."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.borders import Scan
from stickslip.engine import Options
from stickslip.fit import CurveFit, Drawn, draw_curves
from stickslip.fit.repeats import RepeatedFit
from stickslip.fit.uncertainty import student
from stickslip.materials.design import best_measurements
from stickslip.materials.quiet import UNRESOLVED, VIBRATES, Quiet, quiet_above
from stickslip.materials.system import Question
from stickslip.study import Moved
from stickslip.theory import stribeck

Floats = NDArray[np.float64]

_DRAWN_TO = 1e-3  # tolerance of the borders of drawn curves, which scatter by far more
_DRAWN_STEPS = 20_000  # of a cell of a drawn curve
_LONGER = 10  # times as many of curves without a verdict by then; what has none then either widens the interval
_TO_TELL = 100  # curves drawn to see whether there are any, where no intervals are asked for
_NEXT = ("next_speed_1", "next_speed_2", "next_low", "next_high")
_CHANCES = ("quiet_probability", "undecided_probability")
_MORE = 2  # measurements proposed
_SLOWER = 0.2  # of the slowest speed measured: where a fall that no point shows would be looked for
_FEWEST = 30  # curves drawn that agree with new points, from which quantiles are known well enough


def drawn_of(curve: CurveFit, question: Question) -> Drawn | None:
    """Curves as likely as the points leave them; None where none can be drawn, or the points follow no such curve."""
    if not curve.has_intervals:
        return None
    return draw_curves(curve, question.draws or _TO_TELL, question.seed, falling=True)


def scatter_of(
    curve: CurveFit, drawn: Drawn | None, question: Question, scan: Scan, border: float, moved: Moved | None = None
) -> tuple[dict[str, float | Floats], Quiet | None]:
    """What the scatter of the points leaves open of a border, and those of the drawn curves; nothing without any."""
    if not question.draws or drawn is None:
        return nothing_known(question), None
    quiet = _borders(drawn, question, scan, moved)
    least, most = quiet.between()
    low, high = np.sort(least), np.sort(most)
    tail = round((1.0 - question.level) / 2.0 * most.size)
    ends = float(low[tail]), float(high[-1 - tail])
    found: dict[str, float | Floats] = {
        "quiet_above_low": ends[0], "quiet_above_high": ends[1],
        "draws_used": float(np.count_nonzero(quiet.state != UNRESOLVED)), "draws_falling": float(drawn.falling.mean()),
    }  # fmt: skip
    speeds = np.array(question.speeds.values)
    if speeds.size:
        chances = np.mean(most[:, None] < speeds, axis=0), np.mean(least[:, None] < speeds, axis=0)
        for name, chance in zip(_CHANCES, (chances[0], chances[1] - chances[0]), strict=True):
            found[name] = chance if question.several_speeds else float(chance[0])
    return found | _measurements(curve, drawn, (least, most), ends, border, tail / most.size), quiet


def nothing_known(question: Question) -> dict[str, float | Floats]:
    """What is said of a material of which no curves are drawn."""
    if not question.draws:
        return {}
    names = ("quiet_above_low", "quiet_above_high", "better_than_next", "draws_falling", *_NEXT)
    found: dict[str, float | Floats] = {**dict.fromkeys(names, math.nan), "draws_used": 0.0}
    if question.speeds.values:
        speeds = len(question.speeds.values)
        found |= dict.fromkeys(_CHANCES, np.full(speeds, np.nan) if question.several_speeds else math.nan)
    return found


def _borders(drawn: Drawn, question: Question, scan: Scan, moved: Moved | None) -> Quiet:
    """The borders of drawn curves.

    A curve that falls for ever faster than the damper grows vibrates at any speed; so does, as far as this can tell,
    one whose friction would be negative within the range.
    """
    options = replace(question.options, rtol=Options.rtol, max_steps=_DRAWN_STEPS)
    tolerance = max(_DRAWN_TO, question.limits.tolerance)
    a1, a2 = drawn.coefficients["a1"], drawn.coefficients["a2"]
    load = question.system["normal_load"] * question.system["friction_scale"]
    held = question.system["damping"] + load * a2 >= 0
    lost = drawn.falling & ~(held & (a1 + a2 * scan.high >= 0))
    found = Quiet(np.full(a2.size, scan.high), np.full(a2.size, scan.high), np.full(a2.size, VIBRATES, np.int8))
    if not lost.all():
        rest = {name: values[~lost] for name, values in drawn.coefficients.items()}
        part = quiet_above(rest, question.system, scan, tolerance, options, moved)
        found.speed[~lost], found.low[~lost], found.state[~lost] = part.speed, part.low, part.state
    if (open_ := found.state == UNRESOLVED).any():
        longer = replace(options, max_steps=_LONGER * _DRAWN_STEPS)
        rest = {name: values[open_] for name, values in drawn.coefficients.items()}
        part = quiet_above(rest, question.system, scan, tolerance, longer)
        found.speed[open_], found.low[open_], found.state[open_] = part.speed, part.low, part.state
    return found


def _measurements(
    curve: CurveFit, drawn: Drawn, borders: tuple[Floats, Floats], ends: tuple[float, float], border: float, tail: float
) -> dict[str, float]:
    """The two speeds, among those measured, at which more points would narrow the interval most, and about where its
    ends would be then; of repeats the ends with another specimen. NaN where nothing can be told.

    borders : of each curve drawn, the least and the most it may be. tail : share of them beyond either end.
    """
    found = dict.fromkeys(_NEXT, math.nan)
    is_closed = ends[0] > 0 and math.isfinite(ends[1])
    if isinstance(curve, RepeatedFit):  # points of the same specimens tell nothing of what differs between specimens
        n = len(curve.repeats)
        factor = student(n) / student(n - 1) * math.sqrt(n / (n + 1))
        return found | (dict(zip(_NEXT[2:], _shrunk(ends, border, factor), strict=True)) if is_closed else {})
    least, most = borders
    inside = np.isfinite(most) & (most >= ends[0]) & (most <= ends[1]) & (most > 0)
    spare = max(curve.points - 4 + len(curve.assumed), 1)
    sigma = curve.residual_rms * math.sqrt(curve.points / spare)
    slowest = (curve.speeds[0] or 10.0 * curve.searched[0]) * (1.0 if curve.a3 > 0 else _SLOWER)
    curves = {name: values[inside] for name, values in drawn.coefficients.items()}
    design = best_measurements(most[inside], curves, (slowest, curve.speeds[1]), sigma)
    if design is None:
        return found
    found |= dict(zip(_NEXT, design.speeds, strict=False))
    if is_closed:
        factor = design.factor * student(curve.freedom + _MORE) / student(curve.freedom)
        return found | dict(zip(_NEXT[2:], _shrunk(ends, border, factor), strict=True))
    if not sigma > 0:
        return found
    speeds = np.array(design.speeds)[:, None]
    off = (stribeck(speeds, *drawn.coefficients.values()) - curve.predict(speeds)) / sigma
    weight = np.exp(-0.5 * np.sum(off**2, axis=0))  # of a curve where the points lie on the fitted one
    if weight.sum() ** 2 > _FEWEST * np.sum(weight**2):
        found |= {"next_low": _quantile(least, weight, tail), "next_high": _quantile(most, weight, 1.0 - tail)}
    return found


def _shrunk(ends: tuple[float, float], border: float, factor: float) -> list[float]:
    """The ends of an interval about a border, when it is so much narrower."""
    return [border + (end - border) * factor for end in ends]


def _quantile(values: Floats, weights: Floats, share: float) -> float:
    """The value below which a share of the weight lies."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][min(np.searchsorted(total, share * total[-1]), values.size - 1)])


def below(one: Quiet, other: Quiet) -> float:
    """Probability that a draw of one is below an independent one of the other; equal ones count half."""
    values, ordered = one.between()[1], np.sort(other.between()[1])
    left, right = (np.searchsorted(ordered, values, side=side) for side in ("left", "right"))
    return float(np.mean(ordered.size - 0.5 * (left + right)) / ordered.size)
