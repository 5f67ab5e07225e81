"""Defects of a record: where, what they do to which features, and what to do about them.

Each detector looks at arrays and says nothing of a clean record. What can be mended without inventing anything is:
samples that are none are left out, a force of the wrong sign is turned. Features that cannot survive are named, and
become NaN.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid  # type: ignore[import-untyped]

from stickslip.vocabulary.quantities import listed
from stickslip_rig.drive_motion import DRIVE, drive_displacement, drive_velocity, unusable_drive
from stickslip_rig.dropouts import SHORT, bridged, dropouts
from stickslip_rig.hum import Tone
from stickslip_rig.quantities import FORCES
from stickslip_rig.records import acceleration_of, condition_of, force_of
from stickslip_rig.signals import (
    Flags,
    Floats,
    Positions,
    find_drops,
    noise_of,
    runs_of,
    turning_points,
    within,
)
from stickslip_rig.sticks import Sticks

RAMPS = ("friction_speeding_up", "friction_slowing_down")
FRICTION = ("static_friction", "static_friction_first", "dynamic_friction", *RAMPS)
FORCE = ("static_force", "static_force_first", "dynamic_force", "drop_mean", "drop_max", "energy_per_stroke", *FRICTION)
COUNTS = ("sticks", "slips", "drops", "impulse_rate", "stick_fraction", "time_to_sliding")
LIMITED = ("acceleration_max_limited", "acceleration_integral_limited")
ACCELERATION = ("acceleration_max", "acceleration_integral", *LIMITED, "peak_frequency", "peak_acceleration")
MOTION = ("energy_per_stroke", "strokes", "travel", "impulse_rate")
_CONTRADICTIONS = ("loading rate", "unit", "zero", "speed", "clock", "columns")
TOTALS = (*COUNTS, *ACCELERATION, *MOTION, "dynamic_force", "dynamic_friction", "drop_max", "static_force_first",
          "static_friction_first")  # fmt: skip

_LONG = 5  # samples of the same value, at least, that are suspected
_LOST = 0.01  # of the record: what may be missing of it before sums and maxima are unknown
_PLAUSIBLE = (3e-3, 5.0)  # friction coefficients
_DECADES = 30.0  # a factor from here on is one of a wrong unit
_CLEAR = 0.05  # of the largest force, beyond which its sign is that of the stroke
_SWING = 0.02  # of the largest force, a swing that counts
_SUDDEN = 0.4  # of the time from drop to drop, that one takes at most
_OFFSET = 0.1  # of the sliding force
_FUNDAMENTAL = 130.0  # Hz: from here on a line of mains is a harmonic
_COARSE = 40  # samples from drop to drop, in which a stick may be missed
_SCATTERS = 0.02  # of the largest force, from sample to sample: few samples hide drops then
SAME_FORCE = 0.02  # how far the sliding force may depend on where the drive rests
_DIFFERS = 0.05  # of a way
_FASTER = 0.2  # of a speed, with its noise


@dataclass(frozen=True)
class Defect:
    """One defect: facts, a semicolon between them, and the features that do not survive it.

    again : whether only another record has those features.
    """

    name: str
    text: str
    spoils: tuple[str, ...] = ()
    again: bool = False


def remarks_of(defects: Sequence[Defect]) -> str:
    """A verdict, what is not determined, and a line for each fact; nothing of a clean record."""
    if not defects:
        return ""
    lost = dict.fromkeys(name for defect in defects for name in defect.spoils)
    if any(defect.again for defect in defects):
        verdict = "record it again"
    elif any(defect.name in _CONTRADICTIONS for defect in defects):
        verdict = "check this before you use the numbers"
    else:
        verdict = "use the other numbers" if lost else "use the numbers"
    if lost:
        verdict += f"\nnot determined: {', '.join(lost)}"
    facts = [f"{defect.name}: {fact}" for defect in defects for fact in defect.text.split("; ")]
    return "\n".join([verdict, *facts])


def reason_of(remarks: str) -> str:
    """The reason why features are not determined, in one line."""
    return "; ".join(line for line in remarks.splitlines() if not line.startswith("not determined"))


# --- the samples ------------------------------------------------------------------------------------------------------


def mended(record: xr.Dataset, tolerance: float) -> tuple[xr.Dataset, list[Defect]]:
    """The record without samples that are none, its force in the direction of the drive, and what was wrong.

    tolerance : of the slip speed.
    """
    force = next(name for name in FORCES if name in record)
    defects, missing = [], np.zeros(record.sizes["time"], np.bool_)
    for name in (str(name) for name in record.data_vars if name != "stick"):
        bad = dropouts(record, name, force)
        if not bad.any():
            continue
        text = f"{name} shows a marker, a spike or a value held in {_samples(record, bad)}; those samples are left out"
        defects.append(Defect("dropout", text))
        starts, ends = runs_of(bad)
        brief = ends - starts < SHORT
        short = within(starts[brief], ends[brief], bad.size)
        missing |= bad & ~short
        record = record.assign({name: record[name].copy(data=bridged(record[name].values, short))})
    if missing.any() and missing.mean() < 0.9:
        record = record.isel(time=~missing)
    acceleration = acceleration_of(record)
    for name, spoils in ((force, (*FORCE, *COUNTS)), ("acceleration", ACCELERATION)):
        if name not in record:
            continue
        values = record[name].values
        if np.ptp(values) == 0:
            text = f"{name} is {values[0]:g} throughout: is the sensor connected?"
            defects.append(Defect("dead channel", text, spoils, again=True))
        elif (flat := _flat(values, acceleration)).any():
            text = f"{name} is cut off in {_samples(record, flat)}; its peaks are higher than the range of the sensor"
            defects.append(Defect("saturation", text, spoils, again=True))
    if reason := unusable_drive(record, record[force].values, tolerance):
        of_drive = [name for name in DRIVE if name in record]
        defects.append(Defect("drive", f"{listed(of_drive, 'and')} {reason}; it is not used"))
        record = record.drop_vars(of_drive)
    if _is_opposite(record, record[force].values):
        defects.append(Defect("sign", f"{force} is opposite to the motion of the drive; it is turned"))
        record = record.assign({name: -record[name] for name in FORCES if name in record})
    return record, defects


def _flat(values: Floats, acceleration: Floats) -> Flags:
    """Samples at the top or bottom of a channel that cut off a signal on its way: as steep in front as further off."""
    flat = np.zeros(values.size, np.bool_)
    inner = values[(values > values.min()) & (values < values.max())]
    noisy = inner.size > 2 and noise_of(inner) > 1e-6 * np.ptp(values)
    quantum = float(np.abs(np.diff(values)[np.diff(values) != 0]).min(initial=np.inf))
    for extreme in (values.min(), values.max()):
        at = values == extreme
        starts, ends = runs_of(at)
        longest = (ends - starts + 1).max()
        usable = (ends - starts >= 2) & (starts > 6) & (ends < values.size - 7)
        starts, ends = starts[usable], ends[usable]
        if starts.size < 3 and not (starts.size and longest >= _LONG):
            continue
        before = np.stack([starts - 3, starts - 5, ends + 1, ends + 3])
        near_in, far_in, near_out, far_out = np.abs(values[before + 2] - values[before]).sum(axis=1)
        entry, leave = near_in + far_in, near_out + far_out
        steep = near_in > 0.7 * far_in if entry > leave else near_out > 0.7 * far_out
        high = max(entry, leave) / starts.size > max(16.0 * quantum, 1e-6 * np.ptp(values))
        # steady sliding without noise is as flat, but then the specimen rests, and the force falls as it rose
        moves = np.abs(acceleration[at]).mean() > 0.3 * np.abs(acceleration).mean()
        if steep and high and (noisy or moves or leave > 1.5 * entry):
            flat |= at
    return flat


def _is_opposite(record: xr.Dataset, force: Floats) -> bool:
    """True if the specimen does work on the drive, not the other way round."""
    way = drive_displacement(record)
    if way is None or not np.ptp(way) > 0:
        return False
    work = 0.5 * (force[1:] + force[:-1]) * np.diff(way)
    return bool(work.any() and work.sum() <= -0.5 * np.abs(work).sum())


def _samples(record: xr.Dataset, inside: Flags) -> str:
    """The number of samples, and the first spans of time in which they lie."""
    return f"{int(inside.sum())} samples ({_spans(record['time'].values, *runs_of(inside))})"


def _spans(time: Floats, starts: Positions, ends: Positions) -> str:
    """The first spans of time (s), from position to position."""
    first = [f"{time[a]:.4g} to {time[b]:.4g} s" if a < b else f"{time[a]:.4g} s"
             for a, b in zip(starts[:3], ends[:3], strict=True)]  # fmt: skip
    return ", ".join(first) + (" ..." if starts.size > 3 else "")


# --- time -------------------------------------------------------------------------------------------------------------


def of_time(time: Floats, gaps: Positions) -> Iterator[Defect]:
    """Gaps, and a clock whose steps change."""
    steps, duration = np.diff(time), float(time[-1] - time[0])
    if gaps.size:
        missing = float(steps[gaps].sum())
        text = f"{100.0 * missing / duration:.2g} % of the time is missing ({_spans(time, gaps, gaps + 1)})"
        if missing < _LOST * duration:
            yield Defect("gap", text + "; counts and integrals are of what was recorded, and at least that")
        else:
            yield Defect("gap", text, TOTALS, True)
    tenth = max(1, steps.size // 10)
    first, last = float(np.median(steps[:tenth])), float(np.median(steps[-tenth:]))
    regular = np.median(np.abs(steps[:tenth] - first)) < 0.002 * first
    if regular and abs(last / first - 1.0) > 0.005:
        yield Defect("clock", f"its step changes from {first:.4g} to {last:.4g} s; times are taken as they are")


# --- what contradicts itself ------------------------------------------------------------------------------------------


def of_scales(
    samples: xr.Dataset, sticks: Sticks, values: dict[str, float | Floats], tolerance: float
) -> Iterator[Defect]:
    """Units, stiffness and speed that cannot be true together; channels and a zero that are not those of the motion."""
    record, ratio = sticks.record, sticks.loading / sticks.expected
    force, acceleration = force_of(record), acceleration_of(record)
    mass, stiffness = condition_of(record, "mass"), condition_of(record, "stiffness")
    wrong = max(ratio, 1.0 / ratio) if np.isfinite(ratio) else 1.0
    known = [values[name] for name in FRICTION if np.isfinite(values[name])]
    plausible = bool(known) and _PLAUSIBLE[0] <= max(known) <= _PLAUSIBLE[1]
    if wrong > 1.0:
        rates = f"{sticks.loading:.4g} N/s where it sticks, stiffness times speed are {sticks.expected:.4g} N/s"
        text = f"the force rises by {rates}; one of the three is wrong by a factor of {wrong:.4g}"
        spoils: tuple[str, ...] = () if drive_displacement(record) is not None else ("travel", "impulse_rate")
        if wrong > _DECADES and not plausible:
            text, spoils = text + "; is the force in N or mN?", (*FORCE, *spoils)
        yield Defect("loading rate", text, spoils)
    elif known and not plausible:
        yield Defect("unit", f"a friction coefficient of {max(known):.3g}: are force (N or mN?) and load right?", FORCE)
    drop, top = float(values["drop_max"]), float(np.quantile(np.abs(acceleration), 0.9999))
    share = 2.0 * mass * top / drop if mass and top and np.isfinite(drop) and wrong < _DECADES else 0.0
    if share and not 1.0 / _DECADES < share < _DECADES:
        text = f"mass times acceleration is {share:.2g} of the force it comes from: is it in m/s2, and the force in N?"
        yield Defect("unit", text, ACCELERATION)
    natural = np.sqrt(stiffness / mass) / (2.0 * np.pi) if mass and stiffness and wrong == 1.0 else 0.0
    yield from _of_sampling(force, sticks, values, natural)
    whole, clear = sticks.sliding_forces()
    if not abs(whole - clear) <= SAME_FORCE * clear and np.isfinite(clear):
        ends = f"{min(whole, clear):.3g} or {max(whole, clear):.3g} N"
        text = f"the sliding force is {ends}, as the drive rests before it reverses or not; record its displacement"
        yield Defect("drive", text, ("dynamic_force", "dynamic_friction"))
    if "stick" not in record:
        yield from _of_counts(force, sticks)
    yield from _of_drive(samples, force_of(samples), drive_velocity(record, tolerance))


def _of_counts(force: Floats, sticks: Sticks) -> Iterator[Defect]:
    """Sticks and drops of the force that differ by more than a factor of two: each drop ends a stick, and each stick
    but that after a reversal of the drive begins with one."""
    drops = find_drops(force)
    sizes = drops.sizes
    large = int(np.count_nonzero(sizes >= 0.5 * sizes.max(initial=0.0)))
    if large > 1 and np.median(drops.ends - drops.starts) > _SUDDEN * np.median(np.diff(drops.starts)):
        large = 0  # friction that falls while the drive speeds up, or a wave
    swings = turning_points(force, _SWING * float(np.abs(force).max())).size // 2 if force.any() else 0
    strokes = np.count_nonzero(np.diff(np.sign(force[np.abs(force) > _CLEAR * np.abs(force).max()]))) + 1
    if large > max(2 * sticks.count, 2) or sticks.count > 2 * (max(sizes.size, swings) + strokes):
        count = f"{sticks.count} sticks and {sizes.size} drops of the force"
        yield Defect("columns", f"{count}: is each column what its heading says? Else it vibrates without sticking")


def _of_sampling(force: Floats, sticks: Sticks, values: dict[str, float | Floats], natural: float) -> Iterator[Defect]:
    """Too few samples for vibration at the natural frequency (Hz, 0 if not known), for slips, or for sticks."""
    rate, scatter = float(values["sample_rate"]), noise_of(force)
    if rate < 4.0 * natural or (rate < 10.0 * natural and scatter > _SCATTERS * np.abs(force).max()):
        text = f"{rate:.4g} samples per second, the specimen vibrates at {natural:.4g} Hz; record faster"
        yield Defect("sampling", text, (*ACCELERATION, *COUNTS, *FORCE), True)
    starts, ends = sticks.slips()
    if starts.size > 3 and np.median(ends - starts) < 4:
        text = f"a slip is {np.median(ends - starts):.0f} samples long: its peaks lie between them; record faster"
        yield Defect("sampling", text, (*ACCELERATION, "drop_mean", "drop_max", "time_to_sliding"), True)
    drops = int(values["drops"])
    if drops > 2 * sticks.count + 5 and force.size < _COARSE * drops:
        text = f"{drops} drops of the force, {sticks.count} sticks: too few samples for so short sticks; record faster"
        spoils = tuple(name for name in (*COUNTS, *FORCE) if not name.startswith("drop"))
        yield Defect("sampling", text, spoils, True)


def _of_drive(record: xr.Dataset, force: Floats, velocity: Floats | None) -> Iterator[Defect]:
    """A zero of the force that is none, a speed that is not the drive's, and a way that is not that of its speed."""
    direction = record["drive_velocity"].values if "drive_velocity" in record else force
    forward = force[direction > 0.5 * max(direction.max(), 0.0)]
    backward = force[direction < 0.5 * min(direction.min(), 0.0)]
    if min(forward.size, backward.size) > 0.05 * force.size:
        up, down = float(np.median(forward)), float(np.median(backward))
        offset, level = 0.5 * (up + down), 0.5 * (up - down)
        if abs(offset) > _OFFSET * level > 0:
            text = f"the force is {up:.3g} N forward and {down:.3g} N backward; its offset or drift is {offset:.3g} N"
            yield Defect("zero", text, tuple(name for name in FORCE if name.startswith("static")))
    if velocity is None:
        return
    top, speed = float(np.quantile(np.abs(velocity), 0.99)), condition_of(record, "drive_speed")
    if speed and abs(top / speed - 1.0) > _FASTER:
        yield Defect("speed", f"the drive moves at up to {top:.4g} m/s, the speed given is {speed:.4g} m/s")
    if {*DRIVE} <= {*record}:
        way = float(np.ptp(record["drive_displacement"].values))
        moved = float(np.ptp(cumulative_trapezoid(record["drive_velocity"].values, record["time"].values, initial=0)))
        if way > 0 and abs(moved / way - 1.0) > _DIFFERS:
            text = f"the drive moves {moved:.4g} m by its velocity and {way:.4g} m by its displacement; clock or unit?"
            yield Defect("clock", text, MOTION)


# --- hum --------------------------------------------------------------------------------------------------------------

_SHOWN = ("sticks", "static_friction_first", "static_friction", "dynamic_friction", "acceleration_max",
          "acceleration_integral")  # fmt: skip


def of_hum(
    tones: list[Tone], sticks: Sticks, before: dict[str, float | Floats], after: dict[str, float | Floats],
    tolerance: float,
) -> Iterator[Defect]:  # fmt: skip
    """Lines that were subtracted, how features moved by that, and which ones the rest of it may still spoil."""
    for channel, unit, features in (("force", "N", (*COUNTS, *FORCE)), ("acceleration", "m/s2", ACCELERATION)):
        own = [tone for tone in tones if tone.channel == channel]
        if not own:
            continue
        lines = ", ".join(f"{t.amplitude:.3g} {unit} at {t.frequency:.2f} Hz" for t in own)
        numbers = {name: (f"{before[name]:.4g}", f"{after[name]:.4g}") for name in _SHOWN if name in features}
        moved = [f"{name} from {old} to {new}" for name, (old, new) in numbers.items() if old != new]
        facts = [f"{lines} in the {channel}, subtracted", f"that changes {', '.join(moved)}" if moved else ""]
        rate = sum(2.0 * np.pi * t.frequency * min(t.left, t.amplitude) for t in own)
        lasting = float(np.median(sticks.time[sticks.ends] - sticks.time[sticks.starts])) if sticks.count else np.inf
        lowest = min(t.frequency for t in own)
        unsure = lasting < 0.5 / lowest or lowest > _FUNDAMENTAL  # sticks are those of the hum, or more of it is there
        strong = channel == "force" and (unsure or not rate <= 0.1 * tolerance * sticks.loading)
        facts.append("it is too strong to be subtracted well enough" if strong else "")
        yield Defect("hum", "; ".join(filter(None, facts)), features if strong else (), strong)
