"""One step of slip by the Runge-Kutta pair in every lane: for any law, smooth or not.

Loops over the lanes of one flat buffer, as in `lanes.py`; a loop a stage, rather than one long loop: a single chain of
six exponentials is too long for the processor to overlap two of them (measured on Zen 3: 50 ns a lane and step against
13).
"""

from .bits import select
from .friction import coefficient_slope
from .dense import conservative_work, load_and_speed, subtract_damper_work
from .equations import jerk_in_lane, slope_in_lane
from .jit import compiled
from .laws import inflection
from .layout import (
    A4, ALPHA, B, DELTA, DW, DW_NEW, ERROR_LOG, ERROR_LOG_NEXT, ERROR_W, ERROR_Y, FLOOR, GAMMA, GOOD, HIDES, JERK,
    JERK_NEW, K_2, K_3, K_4, K_5, K_6, SERIES, STEP, TAKEN, TAU, TAU_END, W, WIDTH, WORK, W_2, W_3, W_4, W_5, W_6,
    W_NEW, Y, Y_NEW, Y_STAR,
)  # fmt: skip
from .rk import (
    C2, C3, C4, C5, C6, embedded_errors, squared_error, stage_2, stage_3, stage_4,
    stage_5, stage_6, stage_7, step_factor,
)  # fmt: skip
from .steep import may_hide

MOST_TRIES = 30
FLAT = 1e-6  # of the step: an extreme value is known when its time is to this


@compiled
def try_step(law, s, rtol):
    """A step of the size STEP in every lane; nothing is committed."""
    try_stages(law, s)
    control_step(law, s, rtol)
    interpolate(s)


@compiled(inline=True)
def mean_belt(s, i, t):
    """The mean of the belt speed over the next time t, in lane i."""
    return s[B + i] + 0.5 * t * s[ALPHA + i]


@compiled
def try_stages(law, s):
    """The stages of one step, a loop each; `s` is the buffer of lanes."""
    for i in range(WIDTH):
        h = min(s[STEP + i], s[TAU_END + i] - s[TAU + i])
        y2, w2 = stage_2(h, s[Y + i], mean_belt(s, i, C2 * h), s[W + i], s[DW + i])
        k2 = slope_in_lane(law, s, i, y2, w2)
        s[TAKEN + i], s[W_2 + i], s[K_2 + i] = h, w2, k2
    for i in range(WIDTH):
        b = mean_belt(s, i, C3 * s[TAKEN + i])
        y3, w3 = stage_3(s[TAKEN + i], s[Y + i], b, s[W + i], s[W_2 + i], s[DW + i], s[K_2 + i])
        k3 = slope_in_lane(law, s, i, y3, w3)
        s[W_3 + i], s[K_3 + i] = w3, k3
    for i in range(WIDTH):
        b = mean_belt(s, i, C4 * s[TAKEN + i])
        y4, w4 = stage_4(
            s[TAKEN + i],
            s[Y + i],
            b,
            s[W + i],
            s[W_2 + i],
            s[W_3 + i],
            s[DW + i],
            s[K_2 + i],
            s[K_3 + i],
        )
        k4 = slope_in_lane(law, s, i, y4, w4)
        s[W_4 + i], s[K_4 + i] = w4, k4
    for i in range(WIDTH):
        b = mean_belt(s, i, C5 * s[TAKEN + i])
        y5, w5 = stage_5(
            s[TAKEN + i], s[Y + i], b,
            s[W + i], s[W_2 + i], s[W_3 + i], s[W_4 + i],
            s[DW + i], s[K_2 + i], s[K_3 + i], s[K_4 + i],
        )  # fmt: skip
        k5 = slope_in_lane(law, s, i, y5, w5)
        s[W_5 + i], s[K_5 + i] = w5, k5
    for i in range(WIDTH):
        b = mean_belt(s, i, C6 * s[TAKEN + i])
        y6, w6 = stage_6(
            s[TAKEN + i], s[Y + i], b,
            s[W + i], s[W_2 + i], s[W_3 + i], s[W_4 + i], s[W_5 + i],
            s[DW + i], s[K_2 + i], s[K_3 + i], s[K_4 + i], s[K_5 + i],
        )  # fmt: skip
        k6 = slope_in_lane(law, s, i, y6, w6)
        s[W_6 + i], s[K_6 + i] = w6, k6
    for i in range(WIDTH):
        y7, w7 = stage_7(
            s[TAKEN + i], s[Y + i], mean_belt(s, i, s[TAKEN + i]),
            s[W + i], s[W_2 + i], s[W_3 + i], s[W_4 + i], s[W_5 + i], s[W_6 + i],
            s[DW + i], s[K_2 + i], s[K_3 + i], s[K_4 + i], s[K_5 + i], s[K_6 + i],
        )  # fmt: skip
        s[Y_NEW + i], s[W_NEW + i], s[DW_NEW + i] = y7, w7, slope_in_lane(law, s, i, y7, w7)


@compiled
def control_step(law, s, rtol):
    """Error norm, verdict and size of the next step.

    Errors are measured against the amplitude about steady sliding, so that a decaying oscillation keeps its relative
    accuracy; the slip speed also against itself and its derivative, since at break-away, where it grows from zero, its
    relative error is what delays the slip.
    """
    for i in range(WIDTH):
        s[ERROR_Y + i], s[ERROR_W + i] = embedded_errors(
            s[TAKEN + i],
            s[W + i], s[W_2 + i], s[W_3 + i], s[W_4 + i], s[W_5 + i], s[W_6 + i], s[W_NEW + i],
            s[DW + i], s[K_2 + i], s[K_3 + i], s[K_4 + i], s[K_5 + i], s[K_6 + i], s[DW_NEW + i],
        )  # fmt: skip
        b = s[B + i] + s[TAKEN + i] * s[ALPHA + i]
        s[JERK_NEW + i] = jerk_in_lane(law, s, i, s[Y_NEW + i], s[W_NEW + i], s[DW_NEW + i], b)
    for i in range(WIDTH):
        floor = s[FLOOR + i]
        amplitude = max(abs(s[Y + i] - s[Y_STAR + i]), abs(s[W + i] - s[B + i])) + 1e-3 * floor
        scale_w = min(amplitude, abs(s[W_NEW + i]) + abs(s[DW_NEW + i]) + floor)
        error2 = squared_error(s[ERROR_Y + i], s[ERROR_W + i], rtol * amplitude, rtol * scale_w)
        factor, error_log = step_factor(error2, s[ERROR_LOG + i])
        # A step that ends far below w = 0 has crossed the zone at once, and the error estimate may not know.
        hides = may_hide(s, i, s[TAKEN + i], s[W_NEW + i], s[DW_NEW + i]) | (s[W_NEW + i] < -s[HIDES + i])
        good = (error2 <= 1.0) & (not hides)
        s[GOOD + i] = select(good, 1.0, 0.0)
        s[STEP + i] = select(hides, min(0.5, factor) * s[TAKEN + i], factor * s[STEP + i])
        s[ERROR_LOG_NEXT + i] = select(good, error_log, s[ERROR_LOG + i])


@compiled
def interpolate(s):
    """The quintic Hermite polynomial over the step of every lane, as rows SERIES, and the friction work from it.

    It meets w, w' and w'' at both ends; inside, its error is a hundredth of what the step itself allows: h^6 w^(6)
    (theta (1 - theta))^3 / 6!.
    """
    for i in range(WIDTH):
        h, w, dw, jerk = s[TAKEN + i], s[W + i], s[DW + i], s[JERK + i]
        rise = s[W_NEW + i] - w - h * (dw + 0.5 * h * jerk)
        slope = h * (s[DW_NEW + i] - dw - h * jerk)
        bend = h * h * (s[JERK_NEW + i] - jerk)
        third = 10.0 * rise - 4.0 * slope + 0.5 * bend
        fourth = -15.0 * rise + 7.0 * slope - bend
        fifth = 6.0 * rise - 3.0 * slope + 0.5 * bend
        s[SERIES + i], s[SERIES + WIDTH + i], s[SERIES + 2 * WIDTH + i] = w, dw, 0.5 * jerk
        per_h3 = 1.0 / (h * h * h)
        s[SERIES + 3 * WIDTH + i] = third * per_h3
        s[SERIES + 4 * WIDTH + i] = fourth * per_h3 / h
        s[SERIES + 5 * WIDTH + i] = fifth * per_h3 / (h * h)
        fallen = h * h * (0.5 * w + h * (dw / 6.0 + h * jerk / 24.0) + third / 20.0 + fourth / 30.0 + fifth / 42.0)
        s[WORK + i] = conservative_work(s, i, h, s[Y_NEW + i] - s[Y + i], s[W_NEW + i], fallen)
    subtract_damper_work(s)


@compiled
def extreme_slope(law, s, i, h, jerk1):
    """w' where w'' of lane i vanishes within h, w'' being jerk1 at the end.

    The derivatives of a Hermite polynomial are less exact than the polynomial, so w' and w'' are those of the equation
    of motion along it. By the Illinois method.
    """
    low, high, f_low, f_high, slope = 0.0, h, s[JERK + i], jerk1, s[DW + i]
    for _ in range(MOST_TRIES):
        t = (low * f_high - high * f_low) / (f_high - f_low)
        y, w = load_and_speed(s, i, t)
        slope = slope_in_lane(law, s, i, y, w)
        f = jerk_in_lane(law, s, i, y, w, slope, s[B + i] + t * s[ALPHA + i])
        moved = abs(t - high)
        if f * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = t, f
        if moved <= FLAT * h or f == 0.0:
            break
    return slope


@compiled
def restart(s, i, h):
    """Let the next step of lane i be of size h, without a memory of errors."""
    s[STEP + i], s[ERROR_LOG + i] = h, 0.0


@compiled
def begin_stepping(law, s, i, cells, c):
    """Size of the first step of a slip, where the speed may grow as fast as the curve falls, or be thrown across it."""
    steepest = cells[A4, c] * inflection(law, cells[DELTA, c])
    growth = abs(coefficient_slope(law, cells, c, steepest)) + cells[GAMMA, c]
    restart(s, i, min(0.05 / (1.0 + growth), s[HIDES + i] / abs(s[DW + i])))
