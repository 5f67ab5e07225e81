"""Hum: lines in the spectrum of a channel that are not of the motion, as mains leave them in cables and amplifiers.

While the contact sticks, or slides steadily, the force is a straight line for as long as a period of the hum, and its
bend, the second difference over a few milliseconds, holds hum and noise alone. So hum is looked for where that is
quiet: frequencies that stand out of their neighbourhood, with a phase that persists over the record, and which the
acceleration does not follow as it follows a force of a spring, K a = F''. What passes is fitted, with an amplitude and
a phase that may drift from second to second as those of mains do, and subtracted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft, interpolate, ndimage, signal, special  # type: ignore[import-untyped]

from stickslip_rig.signals import Flags, Floats, vertex

LAG = 3e-3  # s, of the second difference: passes 40 to 300 Hz, and hardly what is slower
_SMOOTH = 0.02  # s, over which the bend is judged quiet: a period of mains
_SEGMENT = 4.0  # s, of a periodogram
_SEGMENTS = 200  # at most
_BLOCK = 1.0  # s, within which amplitude and phase are constant
_LOWEST, _HIGHEST = 15.0, 400.0  # Hz: mains and their harmonics, aliased or not
_AROUND = 20.0  # Hz, the neighbourhood of a line
_BY_CHANCE = 1e-11  # how often noise may look like a line in a bin
_STANDS_OUT = 8.0  # times the median power of its neighbourhood, at least
_LEAST = {"force": 1e-4, "acceleration": 1e-3}  # of the largest magnitude: what is weaker changes nothing
_PERSISTS = 0.45  # coherence of the phase between blocks, less the scatter of the amplitude
_APART = 3  # those blocks
_SEEN = 0.3  # of what the bend passes at most: lines near its zeros are not
_ROUGH = 0.05  # of a line: what may be left of it where the channel is quiet
_WANDERS = 0.02  # of a line: what may be left of it where parts of the record are not quiet
_NEAR = 4.0  # Hz: what is nearer to a line is a side band of it
_UNIFORM = 0.8  # of the record, from which on quiet parts prove nothing
_ALIKE = 0.5  # of the larger: how far two lines of one motion may differ
_MOST = 12  # lines
_FITS = 20  # at most


@dataclass(frozen=True)
class Tone:
    """One line: its channel, frequency as sampled (Hz), median amplitude, and how much of that is left."""

    channel: str
    frequency: float
    amplitude: float
    left: float


def subtract_hum(force: Floats, acceleration: Floats, step: float) -> tuple[Floats, Floats, list[Tone]]:
    """Both channels, evenly spaced by `step` (s), without hum, and what was subtracted: nothing if there is none."""
    lag = max(1, round(LAG / step))
    if force.size < max(8 * lag, round(0.5 / step)) or 0.5 / step < 2 * _LOWEST:
        return force, acceleration, []
    channels = [_Channel("force", force, lag, step), _Channel("acceleration", acceleration, lag, step)]
    tones = channels[0].clean(channels[1]) or channels[0].clean(channels[1], channels[1].quiet)
    tones += channels[1].clean(channels[0], channels[0].quiet)
    return channels[0].values, channels[1].values, tones


class _Channel:
    """One channel, and its bend: of the force the second difference, of the acceleration the same, integrated twice."""

    def __init__(self, name: str, values: Floats, lag: int, step: float) -> None:
        self.name, self.values, self._lag, self._step = name, values, lag, step
        self._edges = np.linspace(0, values.size, max(1, round(values.size * step / _BLOCK)) + 1).astype(np.intp)
        self._within: Flags | None = None  # where another channel is quiet
        self._least = _LEAST[name] * float(np.abs(values).max())
        self._look()

    def _look(self, spare: float = 0.0) -> None:
        """Bend, and where it is about as small as in the quietest tenth of the record, with a power to spare."""
        self.bend = bend_of(self.values, self._lag, self._step, self.name)
        power = np.maximum(ndimage.uniform_filter1d(self.bend**2, max(3, round(_SMOOTH / self._step))), 0.0)
        lowest = float(np.quantile(power[self._lag : -self._lag], 0.1))
        self.quiet = power <= 6.0 * lowest + spare + 1e-24 * power.max()
        self.quiet[: self._lag] = self.quiet[-self._lag :] = False
        if self._within is not None and (self.quiet & self._within).mean() > 0.05:
            self.quiet &= self._within

    def gain(self, frequency: ArrayLike) -> Floats:
        """Factor by which the bend shows a sine of the channel; never less than the noise lets be seen."""
        angle = np.pi * np.asarray(frequency) * self._step
        gain = -4.0 * np.sin(angle * self._lag) ** 2
        if self.name != "force":
            gain = -gain * (0.5 * self._step / np.sin(np.maximum(angle, 1e-9))) ** 2
        return gain

    def clean(self, other: _Channel, within: Flags | None = None) -> list[Tone]:
        """Subtract the lines that are no motion; `other` is the channel that would share it."""
        original, frequencies, self._within = self.values, list[float](), within
        self._look()
        while len(frequencies) < _MOST:
            lines = [f for f in self._lines() if all(abs(f - g) > _NEAR for g in frequencies)]
            if (new := self._first_hum(lines, other, frequencies)) is None:
                break
            frequencies.append(new)
            amplitudes = self._subtract(original, frequencies)
        if not frequencies:
            return []
        fitted = self._fit(self.bend, self._phases(frequencies)) / self.gain(frequencies)
        left = np.nanmax(np.abs(fitted), axis=0)
        if np.isnan(fitted[:, 0]).mean() > 0.2:  # between the parts that are quiet it may wander
            left = np.maximum(left, _WANDERS * amplitudes)
        rows = sorted(zip(frequencies, amplitudes.tolist(), left.tolist(), strict=True))
        return [Tone(self.name, *row) for row in rows]

    def _lines(self) -> list[float]:
        """Frequencies (Hz) that stand out in the quiet parts, the strongest first."""
        size = min(self.bend.size, round(_SEGMENT / self._step))
        window, padded = np.hanning(size + 2)[1:-1], fft.next_fast_len(4 * size)
        power, weights = np.zeros(padded // 2 + 1), []
        for start in range(0, self.bend.size - size + 1, max(1, size // 2, self.bend.size // _SEGMENTS)):
            shown = self.quiet[start : start + size] * window
            power += np.abs(fft.rfft(self.bend[start : start + size] * shown, padded)) ** 2
            weights.append(float(shown.sum()) ** 2)
        weight, squares = max(sum(weights), 1e-300), max(sum(w**2 for w in weights), 1e-300)
        segments = min(weight**2 / squares, self.bend.size / size)
        frequency = fft.rfftfreq(padded, self._step)
        around = ndimage.median_filter(power, round(_AROUND / frequency[1]) | 1, mode="nearest")
        seen = (np.abs(np.sin(np.pi * self._lag * self._step * frequency)) > _SEEN) & (frequency >= _LOWEST)
        seen &= frequency <= _HIGHEST
        peaks = np.flatnonzero((power >= ndimage.maximum_filter1d(power, 9)) & seen)
        peaks = peaks[power[peaks] > _standing_out(segments) * around[peaks]]
        amplitude = 2.0 * np.sqrt(power[peaks] / weight) / np.abs(self.gain(frequency[peaks]))
        peaks = peaks[amplitude > self._least]
        return [_top_of(frequency, power, _mains(frequency, power, int(i))) for i in peaks[np.argsort(-power[peaks])]]

    def _first_hum(self, lines: list[float], other: _Channel, known: list[float]) -> float | None:
        """The first line that persists and is no motion, nor a harmonic of one; None if there is none."""
        moving: list[float] = []
        for line in lines:
            phases = self._phases([line])
            own, its = self._fit(self.bend, phases)[:, 0], self._fit(other.bend, phases)[:, 0]
            fitted = np.isfinite(own)
            if any(_harmonic(f, line) for f in moving):
                continue
            if self._moves(own[fitted], its[fitted], other):
                moving.append(line)
                continue
            # where it does not stand out all in all, it is cut out of a slower wave
            everywhere = self._fit(self.bend, phases, np.ones(self.quiet.size, np.bool_))[fitted, 0]
            if np.median(np.abs(everywhere)) < 0.5 * np.median(np.abs(own[fitted])):
                continue
            if _persists(own[fitted], any(_harmonic(*sorted([f, line])) for f in known)):
                return line
        return None

    def _moves(self, own: NDArray[np.complex128], its: NDArray[np.complex128], other: _Channel) -> bool:
        """True if two lines are of one motion: the bend of the force is the stiffness times that of the motion."""
        force, motion = (self.bend, other.bend) if self.name == "force" else (other.bend, self.bend)
        loud = np.abs(motion) >= np.quantile(np.abs(motion), 0.9)
        stiffness = float(motion[loud] @ force[loud]) / max(float(motion[loud] @ motion[loud]), 1e-300)
        own, its = (own, stiffness * its) if self.name == "force" else (stiffness * own, its)
        if self.quiet.mean() > _UNIFORM:  # nothing but this line, perhaps: the sizes alone may be those of a motion
            own, its = np.abs(own), np.abs(its)
        return bool(np.linalg.norm(own - its) <= _ALIKE * max(np.linalg.norm(own), np.linalg.norm(its)))

    def _phases(self, frequencies: list[float]) -> list[Floats]:
        """Phases (rad) of the lines at all samples."""
        time = np.arange(self.values.size, dtype=np.float64)
        return [np.asarray(2.0 * np.pi * f * self._step * time, np.float64) for f in frequencies]

    def _fit(self, bend: Floats, phases: list[Floats], where: Flags | None = None) -> NDArray[np.complex128]:
        """Complex amplitudes in each block by least squares over its quiet samples; NaN where they are few."""
        where = self.quiet if where is None else where
        amplitudes = np.full((self._edges.size - 1, len(phases)), np.nan, np.complex128)
        for k, (start, stop) in enumerate(zip(self._edges[:-1], self._edges[1:], strict=True)):
            at = np.flatnonzero(where[start:stop]) + start
            if at.size < max(0.05 * (stop - start), 8 * len(phases)):
                continue
            angles = np.stack([phase[at] for phase in phases])
            waves = np.concatenate([np.cos(angles), -np.sin(angles)])
            parts = np.linalg.lstsq(waves @ waves.T, waves @ bend[at], rcond=1e-10)[0]
            amplitudes[k] = parts[: len(phases)] + 1j * parts[len(phases) :]
        return amplitudes

    def _subtract(self, original: Floats, frequencies: list[float]) -> Floats:
        """Make `values` the channel without lines; their median amplitudes.

        Several fits: the phases of the blocks, joined by straight lines, are those of the next, and so are the parts
        that are quiet once most of the hum is gone.
        """
        bend, middles = bend_of(original, self._lag, self._step, self.name), 0.5 * (self._edges[1:] + self._edges[:-1])
        phases, at = self._phases(frequencies), np.arange(original.size)
        for phase, row in zip(phases, self._fit(bend, phases).T, strict=True):
            phase += _turning(np.nan_to_num(row)) * at / (middles[-1] - middles[0] or 1.0) * (middles.size - 1)
        for _ in range(_FITS):
            before, fitted = self.quiet, self._fit(bend, phases) / self.gain(frequencies)
            self.values = original.copy()
            for phase, row in zip(phases, fitted.T, strict=True):
                if not (known := np.isfinite(row)).any():
                    continue
                phase += _through(at, middles[known], np.unwrap(np.angle(row[known])))
                self.values -= np.interp(at, middles[known], np.abs(row[known])) * np.cos(phase)
            self._look(
                0.5 * float(np.sum((_ROUGH * np.abs(np.nanmedian(fitted, axis=0) * self.gain(frequencies))) ** 2))
            )
            if np.count_nonzero(before != self.quiet) < 1e-3 * before.size:
                break
        return np.asarray(np.nanmedian(np.abs(fitted), axis=0))


def _harmonic(low: float, high: float) -> bool:
    """True if one frequency (Hz) is a multiple of the other."""
    return high > 1.5 * low and abs(high - round(high / low) * low) < 0.5


def _persists(row: NDArray[np.complex128], harmonic: bool) -> bool:
    """True if phase and amplitude last from block to block; the phase of a harmonic drifts several times as fast."""
    if row.size <= _APART:
        return True
    product, size = row[_APART:] * row[:-_APART].conj(), np.abs(row)
    coherence = 1.0 if harmonic else float(np.abs(product.sum()) / max(np.abs(product).sum(), 1e-300))
    return coherence - float(size.std() / size.mean()) >= _PERSISTS


def _turning(row: NDArray[np.complex128]) -> float:
    """Angle (rad) by which the phase turns from block to block; amplitudes of 0 are unknown."""
    turns, agreement = np.linspace(-np.pi, np.pi, 401), np.zeros(401)
    for apart in range(1, min(_APART, row.size - 1) + 1):
        agreement += np.real(np.vdot(row[:-apart], row[apart:]) * np.exp(-1j * apart * turns))
    return float(turns[np.argmax(agreement)])


def _through(at: NDArray[np.intp], x: Floats, y: Floats) -> Floats:
    """A smooth curve through points, continued straight beyond the first and the last of them."""
    if x.size < 3:
        return np.interp(at, x, y)
    curve = interpolate.CubicSpline(x, y, bc_type="natural")
    inside = np.clip(at, x[0], x[-1])
    return np.asarray(curve(inside) + np.where(at < x[0], curve(x[0], 1), curve(x[-1], 1)) * (at - inside))


def bend_of(values: Floats, lag: int, step: float, name: str) -> Floats:
    """The second difference over `lag` samples to either side, 0 at the ends; of an acceleration that of its motion."""
    bend = np.zeros(values.size)
    if name == "force":
        bend[lag:-lag] = values[2 * lag :] - 2.0 * values[lag:-lag] + values[: -2 * lag]
    else:
        triangle = np.bartlett(2 * lag + 1)[1:-1] * lag * step**2
        bend[lag:-lag] = signal.oaconvolve(values, triangle, mode="same")[lag:-lag]
    return bend


def _standing_out(segments: float) -> float:
    """The power, over the median one, that a bin of noise hardly ever exceeds: a sum of squares over the segments."""
    segments = max(segments, 1.0)
    return float(max(special.gammainccinv(segments, _BY_CHANCE) / special.gammaincinv(segments, 0.5), _STANDS_OUT))


def _mains(frequency: Floats, power: Floats, peak: int) -> int:
    """The bin of a multiple of 50 or 60 Hz, if the line might be there as well: quiet parts far apart allow both."""
    for mains in (50.0, 60.0):
        multiple = mains * max(1.0, round(float(frequency[peak]) / mains))
        near = np.flatnonzero(np.abs(frequency - multiple) < 0.15)
        if near.size and abs(frequency[peak] - multiple) < 0.7 and power[near].max() > 0.6 * power[peak]:
            return int(near[np.argmax(power[near])])
    return peak


def _top_of(frequency: Floats, power: Floats, peak: int) -> float:
    """The top of a parabola through the logarithms around a peak (Hz)."""
    is_inside = 0 < peak < power.size - 1
    return float(frequency[peak] + (vertex(np.log(power[peak - 1 : peak + 2])) if is_inside else 0.0) * frequency[1])
