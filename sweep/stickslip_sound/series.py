"""The acceleration as a Fourier series, from samples of the displacement.

Where the contact breaks away or sticks again the acceleration jumps, so its own samples alias: their spectrum falls as
1/f only. The displacement has a continuous slope, and its spectrum falls as 1/f^3. So the displacement is sampled,
OVERSAMPLING times as often as the highest harmonic needs, transformed, and differentiated twice, which for a harmonic
is a factor: what is folded onto harmonic n is (n / (samples - n))^3 of what is there, 0.06 % for the highest one at
eightfold sampling, less for all others. No time of a jump has to be known.

Integration by parts at the ends is exact as well: a parabola takes the differences of displacement and velocity
between both ends away, so that the rest is periodic with a continuous slope, and its curvature is given back as the
mean acceleration. A stretch of any motion is thus a series too, though its last acceleration jumps to its first.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft  # type: ignore[import-untyped]

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

_TOGETHER = 2**17  # values that are summed at once: the angles of more of them lose digits
HIGHEST = 20e3  # Hz; what lies above is not heard
SWIFTEST = 4.0  # natural frequencies that a slip has
MOST_INTERVALS = 2**22
_FEW_SIZES = (4, 5, 6, 7)  # times a power of two: transforms of few different lengths, none a quarter too long


@dataclass(frozen=True)
class Series:
    """mean + the sum over n of 2 Re(harmonics[n - 1] exp(2 pi i n t / duration)), in m/s2.

    duration : of what is repeated (s). harmonics : complex amplitudes, from the first one on.
    """

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
        """The acceleration at `count` times from 0 on, `rate` a second, whatever part of the duration that is.

        Harmonics must lie below half the rate.
        """
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
    """The series of a motion over `duration` (s), with `count` harmonics.

    displacement : m, at evenly spaced times from the start to the end, both included. ends : velocities there, m/s.
    """
    samples = displacement.size - 1
    bend = (ends[1] - ends[0]) / duration
    along = np.arange(samples) / samples
    rise = displacement[-1] - displacement[0] - 0.5 * bend * duration**2
    periodic = displacement[:-1] - displacement[0] - along * (rise + 0.5 * bend * duration**2 * along)
    numbers = np.arange(1, min(count, (samples - 1) // 2) + 1)
    spectrum = fft.rfft(periodic, norm="forward")[1 : numbers.size + 1]
    return Series(duration, float(bend), -((2.0 * np.pi / duration * numbers) ** 2) * spectrum)


def samples_for(duration: Floats, highest: float, natural: Floats, oversampling: int) -> NDArray[np.int64]:
    """Return how many intervals to sample of motions over their durations (s), for tones up to `highest` (Hz).

    At least oversampling x 2 for each period of the highest tone, and of SWIFTEST times the natural frequency (Hz): the
    slip of a stiff contact is over within a fraction of the highest tone's period, and the spectrum of the displacement
    falls only above. No more than MOST_INTERVALS.
    """
    reach = np.maximum(highest, SWIFTEST * natural) * duration
    least = np.clip(2.0 * oversampling * reach, 64.0, MOST_INTERVALS)
    power = np.floor(np.log2(least)) - 2.0
    steps = np.array((*_FEW_SIZES, 8))
    return np.asarray((steps[np.searchsorted(steps, least / 2.0**power)] * 2.0**power).astype(np.int64))


def _chirp(harmonics: Complex, turn: float, count: int) -> Complex:
    """The sum over n >= 1 of harmonics[n - 1] exp(2 pi i n k turn), for k from 0 to count - 1: Bluestein's algorithm.

    With 2 n k = n^2 + k^2 - (k - n)^2 the sum is a convolution. (The exponents of `scipy.signal.czt` are powers of a
    rounded number; here the turns are reduced before they become angles.)
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
