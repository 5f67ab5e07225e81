"""Signals: evenly spaced samples, gaps, smoothed slopes, band limits, spectra, turning points and drops."""

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy import ndimage, signal  # type: ignore[import-untyped]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Positions = NDArray[np.intp]

_GAP = 3.0  # times the usual step
_EVEN = 0.02  # of the mean step: how far a step may differ, as it does when times were rounded
_SHORT = 128  # samples of a window that are summed directly
_ORDER = 4  # of the Butterworth filter that stands for a sensor
_SHARE = 0.02  # of the largest force: the smallest drop that counts unless something else is said
_NOISES = 10.0  # standard deviations of the noise that a swing must exceed; the range of a million samples


def sample_rate(time: Floats) -> float:
    """Samples per second, mean."""
    return (time.size - 1) / float(time[-1] - time[0])


def gaps_of(time: Floats) -> Positions:
    """Positions of the samples before gaps: steps far longer than they usually are, and than those around them."""
    steps = np.diff(time)
    low, high = np.quantile(steps, [0.1, 0.9])
    usual = float(high + 3.0 * (high - low))
    if not steps.max() > _GAP * usual:
        return np.empty(0, np.intp)
    around = ndimage.median_filter(steps, 9, mode="nearest")
    return np.asarray(np.flatnonzero((steps > _GAP * usual) & (steps > _GAP * around)))


def closed(time: Floats, gaps: Positions) -> Floats:
    """The times as if gaps had the usual step: over these, no integral bridges one."""
    if not gaps.size:
        return time
    steps = np.diff(time)
    steps[gaps] = np.median(steps)
    return np.concatenate([time[:1], time[0] + np.cumsum(steps)])


def runs_of(inside: Flags) -> tuple[Positions, Positions]:
    """First and last positions of the intervals in which `inside` holds."""
    changes = np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8))
    return np.flatnonzero(changes == 1), np.flatnonzero(changes == -1) - 1


def within(starts: Positions, ends: Positions, size: int) -> Flags:
    """True for each of `size` samples that lies in one of the intervals, which do not overlap."""
    changes = np.zeros(size + 1, np.int8)
    changes[starts] = 1
    changes[ends + 1] -= 1
    return np.asarray(np.cumsum(changes[:-1], dtype=np.int8) > 0)


def evenly(record: xr.Dataset) -> xr.Dataset:
    """The record at evenly spaced times: itself if they are, else with its signals interpolated linearly.

    As many as there are samples, and those that gaps lack.
    """
    time = record["time"].values
    step = 1.0 / sample_rate(time)
    if np.abs(np.diff(time) - step).max() <= _EVEN * step:
        return record
    gaps = gaps_of(time)
    lacking = np.rint(np.diff(time)[gaps] / np.median(np.diff(time))).sum() - gaps.size if gaps.size else 0
    even = np.linspace(time[0], time[-1], time.size + int(lacking))
    signals = {}
    for name, variable in record.data_vars.items():
        values = np.interp(even, time, variable.values)
        is_flag = variable.dtype.kind in "iub"
        signals[name] = (variable.dims, np.rint(values).astype(np.int8) if is_flag else values, variable.attrs)
    coordinates = {name: c for name, c in record.coords.items() if name != "time"}
    return xr.Dataset(signals, {"time": ("time", even, record["time"].attrs), **coordinates}, record.attrs)


def noise_of(values: Floats) -> float:
    """Standard deviation of white noise on a signal that is smooth most of the time.

    The median magnitude of its second differences over 0.6745 sqrt(6); jumps and kinks, being rare, do not count.
    """
    return float(np.median(np.abs(np.diff(values, 2)))) / (0.6745 * math.sqrt(6.0))


def slope(values: Floats, step: float, width: int) -> Floats:
    """Rate of change of evenly spaced samples: that of a straight line through `width` (odd, >= 3) of them."""
    if width <= _SHORT or values.size < 4 * width:
        return np.asarray(signal.savgol_filter(values, width, 1, deriv=1, delta=step, mode="interp"))
    line = signal.savgol_coeffs(width, 1, deriv=1, delta=step)
    inner = signal.oaconvolve(values, line, mode="valid")  # the same sums, in a time that hardly grows with the width
    return np.pad(inner, width // 2, mode="edge")


def slope_noise(noise: float, step: float, width: int) -> float:
    """Standard deviation of `slope` for white noise of the given one."""
    return noise / step * math.sqrt(12.0 / (width * (width**2 - 1)))


def band_limited(values: Floats, rate: float, bandwidth: float) -> Floats:
    """The record of a sensor of a bandwidth (Hz, -3 dB): a causal Butterworth low-pass of order 4.

    rate : samples per second, more than twice the bandwidth. Raises ValueError.
    """
    if not 2.0 * bandwidth < rate:
        raise ValueError(
            f"a bandwidth of {bandwidth:g} Hz needs more than {2 * bandwidth:g} samples per second, not {rate:.4g}"
        )
    sections = signal.butter(_ORDER, bandwidth, fs=rate, output="sos")
    start = signal.sosfilt_zi(sections) * values[0]  # as if the first value had always been there
    return np.asarray(signal.sosfilt(sections, values, zi=start)[0])


def spectrum_peak(values: Floats, rate: float) -> tuple[float, float]:
    """Frequency (Hz) and amplitude of the largest peak of the amplitude spectrum; NaN if there is none.

    The whole signal, its mean subtracted, under a Hann window; amplitudes are those of sines (1 for sin). A frequency
    between two bins comes from a parabola through the logarithms around the peak.
    """
    window = signal.get_window("hann", values.size)
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * window)) * 2.0 / window.sum()
    floor = 1e-9 * float(np.abs(values).max())
    peaks, _ = signal.find_peaks(spectrum, height=max(floor, np.finfo(float).tiny), distance=4)
    if not peaks.size:
        return math.nan, math.nan
    peak = int(peaks[np.argmax(spectrum[peaks])])
    around = np.log(np.maximum(spectrum[peak - 1 : peak + 2], floor))
    shift = vertex(around)
    return (peak + shift) * rate / values.size, math.exp(around[1] - 0.25 * (around[0] - around[2]) * shift)


def vertex(around: Floats) -> float:
    """The place of the top of a parabola through three values, in steps from the one in the middle."""
    left, top, right = around
    bend = left - 2.0 * top + right
    return float(0.5 * (left - right) / bend) if bend < 0 else 0.0


# --- turning points ---------------------------------------------------------------------------------------------------


def turning_points(values: Floats, threshold: float) -> Positions:
    """Positions of alternating peaks and troughs, each swing between them at least `threshold` high.

    The first and the last position are where the first and the last swing begin and end as far as is seen; the last
    swing may be unfinished. Empty if no swing is as high.
    """
    turns: list[int] = []
    low = high = 0
    rising: bool | None = None
    for i in _extrema(values).tolist():
        value = values[i]
        high = i if value > values[high] else high
        low = i if value < values[low] else low
        if rising is not False and values[high] - value >= threshold:
            turns += [low, high] if rising is None and low < high else [high]
            rising, low, high = False, i, i
        elif rising is not True and value - values[low] >= threshold:
            turns += [high, low] if rising is None and high < low else [low]
            rising, low, high = True, i, i
    if rising is None:
        return np.empty(0, np.intp)
    return np.array([*turns, high if rising else low], np.intp)


def _extrema(values: Floats) -> Positions:
    """Positions of all local extrema, and both ends."""
    slopes = np.sign(np.diff(values))
    moving = np.flatnonzero(slopes)
    turns = moving[1:][slopes[moving[1:]] != slopes[moving[:-1]]]
    return np.concatenate([[0], turns, [values.size - 1]]).astype(np.intp)


@dataclass(frozen=True)
class Drops:
    """Drops of the friction force: positions of the sample before and of the one after each, and sizes (N)."""

    starts: Positions
    ends: Positions
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
