"""The hot loops: one trial step of WIDTH trajectories at once.

Branch-free loops over the lanes of one flat buffer, which LLVM turns into full-width vector code (a test looks at the
assembly). Accepting, rejecting and choosing the next step are part of it. Whatever is rare only raises the lane's FLAG;
the scalar code (`modes.py`) then looks at that lane before the step is committed.

A loop a stage, rather than one long loop: a single chain of six exponentials is too long for the processor to overlap
two of them, and left it waiting (measured on Zen 3: 50 ns a lane and step against 13).
"""

from .bits import select
from .jit import compiled
from .layout import (
    B, BAND2, DROP, DW, DW_NEW, DW_NEXT, DW_TOP, ERROR_LOG, ERROR_LOG_NEXT, ERROR_W, ERROR_Y, EXPONENT, FACTOR,
    FLAG, FLOOR, G, GOOD, HEAT, HEAT_NEXT, JERK, JERK_NEW, JERK_NEXT, K_2, K_3, K_4, K_5, K_6, LEVEL, MARK, OFFSET,
    RADIUS2, RATE, SIDE, SLOPE, STATE_NUMBERS, STEP, TAKEN, TAU, TAU_END, TAU_NEXT, TRIED, TURN, W, WIDTH, WORK,
    W_2, W_3, W_4, W_5, W_6, W_NEW, W_NEXT, W_TOP, Y, Y_NEW, Y_NEXT, Y_STAR,
)  # fmt: skip
from .rk import (
    A71, A72, A73, A74, A75, A76, embedded_errors, friction_power, slip_acceleration, slip_jerk, squared_error,
    stage_2, stage_3, stage_4, stage_5, stage_6, stage_7, step_factor,
)  # fmt: skip

SMALLEST_STEP = 1e-13


@compiled
def step_lanes(law, lanes, rtol, max_steps):
    """Try one step in every lane; commit it where it is good and nothing happened, else leave it as a candidate.

    law : tag of the friction law (`laws`). lanes : float64, LANE_NUMBERS long, changed in place; idle ones compute
        numbers nobody reads.
    rtol : tolerance of a step relative to the amplitude. max_steps : trial steps a cell may take.
    """
    try_step(law, lanes)
    control_step(law, lanes, rtol)
    watch_and_commit(lanes, max_steps)


@compiled(inline=True)
def stage_slope(law, s, i, y, w):
    """w' of lane i at a stage."""
    return slip_acceleration(law, y, w, s[G + i] + s[SLOPE + i], s[DROP + i], s[RATE + i], s[EXPONENT + i])


@compiled(inline=True)
def stage_jerk(law, s, i, y, w, dw):
    """w'' of lane i at a stage with w' = dw."""
    drag = s[G + i] + s[SLOPE + i]
    return slip_jerk(law, y, w, dw, s[B + i], drag, s[DROP + i], s[RATE + i], s[EXPONENT + i])


@compiled(inline=True)
def stage_power(s, i, y, w, k):
    """Friction power of lane i at a stage."""
    return friction_power(y, w, k, s[G + i], s[OFFSET + i])


@compiled
def try_step(law, s):
    """The stages of one step, a loop each; `s` is the buffer of lanes."""
    for i in range(WIDTH):
        h = min(s[STEP + i], s[TAU_END + i] - s[TAU + i])
        y2, w2 = stage_2(h, s[Y + i], s[B + i], s[W + i], s[DW + i])
        k2 = stage_slope(law, s, i, y2, w2)
        s[TAKEN + i], s[W_2 + i], s[K_2 + i] = h, w2, k2
        power = A71 * stage_power(s, i, s[Y + i], s[W + i], s[DW + i])
        s[WORK + i] = power + A72 * stage_power(s, i, y2, w2, k2)
    for i in range(WIDTH):
        y3, w3 = stage_3(s[TAKEN + i], s[Y + i], s[B + i], s[W + i], s[W_2 + i], s[DW + i], s[K_2 + i])
        k3 = stage_slope(law, s, i, y3, w3)
        s[W_3 + i], s[K_3 + i] = w3, k3
        s[WORK + i] += A73 * stage_power(s, i, y3, w3, k3)
    for i in range(WIDTH):
        y4, w4 = stage_4(
            s[TAKEN + i], s[Y + i], s[B + i], s[W + i], s[W_2 + i], s[W_3 + i], s[DW + i], s[K_2 + i], s[K_3 + i]
        )
        k4 = stage_slope(law, s, i, y4, w4)
        s[W_4 + i], s[K_4 + i] = w4, k4
        s[WORK + i] += A74 * stage_power(s, i, y4, w4, k4)
    for i in range(WIDTH):
        y5, w5 = stage_5(
            s[TAKEN + i], s[Y + i], s[B + i],
            s[W + i], s[W_2 + i], s[W_3 + i], s[W_4 + i],
            s[DW + i], s[K_2 + i], s[K_3 + i], s[K_4 + i],
        )  # fmt: skip
        k5 = stage_slope(law, s, i, y5, w5)
        s[W_5 + i], s[K_5 + i] = w5, k5
        s[WORK + i] += A75 * stage_power(s, i, y5, w5, k5)
    for i in range(WIDTH):
        y6, w6 = stage_6(
            s[TAKEN + i], s[Y + i], s[B + i],
            s[W + i], s[W_2 + i], s[W_3 + i], s[W_4 + i], s[W_5 + i],
            s[DW + i], s[K_2 + i], s[K_3 + i], s[K_4 + i], s[K_5 + i],
        )  # fmt: skip
        k6 = stage_slope(law, s, i, y6, w6)
        s[W_6 + i], s[K_6 + i] = w6, k6
        s[WORK + i] = s[TAKEN + i] * (s[WORK + i] + A76 * stage_power(s, i, y6, w6, k6))
    for i in range(WIDTH):
        y7, w7 = stage_7(
            s[TAKEN + i], s[Y + i], s[B + i],
            s[W + i], s[W_2 + i], s[W_3 + i], s[W_4 + i], s[W_5 + i], s[W_6 + i],
            s[DW + i], s[K_2 + i], s[K_3 + i], s[K_4 + i], s[K_5 + i], s[K_6 + i],
        )  # fmt: skip
        s[Y_NEW + i], s[W_NEW + i], s[DW_NEW + i] = y7, w7, stage_slope(law, s, i, y7, w7)


@compiled
def control_step(law, s, rtol):
    """Error norm, verdict and factor for the next step.

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
        s[JERK_NEW + i] = stage_jerk(law, s, i, s[Y_NEW + i], s[W_NEW + i], s[DW_NEW + i])
    for i in range(WIDTH):
        floor = s[FLOOR + i]
        amplitude = max(abs(s[Y + i] - s[Y_STAR + i]), abs(s[W + i] - s[B + i])) + 1e-3 * floor
        scale_w = min(amplitude, abs(s[W_NEW + i]) + abs(s[DW_NEW + i]) + floor)
        error2 = squared_error(s[ERROR_Y + i], s[ERROR_W + i], rtol * amplitude, rtol * scale_w)
        factor, error_log = step_factor(error2, s[ERROR_LOG + i])
        good = error2 <= 1.0
        s[GOOD + i] = select(good, 1.0, 0.0)
        s[FACTOR + i] = factor
        s[ERROR_LOG_NEXT + i] = select(good, error_log, s[ERROR_LOG + i])


@compiled
def watch_and_commit(s, max_steps):
    """Raise flags where something happened inside the step; commit the other good steps."""
    for i in range(WIDTH):
        y, w, dw, jerk, b = s[Y_NEW + i], s[W_NEW + i], s[DW_NEW + i], s[JERK_NEW + i], s[B + i]
        w0, dw0, jerk0, h = s[W + i], s[DW + i], s[JERK + i], s[TAKEN + i]
        # Guards, turned so that the level is reached from below and a turning point is a maximum.
        side = s[SIDE + i]
        level = side * s[LEVEL + i]
        d0, d1, j0, j1 = side * dw0, side * dw, side * jerk0, side * jerk
        reached = side * w >= level
        # An extremum inside the step is no higher than the nearer end plus h times the smaller slope there.
        grazed = (d0 > 0.0) & (d1 <= 0.0) & (max(side * w0, side * w) + h * min(d0, -d1) >= level)
        turned = (d1 <= 0.0) | ((j0 < 0.0) & (j1 > 0.0) & (min(d0, d1) - h * min(-j0, j1) <= 0.0))
        # Extrema: of u each, for they are counted; of w and w' only those that can be the largest so far.
        peak = (dw0 * dw < 0.0) & (max(w0, w) + h * min(abs(dw0), abs(dw)) >= s[W_TOP + i])
        steepest = (jerk0 * jerk < 0.0) & (max(abs(dw0), abs(dw)) + h * min(abs(jerk0), abs(jerk)) >= s[DW_TOP + i])
        extremum = ((w0 > b) != (w > b)) | peak | steepest
        p, q = y - s[Y_STAR + i], w - b
        p0, q0, distance2 = s[Y + i] - s[Y_STAR + i], w0 - b, p * p + q * q
        entered = (p0 * p0 + q0 * q0 >= s[BAND2 + i]) & (distance2 < s[BAND2 + i])
        look = reached | grazed | ((s[TURN + i] > 0.0) & turned) | ((s[MARK + i] > 0.0) & extremum)
        look = look | entered | (distance2 < s[RADIUS2 + i]) | (s[TAU + i] + h >= s[TAU_END + i])
        good = s[GOOD + i] > 0.0
        look = look & good
        tried = s[TRIED + i] + 1.0
        halted = (tried >= max_steps) | (s[STEP + i] < SMALLEST_STEP)
        commit = good & (not look) & (not halted)
        s[FLAG + i] = select(halted, 2.0, select(look, 1.0, 0.0))
        s[TRIED + i] = tried
        s[STEP + i] = select(look, h, h * s[FACTOR + i])
        s[Y_NEXT + i] = select(commit, y, s[Y + i])
        s[W_NEXT + i] = select(commit, w, w0)
        s[DW_NEXT + i] = select(commit, dw, dw0)
        s[JERK_NEXT + i] = select(commit, jerk, jerk0)
        s[TAU_NEXT + i] = s[TAU + i] + select(commit, h, 0.0)
        s[HEAT_NEXT + i] = s[HEAT + i] + select(commit, s[WORK + i], 0.0)
    # The state is copied back from rows of its own: storing a select where it was loaded from becomes a masked store,
    # at 40 cycles each on some processors (Zen 3).
    for i in range(STATE_NUMBERS):
        s[i] = s[STATE_NUMBERS + i]
