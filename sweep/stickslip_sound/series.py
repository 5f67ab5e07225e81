"""The acceleration of a cycle as a Fourier series, from samples of the displacement over one period.

Where the contact breaks away or sticks again the acceleration jumps, so its own samples alias: their spectrum falls as
1/f only. The displacement has a continuous slope, and its spectrum falls as 1/f^3. So the displacement is sampled,
OVERSAMPLING times as often as the highest harmonic needs, transformed, and differentiated twice, which for a harmonic
is a factor: what is folded onto harmonic n is (n / (samples - n))^3 of what is there, 0.06 % for the highest one at
eightfold sampling, less for all others. No time of a jump has to be known.

Integration by parts at the ends is exact as well: a parabola takes the differences of displacement and velocity
between both ends away, so that the rest is periodic with a continuous slope, and its curvature is given back as the
mean acceleration. A stretch of any motion is thus a series too, though its last acceleration jumps to its first.

A cycle with a stick phase begins a little before its break-away: there the mass moves with the belt, and the load on
the contact says where it is. One without begins at the largest displacement along the belt, at rest, where friction
lies on the curve whatever came before. Both follow from what the kernels say of a cell. A contact with memory has a
state that no start can set: it is followed from its start until a period repeats, and sampled from there on.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft  # type: ignore[import-untyped]

from stickslip.engine import Options, Results, Scales, sampled
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.quantities import REGIMES, STATUSES

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_TOGETHER = 2**17  # values that are summed at once: the angles of more of them lose digits
HIGHEST = 20e3  # Hz; what lies above is not heard
SWIFTEST = 4.0  # natural frequencies that a slip has
MOST_INTERVALS = 2**22
_FEW_SIZES = (4, 5, 6, 7)  # times a power of two: transforms of few different lengths, none a quarter too long
RTOL = 1e-9  # of the motion, so that its errors are not heard beside it
LEAD = 0.02  # s of sticking before a break-away, at most
_PERIODIC = REGIMES.index("stick_slip"), REGIMES.index("sustained")
REACHED = STATUSES.index("horizon_reached")
_FIRST, _DOUBLINGS = 8.0, 10  # periods that are waited for the cycle, and how often as many again
_ALIKE = 1e-6  # of their ranges: displacements and velocities a period apart, on the cycle
_PLACES = 1024  # of a period, which show where it slips
_STUCK, _QUIET = 1e-2, 1e-3  # of the belt speed, and of the fastest slip: what slips less is not heard
_PAUSE = 4  # places at least, of a stick phase
_CLOSER = 3  # looks, each at what slipped in the one before


@dataclass(frozen=True)
class Series:
    """mean + the sum over n of 2 Re(harmonics[n - 1] exp(2 pi i n t / duration)), in m/s2."""

    duration: float
    mean: float
    harmonics: Complex

    @property
    def frequencies(self) -> Floats:
        """Of the harmonics, Hz."""
        return np.arange(1, self.harmonics.size + 1) / self.duration

    @property
    def mean_squares(self) -> Floats:
        """Return what each harmonic contributes to the mean square of the acceleration, (m/s2)^2."""
        return 2.0 * (self.harmonics.real**2 + self.harmonics.imag**2)

    def values(self, rate: float, count: int) -> Floats:
        """The acceleration at `count` times from 0 on, `rate` a second, which is more than twice any harmonic's."""
        if self.harmonics.size == 0:
            return np.full(count, self.mean)
        per_duration = rate * self.duration
        whole = round(per_duration)
        if count <= whole and abs(per_duration - whole) <= 1e-12 * whole:
            spectrum = np.zeros(whole // 2 + 1, np.complex128)
            spectrum[1 : self.harmonics.size + 1] = self.harmonics
            return np.asarray(self.mean + fft.irfft(spectrum, whole, norm="forward")[:count])
        values, turn = np.empty(count), 1.0 / per_duration
        numbers = np.arange(1, self.harmonics.size + 1)
        for first in range(0, count, _TOGETHER):
            part = values[first : first + _TOGETHER]
            turned = self.harmonics * np.exp(2j * np.pi * (numbers * (first * turn % 1.0) % 1.0))
            part[:] = self.mean + 2.0 * _chirp(turned, turn, part.size).real
        return values


def series_of(displacement: Floats, ends: Floats, duration: float, count: int) -> Series:
    """The series of a motion over `duration` (s), with `count` harmonics, from displacements (m) at even times, both
    ends included, and the velocities at the ends (m/s)."""
    samples = displacement.size - 1
    bend = (ends[1] - ends[0]) / duration
    along = np.arange(samples) / samples
    rise = displacement[-1] - displacement[0] - 0.5 * bend * duration**2
    periodic = displacement[:-1] - displacement[0] - along * (rise + 0.5 * bend * duration**2 * along)
    numbers = np.arange(1, min(count, (samples - 1) // 2) + 1)
    spectrum = fft.rfft(periodic, norm="forward")[1 : numbers.size + 1]
    return Series(duration, float(bend), -((2.0 * np.pi / duration * numbers) ** 2) * spectrum)


def samples_for(duration: Floats, highest: float, natural: Floats, oversampling: int) -> NDArray[np.int64]:
    """How many intervals to sample of motions over their durations (s), for tones up to `highest` (Hz).

    At least oversampling x 2 for each period of the highest tone, and of SWIFTEST times the natural frequency (Hz): a
    stiff contact slips within a fraction of the tone's period, and the spectrum of the displacement falls only above.
    """
    reach = np.maximum(highest, SWIFTEST * natural) * duration
    least = np.clip(2.0 * oversampling * reach, 64.0, MOST_INTERVALS)
    power = np.floor(np.log2(least)) - 2.0
    steps = np.array((*_FEW_SIZES, 8))
    return np.asarray((steps[np.searchsorted(steps, least / 2.0**power)] * 2.0**power).astype(np.int64))


def _chirp(harmonics: Complex, turn: float, count: int) -> Complex:
    """The sum over n >= 1 of harmonics[n - 1] exp(2 pi i n k turn), for k from 0 to count - 1: Bluestein's algorithm.

    With 2 n k = n^2 + k^2 - (k - n)^2 it is a convolution. (The exponents of `scipy.signal.czt` are powers of a rounded
    number; here the turns are reduced before they become angles.)
    """
    first, last = 1, harmonics.size
    size = fft.next_fast_len(count + last)
    k = np.arange(max(count, last + 1))
    chirp = np.exp(1j * np.pi * ((turn * k) * k % 2.0))
    weighted = np.zeros(size, np.complex128)
    weighted[first : last + 1] = harmonics * chirp[first : last + 1]
    kernel = np.zeros(size, np.complex128)
    kernel[:count] = np.conj(chirp[:count])
    kernel[size - last :] = np.conj(chirp[last:0:-1])
    return np.asarray(chirp[:count] * fft.ifft(fft.fft(weighted) * fft.fft(kernel))[:count])


# --- where cycles begin -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class StartedCycles:
    """Cells that have a cycle, started on it: their numbers among all, and their parameters with start states.

    moving : s from the start until the mass sticks again; the period where it never does. begin : s after the start
    state, where that is not on the cycle.
    """

    which: NDArray[np.intp]
    cells: Parameters
    period: Floats
    moving: Floats
    begin: Floats


def cycles_of(cells: Parameters, results: Results, options: Options, lead: float = LEAD) -> StartedCycles:
    """The cycles of cells whose results are known; lead : s of sticking before the break-away, at most."""
    which = np.flatnonzero(np.isin(results["regime"], _PERIODIC) & (results["period"] > 0.0))
    own, results = taken(cells, which), taken(results, which)
    if "mu_breakaway" not in results:
        return _followed(which, own, results, options)
    sticks = results["regime"] == _PERIODIC[0]
    period, sticking = results["period"], np.where(sticks, results["stick_fraction"] * results["period"], 0.0)
    belt, ahead = own["belt_speed"], np.minimum(0.5 * sticking, lead)
    forward = belt > 0.0
    force = np.where(forward, results["cycle_force_max"], results["cycle_force_min"])
    load = np.where(forward, 1.0, -1.0) * results["mu_breakaway"] * Scales(own).load
    force = np.where(sticks, load - own["damping"] * belt - own["stiffness"] * belt * ahead, force)
    start = {
        "displacement": force / own["stiffness"],
        "velocity": np.where(sticks, np.nan, 0.0),
        "contact_time": np.where(sticks, sticking - ahead, 0.0),
    }
    moving = np.where(sticks, ahead + period - sticking, period)
    return StartedCycles(which, own | start, period, moving, np.zeros(which.size))


def _followed(which: NDArray[np.intp], cells: Parameters, results: Results, options: Options) -> StartedCycles:
    """Cycles that are followed until a period repeats; those that never do are left out."""
    period, begin, moving = results["period"], np.full(which.size, np.nan), np.array(results["period"])
    waiting, wait = np.arange(which.size), _FIRST
    for _ in range(_DOUBLINGS):
        if not waiting.size:
            break
        periods, counts = period[waiting], np.full(waiting.size, _PLACES + 1)
        motions, ends, status = sampled(taken(cells, waiting), periods / _PLACES, counts, options, wait * periods)
        apart = np.array([abs(x[-1] - x[0]) / np.ptp(x) for x in motions])
        apart = np.maximum(apart, np.abs(ends[:, 1] - ends[:, 0]) / (2.0 * results["velocity_amplitude"][waiting]))
        repeats = (status == REACHED) & (apart < _ALIKE)
        begin[waiting[repeats]] = wait * period[waiting[repeats]]
        waiting, wait = waiting[~repeats], 2.0 * wait
    known = np.flatnonzero(np.isfinite(begin))
    for i in known:
        begin[i], moving[i] = _slip(taken(cells, slice(i, i + 1)), begin[i], period[i], options)
    return StartedCycles(which[known], taken(cells, known), period[known], moving[known], begin[known])


def _slip(cell: Parameters, begin: float, window: float, options: Options) -> tuple[float, float]:
    """From when on a cell slips in a period from `begin` on, and for how long, all its slips; the rest is silence."""
    for _ in range(_CLOSER):
        step = window / _PLACES
        (x,), *_ = sampled(cell, np.array([step]), np.array([_PLACES + 1]), options, begin)
        slipped = np.abs(np.diff(x) - cell["belt_speed"] * step)
        moves = np.flatnonzero(slipped > max(_STUCK * abs(float(cell["belt_speed"][0])) * step, _QUIET * slipped.max()))
        gaps = np.diff(np.append(moves, moves[:1] + _PLACES))  # the longest stick phase is what is left out
        longest = int(np.argmax(gaps))
        if gaps[longest] < _PAUSE:
            break
        begin += (int(moves[(longest + 1) % moves.size]) - 1) * step
        window = (_PLACES - int(gaps[longest]) + 3) * step
    return begin, window
