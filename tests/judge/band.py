"""The settling band of a slip: on which side of it the mass turns, and when it enters.

The distance from steady sliding is sqrt((xi - xi*)^2 + xi'^2). The band is a share of that at which the slip begins: at
the start, or at a break-away from a stick phase. A slip that only changes its direction continues.
"""

from math import inf, isnan, sqrt

from .curve import weakened
from .jit import compiled
from .layout import (
    A1, A3, BAND2, BAND_SHARE, BELT, CENTRE, CROSSED, ENTERED, FIRST_SLIP, GAMMA, INSIDE, MIDDLE, REVERSAL, SIDE,
    SIGMA, STOP, TAU, P, W,
)  # fmt: skip
from .linear import linear
from .stepping import step

SMALLEST = 1e-12  # band
PIECES = 400  # in which a fall is searched for the last entry


@compiled
def displacement(c, s, p):
    """xi, of the true frame."""
    return s[SIGMA] * (p + c[A1] + c[A3] - c[GAMMA] * s[SIGMA] * c[BELT])


@compiled
def steady(c):
    """xi of steady sliding on the curve."""
    mu = c[A1] + c[A3] - weakened(c, abs(c[BELT]))
    return mu if c[BELT] >= 0.0 else -mu


@compiled
def excess(c, s, p, w):
    """Squared distance from where the motion is taken to settle, beyond that of the band."""
    return (displacement(c, s, p) - s[MIDDLE]) ** 2 + (c[BELT] - s[SIGMA] * w) ** 2 - s[BAND2]


@compiled
def begin_band(c, s):
    """A slip begins at the present state."""
    distance2 = (displacement(c, s, s[P]) - steady(c)) ** 2 + (c[BELT] - s[SIGMA] * s[W]) ** 2
    s[BAND2] = max(c[BAND_SHARE] ** 2 * distance2, SMALLEST**2)
    s[MIDDLE] = steady(c) if isnan(c[CENTRE]) else c[CENTRE]
    s[SIDE], s[CROSSED], s[INSIDE], s[REVERSAL] = 0.0, 0.0, 0.0, inf
    if isnan(s[FIRST_SLIP]):
        s[FIRST_SLIP] = s[TAU]
    note_side(c, s, displacement(c, s, s[P]))
    enter_or_leave(s, s[TAU], excess(c, s, s[P], s[W]) < 0.0)


@compiled
def note_side(c, s, xi):
    """The slip begins or turns at xi: outside the band on the other side it has crossed the equilibrium."""
    distance = xi - steady(c)
    if distance * distance > s[BAND2]:
        side = 1.0 if distance > 0.0 else -1.0
        if side * s[SIDE] < 0.0:
            s[CROSSED] += 1.0
        s[SIDE] = side


@compiled
def enter_or_leave(s, tau, inside):
    """At tau the motion is inside the band, or outside."""
    if inside and s[INSIDE] == 0.0:
        s[ENTERED] = tau
    s[INSIDE] = 1.0 if inside else 0.0


@compiled
def note_entry_in_step(c, s, belt, h, k):
    """The next h of slip on the curve, from the present state."""
    end = step(c, belt, s[P], s[W], 0.0, h, k)
    early, late, inside = 0.0, h, excess(c, s, end[0], end[1]) < 0.0
    if inside and s[INSIDE] == 0.0:
        for _ in range(50):
            t = 0.5 * (early + late)
            there = step(c, belt, s[P], s[W], 0.0, t, k)
            if excess(c, s, there[0], there[1]) < 0.0:
                late = t
            else:
                early = t
    enter_or_leave(s, s[TAU] + late, inside)


@compiled
def excess_on_line(c, s, q, v, d, slope):
    """`excess` at (q, v) = (w - B, w') on the line of friction, d = gamma + slope."""
    p = v + d * q + (c[GAMMA] + slope) * s[SIGMA] * c[BELT] + c[STOP] - c[A1] - c[A3]
    return excess(c, s, p, q + s[SIGMA] * c[BELT])


@compiled
def note_entry_on_line(c, s, q, v, d, slope, duration):
    """A fall from (q, v) on; one that never ends is searched until it is well inside the band."""
    if duration == inf:
        duration = 1.0
        at_rest = excess_on_line(c, s, 0.0, 0.0, d, slope) + s[BAND2]
        if at_rest < s[BAND2]:
            while excess_on_line(c, s, *linear(q, v, d, duration), d, slope) + s[BAND2] > at_rest + 0.01 * s[BAND2]:
                duration *= 2.0
    for n in range(1, PIECES + 1):
        early, late = duration * (n - 1) / PIECES, duration * n / PIECES
        inside, end = excess_on_line(c, s, *linear(q, v, d, late), d, slope) < 0.0, late
        if inside and s[INSIDE] == 0.0:
            for _ in range(60):
                t = 0.5 * (early + late)
                if excess_on_line(c, s, *linear(q, v, d, t), d, slope) < 0.0:
                    late = t
                else:
                    early = t
        enter_or_leave(s, s[TAU] + late, inside)
        if end == duration:
            break


@compiled
def note_entry_in_hold(c, s, duration):
    """A hold from the present state on, in which u moves at B - w."""
    speed = s[SIGMA] * c[BELT] - s[W]
    far = excess(c, s, s[P] + speed * duration, s[W])
    late = duration
    if far < 0.0 and s[INSIDE] == 0.0:
        room = sqrt(s[BAND2] - speed * speed)
        late = (s[SIGMA] * (s[MIDDLE] - displacement(c, s, s[P])) - room) / speed
    enter_or_leave(s, s[TAU] + late, far < 0.0)
