"""A sound: the acceleration of a mass over time, at true pitch or slower, ready to be heard.

Of a cycle the series of one period is computed, and summed at the times of the samples: exactly periodic, however long
it lasts. Other motions are a series of the stretch that is heard.
"""

from __future__ import annotations

import base64
import io
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite, nan, pi
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray
from scipy.io import wavfile  # type: ignore[import-untyped]

from stickslip.config.grid import shared_by
from stickslip.engine import Options, Results, Scales, SolverKeywords, compute, sampled
from stickslip.errors import NotReachedError
from stickslip.files.targets import replaced
from stickslip.theory.contacts import static_friction
from stickslip.vocabulary.cells import Cells, Parameters, as_cells
from stickslip.vocabulary.models import model_with
from stickslip.vocabulary.quantities import REGIMES, STATUS_MESSAGES, STATUSES
from stickslip_sound.loudness import a_weighting, levels
from stickslip_sound.series import HIGHEST, REACHED, RTOL, Series, cycles_of, samples_for, series_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["FULL_SCALE", "RATE", "Sound", "a_weighting", "levels", "of"]  # what is in `stickslip.sound`

Floats = NDArray[np.float64]
RATE = 44_100  # samples a second
FULL_SCALE = 100.0  # m/s2
KNEE = 0.9  # of full scale, from where on what is louder is compressed
OVERSAMPLING = 8
_LOUDEST = 32767  # of 16 bits
_LOWEST = 20.0  # Hz that are heard
_LEAD, _FADE = 0.02, 0.005  # s: before a first break-away; at both ends
_FINEST = 1000  # denominator of the ratio of two rates
_SETTLED = 2.0  # settling times after which a decay is far below what 16 bits hold


@dataclass(frozen=True, eq=False)
class Sound:
    """The sound that a microphone following the mass would record.

    acceleration : m/s2, limited to what is heard, faded at both ends. rate : samples a second. slow : how many times
    slower than the motion. full_scale : the acceleration (m/s2) that is the loudest the sound can be. frequency : of
    the cycle, or of the decay (Hz, of the motion); NaN where there is neither. repeats : whether it is a cycle.
    """

    acceleration: Floats
    rate: int
    slow: float
    full_scale: float
    regime: str
    frequency: float
    repeats: bool

    @cached_property
    def samples(self) -> Floats:
        """Between -1 and 1: in proportion to the acceleration up to 0.9, above that softly compressed."""
        samples = self.acceleration / self.full_scale
        over, room = np.abs(samples) - KNEE, 1.0 - KNEE
        return np.where(over > 0.0, np.copysign(KNEE + room * np.tanh(np.maximum(over, 0.0) / room), samples), samples)

    @property
    def seconds(self) -> float:
        """Duration, s."""
        return self.acceleration.size / self.rate

    @cached_property
    def peak(self) -> float:
        """Largest magnitude of the acceleration, m/s2."""
        return float(np.abs(self.acceleration).max(initial=0.0))

    @property
    def clips(self) -> bool:
        """Return whether some of it is compressed."""
        return self.peak > KNEE * self.full_scale

    def wav(self) -> bytes:
        """A WAV file of one channel, of 16-bit integers."""
        file = io.BytesIO()
        wavfile.write(file, self.rate, np.rint(self.samples * _LOUDEST).astype(np.int16))
        return file.getvalue()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a WAV file, whole or not at all. Raises StoreError."""
        with replaced(path) as temporary:
            temporary.write_bytes(self.wav())

    def described(self) -> str:
        """Regime, frequency and peak on a line, with what to know when judging it by ear."""
        words, heard = [self.regime.replace("_", "-")], self.frequency / self.slow
        if isfinite(heard):
            side = "below" if heard < _LOWEST else "above" if heard >= min(HIGHEST, 0.5 * self.rate) else ""
            words.append(f"{self.frequency:.3g} Hz{f' ({side} hearing)' if side else ''}")
        words.append(f"peaks of {self.peak:.3g} m/s2")
        words += [f"compressed above {KNEE * self.full_scale:g} m/s2"] * self.clips
        words += [f"{self.slow:g} times slower"] * (self.slow != 1.0)
        return ", ".join(words + ["from the start, no cycle"] * (not self.repeats))

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.wav()).decode("ascii")
        return f'<audio controls src="data:audio/wav;base64,{data}"></audio><div>{self.described()}</div>'


# --- of a cell --------------------------------------------------------------------------------------------------------


def of(
    cell: Mapping[str, float],
    seconds: float = 2.0,
    *,
    rate: int = RATE,
    slow: float = 1.0,
    full_scale: float = FULL_SCALE,
    **solver: Unpack[SolverKeywords],
) -> Sound:
    """Make the sound of a cell.

    Parameters
    ----------
    cell : Mapping of str to float
        As `simulate` takes it, a number each in SI.
    seconds, rate : float, int
        How long it lasts, and samples a second.
    slow : float
        10 for ten times slower and lower, 0.1 for ten times faster.
    full_scale : float
        m/s2; sounds can be compared where theirs are equal.
    **solver
        law, rtol (1e-9) and max_steps, or options, as for `evaluate`.

    Raises
    ------
    TypeError, ValueError
        For bad input.
    NotReachedError
        Where the motion cannot be integrated so far.
    """
    for name, value in {"seconds": seconds, "rate": rate, "slow": slow, "full_scale": full_scale}.items():
        if not (isfinite(value) and value > 0 and (name != "rate" or value == int(value))):
            raise ValueError(f"{name}: got {value!r}, expected a{' whole' * (name == 'rate')} number > 0")
    options = Options.of(SolverKeywords(**{"rtol": RTOL, **solver})).for_contact(cell)
    full = as_cells(cell, options.law)
    if full["mass"].size != 1:
        raise ValueError("a sound is that of one cell: give every parameter one number")
    results, count = compute(Cells.of(full), options).results, max(round(seconds * rate), 2)
    lead, own_rate, highest = _LEAD / slow, rate * slow, min(HIGHEST, 0.499 * rate) * slow
    cycles = cycles_of(full, results, options, lead)
    regime, repeats = REGIMES[int(results["regime"][0])], bool(cycles.which.size)
    if regime == "failed":
        raise NotReachedError(f"this cell has no motion to listen to, {_said(results['status'])}")
    frequency = _frequency(full, results)
    if regime == "stuck" or frequency >= highest:
        acceleration = np.zeros(count)
    elif not repeats:
        acceleration = _transient(full, results, (own_rate, highest, lead), count, options)
    else:  # of a cycle longer than the sound a stretch
        duration = min(float(cycles.period[0]), count / own_rate)
        series = _series(cycles.cells, duration, highest, options, cycles.begin)
        if duration == cycles.period[0]:
            series = replace(series, mean=0.0)  # what is left of it is rounding
        acceleration = series.values(own_rate, count)
    acceleration *= _fades(count, rate)
    return Sound(acceleration, int(rate), float(slow), float(full_scale), regime, frequency, repeats)


def sound_of_cell(ds: xr.Dataset, seconds: float = 2.0, *, slow: float = 1.0, **at: Any) -> Sound:
    """Return the sound of one cell of a dataset, as `sound.of` does. at : which cell, as for `ds.stickslip.cell`."""
    how = shared_by(ds) | {"rtol": RTOL}
    return of(ds.stickslip.cell(**at), seconds, slow=slow, **how)


def _series(cell: Parameters, duration: float, highest: float, options: Options, begin: Floats | float = 0.0) -> Series:
    """The motion over a duration (s), from `begin` (s) on, with its tones up to `highest` (Hz, its own time)."""
    intervals = samples_for(np.array([duration]), highest, Scales(cell).natural_frequency, OVERSAMPLING)
    motions, ends, status = sampled(cell, duration / intervals, intervals + 1, options, begin)
    if status[0] != REACHED:
        raise NotReachedError(f"the motion is not known to {duration:g} s, {_said(status)}")
    return series_of(motions[0], ends[0], duration, int(highest * duration))


def _said(status: NDArray[Any]) -> str:
    name = STATUSES[int(status[0])]
    return f"{name}: {STATUS_MESSAGES[name]}"


def _transient(
    cell: Parameters, results: Results, band: tuple[float, float, float], count: int, options: Options
) -> Floats:
    """The motion from its first break-away on, or from the start where it slips at once, after a little silence.

    band : samples a second, the highest tone (Hz), and the silence (s), in its own time.
    """
    rate, highest, lead = band
    first = float(results["breakaway_time"][0])
    if not isfinite(first) or not _sticks_at_first(cell):
        first = 0.0
    passed = max(0.0, first - lead)
    # Until then the mass moves with the belt: what has passed is passed over, for the sake of the digits of the time.
    later = {"displacement": cell["displacement"] + cell["belt_speed"] * passed}
    later["contact_time"] = cell["contact_time"] + passed
    silent = min(round((lead - (first - passed)) * rate), count // 4)
    left = count - silent
    if (settled := _SETTLED * float(results["settling_time"][0])) > 0.0:
        left = max(min(left, int((first - passed + settled) * rate)), 2)
    values = _series(cell | later, left / rate, highest, options).values(rate, left)
    return np.concatenate([np.zeros(silent), values, np.zeros(count - silent - left)])


def _sticks_at_first(cell: Parameters) -> bool:
    """Return whether the contact holds at the start; else it slips at once, and its first break-away is a later one."""
    if not np.isnan(cell["velocity"][0]):
        return False
    mu = model_with(cell).static_of(cell)
    limit = static_friction(cell["contact_time"], mu, cell["ageing_rate"], cell["ageing_time"]) * Scales(cell).load
    return bool((np.abs(cell["stiffness"] * cell["displacement"] + cell["damping"] * cell["belt_speed"]) <= limit)[0])


def _fades(count: int, rate: float) -> Floats:
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
