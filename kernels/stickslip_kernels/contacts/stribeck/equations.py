"""The equations of motion of slip, in the frame of `layout.py`."""

from ... import layout as at
from ...dense import rise_and_work
from ...jit import compiled
from .laws import next_station, shape, weakening_slope


@compiled(inline=True)
def weakening_in_lane(law, s, i, w):
    """The weakening part of friction of lane i at slip speed w."""
    return s[at.DROP + i] * shape(law, s[at.RATE + i] * w, s[at.EXPONENT + i])


@compiled(inline=True)
def slope_in_lane(law, s, i, y, w):
    """w' of lane i at (y, w)."""
    return y - (s[at.G + i] + s[at.SLOPE + i]) * w - weakening_in_lane(law, s, i, w)


@compiled(inline=True)
def jerk_in_lane(law, s, i, y, w, dw, b):
    """w'' of lane i at (y, w) with w' = dw, the belt moving at b; w' tells the weakening without computing it again."""
    drag, rate, drop = s[at.G + i] + s[at.SLOPE + i], s[at.RATE + i], s[at.DROP + i]
    weakening = y - drag * w - dw
    return (b - w) - (drag + rate * weakening_slope(law, rate * w, weakening, drop, s[at.EXPONENT + i])) * dw


@compiled(inline=True)
def state_at(law, s, i, t):
    """y, w, w' and the friction work at t after the start of the step of lane i."""
    w, rise, work = rise_and_work(s, i, t)
    y = s[at.Y + i] + rise
    return y, w, slope_in_lane(law, s, i, y, w), work


@compiled(inline=True)
def next_speed(law, s, i, w, way):
    """The next slip speed after w >= 0, upwards or downwards, at which the curve of lane i has a station."""
    return next_station(law, s[at.RATE + i] * w, way) / s[at.RATE + i]
