"""The specimen of a rig in a record: its stiffness, its mass, its motion, and the friction that moves it.

It is pulled by friction, its spring and its damper: friction is F + c v + m a in the direction of the drive, over the
load the coefficient; the slip speed is that of the drive less v. Place, speed and acceleration are one motion x(t), the
least squares of F = k x and a = x'' with the noise of either: slow changes come from the force, fast ones from the
acceleration.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import ndimage, optimize, stats  # type: ignore[import-untyped]
from scipy.integrate import cumulative_trapezoid  # type: ignore[import-untyped]
from scipy.linalg import solveh_banded  # type: ignore[import-untyped]

from stickslip.vocabulary.display_units import quantity
from stickslip_rig.drive_motion import drive_velocity
from stickslip_rig.records import condition_of, force_of
from stickslip_rig.signals import Flags, Floats, noise_of, runs_of, sample_rate
from stickslip_rig.sticks import Sticks

STEADY = 0.02  # of its speed, by which the drive may change during a slip
_FEWEST_SAMPLES, _FEWEST_SLIPS = 8, 3
_WRONG = 0.03  # of the stiffness: a difference that is said
_SURE = 4.0  # standard errors of a delay or a stiffness that is taken from the record
_LEFT = 0.2  # of the mean square of what rings: what a decaying oscillation may leave


class SpecimenMotion(NamedTuple):
    """What a record says of the specimen at each sample, in SI. noise : of the slip speed in sticks."""

    slip_speed: Floats
    friction: Floats
    acceleration: Floats
    drive: Floats
    noise: float
    stiffness: float
    mass: float


def motion_of(sticks: Sticks, load: float, tolerance: float, remarks: list[str]) -> SpecimenMotion:
    """The motion of the specimen, and with it slip speed and friction coefficient. Raises ValueError.

    remarks : gets what is not as the conditions of the record say.
    """
    drive = _drive(sticks, tolerance)
    sticks = _in_time(sticks, remarks)
    inside = _inside(sticks, drive)
    stiffness = _stiffness(sticks, drive, inside, remarks)
    mass = condition_of(sticks.record, "mass") or _ringing_mass(sticks, inside, stiffness, remarks)
    damping = condition_of(sticks.record, "damping") or 0.0
    step, force = 1.0 / sample_rate(sticks.time), force_of(sticks.record)
    if np.count_nonzero(inside) < _FEWEST_SAMPLES:
        inside = np.ones(force.size, np.bool_)
    acceleration = sticks.record["acceleration"].values
    acceleration = acceleration - np.median(acceleration[inside])
    noises = [max(noise_of(values[inside]), floor * float(np.abs(values).max()))
              for values, floor in ((force, 1e-6), (acceleration, 1e-3))]  # fmt: skip
    place = _fused(force / stiffness, acceleration * step**2, (noises[0] / (stiffness * noises[1] * step**2)) ** 2)
    velocity = np.gradient(place, step)
    bent = np.pad(np.diff(place, 2) / step**2, 1, mode="edge")
    friction = (stiffness * place + damping * velocity + mass * bent) / load
    noise = float(stats.median_abs_deviation((drive - velocity)[inside], scale="normal"))
    return SpecimenMotion(drive - velocity, friction, bent, drive, noise, stiffness, mass)


def _drive(sticks: Sticks, tolerance: float) -> Floats:
    """The velocity of the drive (m/s) at each sample. Raises ValueError."""
    velocity = drive_velocity(sticks.record, tolerance)
    if velocity is not None:
        return velocity
    if not (speed := condition_of(sticks.record, "drive_speed")):
        raise ValueError("the speed of the drive is not known: no column, no remark '# speed: 10 mm/s', no option")
    starts = sticks.ends[sticks.broke]
    signs = np.sign(force_of(sticks.record))[starts]
    nearest = np.searchsorted(starts, np.arange(sticks.time.size)).clip(max=max(starts.size - 1, 0))
    return np.asarray(speed * signs[nearest]) if starts.size else np.zeros(sticks.time.size)


def _delay(sticks: Sticks) -> tuple[float, float]:
    """How late the acceleration is (s) by how the force follows it through slips, and the standard error of that.

    F = k (x + delay v) with x, v the integrals of the acceleration, up to a straight line in each slip.
    """
    force, time = force_of(sticks.record), sticks.time
    acceleration = sticks.record["acceleration"].values - np.median(sticks.record["acceleration"].values)
    rows = []
    for start, end in zip(*sticks.slips(), strict=True):
        around = (end - start) // 2 + 2
        part = slice(max(start - around, 0), end + around)
        t = time[part] - time[part].mean()
        speed = cumulative_trapezoid(acceleration[part], t, initial=0)
        table = np.column_stack([cumulative_trapezoid(speed, t, initial=0), speed, force[part]])
        trend = np.column_stack([np.ones_like(t), t])
        free = table - trend @ np.linalg.lstsq(trend, table)[0]
        rows.append((free[:, :2].T @ free[:, :2], free[:, :2].T @ free[:, 2]))
    if len(rows) < _FEWEST_SLIPS:
        return 0.0, np.inf
    squares, products = (np.array(part) for part in zip(*rows, strict=True))
    inverse = np.linalg.pinv(squares.sum(0))
    best = inverse @ products.sum(0)
    score = products - squares @ best
    variance = (inverse @ (score.T @ score) @ inverse)[1, 1]
    return float(best[1] / best[0]), float(np.sqrt(variance) / abs(best[0]))


def _in_time(sticks: Sticks, remarks: list[str]) -> Sticks:
    """The phases with the acceleration at the time of the force: a sensor may delay it."""
    step, total = 1.0 / sample_rate(sticks.time), 0.0
    for _ in range(5):
        delay, error = _delay(sticks)
        if not abs(delay) > max(0.2 * step, _SURE * error):
            break
        total += delay
        values = sticks.record["acceleration"].values
        shifted = np.interp(sticks.time + delay, sticks.time, values)
        record = sticks.record.assign(acceleration=sticks.record["acceleration"].copy(data=shifted))
        sticks = replace(sticks, record=record)
    if total:
        remarks.append(f"the acceleration comes {quantity(total, 's')} after the force: it is shifted")
    return sticks


def _stiffness(sticks: Sticks, drive: Floats, inside: Flags, remarks: list[str]) -> float:
    """The stiffness (N/m): as given, or where that is not so, as the force rises in sticks."""
    given, force = condition_of(sticks.record, "stiffness"), force_of(sticks.record)
    way = cumulative_trapezoid(drive, sticks.time, initial=0)
    starts, ends = runs_of(inside)
    ends = starts + (ends - starts) // 2  # before the slow begin of a slip
    long = ends - starts > 0.5 * np.median(ends - starts) if starts.size else np.zeros(0, np.bool_)
    slopes = (force[ends] - force[starts])[long] / (way[ends] - way[starts])[long]
    seen, error = (
        (float(np.median(slopes)), float(stats.sem(slopes))) if slopes.size > _FEWEST_SLIPS else (np.nan, np.inf)
    )
    if given is not None and not abs(seen / given - 1.0) > max(_WRONG, _SURE * error / given):
        return given
    if not seen > 0:
        raise ValueError("the stiffness is not known, and sticks do not show it: give it as a remark or an option")
    what = f"in sticks the force rises as by a spring of {quantity(seen, 'N m-1')}"
    remarks.append(what if given is None else f"{what}, not {quantity(given, 'N m-1')}: it is taken; check the drive")
    return seen


def _ringing_mass(sticks: Sticks, inside: Flags, stiffness: float, remarks: list[str]) -> float:
    """The mass (kg) that rings on the spring after re-stick. Raises ValueError where nothing rings clearly."""
    rate, (starts, ends) = sample_rate(sticks.time), runs_of(inside)
    edge = (ends - starts) // 8
    starts, ends = starts + edge, ends - edge  # well behind the jump, and before slip begins
    length = int(np.median(ends - starts)) if starts.size else 0
    values = sticks.record["acceleration"].values
    rows = [values[a : a + length] for a, b in zip(starts, ends, strict=True) if b - a >= length]
    unknown = "the mass is not known, and nothing rings after re-stick: give it, as --mass '100 g' or '# mass: 100 g'"
    if length < 4 * _FEWEST_SAMPLES or not rows:
        raise ValueError(unknown)
    mean, t = np.mean(rows, axis=0), np.arange(length) / rate

    def left(ring: Sequence[float]) -> float:
        """What a decaying oscillation of this angular frequency and rate of decay leaves of the mean."""
        basis = np.exp(-ring[1] * t)[:, None] * np.stack([np.cos(ring[0] * t), np.sin(ring[0] * t)], axis=1)
        return float(np.sum((mean - basis @ np.linalg.lstsq(basis, mean)[0]) ** 2) / np.sum(mean**2))

    slowest = 2.0 * np.pi / t[-1]
    tried = [(turn, slowest / 3.0) for turn in np.geomspace(slowest, 0.5 * np.pi * rate, 200)]
    ring = optimize.minimize(left, min(tried, key=left), method="Nelder-Mead")
    if not (ring.fun < _LEFT and 0.0 < ring.x[1] < ring.x[0]):
        raise ValueError(unknown)
    mass, line = stiffness / float(ring.x @ ring.x), float(ring.x[0]) / (2.0 * np.pi)  # decay lowers the frequency
    remarks.append(
        f"the mass is taken from the ringing after re-stick, {quantity(line, 's-1')}: {quantity(mass, 'kg')}"
    )
    return float(mass)


def _inside(sticks: Sticks, drive: Floats) -> Flags:
    """True well inside of sticks under the full speed of the drive."""
    at_speed = np.abs(np.abs(drive) - np.abs(drive).max()) <= STEADY * np.abs(drive).max()
    return np.asarray(ndimage.binary_erosion(sticks.flags() & at_speed, np.ones(7)))


def _fused(place: Floats, bend: Floats, weight: float) -> Floats:
    """x of least (x - place)^2 + weight (second difference of x - bend)^2."""
    size = place.size
    bands = np.repeat([[weight], [-4.0 * weight], [1.0 + 6.0 * weight]], size, axis=1)
    bands[1, [1, -1]] = -2.0 * weight
    bands[2, [0, -1]], bands[2, [1, -2]] = 1.0 + weight, 1.0 + 5.0 * weight
    inner = np.pad(bend[1:-1], 2)
    return np.asarray(solveh_banded(bands, place + weight * np.diff(inner, 2)))
