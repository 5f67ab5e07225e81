"""What to measure next, in words: the material that is least certain first."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import xarray as xr

_HARDLY = 0.9  # of the width of an interval: what leaves more of it is hardly worth the work
_NUMBERS = ("next_speed_1", "next_speed_2", "quiet_above_low", "quiet_above_high", "next_low", "next_high")


def measurements(
    ds: xr.Dataset, unit: str, speed: Callable[[float], str], bound: Callable[[float], str]
) -> Iterator[str]:
    """For each material which points would narrow its interval most, and to what.

    speed, bound : a speed, and an end of an interval (m/s), as numbers in the unit.
    """
    names, hardly = [str(name) for name in ds["material"].values], []
    order = _least_certain(ds) if "next_speed_1" in ds else []
    for i in order:
        first, second, low, high, least, most = (float(ds[name].values[i]) for name in _NUMBERS)
        repeats = int(ds["repeats"].values[i]) if "repeats" in ds else 1
        which = " (the least certain)" if i == order[0] and len(order) > 1 else ""
        if math.isnan(first) and math.isnan(least):
            if which:
                yield f"{names[i]}{which}: too few of the curves drawn have a border to tell what to measure."
            continue
        if most - least > _HARDLY * (high - low) and i != order[0]:
            hardly.append(names[i])
            continue
        again = speed(first) == speed(second)
        place = f"twice at {speed(first)}" if again else f"at {speed(first)} and {speed(second)}"
        do = f"measure {place} {unit}" if repeats < 2 else f"measure another specimen, number {repeats + 1}"
        if first < float(ds["slowest_point"].values[i]):
            do += " (slower than any point, since no fall was seen)"
        ends = [bound(end) for end in (low, high, least, most)]
        shrunk = f"the interval would shrink from {ends[0]}..{ends[1]} to about {ends[2]}..{ends[3]}"
        yield f"{names[i]}{which}: {do}: {'its ends would stay open' if math.isnan(least) else shrunk}."
    for name in hardly:
        yield f"{name}: two more points would hardly narrow the interval."


def _least_certain(ds: xr.Dataset) -> list[int]:
    """Materials with an interval, the least certain first: by what the verdict at the belt speeds leaves open, then by
    the ratio of its ends."""
    low, high = ds["quiet_above_low"].values, ds["quiet_above_high"].values
    chance = (
        ds["quiet_probability"].values.reshape(low.size, -1) if "quiet_probability" in ds else np.ones((low.size, 1))
    )
    doubt = np.round(np.minimum(chance, 1.0 - chance).max(axis=1), 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(high > 0, high / low, 1.0)
    return sorted(np.flatnonzero(~np.isnan(low)).tolist(), key=lambda i: (-doubt[i], -np.nan_to_num(ratio[i], nan=1.0)))
