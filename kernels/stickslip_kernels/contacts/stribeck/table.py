"""The law of a table: a shape made of polynomials, which are numbers of a run, so that nothing is compiled for it.

Measured points and shapes that people register are such tables (`vocabulary/own_laws.py`). Between *knots*, slip speeds
z = w/a4 from 0 on, the shape is a polynomial each. Beside them a table has *stations*, between which it is nearly a
cubic, and its slope monotone; beyond the last it goes on as it does there. A step passes one of them at most, so that
none skips a spike, whose slope turns twice. What closed forms say of other laws is found from station to station.

Below z = 0, where a trial step may end, a shape goes on along its tangent.
"""

from math import inf
from typing import Any, NamedTuple

from ... import layout as at
from ...intrinsics import bits_of, select
from ...jit import compiled
from ...linking import columns_at, with_stations
from . import laws
from .laws import shape, weakening_slope

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


LAWS = {"table": Table(0.0)}


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
