"""Laws that come from outside: tables of measured friction, and shapes that people register.

Nothing is known of such a shape but its values and its slope. So it comes with *stations*, slip speeds z = w/a4 from 0
on, between which it is nearly a cubic, and its slope monotone; beyond the last it goes on as it does there. A step
passes one of them at most, so that none skips a spike, whose slope turns twice. What closed forms say of other laws is
found from station to station. They are numbers of a run, and travel in the tag.

Below z = 0, where a trial step may end, a shape goes on along its tangent.
"""

from math import inf
from typing import Any, NamedTuple

from ... import layout as at
from ...intrinsics import as_index, select
from ...jit import compiled
from . import laws
from .laws import shape, weakening_slope
from .recurrences import of_slope
from .taylor import expansion, find_coefficients

MARGIN = 1.25  # tangents bound a convex trough; the rest is for one that is not quite
MOST_PASSED, MOST_EXPANDED = 1.0, 3.0  # stations in a step; in one by a series, which tells more of what is ahead
HALVINGS = at.STATIONS.bit_length() - 1  # of the search among them
NOTHING = 1e-300
ROUNDING = 1e-12  # of slopes, to whose differences it matters


class Scanned(NamedTuple):
    """Tag of laws that are known by their stations; of each a class of its own is derived.

    stations : float64 (STATION_ROWS, STATIONS), `layout.py`: in the first two rows 0, what they hold from 0 on in
    order, and inf; 0.0 in tags of no run.
    """

    stations: Any


class Expanded(Scanned):
    """Tag of laws that bring a recurrence; of each a class of its own is derived."""


class Table(Scanned):
    """Tag of a piecewise cubic."""


LAWS: dict[str, Scanned] = {}


def add(name, kind, of_shape, of_slope):
    """Add a law of this name, a class derived from `Scanned`, to those that machines may have.

    of_shape, of_slope : the functions of laws `shape` and `weakening_slope`.
    """
    laws.with_stations.of(kind)(lambda law, stations: kind(stations))
    shape.of(kind)(of_shape)
    weakening_slope.of(kind)(of_slope)
    LAWS[name] = kind(0.0)


def add_functions(name, *plain):
    """Add a law given by two functions of (z, delta), z >= 0, and its recurrence (`recurrences.of_slope`), if any."""
    of_z, slope_of_z, *series = (getattr(one, "py_func", one) for one in plain)
    of_z, slope_of_z = (compiled(one, inline=True, keep=False) for one in (of_z, slope_of_z))

    def tangent(law, z, delta):
        return of_z(max(z, 0.0), delta) + min(z, 0.0) * slope_of_z(0.0, delta)

    def slope(law, z, x, drop, delta):
        return drop * slope_of_z(max(z, 0.0), delta)

    kind = type(name, (Expanded if series else Scanned,), {})
    add(name, kind, tangent, slope)
    for one in series:
        find_coefficients.of(kind)(expansion(of_slope(slope_of_z, one)))


@compiled(inline=True)
def place(stations, row, z):
    """Number of the last station, or knot, that is not above z; 0 below all."""
    k = 0
    for halving in range(HALVINGS):
        half = at.STATIONS >> (1 + halving)
        k += half * (z >= stations[row, as_index(k + half)])
    return as_index(k)


@compiled(inline=True)
def cubic(law, z, delta):
    """The cubic of the piece that z lies in; below 0, its tangent there."""
    s = law.stations
    k = place(s, at.KNOT, z)
    t = z - s[at.KNOT, k]
    return s[at.CUBIC_0, k] + t * (s[at.CUBIC_1, k] + t * (s[at.CUBIC_2, k] + t * s[at.CUBIC_3, k]))


@compiled(inline=True)
def cubic_slope(law, z, x, drop, delta):
    """drop times its slope."""
    s = law.stations
    k = place(s, at.KNOT, z)
    t = z - s[at.KNOT, k]
    return drop * (s[at.CUBIC_1, k] + t * (2.0 * s[at.CUBIC_2, k] + t * (3.0 * s[at.CUBIC_3, k])))


add("table", Table, cubic, cubic_slope)


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
    return 1.0 * place(law.stations, at.STATION, high) - 1.0 * place(law.stations, at.STATION, low)


def _next_station(law, z, way):
    """The station beyond z, or inf; downwards 0 at last, from where it is as far."""
    k = place(law.stations, at.STATION, z)
    if way > 0.0:
        return law.stations[at.STATION, k + 1] if k + 1 < at.STATIONS else inf
    if law.stations[at.STATION, k] == z:
        k -= 1
    return law.stations[at.STATION, k] if k >= 0 else -inf


laws.passes_unseen.of(Scanned)(
    lambda law, z, z_end, rise, rise_end: passed(law, z, z_end, rise, rise_end) > MOST_PASSED
)
laws.steps_over.of(Expanded)(
    lambda law, z, z_end, rise, rise_end: passed(law, z, z_end, rise, rise_end) > MOST_EXPANDED
)
laws.next_station.of(Scanned)(_next_station)
laws.has_kinks.of(Scanned)(lambda law: True)
laws.has_kinks.of(Expanded)(lambda law: False)
laws.bends.of(Expanded)(lambda law: True)


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
    k = place(law.stations, at.STATION, z) + 1
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
    slope, k = slope_at(law, z, delta), place(law.stations, at.STATION, z) + 1
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
