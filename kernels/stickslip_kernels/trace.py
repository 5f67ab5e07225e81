"""One trajectory over time: the log that stepping leaves behind, and its samples.

A log holds one row for every segment of the motion: a stick or hold phase, or one step of slip. Samples between the
rows follow from a closed form, or from the dense output of that step, taken again.
"""

from math import inf

import numpy as np

from .dense import state_at
from .equations import jerk_in_lane, weakening_in_lane
from .jit import compiled
from .lanes import try_step
from .layout import (
    A4, B, BELT, DELTA, DROP, DW, EXPONENT, FALL, FAST, G, GAMMA, HOLD, JERK, LANE_NUMBERS, LOG_DROP, LOG_DW,
    LOG_MODE, LOG_OFFSET, LOG_SIGMA, LOG_SLOPE, LOG_TAU, LOG_U, LOG_W, OFFSET, RATE, RISE, SAMPLE_ACCELERATION,
    SAMPLE_FRICTION, SAMPLE_MODE, SAMPLE_RELATIVE, SAMPLE_XI, SLOPE, STEP, STICK, TAU, TAU_END, W, WEAK, Y,
)  # fmt: skip
from .line import motion

ANY_RTOL = 1e-6  # the size of a repeated step is given


@compiled
def log_closed_form(log, tau, mode, sigma, u, w):
    """Note a segment of stick or hold (constant slip speed w) that starts at tau. A full log only counts."""
    if log.shape[0] == 0:
        return
    log[0, 0] += 1.0
    row = int(log[0, 0])
    if row < log.shape[0]:
        log[row, LOG_TAU], log[row, LOG_MODE], log[row, LOG_SIGMA] = tau, mode, sigma
        log[row, LOG_U], log[row, LOG_W], log[row, LOG_DW] = u, w, 0.0


@compiled
def log_slip(log, s, i, mode, sigma):
    """Note the step of slip that starts at the present state of lane i."""
    if log.shape[0] == 0:
        return
    u = s[Y + i] - s[G + i] * s[B + i] + s[OFFSET + i]
    log_closed_form(log, s[TAU + i], mode, sigma, u, s[W + i])
    row = int(log[0, 0])
    if row < log.shape[0]:
        log[row, LOG_DW] = s[DW + i]
        log[row, LOG_OFFSET], log[row, LOG_SLOPE], log[row, LOG_DROP] = s[OFFSET + i], s[SLOPE + i], s[DROP + i]


@compiled
def log_fall(log, tau, sigma, u, w, dw, mu_stop, slope):
    """Note a slip along the line mu_stop + slope w that starts at tau."""
    log_closed_form(log, tau, FALL, sigma, u, w)
    row = int(log[0, 0]) if log.shape[0] > 0 else 0
    if 0 < row < log.shape[0]:
        log[row, LOG_DW], log[row, LOG_OFFSET], log[row, LOG_SLOPE] = dw, mu_stop, slope


@compiled
def repeat_step(law, s, segment, duration, cell, b):
    """Take the step of slip that a row of the log notes again, in lane 0 of the scratch lanes s."""
    gamma, offset, slope, drop = cell[GAMMA], segment[LOG_OFFSET], segment[LOG_SLOPE], segment[LOG_DROP]
    w, dw = segment[LOG_W], segment[LOG_DW]
    s[B], s[G], s[OFFSET], s[SLOPE], s[DROP] = b, gamma, offset, slope, drop
    s[RATE], s[EXPONENT] = 1.0 / cell[A4], cell[DELTA]
    s[Y], s[W], s[DW] = segment[LOG_U] + gamma * b - offset, w, dw
    s[JERK], s[WEAK] = jerk_in_lane(law, s, 0, s[Y], w, dw, b), weakening_in_lane(law, s, 0, w)
    s[TAU_END], s[STEP] = inf, duration
    try_step(law, s, ANY_RTOL)


@compiled
def state_after(law, s, segment, dt, gamma, b):
    """u, w and w' at dt after the start of a segment (a row of the log); b is the belt speed in its frame.

    s : scratch lanes which, if this is a step of slip, `repeat_step` has filled.
    """
    mode, u, w, dw = segment[LOG_MODE], segment[LOG_U], segment[LOG_W], segment[LOG_DW]
    if mode == STICK or mode == HOLD or dt == 0.0:
        return u + (b - w) * dt, w, dw
    if mode == FALL:
        offset, slope = segment[LOG_OFFSET], segment[LOG_SLOPE]
        q, dw = motion(w - b, dw, gamma + slope, dt)
        return offset + slope * (q + b) + gamma * q + dw, q + b, dw
    y, w, dw, _ = state_at(law, s, 0, dt)
    return y - gamma * b + segment[LOG_OFFSET], w, dw


@compiled(allocates=True)
def sample(law, log, cell, times, samples):
    """Fill in the motion at given times.

    log : as `run_block` left it, not overflown (log[0, 0] < rows). cell : (CELL_ROWS,), the cell that was run.
    times : (n,) ascending, not before the first segment. samples : (SAMPLE_ROWS, n), filled in place.
    """
    gamma = cell[GAMMA]
    s = np.zeros(LANE_NUMBERS)
    last, row, repeated = int(log[0, 0]), 1, 0
    for n in range(times.size):
        while row < last and log[row + 1, LOG_TAU] <= times[n]:
            row += 1
        mode, sigma, start = log[row, LOG_MODE], log[row, LOG_SIGMA], log[row, LOG_TAU]
        b = sigma * cell[BELT]
        if row != repeated and (mode == RISE or mode == FAST):
            end = log[row + 1, LOG_TAU] if row < last else times[times.size - 1]
            repeat_step(law, s, log[row], end - start, cell, b)
            repeated = row
        u, w, dw = state_after(law, s, log[row], times[n] - start, gamma, b)
        samples[SAMPLE_XI, n], samples[SAMPLE_RELATIVE, n] = sigma * u, sigma * w
        samples[SAMPLE_ACCELERATION, n] = -sigma * dw
        # The equation of motion itself: what friction must be, stick included.
        samples[SAMPLE_FRICTION, n] = sigma * (u + gamma * (b - w) - dw)
        samples[SAMPLE_MODE, n] = mode
