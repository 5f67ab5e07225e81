"""Recurrences of the weakening part of friction, one a shape: its coefficients from those of the slip speed.

All of them are sums of products. With x the weakening part, coefficient m of its Taylor series is

    x_m = scale_m (f_0 g_(m-1) + f_1 g_(m-2) + ... + f_(m-1) g_0)

of two factors f and g, series in rows of the lane: that of w, of w' or of x itself, or one that the recurrence keeps
in rows SERIES_FACTOR. So one loop (`taylor.py`) serves every law; a recurrence says which factors, and how the next
coefficient of the one it keeps is found. n is a constant where these functions are merged into that loop.
"""

from typing import Any, NamedTuple

from ... import layout as at
from ...jit import compiled


class Recurrence(NamedTuple):
    """One of them, of compiled functions.

    f, g : first rows of the factors. begin(s, i) : what must be known before the first coefficient.
    scale(s, i, per_m) : scale_m, given 1/m. next_f(s, i, n, dw_n, w_1) : f_n, given coefficient n of w' and n + 1 of w.
    next_g(s, i, n, x_n, w_n) : g_n, given coefficients n of x and w.
    """

    f: int
    g: int
    begin: Any
    scale: Any
    next_f: Any
    next_g: Any


inline = compiled(inline=True)

# --- parts of more than one ----------------------------------------------------------------------------------------


nothing = inline(lambda s, i: None)  # all is known
slope = inline(lambda s, i, n, dw_n, w_1: dw_n)  # f = w'
weakening = inline(lambda s, i, n, x_n, w_n: x_n)  # g = x


@inline
def square(s, i, n, w_n):
    """Coefficient n of w^2, given that of w: each product of two different coefficients comes twice."""
    w = at.SERIES + i
    if n == 0:
        return w_n * w_n
    half = s[w] * w_n
    if n > 2:
        for j in range(1, (n + 1) >> 1):
            half += s[w + j * at.WIDTH] * s[w + (n - j) * at.WIDTH]
    if n & 1 == 1:
        return 2.0 * half
    middle = s[w + (n >> 1) * at.WIDTH]
    return 2.0 * half + middle * middle


# --- x = drop e^(-rate w): x' = -rate w' x --------------------------------------------------------------------------


exponential_scale = inline(lambda s, i, per_m: s[at.RATE + i] * -per_m)
EXPONENTIAL = Recurrence(at.SERIES_DW, at.SERIES_WEAK, nothing, exponential_scale, slope, weakening)

# --- x = drop/(1 + rate w): (1 + rate w) x has no coefficients but the first ----------------------------------------


@inline
def begin_quotient(s, i):
    """-rate/(1 + rate w) at the start of the step, into the first row of SERIES_FACTOR: the scale for every m."""
    rate = s[at.RATE + i]
    s[at.SERIES_FACTOR + i] = -rate / (1.0 + rate * s[at.W + i])


quotient_scale = inline(lambda s, i, per_m: s[at.SERIES_FACTOR + i])
speed_above = inline(lambda s, i, n, dw_n, w_1: w_1)  # f_n is coefficient n + 1 of w
QUOTIENT = Recurrence(at.SERIES + at.WIDTH, at.SERIES_WEAK, begin_quotient, quotient_scale, speed_above, weakening)

# --- x = drop e^(-(rate w)^2): x' = -rate^2 (w^2)' x ----------------------------------------------------------------


slope_of_square = inline(lambda s, i, n, dw_n, w_1: (n + 1.0) * square(s, i, n + 1, w_1))  # f = (w^2)'
gaussian_scale = inline(lambda s, i, per_m: s[at.RATE + i] * s[at.RATE + i] * -per_m)
GAUSSIAN = Recurrence(at.SERIES_FACTOR, at.SERIES_WEAK, nothing, gaussian_scale, slope_of_square, weakening)

# --- x = drop (1 - 3/2 rate w + 1/2 (rate w)^3): x' = 3/2 drop rate ((rate w)^2 - 1) w' -----------------------------


@inline
def slope_of_cubic(s, i, n, x_n, w_n):
    """g = (rate w)^2 - 1."""
    return s[at.RATE + i] * s[at.RATE + i] * square(s, i, n, w_n) - (1.0 if n == 0 else 0.0)


cubic_scale = inline(lambda s, i, per_m: s[at.DROP + i] * s[at.RATE + i] * (1.5 * per_m))
CUBIC = Recurrence(at.SERIES_DW, at.SERIES_FACTOR, nothing, cubic_scale, slope, slope_of_cubic)
