"""The equations of motion of slip, in the frame of `layout.py`, on plain numbers and for the lanes."""

from .jit import compiled
from .laws import shape, weakening_slope
from .layout import DROP, EXPONENT, G, RATE, SLOPE


@compiled(inline=True)
def slip_acceleration(law, y, w, drag, drop, rate, exponent):
    """w' in the frame of slip; drag = gamma + slope."""
    return y - drag * w - drop * shape(law, rate * w, exponent)


@compiled(inline=True)
def slip_jerk(law, y, w, dw, b, drag, drop, rate, exponent):
    """w'' from w', which tells the weakening without computing it again: drop shape = y - drag w - w'."""
    return (b - w) - (drag + rate * weakening_slope(law, rate * w, y - drag * w - dw, drop, exponent)) * dw


@compiled(inline=True)
def weakening_in_lane(law, s, i, w):
    """The weakening part of friction of lane i at slip speed w."""
    return s[DROP + i] * shape(law, s[RATE + i] * w, s[EXPONENT + i])


@compiled(inline=True)
def slope_in_lane(law, s, i, y, w):
    """w' of lane i at (y, w)."""
    return slip_acceleration(law, y, w, s[G + i] + s[SLOPE + i], s[DROP + i], s[RATE + i], s[EXPONENT + i])


@compiled(inline=True)
def jerk_in_lane(law, s, i, y, w, dw, b):
    """w'' of lane i at (y, w) with w' = dw, the belt moving at b."""
    drag = s[G + i] + s[SLOPE + i]
    return slip_jerk(law, y, w, dw, b, drag, s[DROP + i], s[RATE + i], s[EXPONENT + i])
