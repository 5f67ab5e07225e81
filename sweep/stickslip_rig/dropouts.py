"""Samples of a channel that are none: markers, values that are held, spikes.

A spring force, and the place and the speed of a drive, do not jump from one sample to the next and back: what does is
of the instrument.
"""

import numpy as np
import xarray as xr
from scipy import ndimage  # type: ignore[import-untyped]

from stickslip_rig.drive_motion import DRIVE, counted_step
from stickslip_rig.records import acceleration_of, has_inertia
from stickslip_rig.signals import Flags, Floats, noise_of, runs_of

_HELD = 5  # samples of the same value, at least, that are suspected
_REPEATS = 0.02  # of the samples of a channel with noise repeat the one before
_JUMP = 8.0  # times the steps beside it
_MARKER = 10.0  # times the largest other magnitude
SHORT = 10  # samples: a straight line across them loses nothing; a spike is no longer
_ROUNDS = 3
_FROZEN = 3.0  # times the steps beside it: the jump after a value was held, where a channel hardly repeats one
_BEYOND = 3.0  # times the largest other acceleration
_CALM = 3.0  # times its usual step: how far a force changes while nothing happens
_SPAN = 13  # steps, whose median is the usual one
_LEAST = 0.02  # of the largest force: a smaller spike is no drop
_RETURNS = 0.25  # of a spike: how far the samples before and after it may be apart
_MOST = 0.1  # of the samples: more of them are the signal


def dropouts(record: xr.Dataset, name: str, force: str) -> Flags:
    """Samples of a channel that are none. force : the channel that the rig measures."""
    values = record[name].values
    if name in DRIVE:
        return spikes(values, 4.0 * counted_step(values))
    bad = markers(values)
    if bad.all() or name not in (force, "acceleration"):
        return bad  # friction beside a spring force jumps where the contact breaks away
    least = _LEAST * float(np.abs(values[~bad]).max())
    if name == force:
        if name != "friction_force" or not has_inertia(record):
            bad |= spikes(bridged(values, bad), least)
        return bad | _held(bridged(values, bad), acceleration_of(record))
    spiky = spikes(bridged(values, bad), least)  # an acceleration shows shocks; but not while the force does nothing
    steps = np.abs(np.diff(record[force].values, append=record[force].values[-1]))
    calm = ndimage.maximum_filter1d(steps, _SPAN) <= _CALM * float(np.median(steps))
    beyond = np.abs(values) > _BEYOND * float(np.abs(values[~(bad | spiky)]).max())
    return np.asarray(bad | (spiky & calm & beyond))


def spikes(values: Floats, least: float) -> Flags:
    """Samples that a jump leads to and one of the opposite sign back from, to where the channel was going.

    least : of a jump.
    """
    bad = np.zeros(values.size, np.bool_)
    for _ in range(_ROUNDS):  # of spikes beside each other only some stand out at first
        whole = bridged(values, bad)
        steps = np.diff(whole)
        usual = _JUMP * ndimage.median_filter(np.abs(steps), _SPAN, mode="nearest")
        jumps = np.flatnonzero(np.abs(steps) > np.maximum(usual, max(_JUMP * noise_of(whole), least))).tolist()
        more = np.zeros_like(bad)
        for k, start in enumerate(jumps):
            near = [end for end in jumps[k + 1 : k + 1 + SHORT] if end - start <= SHORT]
            for end in near if not more[start] else ():
                inside = whole[start + 1 : end + 1]
                line = np.linspace(whole[start], whole[end + 1], inside.size + 2)[1:-1]
                away = (inside - line) * np.sign(steps[start])
                if abs(whole[end + 1] - whole[start]) <= _RETURNS * away.min():
                    more[start + 1 : end + 1] = True
                    break
        if not more.any():
            break
        bad |= more
    return bad if bad.mean() <= _MOST else np.zeros_like(bad)


def bridged(values: Floats, bad: Flags) -> Floats:
    """The channel with straight lines across the samples that are none."""
    at = np.arange(values.size)
    return np.interp(at, at[~bad], values[~bad]) if bad.any() else values


def markers(values: Floats) -> Flags:
    """Samples far beyond all others, as -9999 stands for none."""
    bad = np.zeros(values.size, np.bool_)
    for extreme in (values.min(), values.max()):
        rest = values[(values != extreme) & ~bad]
        if rest.size and abs(extreme) > _MARKER * np.abs(rest).max() > 0:
            bad |= values == extreme
    return bad


def _held(values: Floats, acceleration: Floats) -> Flags:
    """Samples of the same value that a jump leads to and from, or a jump back to where the force was going.

    A spring force does not jump: its steps beside these samples tell how fast it changes. Where no sample repeats both
    channels but a few, those are held as well.
    """
    repeats = np.diff(values) == 0
    least = _FROZEN if np.count_nonzero(np.diff(repeats)) < _REPEATS * values.size else _JUMP
    same = repeats & (np.diff(acceleration) == 0)
    frozen = same & (acceleration[1:] != 0) if same.mean() < _REPEATS else np.zeros(same.size, np.bool_)
    bad, last = np.zeros(values.size, np.bool_), values.size - 1
    starts, ends = runs_of(np.append(repeats, False))
    ends = ends + 1
    suspected = ends - starts + 1 >= _HELD
    for start, end in zip(starts[suspected].tolist(), ends[suspected].tolist(), strict=True):
        beside = [np.abs(np.diff(part)) for part in (values[max(start - 6, 0) : start], values[end + 1 : end + 7])]
        step = max((part.max() for part in beside if part.size), default=0.0)
        before = values[start] - values[max(start - 1, 0)]
        after = values[min(end + 1, last)] - values[end]
        there, back = abs(before) > _JUMP * step, abs(after) > least * step
        expected = (values[start] - values[start - 5]) / 5 * (end + 1 - start) if start > 5 else np.nan
        where_it_went = abs(after - expected) < abs(after) / 2
        if step > 0 and ((there and back) or (back and where_it_went)):
            bad[start : end + 1] = True
    starts, ends = runs_of(np.append(frozen, False))
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        bad[start + 1 : end + 2] |= end - start + 2 >= _HELD
    return bad
