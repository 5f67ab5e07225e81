"""One step of slip: embedded Runge-Kutta pair, error norm, step-size factor.

Straight-line code on plain numbers, for the vectorised loops of `rk_lanes.py`. The equations are those of the frame in
`layout.py`.
"""

from .bits import select
from .exponential import rough_exp2, rough_log2
from .jit import compiled
from .tableau import TSITOURAS_54

# The tableau by the textbook's names, so that the compiler sees constants.
C2, C3, C4, C5, C6, C7 = TSITOURAS_54.nodes[1:]
(
    (A21,),
    (A31, A32),
    (A41, A42, A43),
    (A51, A52, A53, A54),
    (A61, A62, A63, A64, A65),
    (A71, A72, A73, A74, A75, A76),
) = TSITOURAS_54.matrix[1:]
E1, E2, E3, E4, E5, E6, E7 = TSITOURAS_54.error_weights

# PI control (Hairer & Wanner II, IV.2): the step grows like error^-ALPHA * last_error^BETA.
BETA = 0.4 / TSITOURAS_54.order
ALPHA = 1.0 / TSITOURAS_54.order - 0.75 * BETA
LOG2_SAFETY = -0.152003093445  # log2(0.9)
SHRINK_MOST, GROW_MOST = 0.2, 6.0
TINIEST_ERROR2 = 1e-16
ERROR_SHARE = 0.05  # of the tolerance that one step may spend, so that a whole slip stays within it


# Stages. y' = b - w is linear, so y needs only the stages of w: sum_j a_ij (b - w_j) = c_i b - sum_j a_ij w_j.
# Each returns y and w at its node; k_i is w' there, k_1 the w' at the start (first same as last).


@compiled(inline=True)
def stage_2(h, y, b, w, k):
    """Second stage."""
    return y + h * (C2 * b - A21 * w), w + h * (A21 * k)


@compiled(inline=True)
def stage_3(h, y, b, w, w2, k, k2):
    """Third stage."""
    return y + h * (C3 * b - (A31 * w + A32 * w2)), w + h * (A31 * k + A32 * k2)


@compiled(inline=True)
def stage_4(h, y, b, w, w2, w3, k, k2, k3):
    """Fourth stage."""
    return y + h * (C4 * b - (A41 * w + A42 * w2 + A43 * w3)), w + h * (A41 * k + A42 * k2 + A43 * k3)


@compiled(inline=True)
def stage_5(h, y, b, w, w2, w3, w4, k, k2, k3, k4):
    """Fifth stage."""
    dy = C5 * b - (A51 * w + A52 * w2 + A53 * w3 + A54 * w4)
    return y + h * dy, w + h * (A51 * k + A52 * k2 + A53 * k3 + A54 * k4)


@compiled(inline=True)
def stage_6(h, y, b, w, w2, w3, w4, w5, k, k2, k3, k4, k5):
    """Sixth stage."""
    dy = C6 * b - (A61 * w + A62 * w2 + A63 * w3 + A64 * w4 + A65 * w5)
    return y + h * dy, w + h * (A61 * k + A62 * k2 + A63 * k3 + A64 * k4 + A65 * k5)


@compiled(inline=True)
def stage_7(h, y, b, w, w2, w3, w4, w5, w6, k, k2, k3, k4, k5, k6):
    """Seventh stage: the end of the step."""
    dy = C7 * b - (A71 * w + A72 * w2 + A73 * w3 + A74 * w4 + A75 * w5 + A76 * w6)
    return y + h * dy, w + h * (A71 * k + A72 * k2 + A73 * k3 + A74 * k4 + A75 * k5 + A76 * k6)


@compiled(inline=True)
def embedded_errors(h, w, w2, w3, w4, w5, w6, w7, k, k2, k3, k4, k5, k6, k7):
    """Error estimates of y and w."""
    error_y = -h * (E1 * w + E2 * w2 + E3 * w3 + E4 * w4 + E5 * w5 + E6 * w6 + E7 * w7)
    error_w = h * (E1 * k + E2 * k2 + E3 * k3 + E4 * k4 + E5 * k5 + E6 * k6 + E7 * k7)
    return error_y, error_w


@compiled(inline=True)
def squared_error(error_y, error_w, scale_y, scale_w):
    """Squared error norm of a step: the two errors over their scales and over ERROR_SHARE; a step is good up to 1."""
    return (
        (1.0 / ERROR_SHARE**2)
        * (error_y * error_y * (scale_w * scale_w) + error_w * error_w * (scale_y * scale_y))
        / (scale_y * scale_y * (scale_w * scale_w))
    )


@compiled(inline=True)
def step_factor(error2, last_log):
    """Factor by which the next step differs from this one, and log2 of `error2` for the next call.

    A rejected or NaN step shrinks (and a NaN shrinks most).
    """
    log_error = rough_log2(max(error2, TINIEST_ERROR2))
    proportional = rough_exp2(LOG2_SAFETY - 0.5 * ALPHA * log_error + 0.5 * BETA * last_log)
    factor = min(max(proportional, SHRINK_MOST), GROW_MOST)
    factor = select(error2 <= 1.0, factor, min(factor, 0.9))
    return select(error2 < 1e300, factor, SHRINK_MOST), log_error
