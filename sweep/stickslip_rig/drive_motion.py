"""The motion of the drive, as a record shows it: its place, its velocity, and whether it is of use."""

import math

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid  # type: ignore[import-untyped]

from stickslip_rig.signals import (
    Floats,
    evenly,
    find_drops,
    noise_of,
    sample_rate,
    slope,
    slope_noise,
)

DRIVE = ("drive_displacement", "drive_velocity")
_WIDEST = 1 / 20  # of the record, a window
_QUIET = 0.25  # of the tolerance: how much of it the noise of the velocity may use up
_COUNTED = 3.0  # times the mean step: the smallest one of a place that is counted
_TURNED = 0.05  # of the way before: what turns back by less is noise
_MOSTLY = 0.8  # of the drops


def drive_displacement(record: xr.Dataset) -> Floats | None:
    """Position of the drive (m) at each sample, None where its motion is not known."""
    if "drive_displacement" in record:
        return np.asarray(record["drive_displacement"].values, np.float64)
    if "drive_velocity" not in record:
        return None
    return np.asarray(cumulative_trapezoid(record["drive_velocity"].values, record["time"].values, initial=0))


def drive_velocity(record: xr.Dataset, tolerance: float, narrowest: int = 5) -> Floats | None:
    """The velocity of the drive (m/s) at evenly spaced samples, smoothed as far as its noise needs.

    None where its motion is not known, or is too noisy to tell stick from slip.

    tolerance : of the slip speed. narrowest : samples, odd, over which a displacement is smoothed.
    """
    way, step = drive_displacement(record), 1.0 / sample_rate(record["time"].values)
    if way is None:
        return None
    own = record["drive_velocity"].values if "drive_velocity" in record else None
    if own is not None:
        way = np.asarray(cumulative_trapezoid(own, record["time"].values, initial=0))

    def scatter(width: int) -> float:
        if own is not None:
            return 1.1 * noise_of(own) / math.sqrt(width)
        return max(slope_noise(noise_of(way), step, width), 1.5 * counted_step(way) / (width * step))

    width = narrowest
    velocity = own if own is not None else slope(way, step, width)
    error = noise_of(own) if own is not None else scatter(width)
    while error > _QUIET * tolerance * float(np.quantile(np.abs(velocity), 0.99)):
        width = int(1.4 * width) | 1
        if width > _WIDEST * way.size:
            return None
        velocity, error = slope(way, step, width), scatter(width)
    return np.asarray(velocity, np.float64)


def counted_step(way: Floats) -> float:
    """The step (m) in which an encoder counts a place; 0 where it is not counted."""
    steps = np.abs(np.diff(way))
    least = float(steps[steps > 0].min(initial=np.inf))
    return least if np.isfinite(least) and least > _COUNTED * steps.mean() else 0.0


def unusable_drive(record: xr.Dataset, force: Floats, tolerance: float) -> str:
    """Why the motion of the drive is none, or says too little; nothing where it is of use, or not recorded.

    Whatever moves back while the force drops is the specimen: the drive goes on.
    """
    way, drops = drive_displacement(record), find_drops(force)
    if way is None or np.ptp(way) == 0:
        return ""
    lasting = drops.ends - drops.starts
    inside = (drops.starts >= lasting) & (lasting > 0)
    starts, ends = drops.starts[inside], drops.ends[inside]
    before, during = way[starts] - way[2 * starts - ends], way[ends] - way[starts]
    turned = (before * during < 0) & (np.abs(during) > np.maximum(4.0 * noise_of(way), _TURNED * np.abs(before)))
    if starts.size > 1 and turned.mean() > _MOSTLY:
        return "turns back whenever the force drops, as the specimen does"
    return "is too noisy to show when it moves" if drive_velocity(evenly(record), tolerance) is None else ""
