"""Where a noisy signal turns: its peaks and troughs, swings smaller than a threshold left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.rig.records.sampling import Floats, noise_of

_SHARE = 0.02  # of the largest force: the smallest drop that counts unless something else is said
_NOISES = 10.0  # standard deviations of the noise that a swing must exceed; the range of a million samples


def turning_points(values: Floats, threshold: float) -> NDArray[np.intp]:
    """Positions of alternating peaks and troughs, each swing between them at least `threshold` high.

    The first and the last position are where the first and the last swing begin and end as far as is seen; the last
    swing may be unfinished. Empty if no swing is as high.
    """
    candidates = _reduced(values, _extrema(values), threshold)
    found: list[int] = []
    low = high = int(candidates[0])
    rising: bool | None = None
    for i in candidates.tolist():
        value = values[i]
        high = i if value > values[high] else high
        low = i if value < values[low] else low
        if rising is not False and values[high] - value >= threshold:
            found += [low, high] if rising is None and low < high else [high]
            rising, low, high = False, i, i
        elif rising is not True and value - values[low] >= threshold:
            found += [high, low] if rising is None and high < low else [low]
            rising, low, high = True, i, i
    if rising is None:
        return np.empty(0, np.intp)
    return np.array([*found, high if rising else low], np.intp)


def _extrema(values: Floats) -> NDArray[np.intp]:
    """Positions of all local extrema, and both ends."""
    slopes = np.sign(np.diff(values))
    moving = np.flatnonzero(slopes)
    turns = moving[1:][slopes[moving[1:]] != slopes[moving[:-1]]]
    return np.concatenate([[0], turns, [values.size - 1]]).astype(np.intp)


def _reduced(values: Floats, turns: NDArray[np.intp], threshold: float) -> NDArray[np.intp]:
    """Extrema without the swings that are below the threshold and lie within both of their neighbours.

    Such a swing, of a pair of extrema, neither begins nor ends one that counts. With each pair its neighbours grow, so
    that few passes leave few extrema, however noisy the signal.
    """
    while turns.size > 3:
        swings = np.abs(np.diff(values[turns]))
        inner = swings[1:-1]
        within = (inner < threshold) & (inner <= swings[:-2]) & (inner < swings[2:])  # never two beside each other
        if not within.any():
            break
        first = np.flatnonzero(within) + 1
        turns = np.delete(turns, np.concatenate([first, first + 1]))
    return turns


@dataclass(frozen=True)
class Drops:
    """Drops of the friction force: positions of the sample before and of the one after each, and sizes (N)."""

    starts: NDArray[np.intp]
    ends: NDArray[np.intp]
    sizes: Floats


def find_drops(force: Floats, smallest: float | None = None) -> Drops:
    """Every drop of the magnitude of the force from a peak to the next trough.

    smallest : size (N) from which a drop counts; None for a fiftieth of the largest force, or ten standard deviations
    of the noise if that is more. A drop through zero is a reversal of the drive and not one of friction; nor does one
    count that does not end within the record.
    """
    least = smallest if smallest is not None else max(_SHARE * float(np.abs(force).max()), _NOISES * noise_of(force))
    turns = turning_points(force, least) if least > 0 else np.empty(0, np.intp)
    before, after = turns[:-2], turns[1:-1]  # the last swing is unfinished
    size = np.abs(force[before]) - np.abs(force[after])
    falls = (size > 0) & (force[before] * force[after] >= 0)
    return Drops(before[falls], after[falls], size[falls])
