"""The features of a record, and tables of them: of several records and of the tests of a matrix, with the model RPN.

`quantities.py` names the features with their units.
"""

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.integrate import cumulative_trapezoid  # type: ignore[import-untyped]

from stickslip.config.studies import ReportTable
from stickslip.dataset.build import NO_FILL, attributes_of
from stickslip.dataset.display import MapAxis
from stickslip.vocabulary.display_units import number
from stickslip.vocabulary.quantities import STATUS_MESSAGES, STATUSES
from stickslip_rig import defects
from stickslip_rig.drive_motion import drive_displacement
from stickslip_rig.hum import subtract_hum
from stickslip_rig.quantities import FEATURES, PER_PEAK, RATINGS
from stickslip_rig.records import acceleration_of, condition_of, force_of, has_inertia
from stickslip_rig.risk import BANDS, INPUTS, Risk, band_of, number_of, rpn_text
from stickslip_rig.sections import FeatureSettings
from stickslip_rig.settings import Settings
from stickslip_rig.signals import (
    Floats,
    Positions,
    band_limited,
    closed,
    find_drops,
    gaps_of,
    sample_rate,
    spectrum_peaks,
    turning_points,
)
from stickslip_rig.sticks import Sticks, find_sticks

PEAKS = 3  # of the spectrum
_LONGER = 1.3  # times the median: an interval between break-aways in which the drive reverses
_STROKE = 0.02  # of the range of the drive: the shortest displacement that is a stroke

_MOST_NAMES = 5

Numbers = dict[str, float | Floats]


def features(record: xr.Dataset, settings: FeatureSettings | None = None) -> xr.Dataset:
    """Compute the features of one record.

    Parameters
    ----------
    record
        As of `read_record` or `make_record`.
    settings
        Bandwidth, tolerance and the like; chosen from the record unless given.

    Returns
    -------
    Dataset
        Variables without dimension, those of the spectrum over `peak`. NaN where a feature is not defined: no
        break-away, no load, no motion of the drive; and where a defect of the record leaves nothing to be said of it.
        The coordinate `remarks` says what is wrong with the record: a verdict, and a line for each fact.

    Raises
    ------
    ValueError
        For a bandwidth that the sampling rate does not allow.
    """
    settings = settings or FeatureSettings()
    numbers, _, wrong = _evaluated(record, settings)
    for name in {name for defect in wrong for name in defect.spoils}:
        numbers[name] = np.full_like(numbers[name], np.nan)
    conditions: dict[str, Any] = {str(name): c.variable for name, c in record.coords.items() if not c.dims}
    conditions["remarks"] = xr.Variable((), defects.remarks_of(wrong), {"long_name": "what is wrong with the record"})
    variables = {
        name: xr.Variable(declared.dims, numbers[name], attributes_of(declared)) for name, declared in FEATURES.items()
    }
    return xr.Dataset(variables, conditions, {"title": record.attrs.get("title", "")})


def features_of_strokes(record: xr.Dataset, ends: Floats, settings: FeatureSettings) -> dict[str, Floats]:
    """The features of strokes of a record, from each of these times (s) to the next, without those that defects spoil.

    Of each stroke from the first break-away to the last, so that none depends on where in a cycle the drive reverses.
    """
    _, sticks, wrong = _evaluated(record, settings)
    spoiled = {name for defect in wrong for name in defect.spoils}
    return {name: values for name, values in strokes_of(sticks, ends, settings).items() if name not in spoiled}


def strokes_of(sticks: Sticks, ends: Floats, settings: FeatureSettings) -> dict[str, Floats]:
    """The same of stick phases that are found."""
    places = np.searchsorted(sticks.time, ends).tolist()
    parts = [sticks.between(*place).whole_cycles() for place in itertools.pairwise(places)]
    each = [_numbers(part.record, part, settings) for part in parts]
    return {name: np.array([numbers[name] for numbers in each]) for name in FEATURES if name not in PER_PEAK}


def _evaluated(record: xr.Dataset, settings: FeatureSettings) -> tuple[Numbers, Sticks, list[defects.Defect]]:
    """The features of a record without defects that can be mended, its stick phases, and what was wrong with it."""
    record, wrong = defects.mended(record, settings.tolerance)
    sticks = find_sticks(record, settings)
    numbers, even = _numbers(record, sticks, settings), sticks.record
    step = 1.0 / sample_rate(even["time"].values)
    force, acceleration, tones = subtract_hum(force_of(even), acceleration_of(even), step)
    if tones:
        quiet, before = _replaced(even, force, acceleration), numbers
        sticks = find_sticks(quiet, settings)
        numbers = _numbers(quiet, sticks, settings)
        wrong += defects.of_hum(tones, sticks, before, numbers, settings.tolerance)
    time = record["time"].values
    wrong += defects.of_time(time, gaps_of(time))
    wrong += defects.of_scales(record, sticks, numbers, settings.tolerance)
    return numbers, sticks, wrong


def _numbers(record: xr.Dataset, sticks: Sticks, settings: FeatureSettings) -> Numbers:
    """The features of a record with these stick phases."""
    load = condition_of(record, "normal_load")
    return (
        _acceleration(record, sticks.record, settings)
        | _contact(sticks, load)
        | _drops(sticks.record, settings)
        | _motion(record, sticks)
    )


def _replaced(record: xr.Dataset, force: Floats, acceleration: Floats) -> xr.Dataset:
    """The record with other values of the measured force and of the acceleration."""
    name = "spring_force" if "spring_force" in record else "friction_force"
    if name == "friction_force" and has_inertia(record):
        force = force + float(record["mass"]) * acceleration
    values = {name: force, "acceleration": acceleration}
    return record.assign({name: record[name].copy(data=values[name]) for name in values if name in record})


# --- the parts --------------------------------------------------------------------------------------------------------


def _acceleration(record: xr.Dataset, even: xr.Dataset, settings: FeatureSettings) -> Numbers:
    """Maximum and integral of the magnitude, from the samples as they are; the band-limited ones and the spectrum from
    equidistant samples. No integral bridges a gap."""
    time, rate = record["time"].values, sample_rate(even["time"].values)
    numbers: Numbers = dict.fromkeys(defects.ACCELERATION, np.nan)
    numbers |= {**dict.fromkeys(PER_PEAK, np.full(PEAKS, np.nan)), "sample_rate": rate}
    if "acceleration" not in record:
        return numbers
    plain, spaced = record["acceleration"].values, even["acceleration"].values
    if settings.subtract_offset:
        plain, spaced = plain - np.median(plain), spaced - np.median(spaced)
    numbers["acceleration_max"] = float(np.abs(plain).max())
    numbers["acceleration_integral"] = _integral(np.abs(plain), closed(time, gaps_of(time)))
    if settings.bandwidth is not None:
        limited = np.abs(band_limited(spaced, rate, settings.bandwidth))
        numbers["acceleration_max_limited"] = float(limited.max())
        numbers["acceleration_integral_limited"] = _integral(limited, even["time"].values)
    numbers["peak_frequency"], numbers["peak_acceleration"] = spectrum_peaks(spaced, rate, PEAKS)
    return numbers


def _contact(sticks: Sticks, load: float | None) -> Numbers:
    """Friction from stick phases and the slips between them."""
    force, time = np.abs(force_of(sticks.record)), sticks.time
    starts, ends = sticks.slips()
    static = force[starts]
    numbers: Numbers = {
        "sticks": float(sticks.count),
        "slips": float(starts.size),
        "stick_fraction": _integral(sticks.flags().astype(np.float64), time) / float(time[-1] - time[0]),
        "static_force": _median(static),
        "static_force_first": float(static[0]) if static.size else np.nan,
        "dynamic_force": sticks.sliding_forces()[1],
        "time_to_sliding": _median(_times_to_sliding(force, time, starts, ends)),
        "stick_slip_period": _usual(np.diff(time[starts])),
    }
    for name in ("static_force", "static_force_first", "dynamic_force"):
        numbers[name.replace("force", "friction")] = float(numbers[name]) / load if load else np.nan
    return numbers


def _times_to_sliding(force: Floats, time: Floats, starts: Positions, ends: Positions) -> Floats:
    """Times from break-away until the force has fallen to its mean over the slip, of the slips with such samples."""
    work, lasting = cumulative_trapezoid(force, time, initial=0), time[ends] - time[starts]
    means = np.full(starts.size, np.nan)
    np.divide(work[ends] - work[starts], lasting, out=means, where=lasting > 0)
    sizes = ends - starts + 1
    slip = np.repeat(np.arange(starts.size), sizes)
    at = np.arange(slip.size) + np.repeat(starts - np.cumsum(sizes) + sizes, sizes)
    below = np.flatnonzero(force[at] <= means[slip])
    slip, first = np.unique(slip[below], return_index=True)
    after = at[below[first]]
    usable = (sizes[slip] >= 3) & (after > starts[slip])
    slip, after = slip[usable], after[usable]
    share = (force[after - 1] - means[slip]) / (force[after - 1] - force[after])
    return np.asarray(time[after - 1] + share * (time[after] - time[after - 1]) - time[starts[slip]])


def _drops(record: xr.Dataset, settings: FeatureSettings) -> Numbers:
    sizes = find_drops(force_of(record), settings.smallest_drop).sizes
    mean, largest = (float(sizes.mean()), float(sizes.max())) if sizes.size else (np.nan, np.nan)
    return {"drops": float(sizes.size), "drop_mean": mean, "drop_max": largest}


def _motion(record: xr.Dataset, sticks: Sticks) -> Numbers:
    """Features that need the motion of the drive, or at least its speed."""
    time, way = record["time"].values, drive_displacement(record)
    duration = float(time[-1] - time[0])
    speed = condition_of(record, "drive_speed")
    travel = speed * (duration - sticks.rest) if speed else np.nan
    strokes = energy = np.nan
    if way is not None and np.ptp(way) > 0:
        turns = turning_points(way, _STROKE * float(np.ptp(way)))
        travel, strokes = float(np.abs(np.diff(way[turns])).sum()), float(turns.size - 1)
        force = record["friction_force"].values if "friction_force" in record else force_of(record)
        energy = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(way))) / strokes
    return {
        "impulse_rate": np.count_nonzero(sticks.broke) / travel if travel > 0 else np.nan,
        "energy_per_stroke": energy,
        "strokes": strokes,
        "travel": travel,
        "duration": duration,
    }


def _integral(values: Floats, time: Floats) -> float:
    """By the trapezoidal rule, at the times as they are."""
    return float(np.trapezoid(values, time))


def _usual(intervals: Floats) -> float:
    """The mean of intervals, but for those with a reversal in between, which are longer."""
    return float(intervals[intervals <= _LONGER * np.median(intervals)].mean()) if intervals.size else np.nan


def _median(values: Floats) -> float:
    return float(np.median(values)) if values.size else np.nan


# --- tables -----------------------------------------------------------------------------------------------------------


def feature_table(records: Mapping[str, xr.Dataset], settings: Settings | None = None) -> xr.Dataset:
    """Compute features and model RPN of several records.

    Parameters
    ----------
    records
        By name.
    settings
        Of features and risk.

    Returns
    -------
    Dataset
        Along the dimension `record`, whose index are the names. A condition that only some records know is NaN, or an
        empty text, for the others.
    """
    settings = settings or Settings()
    return along_record(
        {name: rate(features(record, settings.features), settings.risk) for name, record in records.items()}
    )


def along_record(results: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """What is known of several records, by name, along `record`; coordinates that some lack are NaN, or empty."""
    rows = list(results.values())
    shared = list(dict.fromkeys(str(name) for row in rows for name in row.coords))
    names = xr.Variable("record", np.asarray(list(results), str), {"long_name": "record"})
    coordinates: dict[str, Any] = {"record": names, **{name: _column(rows, name) for name in shared}}
    return xr.Dataset({name: _column(rows, str(name)) for name in rows[0].data_vars}, coordinates)


def _column(rows: Sequence[xr.Dataset], name: str) -> xr.Variable:
    """One quantity of all records, with the attributes it has where it is known."""
    known = next(row[name].variable for row in rows if name in row.variables)
    gap = "" if known.dtype.kind == "U" else np.nan
    values = [row[name].values if name in row.variables else gap for row in rows]
    encoding = NO_FILL if known.dtype.kind in "iu" or name in rows[0].coords else {}
    return xr.Variable(("record", *known.dims), np.stack([np.asarray(v) for v in values]), known.attrs, encoding)


def as_columns(table: xr.Dataset) -> xr.Dataset:
    """Features with a variable of its own for each peak of the spectrum: a row of a table for each record."""
    peaks = {f"{name}_{i + 1}": table[name].isel(peak=i) for name in PER_PEAK for i in range(table.sizes["peak"])}
    return table.drop_dims("peak").assign(peaks)


def rate(table: xr.Dataset, risk: Risk) -> xr.Dataset:
    """The features with the model RPN, its level before rounding and its band beside them."""
    dims, level, meanings = table["sticks"].dims, risk.level(risk_inputs(table)), ("unknown", *BANDS)
    rpn = number_of(level)
    band = np.asarray([meanings.index(band_of(n)) for n in rpn.ravel().tolist()], np.int8).reshape(rpn.shape)
    return table.assign(
        model_rpn_level=(dims, level, attributes_of(RATINGS["model_rpn_level"])),
        model_rpn=(dims, rpn, attributes_of(RATINGS["model_rpn"])),
        model_rpn_band=(dims, band, attributes_of(RATINGS["model_rpn_band"], meanings), NO_FILL),
    )


def risk_inputs(table: xr.Dataset) -> dict[str, Floats]:
    """The inputs of the risk model: band-limited accelerations where there are any, else sampled ones."""
    return {name: rated(table, name) for name in INPUTS}


def rated(table: xr.Dataset, feature: str) -> Floats:
    """A feature, band-limited where the risk model uses that."""
    plain = table[feature].values.astype(np.float64)
    name = f"{feature}_limited"
    return np.where(np.isnan(table[name].values), plain, table[name].values) if name in table else plain


# --- for people -------------------------------------------------------------------------------------------------------


class FeatureColumn(NamedTuple):
    """A column of tables for people: a feature, its heading with the unit, and the `size` of that unit in SI."""

    feature: str
    heading: str
    size: float = 1.0


SHOWN = (
    FeatureColumn("sticks", "sticks"),
    FeatureColumn("acceleration_max", "|a| m/s2"),
    FeatureColumn("acceleration_integral", "int m/s"),
    FeatureColumn("drops", "drops"),
    FeatureColumn("drop_mean", "drop N"),
    FeatureColumn("impulse_rate", "slips/mm", 1e3),
    FeatureColumn("static_friction_first", "first mu_s"),
    FeatureColumn("static_friction", "mu_s"),
    FeatureColumn("dynamic_friction", "mu_d"),
)


def shown_table(ds: xr.Dataset) -> ReportTable:
    """The features of records or of the tests of a matrix as people read them; a dash where one is not defined."""
    table = as_records(ds)
    columns = [[number(value, 3) for value in rated(table, column.feature) / column.size] for column in SHOWN]
    rpn = [rpn_text(value) for value in table["model_rpn"].values.tolist()]
    rows = list(zip(map(str, table["record"].values.tolist()), rpn, *columns, strict=True))
    return ReportTable("All tests", ("record",), ("RPN", *(column.heading for column in SHOWN)), rows)


def unfinished(matrix: xr.Dataset) -> Iterator[str]:
    """A sentence for each reason why tests of a matrix were not integrated to their end, with the first of them."""
    status, names = matrix["status"].values.ravel(), as_records(matrix)["record"].values
    for code in np.unique(status[status != STATUSES.index("horizon_reached")]).tolist():
        lost = names[status == code].tolist()
        yield f"{len(lost):,} not integrated to the end ({first_of(lost)}): {STATUS_MESSAGES[STATUSES[code]]}"


def first_of(names: Sequence[str]) -> str:
    """The first of some names, and how many more there are."""
    more = f" and {len(names) - _MOST_NAMES:,} more" * (len(names) > _MOST_NAMES)
    return ", ".join(names[:_MOST_NAMES]) + more


def as_records(matrix: xr.Dataset) -> xr.Dataset:
    """The tests of a matrix as records: along the dimension `record`, whose index are their names."""
    if "record" in matrix.dims:
        return matrix
    dims = matrix["sticks"].dims
    table = matrix.drop_vars(matrix.coords)
    table = table.stack(record=dims, create_index=False) if dims else table.expand_dims("record")
    return table.transpose("record", ...).assign_coords(record=test_names(matrix, dims))


def test_names(ds: xr.Dataset, dims: Sequence[Any]) -> list[str]:
    """The points that distinguish each test of a matrix from the others, pure numbers with the name of what they are;
    the title where there is only one."""
    axes = [MapAxis(ds, dim, plain=True) for dim in dims]
    points = [[axis.heading(i) if re.fullmatch(r"[-+.e0-9]+", axis.text(i)) else axis.text(i)
               for i in range(axis.length)] for axis in axes]  # fmt: skip
    return [", ".join(at) or str(ds.attrs.get("title", "")) for at in itertools.product(*points)]
