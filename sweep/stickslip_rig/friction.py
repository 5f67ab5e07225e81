"""Friction over slip speed, while it rises and while it falls, from a record of stick-slip.

mu_start and mu_stop are friction extrapolated to standstill, before and behind the turning point, where the slip speed
is greatest. Close to standstill little can be seen while slip slows down: sensors smear the jump at re-stick. There the
shape of friction while the speed rose, times a factor, is one of the functions that are fitted. An interval holds what
differs from slip to slip (sandwich estimate over slips); what the degree of the polynomial, or the range of the slip
speed near the turning point, changes; what the sensors do, which is what one more filter as slow as they are does; and
`_UNSEEN`. The latter three are added up for what is extrapolated, else, and to the first, in quadrature.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy import ndimage, stats  # type: ignore[import-untyped]

from stickslip.dataset.build import attributes_of
from stickslip.vocabulary.display_units import quantity
from stickslip.vocabulary.parameter import Variable
from stickslip.vocabulary.quantities import listed
from stickslip_rig import defects
from stickslip_rig.evaluation import along_record
from stickslip_rig.quantities import CONDITIONS
from stickslip_rig.records import condition_of
from stickslip_rig.sections import FeatureSettings
from stickslip_rig.signals import Floats, Positions, sample_rate
from stickslip_rig.specimen import STEADY, SpecimenMotion, motion_of
from stickslip_rig.sticks import Sticks, find_sticks

FEWEST_SAMPLES, FEWEST_SLIPS = 8, 3  # of a slip; of a record
COEFFICIENTS = ("mu_start", "mu_reversal", "v_reversal", "mu_stop", "tendency")
_UNSEEN = 0.0005  # of the drop from mu_start to mu_reversal: what sampling leaves of clean records
_WIDEST = 0.3  # of that drop: half an interval that says nothing any more
_SLOWEST = {"mu_reversal": 0.12, "v_reversal": 0.12, "mu_stop": 0.06}  # of a slip: rise times of sensors that show it
_NOISES, _SHARE = 3.0, 0.02  # deviations of the slip speed in sticks, share of its peak: what is slip
_LEFT_OUT = 0.1  # of the slips: so many are worth a remark
_STEPS = 2.5  # deviations of a Gaussian filter in its rise time
_EXTRAPOLATED = ("mu_start", "mu_stop")
_BINS = 16  # of the slip speed, in each direction

_NONE = np.full((2, _BINS + 2), np.nan)
_VALUES = (
    Variable("mu_start", "1", "friction coefficient at break-away"),
    Variable("mu_reversal", "1", "friction coefficient where the slip speed is greatest"),
    Variable("v_reversal", "m s-1", "greatest slip speed"),
    Variable("mu_stop", "1", "friction coefficient just before standstill"),
    Variable("tendency", "1", "stick-slip tendency mu_start - 2 mu_reversal + mu_stop"),
)
_POINT, _DIRECTIONS = ("direction", "bin"), ["rising", "falling"]
_POINTS = (
    Variable("slip_speed", "m s-1", "slip speed, mean of a bin", dims=_POINT),
    Variable("friction", "1", "friction coefficient, mean of a bin", dims=_POINT),
    Variable("friction_sigma", "1", "standard deviation of that mean", dims=_POINT),
    Variable("friction_scatter", "1", "standard deviation of the samples of a bin", dims=_POINT),
)
_COUNTS = (
    Variable("slips_used", "1", "slips that are evaluated"),
    Variable("slips_left_out", "1", "slips that are too short, or during which the drive changes its speed"),
)


class CoefficientEstimate(NamedTuple):
    """A value, its standard deviation from slip to slip, and by how much it may be off besides."""

    value: float
    deviation: float = np.nan
    systematic: float = np.nan


Estimates = dict[str, CoefficientEstimate]  # of the coefficients, by name


class _Slip(NamedTuple):
    """Positions of the first sample, of the greatest slip speed and of the last sample; direction of the drive."""

    first: int
    top: int
    last: int
    sign: float


class _Samples(NamedTuple):
    """Samples of all slips, of one direction: slip speed (m/s), friction coefficient, number of the slip."""

    speed: Floats
    friction: Floats
    slip: Positions

    def those(self, which: Any) -> "_Samples":
        return _Samples(*(values[which] for values in self))


def friction(record: xr.Dataset, settings: FeatureSettings | None = None) -> xr.Dataset:
    """Measure friction over slip speed in a record of stick-slip.

    Parameters
    ----------
    record
        As of `read_record` or `make_record`, with the acceleration, and the conditions normal_load, mass, stiffness and
        damping. Without damping there is none; stiffness is seen in sticks, mass where something rings after them.
    settings
        Of stick phases.

    Returns
    -------
    Dataset
        mu_start, mu_reversal, v_reversal, mu_stop and tendency, Eq. (3) of the article, with the ends of 95 % intervals
        (`mu_start_low`, `mu_start_high`), NaN where the record does not tell; slips_used and slips_left_out; and over
        `direction` (rising, falling) and `bin` slip_speed, friction, friction_sigma and friction_scatter. The
        coordinate `remarks` says why something is not told, and what to mind.

    Raises
    ------
    ValueError
        Where the acceleration or a condition is lacking.
    """
    settings = settings or FeatureSettings()
    if "acceleration" not in record or not record["acceleration"].values.any():
        raise ValueError("friction needs the acceleration of the specimen: got a record without it, or 0 throughout")
    if (load := condition_of(record, "normal_load")) is None:
        raise ValueError(
            "the normal load is not known: give it as a remark of the file, '# load: 10 N', or as an option"
        )
    record, wrong = defects.mended(record, settings.tolerance)
    sticks, remarks = find_sticks(record, settings), [defect.text for defect in wrong]
    motion = motion_of(sticks, load, settings.tolerance, remarks)
    slips, left_out = _slips(sticks, motion)
    estimates = dict.fromkeys(COEFFICIENTS, CoefficientEstimate(np.nan))
    points = dict.fromkeys((v.name for v in _POINTS), _NONE)
    if len(slips) >= FEWEST_SLIPS:
        estimates, points = _evaluated(slips, motion, motion.stiffness / load / sample_rate(sticks.time), remarks)
    else:
        remarks.append(f"{len(slips)} slips of {FEWEST_SAMPLES} samples or more under a steady drive, expected "
                       f"{FEWEST_SLIPS}: nothing is told; sample faster, or use a softer spring")  # fmt: skip
    if left_out > _LEFT_OUT * len(slips):
        remarks.append(f"slips left out: {left_out}, shorter than {FEWEST_SAMPLES} samples, or of an unsteady drive")
    conditions: dict[str, Any] = {str(name): c.variable for name, c in record.coords.items() if not c.dims}
    for name in ("mass", "stiffness"):  # as they were taken
        conditions[name] = xr.Variable((), getattr(motion, name), {"units": CONDITIONS[name].units, "long_name": name})
    conditions |= {"direction": _DIRECTIONS, "remarks": "\n".join(remarks)}
    return _dataset(estimates, points, (len(slips), left_out), conditions, record)


def friction_table(records: Mapping[str, xr.Dataset], settings: FeatureSettings | None = None) -> xr.Dataset:
    """Friction of several records, by name, along `record`. Raises ValueError.

    Conditions that only some records know are NaN, or an empty text, for the others.
    """
    rows = {name: friction(record, settings).drop_vars("direction") for name, record in records.items()}
    table = along_record(rows).assign_coords(direction=_DIRECTIONS)
    return table.assign_attrs(title="Friction from records of a rig")


# --- slips -----------------------------------------------------------------------------------------------------------


def _slips(sticks: Sticks, motion: SpecimenMotion) -> tuple[list[_Slip], int]:
    """The slips that are long enough, under a steady drive and between two sticks, and how many others there are."""
    slips, speed = [], motion.slip_speed
    starts, ends = sticks.slips()
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        sign = float(np.sign(motion.drive[start]))
        top = start + int(np.argmax(sign * speed[start : end + 1]))
        still = sign * speed <= max(_NOISES * motion.noise, _SHARE * sign * speed[top])
        before, after = np.flatnonzero(still[:top]), np.flatnonzero(still[top:])
        if not (before.size and after.size):
            continue
        first, last = int(before[-1]) + 1, top + int(after[0]) - 1
        if last < first:
            continue
        slip = _Slip(first, first + int(np.argmax(sign * speed[first : last + 1])), last, sign)
        length = slip.last - slip.first + 1
        drive = motion.drive[max(slip.first - 5, 0) : slip.last + 5]
        room = length < slip.first and slip.last + length < speed.size
        if length >= FEWEST_SAMPLES and room and np.ptp(drive) <= STEADY * abs(drive).max():
            slips.append(slip)
    return slips, starts.size - len(slips)


# --- the coefficients -------------------------------------------------------------------------------------------------


def _evaluated(
    slips: list[_Slip], motion: SpecimenMotion, loading: float, remarks: list[str]
) -> tuple[Estimates, dict[str, Floats]]:
    """The coefficients, their systematic parts with all that is known of them, and the points.

    loading : change of the coefficient in a stick from sample to sample, over the speed of the drive.
    """
    rise = _rise(slips, motion)
    sides = _sides(slips, motion.slip_speed, motion.friction, rise)
    speed, friction = (ndimage.gaussian_filter1d(values, rise / _STEPS) for values in motion[:2])
    plain, slower = _coefficients(*sides), _coefficients(*_sides(slips, speed, friction, np.sqrt(2.0) * rise))
    drop, estimates = plain["mu_start"].value - plain["mu_reversal"].value, {}
    for name, estimate in plain.items():
        unseen = 0.0 if name == "v_reversal" else _UNSEEN * drop
        off = np.linalg.norm(
            [estimate.systematic, estimate.value - slower[name].value, unseen], 1 if name in _EXTRAPOLATED else 2
        )
        estimates[name] = estimate._replace(systematic=float(off))
    _check_break_away(estimates, slips, motion, loading * (rise + 1.0), remarks)
    _leave_out(estimates, sides[1], rise, len(slips), float(np.median([s.last - s.first + 1 for s in slips])), remarks)
    parts = (estimates["mu_start"], estimates["mu_reversal"], estimates["mu_stop"])
    value, *errors = (np.array(column) * (1.0, -2.0, 1.0) for column in zip(*parts, strict=True))
    estimates["tendency"] = CoefficientEstimate(float(value.sum()), *(float(np.linalg.norm(error)) for error in errors))
    turn = (estimates["v_reversal"].value, estimates["mu_reversal"])
    ends = [[(0.0, estimates["mu_start"]), turn], [(0.0, estimates["mu_stop"])]]
    slow = _sides(slips, motion.slip_speed, friction, rise)
    points = [_binned(sides[i], slow[i].friction, ends[i], len(slips)) for i in (0, 1)]
    return estimates, {name: np.stack(pair) for name, *pair in zip((v.name for v in _POINTS), *points, strict=True)}


def _check_break_away(
    estimates: Estimates, slips: list[_Slip], motion: SpecimenMotion, loading: float, remarks: list[str]
) -> None:
    """Take the friction at which sticks end for mu_start where it is above that with which slip begins.

    loading : by how much it rises, over the speed of the drive, while sensors follow.
    """
    static = float(np.mean([s.sign * motion.friction[s.first - 5 : s.first + 5] for s in slips], axis=0).max())
    start, off = estimates["mu_start"], loading * abs(float(motion.drive[slips[0].first]))
    if static - off > start.value + 2.0 * (start.deviation + start.systematic):
        remarks.append(f"break-away is at {static:.4g}, above friction as slip begins, {start.value:.4g}")
        estimates["mu_start"] = start._replace(value=static, systematic=start.systematic + off)


def _leave_out(
    estimates: Estimates, falling: _Samples, rise: float, slips: int, length: float, remarks: list[str]
) -> None:
    """Replace by NaN what the record does not tell, and say why. rise, length : of sensors and of slips, samples."""
    start, stop = estimates["mu_start"], estimates["mu_stop"]
    drop, half = start.value - estimates["mu_reversal"].value, _half(stop, slips)
    if blurred := [name for name, share in _SLOWEST.items() if rise > share * length]:
        what = f"sensors take {rise:.2g} samples to follow a jump, a slip lasts {length:.0f}"
        names = listed(blurred, "and")
        remarks.append(f"{what}: {names} cannot be told; faster sensors, or a softer spring, show more")
        estimates |= dict.fromkeys(blurred, CoefficientEstimate(np.nan))
    elif not (half <= _WIDEST * drop and stop.value - start.value <= half + _half(start, slips)):
        slowest = quantity(float(np.quantile(falling.speed, 0.02)), "m s-1")
        remarks.append(f"mu_stop cannot be told: of the fall {slowest} is the slowest seen, below friction may change")
        estimates["mu_stop"] = CoefficientEstimate(np.nan)


def _rise(slips: list[_Slip], motion: SpecimenMotion) -> float:
    """How many samples the sensors take to follow the jump of the acceleration at re-stick."""
    half = max(4, min((slip.last - slip.first) // 3 for slip in slips))
    around = np.arange(-half, half + 1)
    jump = np.mean([slip.sign * motion.acceleration[slip.last + around] for slip in slips], axis=0)
    return float(np.ptp(jump) / np.abs(np.diff(jump)).max())


def _sides(slips: list[_Slip], speed: Floats, friction: Floats, rise: float) -> tuple[_Samples, _Samples]:
    """The samples while the slip speed rises, and while it falls, those left out that sensors mix with the stick."""
    ends = [max(slip.last + 1 - int(np.ceil(rise)), slip.top + 2) for slip in slips]
    ranges = [[np.arange(slip.first, slip.top + 1) for slip in slips],
              [np.arange(slip.top, end) for slip, end in zip(slips, ends, strict=True)]]  # fmt: skip
    sides = []
    for parts in ranges:
        at, number = np.concatenate(parts), np.repeat(np.arange(len(slips)), [part.size for part in parts])
        sign = np.array([slip.sign for slip in slips])[number]
        sides.append(_Samples(sign * speed[at], sign * friction[at], number))
    return sides[0], sides[1]


def _coefficients(rising: _Samples, falling: _Samples) -> Estimates:
    """The coefficients that samples give by themselves."""
    start = _at_standstill(rising, (2, 3), 4.0)
    steps = np.unique(np.quantile(rising.speed, np.linspace(0.0, 1.0, 41)))
    means = [stats.binned_statistic(rising.speed, values, bins=steps).statistic for values in rising[:2]]
    speeds, levels = (
        [end, *values[np.isfinite(values)]] for end, values in zip((0.0, start.value), means, strict=True)
    )
    stop = _at_standstill(falling, (1, 2), 2.0, lambda speed: np.interp(speed, speeds, levels) - start.value)
    last = np.searchsorted(rising.slip, np.arange(rising.slip[-1] + 1), "right") - 1  # the greatest, of each slip
    top, beyond = rising.speed[last], falling.speed[np.searchsorted(falling.slip, np.arange(rising.slip[-1] + 1)) + 1]
    before = rising.speed[last - 1]
    bend = 2.0 * top - beyond - before
    peak = top + (beyond - before) ** 2 / (8.0 * bend) + bend / 6.0  # of a parabola, whose slopes are over two samples
    turns = [_at_turn(rising, falling, top, share) for share in (0.85, 0.75)]
    return {
        "mu_start": start,
        "mu_reversal": turns[0]._replace(systematic=abs(turns[0].value - turns[1].value)),
        "v_reversal": CoefficientEstimate(float(peak.mean()), float(stats.sem(peak)), float(bend.mean() / 6.0)),
        "mu_stop": stop,
    }


def _at_standstill(
    samples: _Samples, degrees: tuple[int, ...], reach: float, shape: Callable[[Floats], Floats] | None = None
) -> CoefficientEstimate:
    """Friction at slip speed 0: a polynomial, and `shape`, 0 there, through all samples up to a speed.

    Of these speeds, at least `reach` times the lowest, and of the degrees it takes what is known best: deviation, and
    change by the next degree, the largest of three neighbouring speeds.
    """
    samples = samples.those(np.argsort(samples.speed, kind="stable"))
    lowest = samples.speed[min(samples.slip.max(initial=0) // 2, samples.speed.size - 1)]
    sizes = np.unique(np.geomspace(FEWEST_SAMPLES, max(samples.speed.size, FEWEST_SAMPLES), 24).astype(int))
    sizes = sizes[
        (sizes <= samples.speed.size) & (samples.speed[sizes.clip(max=samples.speed.size) - 1] > reach * lowest)
    ]
    if not sizes.size:
        return CoefficientEstimate(np.nan)
    fits = np.array([[_intercept(samples.those(slice(size)), degree, shape) for degree in (*degrees, degrees[-1] + 1)]
                     for size in sizes.tolist()])  # fmt: skip
    change = ndimage.maximum_filter1d(np.abs(np.diff(fits[:, :, 0], axis=1)), 3, axis=0, mode="nearest")
    i, degree = np.unravel_index(np.argmin(np.hypot(fits[:, :-1, 1], change)), change.shape)
    value, deviation = fits[i, degree].tolist()
    return CoefficientEstimate(value, deviation, float(change[i, degree]))


def _intercept(samples: _Samples, degree: int, shape: Callable[[Floats], Floats] | None) -> tuple[float, float]:
    """Value at 0 of a fitted polynomial and shape, and its standard deviation."""
    columns = np.vander(samples.speed / samples.speed.max(), degree + 1, increasing=True)
    if shape is not None:
        columns = np.column_stack([columns, shape(samples.speed)])
    return _fitted(columns, samples.friction, samples.slip)


def _fitted(columns: Floats, values: Floats, slip: Positions) -> tuple[float, float]:
    """The first coefficient of a linear fit, and its standard deviation by slips, or by samples if that is more."""
    scale = np.sqrt(np.mean(columns**2, axis=0))
    columns = columns / np.where(scale > 0, scale, 1.0)
    inverse = np.linalg.pinv(columns.T @ columns, rcond=1e-10, hermitian=True)
    best = inverse @ (columns.T @ values)
    left = values - columns @ best
    score = np.zeros((slip.max() + 1, best.size))
    np.add.at(score, slip, columns * left[:, None])
    used = np.unique(slip).size
    if used < FEWEST_SLIPS:
        return float(best[0] / scale[0]), np.inf
    by_slips = (inverse @ (score.T @ score) @ inverse)[0, 0] * used / (used - 1)
    by_samples = left @ left / max(values.size - best.size, 1) * inverse[0, 0]
    return float(best[0] / scale[0]), float(np.sqrt(max(by_slips, by_samples)) / scale[0])


def _at_turn(rising: _Samples, falling: _Samples, top: Floats, share: float) -> CoefficientEstimate:
    """Friction where the slip speed is greatest: lines in the distance from there on both sides, down to a share."""
    near = [side.those(side.speed > share * top[side.slip]) for side in (rising, falling)]
    away = [top[side.slip] - side.speed for side in near]
    columns = [np.column_stack([np.ones_like(way), way * (i == 0), way * (i == 1)]) for i, way in enumerate(away)]
    friction, slip = (np.concatenate([side[i] for side in near]) for i in (1, 2))
    return CoefficientEstimate(*_fitted(np.concatenate(columns), friction, slip))


def _half(estimate: CoefficientEstimate, slips: int) -> float:
    """Half the 95 % interval of an estimate from so many slips."""
    return float(np.hypot(stats.t.ppf(0.975, slips - 1) * estimate.deviation, estimate.systematic))


def _binned(side: _Samples, smooth: Floats, ends: Sequence[tuple[float, CoefficientEstimate]], slips: int) -> Floats:
    """Points of one direction, in the order of `_POINTS`: the `ends` of the curve, and between them friction in the
    middle of bins of the slip speed, by a parabola in each; NaN for bins of few samples.

    smooth : friction behind one more filter, whose mean in a bin differs where sensors ring.
    """
    edges = np.geomspace(max(np.quantile(side.speed, 0.01), 1e-3 * side.speed.max()), side.speed.max(), _BINS + 1)
    at = np.clip(np.searchsorted(edges, side.speed, "right") - 1, 0, _BINS - 1)
    rows = np.full((len(_POINTS), _BINS + 2), np.nan)
    for i in range(_BINS):
        own = side.those(at == i)
        if np.unique(own.slip).size >= FEWEST_SLIPS and own.speed.size > 2 * FEWEST_SLIPS:
            middle, off = own.speed.mean(), own.friction.mean() - smooth[at == i].mean()
            columns = np.vander((own.speed - middle) / middle, 3, increasing=True)
            mean, deviation = _fitted(columns, own.friction, own.slip)
            rows[:, i] = middle, mean, np.linalg.norm([deviation, off, _UNSEEN * mean]), own.friction.std()
    for i, (speed, estimate) in enumerate(ends):
        rows[:3, _BINS + i] = speed, estimate.value, _half(estimate, slips) / stats.norm.ppf(0.975)
    return rows[:, np.argsort(rows[0])]


def _dataset(
    estimates: Mapping[str, CoefficientEstimate], points: Mapping[str, Floats], counts: tuple[int, int],
    conditions: Mapping[str, Any], record: xr.Dataset,
) -> xr.Dataset:  # fmt: skip
    """The result of one record."""
    variables: dict[str, Any] = {}
    for row in _VALUES:
        estimate, attributes = estimates[row.name], attributes_of(row)
        half = _half(estimate, max(counts[0], 2))
        variables[row.name] = xr.Variable((), estimate.value, attributes)
        for end, sign in (("low", -1.0), ("high", 1.0)):
            named = attributes | {"long_name": f"{row.long_name}, {end} end of the 95 % interval"}
            variables[f"{row.name}_{end}"] = xr.Variable((), estimate.value + sign * half, named)
    variables |= {row.name: xr.Variable(row.dims, points[row.name], attributes_of(row)) for row in _POINTS}
    variables |= {
        row.name: xr.Variable((), float(n), attributes_of(row)) for row, n in zip(_COUNTS, counts, strict=True)
    }
    return xr.Dataset(variables, dict(conditions), {"title": record.attrs.get("title", "")})
