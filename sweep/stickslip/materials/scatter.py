"""What the scatter of the measured points leaves open: borders of drawn curves, intervals, and what to measure next."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stickslip.borders import Scan
from stickslip.engine import Options
from stickslip.fit import CurveFit, Drawn, draw_curves
from stickslip.fit.design import best_measurements
from stickslip.fit.uncertainty import student
from stickslip.materials.quiet import UNRESOLVED, VIBRATES, Quiet, quiet_above
from stickslip.materials.system import Question
from stickslip.study import Moved

Floats = NDArray[np.float64]

_DRAWN_TO = 1e-3  # tolerance of the borders of drawn curves, which scatter by far more
_DRAWN_STEPS = 20_000  # of a cell of a drawn curve; without a verdict by then it widens the interval
_TO_TELL = 100  # curves drawn to see whether there are any, where no intervals are asked for
_NEXT = ("next_speed_1", "next_speed_2", "next_low", "next_high")
_MORE = 2  # measurements proposed


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
        chance = np.mean(most[:, None] < speeds, axis=0)
        found["quiet_probability"] = chance if question.several_speeds else chance[0]
    return found | _measurements(curve, drawn, most, ends, border), quiet


def nothing_known(question: Question) -> dict[str, float | Floats]:
    """What is said of a material of which no curves are drawn."""
    if not question.draws:
        return {}
    names = ("quiet_above_low", "quiet_above_high", "better_than_next", "draws_falling", *_NEXT)
    found: dict[str, float | Floats] = {**dict.fromkeys(names, math.nan), "draws_used": 0.0}
    if question.speeds.values:
        speeds = len(question.speeds.values)
        found["quiet_probability"] = np.full(speeds, np.nan) if question.several_speeds else math.nan
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
    return found


def _measurements(
    curve: CurveFit, drawn: Drawn, borders: Floats, ends: tuple[float, float], border: float
) -> dict[str, float]:
    """The two speeds at which more points would narrow the interval most, and about where its ends would be then.

    NaN where nothing can be told; the ends alone where one of the interval is open.
    """
    found = dict.fromkeys(_NEXT, math.nan)
    inside = np.isfinite(borders) & (borders >= ends[0]) & (borders <= ends[1]) & (borders > 0)
    spare = max(curve.points - 4 + len(curve.assumed), 1)
    sigma = curve.residual_rms * math.sqrt(curve.points / spare)
    slowest = curve.speeds[0] or 10.0 * curve.searched[0]
    curves = {name: values[inside] for name, values in drawn.coefficients.items()}
    design = best_measurements(borders[inside], curves, (slowest, curve.speeds[1]), sigma)
    if design is None:
        return found
    found |= dict(zip(_NEXT, design.speeds, strict=False))
    if ends[0] > 0 and math.isfinite(ends[1]):
        surer = student(curve.freedom + _MORE) / student(curve.freedom)
        for name, end in zip(_NEXT[2:], ends, strict=True):
            found[name] = border + (end - border) * design.factor * surer
    return found


def below(one: Quiet, other: Quiet) -> float:
    """Probability that a draw of one is below an independent one of the other; equal ones count half."""
    values, ordered = one.between()[1], np.sort(other.between()[1])
    left, right = (np.searchsorted(ordered, values, side=side) for side in ("left", "right"))
    return float(np.mean(ordered.size - 0.5 * (left + right)) / ordered.size)
