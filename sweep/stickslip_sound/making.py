"""The sound of one cell: the acceleration of its mass, at true pitch or slower.

Of a cycle the series of one period is computed, and summed at the times of the samples: exactly periodic, however long
it lasts. Other motions are a series of the stretch that is heard.

That of a record is made from an acceleration that was measured, or simulated on a rig.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from math import isfinite, nan, pi
from typing import Unpack

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, Results, Scales, SolverKeywords, compute, sampled
from stickslip.errors import NotReachedError
from stickslip.theory.contacts import static_friction
from stickslip.vocabulary.cells import Cells, Parameters, as_cells
from stickslip.vocabulary.flags import REGIMES, STATUS_MESSAGES, STATUSES
from stickslip.vocabulary.models import model_with
from stickslip_sound.cycles import RTOL, cycles_of
from stickslip_sound.series import HIGHEST, Series, samples_for, series_of
from stickslip_sound.sounds import FULL_SCALE, Sound

Floats = NDArray[np.float64]

RATE = 44_100  # samples a second
OVERSAMPLING = 8
_LEAD = 0.02  # s before a first break-away
_FADE = 0.005  # s, at both ends
_FINEST = 1000  # denominator of the ratio of two rates
_SETTLED = 2.0  # settling times after which a decay is far below what 16 bits hold
_REACHED = STATUSES.index("horizon_reached")


def of(
    cell: Mapping[str, float],
    seconds: float = 2.0,
    *,
    rate: int = RATE,
    slow: float = 1.0,
    full_scale: float = FULL_SCALE,
    transient: bool = False,
    title: str = "",
    **solver: Unpack[SolverKeywords],
) -> Sound:
    """Make the sound of a cell.

    Parameters
    ----------
    cell : Mapping of str to float
        As `simulate` takes it, a number each in SI.
    seconds : float
        How long it lasts.
    rate : int
        Samples a second.
    slow : float
        10 for ten times slower and lower, 0.1 for ten times faster.
    full_scale : float
        m/s2; sounds can be compared where theirs are equal.
    transient : bool
        The motion from its start, where the cell has a cycle as well. Without one it is always that, from the first
        break-away on.
    **solver
        law, rtol (1e-9) and max_steps, or options, as for `evaluate`.

    Returns
    -------
    Sound

    Raises
    ------
    TypeError, ValueError
        For bad input.
    NotReachedError
        Where the motion cannot be integrated so far.
    """
    checked(seconds=seconds, rate=rate, slow=slow, full_scale=full_scale)
    options = Options.of(SolverKeywords(**{"rtol": RTOL, **solver})).for_contact(cell)
    full = as_cells(cell, options.law)
    if full["mass"].size != 1:
        raise ValueError("a sound is that of one cell: give every parameter one number")
    results, count = compute(Cells.of(full), options).results, max(round(seconds * rate), 2)
    motion = _Motion(rate * slow, min(HIGHEST, 0.499 * rate) * slow, _LEAD / slow, options)
    cycles = cycles_of(full, results, options, motion.lead)
    regime, repeats = REGIMES[int(results["regime"][0])], bool(cycles.which.size) and not transient
    if regime == "failed":
        status = STATUSES[int(results["status"][0])]
        raise NotReachedError(f"this cell has no motion to listen to, {status}: {STATUS_MESSAGES[status]}")
    frequency = _frequency(full, results)
    if regime == "stuck" or frequency >= motion.highest:
        acceleration = np.zeros(count)
    elif not repeats:
        acceleration = _transient(full, results, motion, count)
    else:  # of a cycle longer than the sound a stretch
        duration = min(float(cycles.period[0]), count / motion.rate)
        series = motion.series(cycles.cells, duration, cycles.begin)
        if duration == cycles.period[0]:
            series = replace(series, mean=0.0)  # what is left of it is rounding
        acceleration = series.values(motion.rate, count)
    acceleration *= fades(count, rate)
    return Sound(acceleration, int(rate), float(slow), float(full_scale), regime, frequency, repeats, title)


@dataclass(frozen=True)
class _Motion:
    """Sampling of a motion, in its own time: `rate` values of the acceleration a second, tones up to `highest`
    (Hz), `lead` (s) before a break-away."""

    rate: float
    highest: float
    lead: float
    options: Options

    def series(self, cell: Parameters, duration: float, begin: Floats | float = 0.0) -> Series:
        """The series of the motion over a duration (s), from `begin` (s) on."""
        harmonics = int(self.highest * duration)
        intervals = samples_for(np.array([duration]), self.highest, Scales(cell).natural_frequency, OVERSAMPLING)
        motions, ends, status = sampled(cell, duration / intervals, intervals + 1, self.options, begin)
        if status[0] != _REACHED:
            name = STATUSES[int(status[0])]
            raise NotReachedError(f"the motion is not known to {duration:g} s, {name}: {STATUS_MESSAGES[name]}")
        return series_of(motions[0], ends[0], duration, harmonics)


def _transient(cell: Parameters, results: Results, motion: _Motion, count: int) -> Floats:
    """The motion from its first break-away on, or from the start where it slips at once, after a little silence."""
    first = float(results["breakaway_time"][0])
    if not isfinite(first) or not _sticks_at_first(cell):
        first = 0.0
    passed = max(0.0, first - motion.lead)
    # Until then the mass moves with the belt: what has passed is passed over, for the sake of the digits of the time.
    later = {"displacement": cell["displacement"] + cell["belt_speed"] * passed}
    later["contact_time"] = cell["contact_time"] + passed
    silent = min(round((motion.lead - (first - passed)) * motion.rate), count // 4)
    left = count - silent
    if (settled := _SETTLED * float(results["settling_time"][0])) > 0.0:
        left = max(min(left, int((first - passed + settled) * motion.rate)), 2)
    values = motion.series(cell | later, left / motion.rate).values(motion.rate, left)
    return np.concatenate([np.zeros(silent), values, np.zeros(count - silent - left)])


def _sticks_at_first(cell: Parameters) -> bool:
    """Return whether the contact holds at the start; else it slips at once, and its first break-away is a later one."""
    if not np.isnan(cell["velocity"][0]):
        return False
    mu = model_with(cell).static_of(cell)
    limit = static_friction(cell["contact_time"], mu, cell["ageing_rate"], cell["ageing_time"]) * Scales(cell).load
    return bool((np.abs(cell["stiffness"] * cell["displacement"] + cell["damping"] * cell["belt_speed"]) <= limit)[0])


def fades(count: int, rate: float) -> Floats:
    """Factors that rise from 0 and fall to 0 at the ends, as a cosine does."""
    length = min(round(_FADE * rate), count // 4)
    rise = 0.5 - 0.5 * np.cos(pi * np.arange(length) / max(length, 1))
    return np.concatenate([rise, np.ones(count - 2 * length), rise[::-1]])


def _frequency(cell: Parameters, results: Results) -> float:
    """Of the cycle; of the decay by linear theory; NaN where there is neither."""
    if results["period"][0] > 0.0:
        return float(results["frequency"][0])
    ratio = float(results["damping_ratio"][0])
    if REGIMES[int(results["regime"][0])] == "damped" and abs(ratio) < 1.0:
        natural = np.sqrt(1.0 - ratio * ratio) * Scales(cell).rate
        return float(results.get("growth_frequency", natural)[0]) / (2.0 * pi)
    return nan


def checked(**numbers: float) -> None:
    """Raise ValueError for a number that makes no sound."""
    for name, value in numbers.items():
        if not (isfinite(value) and value > 0):
            raise ValueError(f"{name}: got {value!r}, expected a number > 0")
    if numbers["rate"] != int(numbers["rate"]):
        raise ValueError(f"rate: got {numbers['rate']!r}, expected a whole number of samples a second")


def of_record(
    acceleration: Floats, record_rate: float, *, rate: int = RATE, slow: float = 1.0, full_scale: float = FULL_SCALE,
    title: str = "",
) -> Sound:  # fmt: skip
    """The sound of an evenly sampled acceleration (m/s2).

    record_rate : samples a second of the record; tones up to half of it are in the sound. rate, slow, full_scale : as
        for `of`. Resampled by a symmetric low-pass, unless the rates are equal. Raises ValueError.
    """
    checked(record_rate=record_rate, rate=rate, slow=slow, full_scale=full_scale)
    values = np.asarray(acceleration, np.float64)
    ratio = Fraction(rate * slow / record_rate).limit_denominator(_FINEST)
    if ratio != 1:
        from scipy import signal  # type: ignore[import-untyped]

        values = signal.resample_poly(values, ratio.numerator, ratio.denominator)
    values = values * fades(values.size, rate)
    return Sound(values, int(rate), float(slow), float(full_scale), "", nan, False, title)
