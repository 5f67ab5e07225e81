"""The law of a table: a shape made of polynomials, which are numbers of a run, so that nothing is compiled for it.

Measured points and shapes that people register are such tables (`vocabulary/own_laws.py`). Between *knots*, slip speeds
z = w/a4 from 0 on, the shape is a polynomial each. Beside them a table has *stations*, between which it is nearly a
cubic, and its slope monotone; beyond the last it goes on as it does there. A step passes one of them at most, so that
none skips a spike, whose slope turns twice. What closed forms say of other laws is found from station to station.

Below z = 0, where a trial step may end, a shape goes on along its tangent.
"""

from math import inf, nan
from typing import Any, NamedTuple

from ... import layout as at
from ...arithmetic import bits_of, select
from ...jit import compiled
from ...linking import by_law, columns_at, with_stations
from . import laws
from .laws import inflection, last_weakening, shape, speed_of_shape_slope, weakening_slope

MARGIN = 1.25  # tangents bound a convex trough; the rest is for one that is not quite
MOST_PASSED = 1.0  # stations in a step
NOTHING = 1e-300
ROUNDING = 1e-12  # of slopes, to whose differences it matters


class Table(NamedTuple):
    """Tag of this law.

    stations : float64 (STATION_ROWS, STATIONS), `layout.py`: in the first two rows 0, what they hold from 0 on in
    order, and inf; 0.0 in tags of no run.
    """

    stations: Any


TABLES = {"table": Table(0.0)}


def _at_an_address(law, stations):
    return Table(columns_at(stations, (at.STATION_ROWS, at.STATIONS)))


with_stations.of(Table)(_at_an_address)


def search(row, starts):
    """The function that gives the number of the last station, or knot, that is not above z; 0 below all.

    Where to look follows from the bits of a number, which are nearly its logarithm.
    """

    @compiled(inline=True)
    def place(stations, z):
        bucket = (bits_of(z + at.BUCKET_START) >> at.BUCKET_SHIFT) - at.FIRST_BUCKET
        k = int(stations[starts, min(max(bucket, 0), at.STATIONS - 1)])
        k += z >= stations[row, k + 1]  # as a branch it would be mispredicted as often as not
        while z >= stations[row, k + 1]:
            k += 1
        return k

    return place


place, piece = search(at.STATION, at.STATION_BUCKETS), search(at.KNOT, at.KNOT_BUCKETS)


@shape.of(Table)
def of_piece(law, z, delta):
    """The polynomial of the piece that z lies in; below 0, its tangent there."""
    s = law.stations
    k = piece(s, z)
    t, p = z - s[at.KNOT, k], at.POWERS
    high = s[p + 3, k] + t * (s[p + 4, k] + t * s[p + 5, k])
    return s[p, k] + t * (s[p + 1, k] + t * (s[p + 2, k] + t * high))


@weakening_slope.of(Table)
def slope_of_piece(law, z, x, drop, delta):
    """drop times its slope."""
    s = law.stations
    k = piece(s, z)
    t, p = z - s[at.KNOT, k], at.POWERS
    high = 3.0 * s[p + 3, k] + t * (4.0 * s[p + 4, k] + t * (5.0 * s[p + 5, k]))
    return drop * (s[p + 1, k] + t * (2.0 * s[p + 2, k] + t * high))


# --- what steps must know ---------------------------------------------------------------------------------------------


@compiled(inline=True)
def passed(law, z, z_end, rise, rise_end):
    """The number of stations that a step may pass, over which z changes at these rates: tangents at its ends bound how
    far it goes beyond them.
    """
    beyond = MARGIN * abs(rise * rise_end) / (abs(rise) + abs(rise_end) + NOTHING)
    beyond = select(rise * rise_end < 0.0, beyond, 0.0)
    low = min(z, z_end) - select(rise < 0.0, beyond, 0.0)
    high = max(z, z_end) + select(rise > 0.0, beyond, 0.0)
    return 1.0 * place(law.stations, high) - 1.0 * place(law.stations, low)


def _next_station(law, z, way):
    """The station beyond z, or inf; downwards 0 at last, from where it is as far."""
    k = place(law.stations, z)
    if way > 0.0:
        return law.stations[at.STATION, k + 1] if k + 1 < at.STATIONS else inf
    if law.stations[at.STATION, k] == z:
        k -= 1
    return law.stations[at.STATION, k] if k >= 0 else -inf


laws.passes_unseen.of(Table)(lambda law, z, z_end, rise, rise_end: passed(law, z, z_end, rise, rise_end) > MOST_PASSED)
laws.next_station.of(Table)(_next_station)
laws.has_kinks.of(Table)(lambda law: True)


# --- the slope from station to station --------------------------------------------------------------------------------


@compiled(inline=True)
def slope_at(law, z, delta):
    """Slope of the shape at z."""
    return weakening_slope(law, z, 1.0, 1.0, delta)


@compiled
def bend_between(law, low, high, delta):
    """Return where, between two neighbours, the slope has its extremum; `high` where it has none inside."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    before, here, after = slope_at(law, low, delta), slope_at(law, middle, delta), slope_at(law, high, delta)
    part = 0.5 * (before - after) / (before - 2.0 * here + after)
    return middle + half * part if abs(part) < 1.0 else high


@compiled
def slopes_between(law, low, high, delta):
    """The least and the largest slope of the shape between two slip speeds."""
    z = max(low, 0.0)
    least = most = slope_at(law, z, delta)
    k = place(law.stations, z) + 1
    while z < high and k < at.STATIONS:
        end = min(law.stations[at.STATION, k], high)
        if end == inf:
            break
        for point in (bend_between(law, z, end, delta), end):
            slope = slope_at(law, point, delta)
            least, most = min(least, slope), max(most, slope)
        z, k = end, k + 1
    return least, most


@compiled
def is_concave_from(law, z, delta):
    """Return whether the slope of the shape is concave from z on: at stations, and half way between them."""
    slope, k = slope_at(law, z, delta), place(law.stations, z) + 1
    before = inf  # the bend up to z
    while k < at.STATIONS and law.stations[at.STATION, k] < inf:
        half = 0.5 * (law.stations[at.STATION, k] - z)
        for _ in range(2):
            last, z = slope, z + half
            slope = slope_at(law, z, delta)
            bend = (slope - last) / half
            if bend > before + ROUNDING * (abs(slope) + abs(last)) / half:
                return False
            before = bend
        k += 1
    return True


# --- the friction coefficient over the slip speed w = |v_rel|, of any law ---------------------------------------------
# In kernel units (`layout.py`): a1 and a3 are pure numbers, a2 is per unit of speed, a4 is a speed.


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


# Where friction is least of all.
speed_of_minimum.of(Table)(lambda law, cells, c: lowest(law, cells, c, 0.0, inf)[1])
least_coefficient.of(Table)(lambda law, cells, c, low, high: lowest(law, cells, c, low, high)[0])
# That of standstill: steps do not skip what follows.
steepest.of(Table)(lambda law, cells, c: abs(coefficient_slope(law, cells, c, 0.0)))


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
