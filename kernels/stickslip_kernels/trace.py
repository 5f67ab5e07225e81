"""One trajectory over time: the log that stepping leaves behind, and its samples.

A log holds one row for every segment of the motion: a stick or hold phase, or one step of slip. Samples between the
rows are not interpolated: a closed form, or a shorter step of the same method, leads to each.
"""

from .jit import compiled
from .layout import (
    A4, B, BELT, DELTA, DROP, DW, FALL, G, GAMMA, HOLD, LOG_DROP, LOG_DW, LOG_MODE, LOG_OFFSET, LOG_SIGMA,
    LOG_SLOPE, LOG_TAU, LOG_U, LOG_W, OFFSET, SAMPLE_ACCELERATION, SAMPLE_FRICTION, SAMPLE_MODE, SAMPLE_RELATIVE,
    SAMPLE_XI, SLOPE, STICK, TAU, W, Y,
)  # fmt: skip
from .line import motion
from .rk import rk_step


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
def state_after(law, segment, dt, b, gamma, rate, exponent):
    """u, w and w' at dt after the start of a segment (a row of the log); b is the belt speed in its frame."""
    mode, u, w, dw = segment[LOG_MODE], segment[LOG_U], segment[LOG_W], segment[LOG_DW]
    if mode == STICK or mode == HOLD or dt == 0.0:
        return u + (b - w) * dt, w, dw
    if mode == FALL:
        offset, slope = segment[LOG_OFFSET], segment[LOG_SLOPE]
        q, dw = motion(w - b, dw, gamma + slope, dt)
        return offset + slope * (q + b) + gamma * q + dw, q + b, dw
    offset, slope, drop = segment[LOG_OFFSET], segment[LOG_SLOPE], segment[LOG_DROP]
    to_y = gamma * b - offset
    y, w, dw, _ = rk_step(law, dt, u + to_y, w, dw, b, gamma, offset, slope, drop, rate, exponent)
    return y - to_y, w, dw


@compiled
def sample(law, log, cell, times, samples):
    """Fill in the motion at given times.

    log : as `run_block` left it, not overflown (log[0, 0] < rows). cell : (CELL_ROWS,), the cell that was run.
    times : (n,) ascending, not before the first segment. samples : (SAMPLE_ROWS, n), filled in place.
    """
    gamma, rate = cell[GAMMA], 1.0 / cell[A4]
    last = int(log[0, 0])
    row = 1
    for n in range(times.size):
        while row < last and log[row + 1, LOG_TAU] <= times[n]:
            row += 1
        mode, sigma = log[row, LOG_MODE], log[row, LOG_SIGMA]
        b = sigma * cell[BELT]
        u, w, dw = state_after(law, log[row], times[n] - log[row, LOG_TAU], b, gamma, rate, cell[DELTA])
        samples[SAMPLE_XI, n], samples[SAMPLE_RELATIVE, n] = sigma * u, sigma * w
        samples[SAMPLE_ACCELERATION, n] = -sigma * dw
        # The equation of motion itself: what friction must be, stick included.
        samples[SAMPLE_FRICTION, n] = sigma * (u + gamma * (b - w) - dw)
        samples[SAMPLE_MODE, n] = mode
