"""Bristles by linearly implicit steps (`implicit.py`): on any law, stiff ones, elasto-plastic ones, fading damping."""

from math import factorial, pi
from typing import NamedTuple

from .. import layout as at
from ..dense import work_by_ends
from ..exponential import exp
from ..intrinsics import select, widest_vectors
from ..jit import compiled
from .bristle_series import LEVEL_OF_CURVE, LOAD_SCALE, S_0, S_1, SIGN, SPEED_SCALE
from .implicit import end_of_step, errors, factorise, rates, slopes, stages, step_factor
from .stribeck import laws


class LuGre(NamedTuple):
    """Tag of contacts of bristles."""

    code: int


# rows of a lane, beside those of `bristle_series.py`: how fast s_1 falls; the elastic part
S_1_RATE, ELASTIC = at.W_6, at.K_2
SPENT = 0.3  # of the tolerance that one step may spend
HELD = 30.0  # periods of bristles in a step from which on the slip follows the load
NOTHING = 1e-300
CURVED = 4.0  # slip speeds by which w may curve in a step; more is what errors of the load do to stiff bristles
FLOOR = 1e-3  # of the speed scale
SLIDING = 0.1  # by how much bristles that slide may be off the deflection at which they do
SINE = tuple((-1.0) ** n / factorial(2 * n + 1) for n in range(8))  # coefficients of sin(x)/x


# --- the equations ----------------------------------------------------------------------------------------------------


@compiled(inline=True)
def yielding(elastic, q):
    """alpha(q) q and its derivative. elastic : 0 for LuGre."""
    ramp = min(max((q - elastic) / (1.0 - elastic), 0.0), 1.0)
    x = pi * (ramp - 0.5)
    x2 = x * x
    sine, cosine = SINE[7], 15.0 * SINE[7]
    for n in range(6, -1, -1):
        sine, cosine = sine * x2 + SINE[n], cosine * x2 + (2 * n + 1) * SINE[n]
    alpha, slope = 0.5 + 0.5 * x * sine, 0.5 * pi * cosine / (1.0 - elastic)
    plain = elastic == 0.0
    slope = select((ramp > 0.0) & (ramp < 1.0), slope, 0.0)
    return select(plain, q, alpha * q), select(plain, 1.0, alpha + q * slope)


@compiled(inline=True)
def bristles(law, s, i, w, f):
    """z' and its derivatives by w and by f; s_1 and its derivative by w; g and its slope."""
    sign, rate, drop, delta = s[SIGN + i], s[at.RATE + i], s[at.DROP + i], s[at.EXPONENT + i]
    over = max(rate * w, 0.0)
    weakening = drop * laws.shape(law, over, delta)
    g = s[LEVEL_OF_CURVE + i] + weakening
    per_g = 1.0 / g
    g_slope = laws.weakening_slope(law, over, weakening, drop, delta) * rate * sign
    q = sign * f * per_g
    yields, yields_slope = yielding(s[ELASTIC + i], q)
    fade = s[S_1_RATE + i] * w
    s_1 = s[S_1 + i] * exp(-fade * fade)
    by_w = 1.0 - yields + sign * w * yields_slope * q * g_slope * per_g
    s_1_slope = -2.0 * fade * s[S_1_RATE + i] * s_1
    return w * (1.0 - yields), by_w, -sign * w * yields_slope * per_g, s_1, s_1_slope, g, g_slope


@rates.of(LuGre)
def _rates(kind, s, i, y, w, f):
    give, _, _, s_1, _, _, _ = bristles(kind[1], s, i, w, f)
    return w, y - (s[at.G + i] + s[at.SLOPE + i]) * w - f - s_1 * give, s[S_0 + i] * give


@slopes.of(LuGre)
def _slopes(kind, s, i, y, w, f):
    give, by_w, by_f, s_1, s_1_slope, _, _ = bristles(kind[1], s, i, w, f)
    damping = s[at.G + i] + s[at.SLOPE + i] + s_1 * by_w + s_1_slope * give
    return 1.0, 1.0, -damping, -1.0 - s_1 * by_f, s[S_0 + i] * by_w, s[S_0 + i] * by_f


@compiled(inline=True)
def derivatives(law, s, i, t, h, y, w, f):
    """w' and w'' at t after the start of a step of length h.

    Where bristles hold w back, w' is the small difference of large forces, and what the step leaves of an error in them
    would be all of it. There slip follows the load, f' = y', so that w = B/(1 + s_0 (1 - q)). Where they follow the
    slip at once, f is g, and the same holds of w''.
    """
    sign, s_0, drag = s[SIGN + i], s[S_0 + i], s[at.G + i] + s[at.SLOPE + i]
    give, by_w, by_f, s_1, s_1_slope, g, g_slope = bristles(law, s, i, w, f)
    damping, firm, drive = drag + s_1 * by_w + s_1_slope * give, s_0 * by_w, s[at.B + i] + t * s[at.ALPHA + i]
    follows = abs(w * (1.0 + firm) - drive) < 0.5 * abs(drive) + FLOOR * s[SPEED_SCALE + i]
    held = follows & (h * h * firm > HELD * HELD) & (h * firm > HELD * abs(damping))
    dw = y - drag * w - f - s_1 * give
    bend = drive - w - damping * dw - (1.0 + s_1 * by_f) * s_0 * give
    slow = (s[at.ALPHA + i] - s_0 * by_f * s_0 * give) / (1.0 + firm)
    rate = s_0 * abs(w) / g
    slides = (rate * h > HELD) & (abs(1.0 - sign * f / g) < SLIDING)
    sliding = (y - drag * w - sign * g) / (1.0 + g_slope * (s_1 / s_0 - 1.0 / rate))
    dw = select(held, slow, select(slides, sliding, dw))
    bend = select(slides, drive - w - (drag + g_slope) * dw, bend)
    return dw, select(held, 2.0 * slow * slow * w / (w * w + NOTHING), bend)


# --- a step -----------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def try_step(law, s, rtol):
    """A step of the size STEP in every lane; nothing is committed."""
    kind = (LuGre(0), law)
    factorise(kind, s)
    stages(kind, s)
    control_step(law, s, rtol)


@compiled
def control_step(law, s, rtol):
    """End of the step, its error, and the size of the next."""
    widest_vectors()
    tolerance2 = 1.0 / (SPENT * rtol) ** 2
    for i in range(at.WIDTH):
        (y, w, f), (e_y, e_w, e_f) = end_of_step(s, i), errors(s, i)
        per_load, per_speed = 1.0 / s[LOAD_SCALE + i], 1.0 / max(abs(w), s[SPEED_SCALE + i])
        e_y, e_w, e_f = e_y * per_load, e_w * per_speed, e_f * per_load
        error2 = (e_y * e_y + e_w * e_w + e_f * e_f) * tolerance2
        h = s[at.TAKEN + i]
        s[at.Y_NEW + i], s[at.W_NEW + i], s[at.WEAK_NEW + i] = y, w, f
        s[at.DW_NEW + i], s[at.JERK_NEW + i] = derivatives(law, s, i, h, h, y, w, f)
        most = CURVED / (h * h * per_speed)
        s[at.JERK + i] = min(max(s[at.JERK + i], -most), most)
        s[at.JERK_NEW + i] = min(max(s[at.JERK_NEW + i], -most), most)
        leaps = leaps_over_breakaway(s, i, h, f) | passes_friction(law, s, i, h)
        s[at.GOOD + i] = select((error2 <= 1.0) & (not leaps), 1.0, 0.0)
        s[at.STEP + i] = select(leaps, 0.5, step_factor(error2)) * s[at.STEP + i]
        s[at.WORK + i] = work_by_ends(s, i, h)


@compiled(inline=True)
def leaps_over_breakaway(s, i, h, f):
    """Return whether a long step brings bristles that hold the slip back closer to giving way than half way.

    Beyond, equations with the sign of w held on to have a motion backwards under any load, and nothing in a step that
    ends there tells.
    """
    sign, per_g = s[SIGN + i], 1.0 / (s[LEVEL_OF_CURVE + i] + s[at.DROP + i])
    room = 1.0 - sign * s[at.WEAK + i] * per_g
    return (h * h * s[S_0 + i] * room > HELD * HELD) & (sign * (f - s[at.WEAK + i]) * per_g > 0.5 * room)


@compiled(inline=True)
def passes_friction(law, s, i, h):
    """Return whether a step may have passed over friction unseen."""
    rate = s[at.RATE + i]
    z, z_end, rise = rate * s[at.W + i], rate * s[at.W_NEW + i], h * rate
    return laws.passes_unseen(law, z, z_end, rise * s[at.DW + i], rise * s[at.DW_NEW + i])
