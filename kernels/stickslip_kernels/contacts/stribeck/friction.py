"""The friction coefficient over the slip speed w = |v_rel|, in kernel units (`layout.py`).

a1 and a3 are pure numbers, a2 is per unit of speed, a4 is a speed; the shape of the weakening is that of the law.
"""

from math import inf, nan

from ... import layout as at
from ...jit import compiled
from ...linking import by_law
from .laws import inflection, last_weakening, shape, speed_of_shape_slope, weakening_slope
from .table import Table, bend_between, place

MOST_DOUBLINGS, HALVINGS = 60, 60
FAR = 1e100  # speeds a4 from which on a curve goes on as it does at last


@compiled
def coefficient(law, cells, c, w):
    """Friction coefficient of cell c at slip speed w >= 0."""
    return cells[at.A1, c] + cells[at.A2, c] * w + cells[at.A3, c] * shape(law, w / cells[at.A4, c], cells[at.DELTA, c])


@compiled
def coefficient_slope(law, cells, c, w):
    """Derivative of `coefficient` with respect to w."""
    z, drop, delta = w / cells[at.A4, c], cells[at.A3, c], cells[at.DELTA, c]
    return cells[at.A2, c] + weakening_slope(law, z, drop * shape(law, z, delta), drop, delta) / cells[at.A4, c]


@compiled
def speed_of_slope(law, cells, c, slope):
    """The largest slip speed at which the curve of cell c has the given slope; inf if it stays steeper.

    0 if the curve is nowhere that steep, or the weakening part strengthens friction. Slope 0 gives the minimum of the
    curve, -gamma gives v_H, where steady sliding with damping gamma loses its stability.
    """
    a2, a3, a4 = cells[at.A2, c], cells[at.A3, c], cells[at.A4, c]
    if a3 <= 0.0:
        return 0.0 if slope <= a2 or a3 < 0.0 else inf
    return a4 * speed_of_shape_slope(law, (slope - a2) * a4 / a3, cells[at.DELTA, c])


@by_law("ci:f")
def speed_of_minimum(law, cells, c):
    """Slip speed v_min of cell c at which the falling branch of its curve ends in a minimum.

    0 if the curve falls nowhere, inf if it falls without end, NaN if it rises first and falls without end then: such a
    curve has a maximum and no minimum.
    """
    if cells[at.A3, c] >= 0.0:
        return speed_of_slope(law, cells, c, 0.0)
    at_rest, bend = coefficient_slope(law, cells, c, 0.0), cells[at.A4, c] * inflection(law, cells[at.DELTA, c])
    if at_rest < 0.0 or (at_rest == 0.0 and bend == 0.0):  # strengthening: the slope is largest at the inflection
        return last_rising(law, cells, c, 0.0, bend, 0.0) if coefficient_slope(law, cells, c, bend) > 0.0 else inf
    far = cells[at.A4, c] * min(last_weakening(law, cells[at.DELTA, c]), FAR)
    return nan if coefficient_slope(law, cells, c, far) < 0.0 else 0.0


@by_law("ciff:f")
def least_coefficient(law, cells, c, low, high):
    """The least friction coefficient of cell c at slip speeds from `low` to `high`."""
    least = min(coefficient(law, cells, c, low), coefficient(law, cells, c, high))
    minimum = speed_of_minimum(law, cells, c)
    return min(least, coefficient(law, cells, c, minimum)) if low < minimum < high else least


@by_law("ci:p", inline=True)
def stable_speeds(law, cells, c):
    """The widest interval about the belt speed of slip speeds at which gamma + mu' > 0; empty if it is not there.

    A belt on the convex part of the curve may find itself below it.
    """
    convex_from = cells[at.A4, c] * inflection(law, cells[at.DELTA, c])
    if cells[at.A3, c] > 0.0 and abs(cells[at.BELT, c]) >= convex_from:
        return speed_of_slope(law, cells, c, -cells[at.GAMMA, c]), inf
    return stable_about_belt(law, cells, c)


@compiled
def stable_about_belt(law, cells, c):
    """`stable_speeds` for any curve: the slope has its only extremum at the inflection, and is monotone beside it."""
    gamma, b, bend = cells[at.GAMMA, c], abs(cells[at.BELT, c]), inflection(law, cells[at.DELTA, c])
    if not gamma + coefficient_slope(law, cells, c, b) > 0.0:
        return b, b
    bend *= cells[at.A4, c]
    low = 0.0
    if b > bend and gamma + coefficient_slope(law, cells, c, bend) <= 0.0:
        low = last_rising(law, cells, c, gamma, b, bend)
    elif gamma + coefficient_slope(law, cells, c, 0.0) <= 0.0:
        low = last_rising(law, cells, c, gamma, min(b, bend) if bend > 0.0 else b, 0.0)
    if b < bend and gamma + coefficient_slope(law, cells, c, bend) <= 0.0:
        return low, last_rising(law, cells, c, gamma, b, bend)
    near = max(b, bend)
    far = 2.0 * (near + cells[at.A4, c])
    for _ in range(MOST_DOUBLINGS):
        if gamma + coefficient_slope(law, cells, c, far) <= 0.0:
            return low, last_rising(law, cells, c, gamma, near, far)
        near, far = far, 2.0 * far
    return low, inf


@by_law()
def steepest(law, cells, c):
    """The largest slope that a first step on the curve of cell c must allow for, either way."""
    return abs(coefficient_slope(law, cells, c, cells[at.A4, c] * inflection(law, cells[at.DELTA, c])))


@compiled
def last_rising(law, cells, c, gamma, inside, outside):
    """Return where gamma + mu' > 0 ends on the way from one slip speed to another, between which it is monotone."""
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        if gamma + coefficient_slope(law, cells, c, middle) > 0.0:
            inside = middle
        else:
            outside = middle
    return inside


@compiled(inline=True)
def line_slope(w_reversal, mu_reversal, mu_stop):
    """Slope of the straight line from (w_reversal, mu_reversal) to (0, mu_stop): Eq. (2a)."""
    return (mu_reversal - mu_stop) / w_reversal


# --- the same for a table ---------------------------------------------------------------------------------------------


@compiled
def lowest(law, cells, c, low, high):
    """The least friction coefficient of cell c between two slip speeds, and where; inf if it falls for ever."""
    a4, delta = cells[at.A4, c], cells[at.DELTA, c]
    w, k = low, place(law.stations, low / a4) + 1
    least, where = coefficient(law, cells, c, w), w
    while w < high:
        end = min(a4 * law.stations[at.STATION, k], high) if k < at.STATIONS else high
        if end == inf:
            return least, inf if coefficient_slope(law, cells, c, w) < 0.0 else where
        for point in (min(a4 * bend_between(law, w / a4, end / a4, delta), end), end):
            if coefficient_slope(law, cells, c, w) < 0.0 < coefficient_slope(law, cells, c, point):
                bottom = last_rising(law, cells, c, 0.0, point, w)
                if coefficient(law, cells, c, bottom) < least:
                    least, where = coefficient(law, cells, c, bottom), bottom
            w = point
        if coefficient(law, cells, c, end) < least:
            least, where = coefficient(law, cells, c, end), end
        k += 1
    return least, where


@speed_of_minimum.of(Table)
def _speed_of_minimum(law, cells, c):
    """Where friction is least of all."""
    return lowest(law, cells, c, 0.0, inf)[1]


@least_coefficient.of(Table)
def _least_coefficient(law, cells, c, low, high):
    return lowest(law, cells, c, low, high)[0]


@steepest.of(Table)
def _steepest(law, cells, c):
    """That of standstill: steps do not skip what follows."""
    return abs(coefficient_slope(law, cells, c, 0.0))


@compiled
def end_of_rising(law, cells, c, inside, outside):
    """Where gamma + mu' > 0 ends on the way from one slip speed to another, no station between; NaN if it does not."""
    a4, gamma = cells[at.A4, c], cells[at.GAMMA, c]
    bend = a4 * bend_between(law, min(inside, outside) / a4, max(inside, outside) / a4, cells[at.DELTA, c])
    for point in (bend, outside):
        if not gamma + coefficient_slope(law, cells, c, point) > 0.0:
            return last_rising(law, cells, c, gamma, inside, point)
        inside = point
    return nan


@stable_speeds.of(Table)
def _stable_speeds(law, cells, c):
    b, a4 = abs(cells[at.BELT, c]), cells[at.A4, c]
    if not cells[at.GAMMA, c] + coefficient_slope(law, cells, c, b) > 0.0:
        return b, b
    first, low, high = place(law.stations, b / a4), 0.0, inf
    w, k = b, first
    while w > 0.0:
        station = a4 * law.stations[at.STATION, k] if k > 0 else 0.0
        low = end_of_rising(law, cells, c, w, min(station, w))
        if low >= 0.0:
            break
        w, k, low = min(station, w), k - 1, 0.0
    w, k = b, first + 1
    while k < at.STATIONS and law.stations[at.STATION, k] < inf:
        station = max(a4 * law.stations[at.STATION, k], w)
        high = end_of_rising(law, cells, c, w, station)
        if high >= 0.0:
            break
        w, k, high = station, k + 1, inf
    return low, high
