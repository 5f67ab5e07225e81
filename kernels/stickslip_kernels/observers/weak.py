"""Weak drag: what a motion does in the end if it changes too little in a loop to be followed there.

In polar coordinates about steady sliding, q = r sin(theta), p = r cos(theta), a loop changes r by -pi r D(r) to first
order, D being the mean of the drag F' over the loop with weight cos^2(theta)/pi; where slip changes its direction, at
w = 0, F jumps by twice the friction of standstill and F' has a peak of that size. To second order the change is wrong
by what F differs by on a circle of another radius: at most by the change of r on the way times the integral of
|F'| sin^2; and by (F/r)^2 of what F does in a loop at all, since theta' = 1 - F cos(theta)/r (the term before is odd).
Where D exceeds twice the sum, its sign is that of the change (averaging: J. A. Sanders, F. Verhulst, J. Murdock,
Averaging Methods in Nonlinear Dynamical Systems, Springer 2007).

Orbits in a plane do not cross: the return map, from turn to turn, is monotone. So a spiral whose turns lie between
those of another one does in the end what that does, and a motion is known by one that is followed from further in
(`leaps`): if that sticks, so do all between, since the map is flat from there to the cycle. When is not known then.
With ageing the state is more than a plane, and all that is known is that what grows must stick.
"""

from math import asin, cos, inf, log, pi, sin

from .. import layout as at
from ..contacts.stribeck.equations import jerk_in_lane, next_speed, slope_in_lane, weakening_in_lane
from ..contacts.stribeck.friction import Table
from ..contacts.stribeck.laws import inflection
from ..contacts.stribeck.runge_kutta import restart
from ..dense import NODES, WEIGHTS
from ..jit import compiled
from ..linking import by_law
from .settling import drag_at, drags_between

SAFETY = 2.0
WEAKEST = 0.25  # force over radius: beyond, friction decides how long the motion stays where it is
GRADED = 0.1  # first panel beside the slowest point, in units of a4
LEAST = 1e-3  # share of a panel, or of a step of the radius, that is taken even where a station ends it
RADII = 24  # between which the mean drag may change by less than itself
CLOSER = 0.85  # of the distance to the circle that touches standstill, from one radius to the next
CLOSEST = 20.0  # to that circle, in changes of r within a loop
BARELY = 1e-9  # slip speed over that of the belt, just before standstill
FROM_OUTSIDE, FROM_INSIDE = 1.0, 2.0  # of LEAPT: towards smaller loops, to the standstill that growing ones come to


@compiled
def friction_at(law, s, i, w):
    """Friction coefficient of the curve of lane i at slip speed w."""
    return s[at.OFFSET + i] + s[at.SLOPE + i] * w + weakening_in_lane(law, s, i, w)


@compiled
def excess_force(law, s, i, w):
    """F at the relative speed w of either sign: damper and friction beyond those of steady sliding."""
    b, mu = s[at.B + i], friction_at(law, s, i, abs(w))
    return s[at.G + i] * (w - b) + (mu if w >= 0.0 else -mu) - friction_at(law, s, i, b)


@compiled
def mean_drag(law, s, i, r, offset):
    """Mean drag of a loop of radius r > 0 about p = offset, its error, and the most r changes by within a loop.

    By Gauss over panels, which end at stations of the law.
    """
    b = s[at.B + i]
    lowest = -asin(min(b / r, 1.0))  # angle at which w is least, or zero
    mean, square, change, top = 0.0, 0.0, 0.0, 0.0
    for side in range(2):
        way, sign = (0.5 * pi - lowest, 1.0) if side == 0 else (0.5 * pi + lowest, -1.0)
        start, size = 0.0, GRADED * min(1.0, 1.0 / (s[at.RATE + i] * r))
        while start < way:
            size = min(size, way - start)
            station = next_speed(law, s, i, abs(b + r * sin(lowest + sign * start)), 1.0)
            if station < abs(b + r * sin(lowest + sign * (start + size))):
                size = max(sign * (asin((sign * station - b) / r) - lowest) - start, LEAST * size)
            for node in range(len(NODES)):
                angle = lowest + sign * (start + size * NODES[node])
                q, weight = r * sin(angle), 2.0 * size * WEIGHTS[node]
                drag = drag_at(law, s, i, abs(b + q))
                mean += weight * drag * cos(angle) ** 2
                square += weight * abs(drag) * sin(angle) ** 2
                force = abs(excess_force(law, s, i, b + q) - offset)
                change += weight * force * abs(sin(angle))
                top = max(top, force)
            start += size
            size = min(1.5 * size, GRADED)
    if r > b:
        jump, steep = 2.0 * friction_at(law, s, i, 0.0), (1.0 - (b / r) ** 2) ** 0.5
        mean += 2.0 * jump * steep / r
        square += 2.0 * jump * (b / r) ** 2 / (r * steep)
    if top > WEAKEST * r:
        return mean / pi, inf, change
    return mean / pi, SAFETY * (square + (top / r) ** 2) * change / (pi * r), change


@compiled
def decays_on_average(law, s, i):
    """Return whether all loops from the present one down, none of which comes to rest, shrink."""
    b, drag = s[at.B + i], drag_at(law, s, i, s[at.B + i])
    p, q = s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - b
    r = (p * p + q * q) ** 0.5
    if b <= 0.0 or drag <= 0.0 or s[at.CROSSED + i] < 2.0 or s[at.MODE + i] == at.RISE and s[at.W_MIN + i] > 0.0:
        return False
    radius = 0.0
    for n in range(RADII):
        before = drag
        while radius < r * (n + 1) / RADII:
            radius = next_radius(law, s, i, radius, r * (n + 1) / RADII)
            drag, error, change = mean_drag(law, s, i, radius, 0.0)
            if not drag > max(error, abs(drag - before)) or radius + change >= b - s[at.W_MIN + i]:
                return False
    return True


@compiled(inline=True)
def next_radius(law, s, i, r, end):
    """The radius at `end`, or on the way there from r the first of a loop that touches a station of the curve."""
    b, way = s[at.B + i], 1.0 if end > r else -1.0
    outer = way * (next_speed(law, s, i, b + r, way) - b)
    inner = way * (b - next_speed(law, s, i, b - r, -way)) if r < b else way * (next_speed(law, s, i, r - b, way) + b)
    return way * min(way * end, max(min(outer, inner), way * r + LEAST * abs(end - r)))


@by_law("si:f")
def most_drag(law, s, i):
    """The largest gamma + mu' of loops that do not come to rest."""
    b, bend = s[at.B + i], inflection(law, s[at.EXPONENT + i]) / s[at.RATE + i]
    most = max(drag_at(law, s, i, 0.0), drag_at(law, s, i, 2.0 * b))
    return max(most, drag_at(law, s, i, bend)) if bend < 2.0 * b else most


most_drag.of(Table)(lambda law, s, i: drags_between(law, s, i, 0.0, 2.0 * s[at.B + i])[1])


@compiled
def feeds_all_loops(law, s, i):
    """Return whether every loop of the plain curve about steady sliding grows until it comes to rest, and sticks there.

    With V = p^2 + q^2, V' = -2 q F > 0. It reaches w = 0 where F > 0: under a load below the friction there.
    """
    b = s[at.B + i]
    return b > 0.0 and s[at.W_MIN + i] == 0.0 and most_drag(law, s, i) <= 0.0 and drag_at(law, s, i, b) < 0.0


@compiled
def is_caught(law, s, i):
    """Return whether a loop that grew into standstill comes there under a load that the contact holds, of either sign.

    p^2 is at most what r^2 grew by in the last loop.
    """
    b = s[at.B + i]
    growth = (2.0 * SAFETY * pi * abs(mean_drag(law, s, i, b, 0.0)[0])) ** 0.5 * b
    return growth < friction_at(law, s, i, 0.0) + friction_at(law, s, i, b) + s[at.G + i] * b


@compiled
def leaps(m, i):
    """Put lane i where its motion is known to come, if that takes more steps than are left; whether it did."""
    law, s, b = m.law, m.s, m.s[at.B + i]
    if s[at.W_MIN + i] > 0.0 or b <= 0.0 or s[at.TAU_END + i] < inf or m.observer.until == at.UNTIL_HORIZON:
        return False
    p, q = s[at.Y + i] - s[at.Y_STAR + i], s[at.W + i] - b
    loops_left = (m.max_steps / s[at.TRIED + i] - 1.0) * (s[at.TAU + i] - s[at.SLIP_START + i]) / (2.0 * pi)
    r = (p * p + q * q) ** 0.5
    if r < b:
        if not feeds_all_loops(law, s, i) or not is_caught(law, s, i):
            return False
        if log(b / r) < pi * -mean_drag(law, s, i, r, 0.0)[0] * loops_left:
            return False
        put(m, i, 0.0, b * (BARELY - 1.0))
        s[at.LEAPT + i] = FROM_INSIDE
        return True
    far = -friction_at(law, s, i, b)  # F0 of loops far beyond b
    offset = far if mean_drag(law, s, i, r, far)[2] < mean_drag(law, s, i, r, 0.0)[2] else 0.0
    r = ((p - offset) ** 2 + q * q) ** 0.5
    end, loops = r, 0.0
    before = mean_drag(law, s, i, r, offset)[0] if r > b else 0.0
    while before > 0.0:
        radius = next_radius(law, s, i, end, b + CLOSER * (end - b))
        drag, error, change = mean_drag(law, s, i, radius, offset)
        if not drag > max(error, abs(drag - before)) or radius - b < CLOSEST * change or radius < 1e-3 * r:
            break
        loops += log(end / radius) / (pi * max(drag, before))
        end, before = radius, drag
    share = end / r
    if loops < loops_left or b + share * q <= 0.0:
        return False
    put(m, i, offset + share * (p - offset), share * q)
    s[at.LEAPT + i] = FROM_OUTSIDE
    return True


@compiled
def put(m, i, p, q):
    """Put lane i at (p, q)."""
    law, s = m.law, m.s
    y, w = s[at.Y_STAR + i] + p, s[at.B + i] + q
    s[at.Y + i], s[at.W + i], s[at.WEAK + i] = y, w, weakening_in_lane(law, s, i, w)
    s[at.DW + i] = slope_in_lane(law, s, i, y, w)
    s[at.JERK + i] = jerk_in_lane(law, s, i, y, w, s[at.DW + i], s[at.B + i])
    restart(law, s, i, 0.01)
