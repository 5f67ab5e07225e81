"""How loud cells are: the time-average A-weighted level of the acceleration, from one period of their cycles.

The mean square of a periodic acceleration is the sum of those of its harmonics, each weighted by its frequency: no more
than one period has to be sampled. Where the mass sticks for long, even less: the weighting has forgotten a slip after
a quarter of a second, so that the slip alone is sampled, and the rest of the period is silence.

A-weighting: how much less the ear hears of low and very high tones.

The analytic formula of IEC 61672-1:2013, Annex E: four poles at 20.6 and 12194 Hz, one each at 107.7 and 737.9 Hz, and
0 dB at 1 kHz.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.engine import Options, Results, StopFlag, sampled, solve
from stickslip.errors import StoppedError
from stickslip.sound.cycles import Cycles, cycles_of
from stickslip.sound.series import natural_frequency, samples_for, series_of
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.flags import STATUSES

Floats = NDArray[np.float64]
HIGHEST = 20e3  # Hz; what lies above is not heard, and not summed
_POLES = 20.598997, 107.65265, 737.86223, 12194.217  # Hz


def _unscaled(frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    f2 = frequency * frequency
    one, two, three, four = (pole * pole for pole in _POLES)
    return np.asarray(four * f2 * f2 / ((f2 + one) * np.sqrt((f2 + two) * (f2 + three)) * (f2 + four)))


_AT_1_KHZ = float(_unscaled(np.array(1000.0)))


def a_weighting(frequency: ArrayLike) -> NDArray[np.float64]:
    """The factor on the amplitude of a tone of a frequency (Hz): 1 at 1 kHz, 0 at 0."""
    return _unscaled(np.asarray(frequency, np.float64)) / _AT_1_KHZ


def decibels(factor: ArrayLike) -> NDArray[np.float64]:
    """A ratio of amplitudes in dB; -inf for 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(20.0 * np.log10(np.asarray(factor, np.float64)))


REFERENCE = 1e-6  # m/s2, ISO 1683
OVERSAMPLING = 2  # folds a little onto the highest harmonics: less than 0.01 dB in all
FORGOTTEN = 0.25  # s after which the weighting, whose slowest poles lie at 20.6 Hz, has fallen by exp(-32)
MOST_HARMONICS = 2**17  # of a slip: one that takes longer than 6.5 s is summed up to less than 20 kHz
CLEAR = 100.0  # what is less than so many times the rounding of the samples, in its square, is none
_MOST_SAMPLES = 2**20  # at once
_REACHED = STATUSES.index("horizon_reached")


def levels_of(cells: Parameters, options: Options, stop: StopFlag) -> tuple[Results, Floats]:
    """Return what becomes of some cells, by names of `VARIABLES`, and their levels in dB, in this thread.

    NaN where there is no cycle, or its integration failed; -inf where nothing of it is heard: it is all above 20 kHz,
    or a vibration so slow and smooth that its audible harmonics are lost in rounding. The numbers of a cell do not
    depend on the others. Raises StoppedError once `stop` is raised.
    """
    size = cells["mass"].size
    results = solve(cells, options, stop)
    cycles, level = cycles_of(cells, results), np.full(size, np.nan)
    windows = np.minimum(cycles.moving + FORGOTTEN, cycles.period)
    harmonics = np.minimum((HIGHEST * windows).astype(np.int64), MOST_HARMONICS)
    intervals = samples_for(windows, HIGHEST, natural_frequency(cycles.cells), OVERSAMPLING)
    for some in _together(intervals):
        if stop[0]:
            raise StoppedError
        level[cycles.which[some]] = _levels(cycles, some, windows, harmonics, intervals, options)
    return results, level


def _together(intervals: NDArray[np.int64]) -> Iterator[slice]:
    """Neighbours that are sampled at once."""
    first, total = 0, 0
    for i, number in enumerate(intervals.tolist()):
        if total and total + number > _MOST_SAMPLES:
            yield slice(first, i)
            first, total = i, 0
        total += number
    if total:
        yield slice(first, intervals.size)


def _levels(
    cycles: Cycles,
    some: slice,
    windows: Floats,
    harmonics: NDArray[np.int64],
    intervals: NDArray[np.int64],
    options: Options,
) -> Floats:
    """The levels of the cycles in a slice, dB."""
    own = taken(cycles.cells, some)
    window, count = windows[some], intervals[some]
    motions, ends, status = sampled(own, window / count, count + 1, options)
    squares = np.full(window.size, np.nan)
    for i in np.flatnonzero(status == _REACHED).tolist():
        series = series_of(motions[i], ends[i], float(window[i]), int(harmonics[some][i]))
        weights = a_weighting(series.frequencies) ** 2
        rounding = np.finfo(float).eps * np.abs(motions[i]).max() * (2.0 * np.pi * series.frequencies) ** 2
        noise = 2.0 * (weights * rounding**2).sum() / count[i]
        heard = (series.mean_squares * weights).sum()
        squares[i] = heard if heard > CLEAR * noise else 0.0
    return decibels(np.sqrt(squares * window / cycles.period[some]) / REFERENCE)
