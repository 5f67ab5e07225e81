"""How the plate of a rig moves: segments of constant acceleration.

A segment is (duration in s, speed at its start in m/s, acceleration in m/s2). A test is a hold time (`waiting_time`),
then reciprocating strokes, each followed by standstill (`dwell`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PIECES = 64  # straight pieces of the speed of a sinusoidal stroke
_SINE_MEAN = 1.0 / (PIECES * math.tan(0.5 * math.pi / PIECES))  # of these pieces, over the top speed


def segments(profile: str, strokes: int, quantities: Mapping[str, float]) -> Floats:
    """The segments of a test, shape (m, 3).

    profile : "trapezoid" (from standstill to `belt_speed` within `ramp`, constant, and back) or "sine" (half a period,
        with `belt_speed` in its middle, in straight pieces). quantities : belt_speed, stroke, ramp, dwell,
        waiting_time.
    """
    stroke = _trapezoid(quantities) if profile == "trapezoid" else _sine(quantities)
    rest = np.array([[quantities["dwell"], 0.0, 0.0]])
    there, back = np.concatenate([stroke, rest]), np.concatenate([stroke * (1.0, -1.0, -1.0), rest])
    wait = np.array([[quantities["waiting_time"], 0.0, 0.0]])
    whole = np.concatenate([wait, *(back if n % 2 else there for n in range(strokes))])
    return np.asarray(whole[whole[:, 0] > 0.0])


def duration(profile: str, strokes: int, quantities: Mapping[str, Floats]) -> Floats:
    """Duration of tests from the first stroke on, s: arrays of the quantities of `segments`."""
    stroke = quantities["stroke"] / quantities["belt_speed"]
    once = stroke + quantities["ramp"] if profile == "trapezoid" else stroke / _SINE_MEAN
    return np.asarray(strokes * (once + quantities["dwell"]))


def _trapezoid(quantities: Mapping[str, float]) -> Floats:
    speed, ramp = quantities["belt_speed"], quantities["ramp"]
    plateau = max(quantities["stroke"] / speed - ramp, 0.0)
    return np.array([[ramp, 0.0, speed / ramp], [plateau, speed, 0.0], [ramp, speed, -speed / ramp]])


def _sine(quantities: Mapping[str, float]) -> Floats:
    """Speeds at the ends of the pieces lie on the sine; the stroke is that of the pieces, exactly."""
    share = np.linspace(0.0, 1.0, PIECES + 1)
    speed = quantities["belt_speed"] * np.sin(math.pi * share)
    speed[-1] = 0.0
    duration = quantities["stroke"] / np.trapezoid(speed, share)
    piece = duration / PIECES
    return np.stack([np.full(PIECES, piece), speed[:-1], np.diff(speed) / piece], axis=1)


def motion(drive: Floats, time: Floats) -> tuple[Floats, Floats]:
    """Speed and displacement of the plate at some times (s since the start of the drive)."""
    ends = np.cumsum(drive[:, 0])
    begins = ends - drive[:, 0]
    ways = drive[:, 0] * (drive[:, 1] + 0.5 * drive[:, 0] * drive[:, 2])
    at = np.minimum(np.searchsorted(ends, time, side="right"), len(drive) - 1)
    since = time - begins[at]
    speed = drive[at, 1] + drive[at, 2] * since
    return speed, (np.cumsum(ways) - ways)[at] + since * 0.5 * (drive[at, 1] + speed)
