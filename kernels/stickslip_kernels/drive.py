"""The drive: a belt of constant speed, or one that keeps its acceleration from segment to segment.

The type of the tag says which. A steady belt is one segment, without acceleration, as long as the horizon.
"""

from typing import Any, NamedTuple

from . import layout as at
from .contacts import steady_friction
from .jit import by_type, compiled

ROUNDING = 1e-13  # of the time: what is left of a segment when it counts as over
SMALLEST_SPEED = 1e-12  # motion below it is negligible beside forces of the order of the load


class SteadyBelt(NamedTuple):
    """Tag of a belt that moves at the constant speed BELT of its cell."""

    code: int


class Segments(NamedTuple):
    """Tag of belts that follow segments.

    table : float64 (any, SEGMENT_COLUMNS). spans : float64 (n, 2), the first segment of each cell and the one past its
    last.
    """

    table: Any
    spans: Any


STEADY_BELT = SteadyBelt(0)
by_drive = by_type(lambda m, *_: m.types[m.fields.index("drive")], inline=True)


# --- what differs: here for the steady belt, below for segments -------------------------------------------------------


@by_drive
def open_drive(m, i, c):
    """Let the drive of cell c begin in lane i, forward being the direction of SIGMA = 1."""
    s, belt = m.s, m.cells[at.BELT, c]
    mu = steady_friction(m.contact, m.law, m.cells, c, abs(belt))
    s[at.XI_STAR + i] = mu if belt >= 0.0 else -mu
    s[at.B + i], s[at.ALPHA + i], s[at.FLOOR + i] = belt, 0.0, 1e-3 * abs(belt) + SMALLEST_SPEED
    s[at.TAU + i], s[at.TAU_END + i] = 0.0, m.cells[at.HORIZON, c]


@by_drive
def next_segment(m, i):
    """Open the next segment of lane i; False if there is none."""
    return False


@by_drive
def steady_load(m, i):
    """Displacement of steady sliding at the present speed of the belt, in the frame."""
    return m.s[at.SIGMA + i] * m.s[at.XI_STAR + i]


@by_drive
def keeps_direction(m, c):
    """Return whether the belt of cell c neither rests nor turns round."""
    return m.cells[at.BELT, c] != 0.0


@open_drive.of(Segments)
def _open_segments(m, i, c):
    first, last, fastest = int(m.drive.spans[c, 0]), int(m.drive.spans[c, 1]), 0.0
    for n in range(first, last):
        fastest = max(fastest, abs(m.drive.table[n, at.SEGMENT_BELT]))
    m.s[at.FLOOR + i], m.s[at.TAU_END + i] = 1e-3 * fastest + SMALLEST_SPEED, 0.0
    open_segment(m, i, first)


@keeps_direction.of(Segments)
def _keeps_direction_in_segments(m, c):
    first, last = int(m.drive.spans[c, 0]), int(m.drive.spans[c, 1])
    at_first = m.drive.table[first, at.SEGMENT_BELT]
    for n in range(first, last):
        b = m.drive.table[n, at.SEGMENT_BELT]
        b_end = b + m.drive.table[n, at.SEGMENT_ALPHA] * m.drive.table[n, at.SEGMENT_TIME]
        if not (b * at_first > 0.0 and b_end * at_first > 0.0):
            return False
    return True


@next_segment.of(Segments)
def _next_of_segments(m, i):
    n = int(m.s[at.SEGMENT + i]) + 1
    if n >= m.drive.spans[int(m.s[at.CELL + i]), 1]:
        return False
    open_segment(m, i, n)
    return True


@steady_load.of(Segments)
def _steady_load_of_moment(m, i):
    b = belt_in_lane(m, i, 0.0)
    mu = steady_friction(m.contact, m.law, m.cells, int(m.s[at.CELL + i]), abs(b))
    return mu if b >= 0.0 else -mu


# --- what follows ---------------------------------------------------------------------------------------------------


@compiled
def open_segment(m, i, n):
    """Let the drive of lane i enter segment number n, at the end of the one before."""
    s, sigma, table = m.s, m.s[at.SIGMA + i], m.drive.table
    s[at.SEGMENT + i] = n
    s[at.ALPHA + i] = sigma * table[n, at.SEGMENT_ALPHA]
    s[at.B + i] = sigma * table[n, at.SEGMENT_BELT] + s[at.G + i] * s[at.ALPHA + i]
    s[at.TAU + i] = s[at.TAU_END + i]
    s[at.TAU_END + i] += table[n, at.SEGMENT_TIME]


@compiled(inline=True)
def segment_is_over(s, i):
    """Return whether nothing but rounding is left of the segment of lane i."""
    return s[at.TAU_END + i] - s[at.TAU + i] <= ROUNDING * (1.0 + s[at.TAU + i])


@compiled(inline=True)
def pass_time(m, i, t):
    """Let a time t of the segment of lane i pass."""
    m.s[at.B + i] += m.s[at.ALPHA + i] * t
    m.s[at.TAU + i] += t


@compiled(inline=True)
def belt_in_lane(m, i, t):
    """Speed of the belt at t after the present state of lane i, in the frame."""
    return m.s[at.B + i] + (t - m.s[at.G + i]) * m.s[at.ALPHA + i]


@compiled(inline=True)
def flip(s, i):
    """Reverse the frame of lane i: what was forward is backward now."""
    s[at.SIGMA + i], s[at.ALPHA + i], s[at.B + i] = -s[at.SIGMA + i], -s[at.ALPHA + i], -s[at.B + i]
