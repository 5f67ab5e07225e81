"""Stick phases in a record, from its stick flag or from the force.

While the contact sticks, the drive stretches the spring: the force changes at the rate K u, K being the stiffness of
the spring and u the velocity of the drive. So the rate of the force gives the slip speed, |u - rate/K|, and the contact
sticks where that is less than a share (`tolerance`) of the speed of the drive.

K u is taken from what the record holds: the motion of the drive, the conditions stiffness and drive_speed, or else from
the force itself, as its fastest loading rate. Without the motion of the drive a stick under a slow drive, or one at
rest, loads the spring slowly or not at all, as steady sliding does: what follows a drop such as those after which the
contact sticks is a stick as well; a constant force that follows none, before a reversal, is `unclear`.
"""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from stickslip_rig.drive_motion import drive_velocity
from stickslip_rig.records import condition_of, force_of
from stickslip_rig.sections import FeatureSettings
from stickslip_rig.signals import (
    Flags,
    Floats,
    Positions,
    evenly,
    find_drops,
    noise_of,
    runs_of,
    sample_rate,
    slope,
    slope_noise,
    within,
)

_NARROWEST = 5  # samples of a window
_WIDEST = 1 / 20  # of the record
_CLEAR = 0.05  # of the largest force, beyond which its sign is that of the stroke
_RARE = 0.2  # of the time between sticks: a drive does not rest for all but that
_LEVEL = 0.02  # of a force, and of its rate in a stick: how far a constant one may wander
_FAST = 1.5  # of the loading rate in a stick: what changes faster is no stick
_QUIET = 0.25  # of the tolerance: how much of it the noise of the slope may use up


@dataclass(frozen=True)
class Sticks:
    """Stick phases of an evenly sampled record.

    record : the samples. starts, ends : positions of the first and of the last sample of each phase.
    broke : whether the phase ended in sliding, which the last one may not. loading : rate of the force while sticking
    (N/s), as the record shows it, and expected : as stiffness and speed of the drive say; NaN where that is not known.
    unclear : samples after which the drive reverses, of a constant force: sliding, or a drive at rest.
    rest : how long (s) the drive is known to rest, where its motion is not recorded.
    """

    record: xr.Dataset
    starts: Positions
    ends: Positions
    broke: Flags
    unclear: Flags
    rest: float = 0.0
    loading: float = np.nan
    expected: float = np.nan

    @property
    def time(self) -> Floats:
        """Times (s) of the samples."""
        return np.asarray(self.record["time"].values)

    @property
    def count(self) -> int:
        """Number of stick phases."""
        return self.starts.size

    def flags(self) -> Flags:
        """True if the contact sticks, for each sample."""
        return within(self.starts, self.ends, self.time.size)

    def slips(self) -> tuple[Positions, Positions]:
        """Positions of the break-aways, and of the re-sticks after them or of the end of the record."""
        after = np.append(self.starts[1:], self.time.size - 1)[: self.count]
        return self.ends[self.broke], after[self.broke]

    def between(self, first: int, last: int) -> "Sticks":
        """The phases within the samples from `first` up to `last`, cut off at both; what lasts on has not broken."""
        inside = (self.ends >= first) & (self.starts < last)
        starts, ends = np.maximum(self.starts[inside], first), np.minimum(self.ends[inside], last - 1)
        return replace(
            self, record=self.record.isel(time=slice(first, last)), starts=starts - first, ends=ends - first,
            broke=self.broke[inside] & (self.ends[inside] < last - 1),
            unclear=self.unclear[first:last],
            rest=self.rest * (last - first) / self.time.size,
        )  # fmt: skip

    def whole_cycles(self) -> "Sticks":
        """The part from the first break-away to the last; all of it if there are less than two."""
        breaks = self.ends[self.broke]
        return self.between(int(breaks[0]), int(breaks[-1]) + 2) if breaks.size > 1 else self

    def sliding_forces(self) -> tuple[float, float]:
        """The mean magnitude of the force (N) over all slips, and without what is unclear; NaN where nothing slides."""
        starts, ends = self.slips()
        force, steps = np.abs(force_of(self.record)), np.diff(self.time)
        inside = np.zeros(steps.size + 1)
        np.add.at(inside, starts, 1.0)
        np.add.at(inside, ends, -1.0)
        weights = np.cumsum(inside[:-1]) * steps
        clear = np.where(self.unclear[1:], 0.0, weights)
        means = 0.5 * (force[1:] + force[:-1])
        if clear.sum() < _RARE * weights.sum():
            clear = weights
        whole, certain = (float(means @ w / w.sum()) if w.any() else np.nan for w in (weights, clear))
        return whole, certain


def find_sticks(record: xr.Dataset, settings: FeatureSettings | None = None) -> "Sticks":
    """Find the stick phases of a record: those of its flag `stick`, else those that its force shows.

    Parameters
    ----------
    record
        As of `read_record` or `make_record`.
    settings
        Window, tolerance and smallest drop.
    """
    settings = settings or FeatureSettings()
    even, last = evenly(record), record.sizes["time"] - 1
    if "stick" in even:
        starts, ends = runs_of(even["stick"].values > 0)
        return Sticks(even, starts, ends, ends < last, np.zeros(even.sizes["time"], np.bool_))
    rates, expected = _Rates(even, settings), np.nan
    if "stiffness" in even.coords and rates.is_known:
        measured, expected = _Rates(even.drop_vars("stiffness"), settings), rates.full_rate()
        if measured.is_sustained() and abs(np.log(measured.full_rate() / expected)) > np.log1p(settings.tolerance):
            rates = measured
    starts, ends, unclear, rest = rates.phases()
    loading = rates.full_rate() if rates.is_known or rates.is_sustained() else np.nan
    return Sticks(even, starts, ends, ends < last, unclear, rest, loading, expected)


def _joined(starts: Positions, ends: Positions, together: Flags) -> tuple[Positions, Positions]:
    """Intervals merged across the gaps for which `together` holds; it has one entry fewer than there are intervals."""
    if starts.size < 2:
        return starts, ends
    return starts[np.concatenate([[True], ~together])], ends[np.concatenate([~together, [True]])]


class _Rates:
    """The rate of the force of one record, and what it says."""

    def __init__(self, record: xr.Dataset, settings: FeatureSettings) -> None:
        self._tolerance, self._smallest_drop = settings.tolerance, settings.smallest_drop
        self._force = force_of(record)
        self._step = 1.0 / sample_rate(record["time"].values)
        self._record = record
        self._stiffness, speed = condition_of(record, "stiffness"), condition_of(record, "drive_speed")
        self._known = self._stiffness * speed if self._stiffness and speed else None  # N/s, without direction
        self._choose_width(settings.window)

    def phases(self) -> tuple[Positions, Positions, Flags, float]:
        """First and last positions of the stick phases, the samples that are unclear, and how long (s) the drive rested
        in those phases, as far as it would have loaded the spring more."""
        starts, ends = runs_of(self._sticking())
        starts, ends = _joined(starts, ends, starts[1:] - ends[:-1] - 1 < max(2, self._width // 2))
        long_enough = ends - starts + 1 >= self._width
        starts, ends = starts[long_enough], ends[long_enough]
        if self._velocity is None:
            starts, ends = _joined(starts, ends, self._turns_while_sticking(starts, ends))
        starts, ends = self._sharpened(starts, ends)
        if self._velocity is None and starts.size:
            return self._with_slow_sticks(starts, ends)
        return starts, ends, np.zeros(self._force.size, np.bool_), 0.0

    # --- the rate -----------------------------------------------------------------------------------------------------

    def _choose_width(self, window: float | None) -> None:
        """The window, and with it `_rate` (N/s), `_velocity` (m/s, None if not known), `_full` (K u, or K)."""
        widest = max(_NARROWEST, int(_WIDEST * self._force.size))
        noise, width = noise_of(self._force), _NARROWEST
        if window is not None:
            width = min(max(int(round(window / self._step)), 3), self._force.size - 2)
        width |= 1  # odd
        while True:
            self._width, self._rate = width, slope(self._force, self._step, width)
            self._velocity = drive_velocity(self._record, self._tolerance, width)
            self._full = self._full_loading()
            allowed = _QUIET * self._tolerance * self.full_rate()
            if window is not None or width >= widest or slope_noise(noise, self._step, width) <= allowed:
                return
            width = int(1.4 * width) | 1
            while width < widest and slope_noise(noise, self._step, width) > allowed:
                width = int(1.4 * width) | 1  # wider windows find slower rates, and allow less

    def _full_loading(self) -> float:
        """K (N/m) where the motion of the drive is known, K |u| (N/s) where it is not; from the force if need be."""
        if self._velocity is None:
            return self._known or _top(self._rate * np.sign(self._force))
        if self._stiffness:
            return self._stiffness
        moving = np.abs(self._velocity) > 0.5 * np.abs(self._velocity).max()
        return _top(self._rate[moving] / self._velocity[moving])

    @property
    def is_known(self) -> bool:
        """True if stiffness and speed say how fast a stick loads."""
        return bool(self._stiffness) and (self._velocity is not None or self._known is not None)

    def is_sustained(self) -> bool:
        """True if the force often rises just as fast as it ever does for long: the contact sticks then."""
        moving = self._velocity if self._velocity is not None else np.sign(self._force)
        rates = self._rate * np.sign(moving) / max(self.full_rate(), 1e-300)
        rates = rates[np.abs(moving) > 0.95 * np.abs(moving).max()]
        often = np.count_nonzero(np.abs(rates - 1.0) <= 0.5 * self._tolerance)
        return bool(often > max(0.5 * np.count_nonzero(rates > 0.3), 3 * self._width))

    def full_rate(self) -> float:
        """K |u| at the full speed of the drive (N/s)."""
        return self._full * (float(np.abs(self._velocity).max()) if self._velocity is not None else 1.0)

    def _sticking(self) -> Flags:
        """True if the slip speed is small, for each sample."""
        if not self._full > 0:
            return np.zeros(self._force.size, np.bool_)
        if self._velocity is not None:
            slip = np.abs(self._velocity - self._rate / self._full)
            return np.asarray(slip <= self._tolerance * np.abs(self._velocity).max())
        slow = np.abs(np.abs(self._rate) / self._full - 1.0) <= self._tolerance
        starts, ends = runs_of(slow)
        falls = self._force[starts] * self._force[ends] <= 0  # through zero
        is_loading = self._rate * self._force > 0
        return np.asarray(slow & (is_loading | within(starts[falls], ends[falls], slow.size)))

    # --- the phases ---------------------------------------------------------------------------------------------------

    def _turns_while_sticking(self, starts: Positions, ends: Positions) -> Flags:
        """True if the drive reverses between a phase and the next, for each gap: the contact sticks all the while.

        Such a gap leads to a phase in which the force falls through zero, is shorter than it, and the force does not
        fall faster in it, as it does in a slip.
        """
        if starts.size < 2:
            return np.zeros(0, np.bool_)
        after, before = starts[1:], ends[:-1]
        reverses = self._force[after] * self._force[ends[1:]] <= 0
        brief = after - before - 1 < ends[1:] - after + 1
        bounds = np.column_stack([before + 1, after]).ravel()
        fastest = np.maximum.reduceat(np.abs(self._rate), bounds)[::2]
        return np.asarray(reverses & brief & (fastest <= (1 + self._tolerance) * self._full))

    def _sharpened(self, starts: Positions, ends: Positions) -> tuple[Positions, Positions]:
        """Each phase grown, by at most a window, to where the force turns: the slopes near its ends are smeared.

        A phase in which the force does not change, that of a drive at rest, stays as it is.
        """
        force, last, resting = self._force, self._force.size - 1, self._tolerance * self.full_rate()
        sharp_starts, sharp_ends = starts.copy(), ends.copy()
        for i, (start, end) in enumerate(zip(starts.tolist(), ends.tolist(), strict=True)):
            middle = self._rate[start : end + 1].mean()
            if abs(middle) < resting:
                continue
            floor = sharp_ends[i - 1] + 1 if i else 0
            ceiling = starts[i + 1] - 1 if i + 1 < starts.size else last
            low, high = max(floor, start - self._width), min(ceiling, end + self._width)
            if low <= start:
                sharp_starts[i] = low + int(np.argmin(np.sign(middle) * force[low : start + 1]))
            sharp_ends[i] = end + int(np.argmax(np.sign(middle) * force[end : high + 1]))
        return sharp_starts, sharp_ends

    def _with_slow_sticks(self, starts: Positions, ends: Positions) -> tuple[Positions, Positions, Flags, float]:
        """The phases with those under a slow drive or one at rest, and the samples that are unclear.

        From a drop of usual size to the next one the contact sticks, and before the first of a stroke. Usual is at
        least half the size of those after which it sticks.
        """
        size, noise = self._force.size, noise_of(self._force)
        drops, force = find_drops(self._force, self._smallest_drop), np.abs(self._force)
        bottoms = np.array([  # the first sample as low as the trough: that may lie anywhere on a noisy plateau
            a + int(np.argmax(force[a : b + 1] <= force[b] + 4.0 * noise))
            for a, b in zip(drops.starts.tolist(), drops.ends.tolist(), strict=True)
        ], np.intp)  # fmt: skip
        next_stick = np.append(starts, 2 * size)[np.searchsorted(starts, drops.starts + 1)]
        again = next_stick - bottoms <= self._width
        usual = drops.sizes >= 0.5 * float(np.median(drops.sizes[again])) if again.sum() > 1 else np.zeros_like(again)
        begins, stops = np.append(0, bottoms + 1), np.append(drops.starts, size - 1)  # between drops
        stroke = self._strokes()
        first = np.append(-1, stroke[drops.starts]) != np.append(stroke[drops.starts], -1)  # of a stroke
        follows = np.append(False, usual) | first & np.append(usual, False)
        follows &= begins <= stops
        slow = within(begins[follows], stops[follows], size) & (np.abs(self._rate) <= _FAST * self._full)
        begins, stops = runs_of(slow & ~within(starts, ends, size))
        brief = max(self._width, int(np.median(bottoms - drops.starts)) if bottoms.size else 0)
        lasting = np.isin(begins - 1, ends) & np.isin(stops + 1, starts) | (stops - begins >= brief)
        fast, begins, stops = starts, begins[lasting], stops[lasting]
        starts, ends = np.sort(np.append(starts, begins)), np.sort(np.append(ends, stops))
        gaps, is_fast = starts[1:] - ends[:-1], np.isin(starts, fast)
        last = np.append(bottoms, -1)[np.searchsorted(drops.starts, starts[1:]) - 1]  # of the drops before
        together = (gaps <= self._width) & (last <= ends[:-1]) | (gaps <= 1) & ~(is_fast[1:] & is_fast[:-1])
        starts, ends = _joined(starts, ends, together)
        sticks = within(starts, ends, size)
        slides = ~sticks & ~within(drops.starts, bottoms, size)
        return starts, ends, self._unclear(slides, noise), self._rest(sticks)

    def _rest(self, sticking: Flags) -> float:
        """Time (s) that a drive at full speed would have saved to load the spring as far."""
        share = np.abs(self._rate) / self._full
        starts, ends = runs_of(sticking & (share < 1.0 - self._tolerance))
        long = ends - starts > 2 * self._width
        return self._step * float(np.sum(1.0 - share[within(starts[long], ends[long], share.size)]))

    def _strokes(self) -> Positions:
        """For each sample, how often the force had changed its sign, by more than noise."""
        clear = np.flatnonzero(np.abs(self._force) > _CLEAR * np.abs(self._force).max())
        turns = clear[1:][np.diff(np.sign(self._force[clear])) != 0]
        return np.searchsorted(turns, np.arange(self._force.size), "right")

    def _unclear(self, slides: Flags, noise: float) -> Flags:
        """Samples of a constant force, as far as it lasts up to a reversal of the drive or the end."""
        unclear, lasting = np.zeros(slides.size, np.bool_), min(4 * self._width + 1, slides.size - 2) | 1
        slides[np.flatnonzero(np.diff(self._strokes())) + 1] = False
        resting = np.abs(slope(self._force, self._step, lasting)) <= _LEVEL * self._full
        for start, end in zip(*(places.tolist() for places in runs_of(slides)), strict=True):
            quiet = np.flatnonzero(resting[start : end + 1])
            if quiet.size <= lasting:
                continue
            part = np.abs(self._force[start : start + int(quiet[-1]) + 1])
            value = float(np.median(part[-lasting:]))
            away = np.flatnonzero(np.abs(part - value) > max(5.0 * noise, _LEVEL * value))
            first = int(away[-1]) + 1 if away.size else 0
            if part.size - first > lasting:
                unclear[start + first : end + 1] = True
        return unclear


def _top(rates: Floats) -> float:
    """The fastest sustained loading rate, 0 if there is none: a spring is never loaded faster than in stick."""
    loading = rates[np.isfinite(rates) & (rates > 0)]
    if not loading.size:
        return 0.0
    top = float(np.quantile(loading, 0.998))
    for _ in range(3):
        top = float(np.median(loading[loading > 0.7 * top]))
    return top
