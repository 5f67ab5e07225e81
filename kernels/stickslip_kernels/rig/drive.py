"""The drive of a rig: segments in which the belt keeps its acceleration."""

from ..jit import compiled
from ..layout import (
    ALPHA, B, CELL, G, LAST_SEGMENT, RIG_SEGMENT, SEGMENT_ALPHA, SEGMENT_BELT, SEGMENT_TIME, SIGMA, TAU, TAU_END,
)  # fmt: skip

ROUNDING = 1e-13  # of the time: what is left of a segment when it counts as over


@compiled(inline=True)
def open_segment(s, i, segments, n):
    """Let the drive of lane i enter segment number n, at the end of the one before."""
    sigma = s[SIGMA + i]
    s[RIG_SEGMENT + i] = n
    s[ALPHA + i] = sigma * segments[n, SEGMENT_ALPHA]
    s[B + i] = sigma * segments[n, SEGMENT_BELT] + s[G + i] * s[ALPHA + i]
    s[TAU + i] = s[TAU_END + i]
    s[TAU_END + i] += segments[n, SEGMENT_TIME]


@compiled(inline=True)
def next_segment(s, i, segments, runs):
    """Open the next segment of lane i; False if there is none."""
    n = int(s[RIG_SEGMENT + i]) + 1
    if n >= runs[int(s[CELL + i]), LAST_SEGMENT]:
        return False
    open_segment(s, i, segments, n)
    return True


@compiled(inline=True)
def segment_is_over(s, i):
    """Whether nothing but rounding is left of the segment of lane i."""
    return s[TAU_END + i] - s[TAU + i] <= ROUNDING * (1.0 + s[TAU + i])


@compiled(inline=True)
def pass_time(s, i, t):
    """Let a time t of the segment of lane i pass."""
    s[B + i] += s[ALPHA + i] * t
    s[TAU + i] += t


@compiled(inline=True)
def belt_in_lane(s, i, t):
    """Speed of the belt at t after the start of the step of lane i."""
    return s[B + i] + (t - s[G + i]) * s[ALPHA + i]


@compiled(inline=True)
def flip(s, i):
    """Look at lane i from the other side: forward in its frame is backward now."""
    s[SIGMA + i], s[ALPHA + i], s[B + i] = -s[SIGMA + i], -s[ALPHA + i], -s[B + i]
