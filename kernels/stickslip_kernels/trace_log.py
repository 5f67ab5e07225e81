"""The log a single trajectory leaves behind: one row for every segment of its motion."""

from .jit import compiled
from .layout import DROP, DW, G, LOG_DROP, LOG_DW, LOG_MODE, LOG_OFFSET, LOG_SIGMA, LOG_SLOPE, LOG_TAU, LOG_U, LOG_W  # fmt: skip
from .layout import B, OFFSET, SLOPE, TAU, W, Y


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
