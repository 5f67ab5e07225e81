"""Hum: lines in the spectrum of a channel that are not of the motion, as mains leave them in cables and amplifiers.

While the contact sticks, or slides steadily, the force is a straight line for as long as a period of the hum, and its
bend, the second difference over a few milliseconds, holds hum and noise alone. So hum is looked for where that is
quiet: frequencies that stand out of their neighbourhood, with a phase that persists over the record, and which the
acceleration does not follow as it follows a force of a spring, K a = F''. What passes is subtracted, demodulated: with
an amplitude and a phase that may drift from second to second as those of mains do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, signal, special  # type: ignore[import-untyped]

from stickslip_rig.signals import Flags, Floats, vertex

_LAG = 3e-3  # s, of the second difference: passes 40 to 300 Hz, and hardly what is slower
_SMOOTH = 0.02  # s, over which the bend is judged quiet: a period of mains
_SEGMENT = 4.0  # s, of a periodogram
_DRIFT = 0.5  # s, standard deviation of the window within which amplitude and phase are constant
_BLOCKS = 10  # in that deviation
_LOWEST, _HIGHEST = 15.0, 400.0  # Hz: mains and their harmonics, aliased or not
_AROUND = 20.0  # Hz, the neighbourhood of a line
_BY_CHANCE = 1e-11  # how often noise may look like a line in a bin
_STANDS_OUT = 8.0  # times the median power of its neighbourhood, at least
_LEAST = {"force": 1e-4, "acceleration": 1e-3}  # of the largest magnitude: what is weaker changes nothing
_PERSISTS = 0.45  # coherence of the phase from second to second, less the scatter of the amplitude
_APART = 3  # those seconds
_SEEN = 0.3  # of what the bend passes at most: lines near its zeros are not
_ROUGH = 0.05  # of a line: what may be left of it where the channel is quiet
_WANDERS = 0.3  # of the change of an amplitude in a second: what may be left of it in between
_NEAR = 4.0  # Hz: what is nearer to a line is a side band of it
_UNIFORM = 0.8  # of the record, from which on quiet parts prove nothing
_ALIKE = 0.5  # of the larger: how far two lines of one motion may differ
_MOST = 12  # lines
_ROUNDS = 6  # of demodulation: each leaves a part of what drifts fast
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Tone:
    """One line: its channel, frequency as sampled (Hz), median amplitude, and how much of that is left."""

    channel: str
    frequency: float
    amplitude: float
    left: float


def subtract_hum(force: Floats, acceleration: Floats, step: float) -> tuple[Floats, Floats, list[Tone]]:
    """Both channels, evenly spaced by `step` (s), without hum, and what was subtracted: nothing if there is none."""
    lag = max(1, round(_LAG / step))
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
        self._least = _LEAST[name] * float(np.abs(values).max())
        self._look(None)

    def _look(self, within: Flags | None, spare: float = 0.0) -> None:
        """Bend, and where it is about as small as in the quietest tenth of the record, with a power to spare.

        within : where another channel is quiet.
        """
        lag, values = self._lag, self.values
        self.bend = np.zeros(values.size)
        if self.name == "force":
            self.bend[lag:-lag] = values[2 * lag :] - 2.0 * values[lag:-lag] + values[: -2 * lag]
        else:
            triangle = np.bartlett(2 * lag + 1)[1:-1] * lag * self._step**2
            self.bend[lag:-lag] = signal.oaconvolve(values, triangle, mode="same")[lag:-lag]
        power = np.maximum(ndimage.uniform_filter1d(self.bend**2, max(3, round(_SMOOTH / self._step))), 0.0)
        lowest = float(np.quantile(power[lag:-lag], 0.1))
        self.quiet = power <= 6.0 * lowest + spare + 1e-24 * power.max()
        self.quiet[:lag] = self.quiet[-lag:] = False
        if within is not None and (self.quiet & within).mean() > 0.05:
            self.quiet &= within

    def _gain(self, frequency: Floats | float) -> Floats:
        """Factor by which the bend shows a sine of the channel."""
        angle = np.pi * np.maximum(frequency, 1e-6) * self._step
        gain = -4.0 * np.sin(angle * self._lag) ** 2
        return np.asarray(gain if self.name == "force" else -gain * (0.5 * self._step / np.sin(angle)) ** 2)

    def clean(self, other: _Channel, within: Flags | None = None) -> list[Tone]:
        """Subtract the lines that are no motion; `other` is the channel that would share it."""
        tones: list[Tone] = []
        original, frequencies = self.values, list[float]()
        self._look(within)
        while len(frequencies) < _MOST:
            lines = [f for f in self._lines() if all(abs(f - g) > _NEAR for g in frequencies)]
            if (new := self._first_hum(lines, other, frequencies)) is None:
                break
            frequencies.append(new)
            tones = self._subtract(original, frequencies, within)
        return sorted(tones, key=lambda tone: tone.frequency)

    def _lines(self) -> list[float]:
        """Frequencies (Hz) that stand out in the quiet parts, the strongest first."""
        size = min(self.bend.size, round(_SEGMENT / self._step))
        frequency, power = signal.welch(self.bend * self.quiet, 1.0 / self._step, nperseg=size, nfft=4 * size,
                                        detrend=False, scaling="spectrum")  # fmt: skip
        segments = max(1.0, self.bend.size / size)
        around = ndimage.median_filter(power, round(_AROUND / frequency[1]) | 1, mode="nearest")
        chance = special.gammainccinv(segments, _BY_CHANCE) / special.gammaincinv(segments, 0.5)
        seen = (np.abs(np.sin(np.pi * self._lag * self._step * frequency)) > _SEEN) & (frequency >= _LOWEST)
        seen &= (frequency <= _HIGHEST) & (power > max(chance, _STANDS_OUT) * around)
        seen &= np.sqrt(2.0 * power) > self._least * self.quiet.mean() * np.abs(self._gain(frequency))
        peaks = np.flatnonzero(seen & (power >= ndimage.maximum_filter1d(power, 9)))
        return [float(frequency[i] + vertex(np.log(power[i - 1 : i + 2])) * frequency[1])
                for i in peaks[np.argsort(-power[peaks])] if 0 < i < power.size - 1]  # fmt: skip

    def _first_hum(self, lines: list[float], other: _Channel, known: list[float]) -> float | None:
        """The first line that persists and is no motion, nor a harmonic of one; None if there is none."""
        moving: list[float] = []
        second = round(1.0 / self._step)
        for line in lines:
            if any(_harmonic(f, line) for f in moving):
                continue
            own, its = (self._demodulated(bend, line)[second // 2 :: second] for bend in (self.bend, other.bend))
            if self._moves(own, its, other):
                moving.append(line)
            # where it does not stand out all in all, it is cut out of a slower wave
            elif np.median(np.abs(self._demodulated(self.bend, line, everywhere=True))) < 0.5 * np.median(np.abs(own)):
                continue
            elif _persists(own, any(_harmonic(*sorted([f, line])) for f in known)):
                return line
        return None

    def _moves(self, own: Complex, its: Complex, other: _Channel) -> bool:
        """True if two lines are of one motion: the bend of the force is the stiffness times that of the motion."""
        force, motion = (self.bend, other.bend) if self.name == "force" else (other.bend, self.bend)
        loud = np.abs(motion) >= np.quantile(np.abs(motion), 0.9)
        stiffness = float(motion[loud] @ force[loud]) / max(float(motion[loud] @ motion[loud]), 1e-300)
        own, its = (own, stiffness * its) if self.name == "force" else (stiffness * own, its)
        if self.quiet.mean() > _UNIFORM:  # nothing but this line, perhaps: the sizes alone may be those of a motion
            own, its = np.abs(own), np.abs(its)
        return bool(np.linalg.norm(own - its) <= _ALIKE * max(np.linalg.norm(own), np.linalg.norm(its)))

    def _demodulated(self, bend: Floats, frequency: float, everywhere: bool = False) -> Complex:
        """Complex amplitude of a line at each sample, from the quiet ones around it: of short blocks, under a Gaussian
        window, between which it is interpolated."""
        block = max(1, round(_DRIFT / _BLOCKS / self._step))
        begins = np.arange(0, bend.size, block)
        shown = np.ones(bend.size) if everywhere else self.quiet.astype(np.float64)
        weights, values = (np.pad(each, (0, begins.size * block - bend.size)).reshape(-1, block)
                           for each in (shown, shown * bend))  # fmt: skip
        turn = -2j * np.pi * frequency * self._step
        turned = (values @ np.exp(turn * np.arange(block))) * np.exp(turn * begins)
        turned, weight = (ndimage.gaussian_filter1d(each, _BLOCKS, mode="constant")
                          for each in (turned, weights.sum(axis=1)))  # fmt: skip
        amplitudes = 2.0 * turned / np.maximum(weight, 0.02 * block)
        return np.asarray(np.interp(np.arange(bend.size), begins + 0.5 * (block - 1), amplitudes))

    def _subtract(self, original: Floats, frequencies: list[float], within: Flags | None) -> list[Tone]:
        """Make `values` the channel without lines, round by round; the lines, with what is left of them."""
        turning = [np.exp(2j * np.pi * f * self._step * np.arange(original.size)) for f in frequencies]
        lines: list[Complex] = [np.zeros(original.size, np.complex128) for _ in frequencies]
        self.values = original
        self._look(within)
        for _ in range(_ROUNDS):
            for k, frequency in enumerate(frequencies):
                more = self._demodulated(self.bend, frequency) / self._gain(frequency)
                lines[k] += more
                self.values = self.values - np.real(more * turning[k])
                sizes = np.median(np.abs(lines), axis=1) * self._gain(np.asarray(frequencies))
                self._look(within, 0.5 * float(np.sum((_ROUGH * sizes) ** 2)))
        return [Tone(self.name, f, float(np.median(np.abs(line))), self._left(f, line))
                for f, line in zip(frequencies, lines, strict=True)]  # fmt: skip

    def _left(self, frequency: float, line: Complex) -> float:
        """The largest amplitude that is left of a line; or a share of how its own one changes in a second, if that is
        more: hum drifts, and what comes and goes has some of the motion in it."""
        second = round(1.0 / self._step)
        changes = np.abs(line[second:]) - np.abs(line[:-second])
        rest = np.abs(self._demodulated(self.bend, frequency) / self._gain(frequency)).max()
        return max(float(rest), _WANDERS * float(np.sqrt(np.mean(changes**2))) if changes.size else 0.0)


def _harmonic(low: float, high: float) -> bool:
    """True if one frequency (Hz) is a multiple of the other."""
    return high > 1.5 * low and abs(high - round(high / low) * low) < 0.5


def _persists(row: Complex, harmonic: bool) -> bool:
    """True if phase and amplitude last from second to second; the phase of a harmonic drifts several times as fast."""
    if row.size <= _APART:
        return True
    product, size = row[_APART:] * row[:-_APART].conj(), np.abs(row)
    coherence = 1.0 if harmonic else float(np.abs(product.sum()) / max(np.abs(product).sum(), 1e-300))
    return coherence - float(size.std() / size.mean()) >= _PERSISTS
