"""The features of a record; `rig/quantities.py` names them with their units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.rig.analysis import defects
from stickslip.rig.analysis.hum import subtract_hum
from stickslip.rig.analysis.sticks import Positions, Sticks, drive_displacement, find_sticks
from stickslip.rig.analysis.turning import find_drops, turning_points
from stickslip.rig.quantities import FEATURES, PER_PEAK
from stickslip.rig.records.record import condition_of, force_of
from stickslip.rig.records.sampling import (
    Floats,
    band_limited,
    closed,
    cumulative,
    gaps_of,
    sample_rate,
    spectrum_peaks,
)
from stickslip.rig.risk import BANDS, FORMULA, INPUTS, RPN_NAME, Risk, band_of, number_of
from stickslip.rig.settings import FeatureSettings, Settings

PEAKS = 3  # of the spectrum
_STROKE = 0.02  # of the range of the drive: the shortest displacement that is a stroke
_NO_FILL = {"_FillValue": None}

Numbers = dict[str, float | Floats]


def features(record: xr.Dataset, settings: FeatureSettings | None = None) -> xr.Dataset:
    """The features of one record: variables without dimension, those of the spectrum over `peak`.

    NaN where a feature is not defined: no break-away, no load, no motion of the drive; and where a defect of the record
    leaves nothing to be said of it. The coordinate `remarks` says what is wrong with the record: a verdict, and a line
    for each fact. Raises ValueError for a bandwidth that the sampling rate does not allow.
    """
    how = settings or FeatureSettings()
    record, wrong = defects.mended(record)
    found, sticks = _measured(record, how)
    even = sticks.record
    step = 1.0 / sample_rate(even["time"].values)
    force, acceleration, tones = subtract_hum(force_of(even), even["acceleration"].values, step)
    if tones:
        before, (found, sticks) = found, _measured(_replaced(even, force, acceleration), how)
        wrong += defects.of_hum(tones, sticks, before, found, how.tolerance)
    time = record["time"].values
    wrong += [*defects.of_time(time, gaps_of(time)), *defects.of_scales(record, sticks, found)]
    for name in {name for defect in wrong for name in defect.spoils}:
        found[name] = np.full_like(found[name], np.nan)
    variables = {
        name: xr.Variable(("peak",) if name in PER_PEAK else (), found[name], _attributes(name)) for name in FEATURES
    }
    conditions: dict[str, Any] = {str(name): c.variable for name, c in record.coords.items() if not c.dims}
    conditions["remarks"] = xr.Variable((), defects.remarks_of(wrong), {"long_name": "what is wrong with the record"})
    return xr.Dataset(variables, conditions, {"title": record.attrs.get("title", "")})


def _measured(record: xr.Dataset, how: FeatureSettings) -> tuple[Numbers, Sticks]:
    """The features of a record as it is, and its stick phases."""
    sticks = find_sticks(record, how)
    found = _acceleration(record, sticks.record, how) | _contact(sticks, condition_of(record, "normal_load"))
    return found | _drops(sticks.record, how) | _motion(record, sticks), sticks


def _replaced(record: xr.Dataset, force: Floats, acceleration: Floats) -> xr.Dataset:
    """The record with other values of the measured force and of the acceleration."""
    name = "spring_force" if "spring_force" in record else "friction_force"
    if name == "friction_force" and "mass" in record.coords:
        force = force + float(record["mass"]) * acceleration
    return record.assign(
        {name: record[name].copy(data=force), "acceleration": record["acceleration"].copy(data=acceleration)}
    )


def missing_features() -> xr.Dataset:
    """The features of a missing record: NaN."""
    size = {name: (PEAKS,) if name in PER_PEAK else () for name in FEATURES}
    dims = {name: ("peak",) if name in PER_PEAK else () for name in FEATURES}
    return xr.Dataset({n: xr.Variable(dims[n], np.full(size[n], np.nan), _attributes(n)) for n in FEATURES})


def feature_table(records: Mapping[str, xr.Dataset], settings: Settings | None = None) -> xr.Dataset:
    """Features and model RPN of several records along the dimension `record`, whose index are their names.

    A condition that only some records know is NaN, or an empty text, for the others.
    """
    how = settings or Settings()
    rows = [rate(features(record, how.features), how.risk) for record in records.values()]
    shared = list(dict.fromkeys(str(name) for row in rows for name in row.coords))
    columns = {name: _column(rows, name) for name in [*shared, *map(str, rows[0].data_vars)]}
    names = xr.Variable("record", np.asarray(list(records), str), {"long_name": "record"})
    coordinates: dict[str, Any] = {"record": names, **{name: columns[name] for name in shared}}
    variables = {name: column for name, column in columns.items() if name not in shared}
    return xr.Dataset(variables, coordinates)


def as_columns(found: xr.Dataset) -> xr.Dataset:
    """Features with a variable of its own for each peak of the spectrum: a row of a table for each record."""
    peaks = {f"{name}_{i + 1}": found[name].isel(peak=i) for name in PER_PEAK for i in range(found.sizes["peak"])}
    return found.drop_dims("peak").assign(peaks)


def rate(found: xr.Dataset, risk: Risk) -> xr.Dataset:
    """The features with the model RPN, its level before rounding and its band beside them; and, of a calibrated model,
    whether a feature lies outside the range of its pairs."""
    inputs = risk_inputs(found)
    level = risk.level(inputs)
    number = number_of(level)
    comment = f"{RPN_NAME}: {FORMULA}"
    bands = ("unknown", *BANDS)
    band = np.asarray([bands.index(band_of(n)) for n in number.ravel().tolist()], np.int8).reshape(number.shape)
    rpn = {"units": "1", "long_name": RPN_NAME, "comment": "1 to 10; missing where a feature is not known"}
    flags = {"units": "1", "long_name": f"traffic light of the {RPN_NAME}", "flag_meanings": " ".join(bands),
             "flag_values": np.arange(len(bands), dtype=np.int8)}  # fmt: skip
    dims = found["sticks"].dims
    if risk.is_calibrated:
        outside = np.any([*risk.outside(inputs).values()], axis=0).astype(np.int8)
        extrapolated = {"units": "1", "long_name": f"whether (1) the {RPN_NAME}, is an extrapolation",
                        "comment": "a feature lies outside the range of the pairs of the calibration"}  # fmt: skip
        found = found.assign(model_rpn_extrapolated=xr.Variable(dims, outside, extrapolated, _NO_FILL))
    return found.assign(
        model_rpn_level=(dims, level, {"units": "1", "long_name": f"level of the {RPN_NAME}", "comment": comment}),
        model_rpn=xr.Variable(dims, number, rpn),
        model_rpn_band=xr.Variable(dims, band, flags, _NO_FILL),
    )


def risk_inputs(found: xr.Dataset) -> dict[str, NDArray[np.float64]]:
    """What the risk model is computed from: band-limited accelerations where there are any, else sampled ones."""
    inputs = {}
    for name in INPUTS:
        plain = found[name].values.astype(np.float64)
        limited = found[f"{name}_limited"].values if f"{name}_limited" in found else np.full_like(plain, np.nan)
        inputs[name] = np.where(np.isnan(limited), plain, limited)
    return inputs


# --- the parts --------------------------------------------------------------------------------------------------------


def _acceleration(record: xr.Dataset, even: xr.Dataset, how: FeatureSettings) -> Numbers:
    """Maximum and integral of the magnitude, from the samples as they are; the band-limited ones and the spectrum from
    equidistant samples. No integral bridges a gap."""
    time = record["time"].values
    rate_ = sample_rate(even["time"].values)
    plain, spaced = record["acceleration"].values, even["acceleration"].values
    if how.subtract_offset:
        plain, spaced = plain - np.median(plain), spaced - np.median(spaced)
    found: Numbers = {
        "acceleration_max": float(np.abs(plain).max()),
        "acceleration_integral": _integral(np.abs(plain), closed(time, gaps_of(time))),
        "acceleration_max_limited": np.nan,
        "acceleration_integral_limited": np.nan,
        "sample_rate": rate_,
    }
    if how.bandwidth is not None:
        limited = np.abs(band_limited(spaced, rate_, how.bandwidth))
        found["acceleration_max_limited"] = float(limited.max())
        found["acceleration_integral_limited"] = _integral(limited, even["time"].values)
    found["peak_frequency"], found["peak_acceleration"] = spectrum_peaks(spaced, rate_, PEAKS)
    return found


def _contact(sticks: Sticks, load: float | None) -> Numbers:
    """Friction from stick phases and the slips between them."""
    force, time = np.abs(force_of(sticks.record)), sticks.time
    starts, ends = sticks.slips()
    static = force[starts]
    work = cumulative(force, time)
    lasting, means = time[ends] - time[starts], np.full(starts.size, np.nan)
    np.divide(work[ends] - work[starts], lasting, out=means, where=lasting > 0)
    dynamic = sticks.sliding_forces()[1]
    found: Numbers = {
        "sticks": float(sticks.count),
        "slips": float(starts.size),
        "stick_fraction": _integral(sticks.flags().astype(np.float64), time) / float(time[-1] - time[0]),
        "static_force": _median(static),
        "static_force_first": float(static[0]) if static.size else np.nan,
        "dynamic_force": dynamic,
        "time_to_sliding": _median(_times_to_sliding(force, time, starts, ends, means)),
    }
    for force_name in ("static_force", "static_force_first", "dynamic_force"):
        found[force_name.replace("force", "friction")] = float(found[force_name]) / load if load else np.nan
    return found


def _times_to_sliding(force: Floats, time: Floats, starts: Positions, ends: Positions, means: Floats) -> Floats:
    """Times from break-away until the force has fallen to its mean over the slip, of the slips with such samples."""
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


def _drops(record: xr.Dataset, how: FeatureSettings) -> Numbers:
    sizes = find_drops(force_of(record), how.smallest_drop).sizes
    mean, largest = (float(sizes.mean()), float(sizes.max())) if sizes.size else (np.nan, np.nan)
    return {"drops": float(sizes.size), "drop_mean": mean, "drop_max": largest}


def _motion(record: xr.Dataset, sticks: Sticks) -> Numbers:
    """What needs the motion of the drive, or at least its speed."""
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


# --- small things -----------------------------------------------------------------------------------------------------


def _integral(values: Floats, time: Floats) -> float:
    """By the trapezoidal rule, at the times as they are."""
    return float(np.trapezoid(values, time))


def _median(values: Floats) -> float:
    return float(np.median(values)) if values.size else np.nan


def _attributes(name: str) -> dict[str, str]:
    declared = FEATURES[name]
    return {"units": declared.units, "long_name": declared.long_name}


def _column(rows: Sequence[xr.Dataset], name: str) -> xr.Variable:
    """One quantity of all records, with the attributes it has where it is known."""
    known = next(row[name].variable for row in rows if name in row.variables)
    gap = "" if known.dtype.kind == "U" else np.nan
    values = [row[name].values if name in row.variables else gap for row in rows]
    encoding = _NO_FILL if known.dtype.kind in "iu" or name in rows[0].coords else {}
    return xr.Variable(("record", *known.dims), np.stack([np.asarray(v) for v in values]), known.attrs, encoding)
