"""The equations of motion of slip, in the frame of `layout.py`, on plain numbers and for the lanes."""

from . import layout as at
from .jit import compiled
from .laws import shape, weakening_slope


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
    return s[at.DROP + i] * shape(law, s[at.RATE + i] * w, s[at.EXPONENT + i])


@compiled(inline=True)
def slope_in_lane(law, s, i, y, w):
    """w' of lane i at (y, w)."""
    return slip_acceleration(
        law, y, w, s[at.G + i] + s[at.SLOPE + i], s[at.DROP + i], s[at.RATE + i], s[at.EXPONENT + i]
    )


@compiled(inline=True)
def jerk_in_lane(law, s, i, y, w, dw, b):
    """w'' of lane i at (y, w) with w' = dw, the belt moving at b."""
    drag = s[at.G + i] + s[at.SLOPE + i]
    return slip_jerk(law, y, w, dw, b, drag, s[at.DROP + i], s[at.RATE + i], s[at.EXPONENT + i])
