"""Records of a rig: from CSV files, or from arrays.

    # material: felt
    # load: 10 N
    time [ms]; force [N]; acceleration [m/s2]; drive speed [mm/s]
    0,0; 0,00; 0,01; 10,0

The first line that is not a remark names the columns, in any order, with their units in brackets; a configuration may
give units and other headings. Without a unit a column is in SI, as everywhere in this program. Remarks of the form
`# name: value` give conditions of the test.

Time need not be evenly spaced, but must increase. The record holds the samples as they are; `sampling.evenly`
makes them equidistant.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from stickslip.errors import ConfigError, Problem, QuantityError
from stickslip.files.atomic import replaced
from stickslip.files.tables import Cell, Table, line_of, numbers, read_table
from stickslip.fit.columns import load_above
from stickslip.fit.headings import PURE, RECORD, Heading, heading, with_units_below, words_for
from stickslip.rig.quantities import FORCES, MATERIAL, SIGNALS, TIME
from stickslip.rig.settings import Condition, RecordSettings, condition, condition_name, signal_of
from stickslip.vocabulary import units
from stickslip.vocabulary.column_units import column_unit
from stickslip.vocabulary.settings import CONDITIONS
from stickslip.vocabulary.suggest import listed, nearest

FEWEST_SAMPLES = 16
_EXAMPLE = "time [ms], force [N], acceleration [m/s2]"
_NAMES = (TIME.name, *SIGNALS)
_REMARK = re.compile(r"([A-Za-z][A-Za-z _-]{0,30})\s*[:=]\s*(.*)")
_NO_FILL = {"_FillValue": None}


def make_record(time: ArrayLike, signals: Mapping[str, ArrayLike], conditions: Mapping[str, Condition]) -> xr.Dataset:
    """A record from arrays in SI.

    time : s, increasing, at least 16 samples. signals : by names of `SIGNALS`, each as long as `time`; a force and the
    acceleration there must be. conditions : by names of `CONDITIONS` and `material`; they become scalar coordinates.
    Raises ValueError.
    """
    times = np.asarray(time, np.float64)
    if times.ndim != 1 or times.size < FEWEST_SAMPLES:
        raise ValueError(f"time: got the shape {times.shape}, expected at least {FEWEST_SAMPLES} samples in a row")
    if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise ValueError("time: expected finite numbers that increase")
    if lacking := missing(signals):
        raise ValueError(f"no {lacking}")
    variables = {}
    for name, values in signals.items():
        array = np.asarray(values, np.int8 if name == "stick" else np.float64)
        if array.shape != times.shape or not np.isfinite(array).all():
            raise ValueError(f"{name}: expected {times.size} finite numbers, one for each sample")
        declared = SIGNALS[name]
        attributes = {"units": declared.units, "long_name": declared.long_name}
        variables[name] = xr.Variable("time", array, attributes)
    time_attributes = {"units": TIME.units, "long_name": TIME.long_name}
    coordinates = {"time": xr.Variable("time", times, time_attributes, _NO_FILL)}
    coordinates |= {name: _condition(name, value) for name, value in conditions.items()}
    return xr.Dataset(variables, coordinates)


def read_record(
    path: str | Path,
    settings: RecordSettings | None = None,
    conditions: Mapping[str, Condition] | None = None,
    moved: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """The record in a CSV file.

    conditions : what holds unless the file says otherwise, as for `make_record`; the material is the name of the file
    unless one of them names it. moved : called with how many bytes of a long file are read, and how many there are.
    Raises ConfigError with everything that is wrong, by line and column.
    """
    settings = settings or RecordSettings()
    table = read_table(Path(path), _EXAMPLE, is_heading=lambda cells: _may_be_headings(cells, settings))
    headings, has_units = with_units_below(
        table, [heading(cell.text, RECORD, _NAMES) for cell in table.heading], RECORD
    )
    table = replace(table, lines=table.lines[has_units:])
    columns = _columns(table, headings, settings)
    if len(table.lines) < FEWEST_SAMPLES and not table.rest:
        message = f"{len(table.lines)} samples, expected at least {FEWEST_SAMPLES}"
        raise ConfigError(table.name, [Problem((), message)])
    found = numbers(table, [position for position, _ in columns.values()], moved)
    signals = {name: found[position] * factor for name, (position, factor) in columns.items()}
    time = signals.pop(TIME.name)
    _check_time(table, time, columns[TIME.name][0])
    remarks = _conditions(table)
    load = load_above(table)
    above = ({"normal_load": load[0]} if load else {}) | _speed_above(table)
    said = {MATERIAL: Path(path).stem} | dict(conditions or {}) | above | remarks
    record = make_record(time, signals, said)
    used = {position for position, _ in columns.values()}
    left = [one.text for i, one in enumerate(headings) if i not in used and one.text]
    return record.assign_attrs(
        title=str(said[MATERIAL]), record_file=Path(path).name, not_used=left, columns=_understood(columns, headings)
    )


def write_record(record: xr.Dataset, path: Path) -> None:
    """Write a record as CSV that `read_record` reads: the same signals and conditions, to nine digits; time, whose
    steps are small, to twelve."""
    columns = {"time": TIME, **{name: SIGNALS[name] for name in SIGNALS if name in record}}
    heading = ", ".join(name if v.units == "1" else f"{name} [{units.spelled(v.units)}]" for name, v in columns.items())
    remarks = [f"# {name}: {_said(record, name)}" for name in (MATERIAL, *CONDITIONS) if name in record.coords]
    table = np.stack([np.asarray(record[name].values, np.float64) for name in columns], axis=1)
    header, digits = "\n".join([*remarks, heading]), ["%.12g", *["%.9g"] * (len(columns) - 1)]
    with replaced(path) as temporary:
        np.savetxt(temporary, table, digits, delimiter=", ", header=header, comments="", encoding="utf-8")


def _said(record: xr.Dataset, name: str) -> str:
    """A condition as a remark says it."""
    if name == MATERIAL:
        return " ".join(str(record[name].item()).split())
    return f"{float(record[name]):.9g} {units.spelled(CONDITIONS[name].units)}".rstrip()


def force_of(record: xr.Dataset) -> NDArray[np.float64]:
    """The force a rig measures (N): that of the spring; where only friction is known, friction minus inertia.

    Without the mass, the friction force itself.
    """
    if "spring_force" in record:
        return np.asarray(record["spring_force"].values, np.float64)
    friction = np.asarray(record["friction_force"].values, np.float64)
    if "mass" not in record.coords:
        return friction
    return np.asarray(friction - float(record["mass"]) * record["acceleration"].values, np.float64)


def condition_of(record: xr.Dataset, name: str) -> float | None:
    """A condition of the test as a number in SI, None where it is not known."""
    return float(record[name]) if name in record.coords else None


def missing(names: Mapping[str, object]) -> str:
    """What a record lacks of a force and the acceleration, in words; nothing if it has both."""
    lacking = [] if any(name in names for name in FORCES) else ["force"]
    return listed([*lacking, *([] if "acceleration" in names else ["acceleration"])] or [""], "and")


def _condition(name: str, value: Condition) -> xr.Variable:
    if name == MATERIAL:
        return xr.Variable((), str(value), {"long_name": MATERIAL})
    declared = CONDITIONS[name]
    return xr.Variable((), float(value), {"units": declared.units, "long_name": declared.long_name}, _NO_FILL)


# --- the heading ------------------------------------------------------------------------------------------------------


def _may_be_headings(cells: Sequence[str], settings: RecordSettings) -> bool:
    """Whether cells name the columns of a record: time, and something that is measured."""
    found = {_signal(heading(cell, RECORD, _NAMES), settings) for cell in cells}
    return TIME.name in found and bool(found & {*FORCES, "acceleration"})


def _signal(one: Heading, settings: RecordSettings) -> str | None:
    """Which column this is, by what people said, else by its name; None if none."""
    if any(word in (one.name, one.text) for word in settings.ignore):
        return None
    return next((name for name, word in settings.columns.items() if one.is_called(word)), signal_of(one))


def _columns(table: Table, headings: Sequence[Heading], settings: RecordSettings) -> dict[str, tuple[int, float]]:
    """By name, the position of each column and the factor that converts its numbers to SI. Raises ConfigError."""
    found: dict[str, tuple[int, float]] = {}
    problems = []
    for position, (cell, one) in enumerate(zip(table.heading, headings, strict=True)):
        if (name := _signal(one, settings)) is None:
            continue
        try:
            if name in found:
                raise QuantityError("it once", "name the other column under record: ignore")
            found[name] = (position, _factor(name, one.unit, settings.units.get(name)))
        except QuantityError as error:
            message = f"got {cell.text!r}, expected {error.expected}"
            problems.append(Problem((), message, cell.place, error.hint))
    lacking = [*([] if TIME.name in found else [TIME.name]), *filter(None, [missing(found)])]
    if lacking and not problems:
        unknown = [i for i, one in enumerate(headings) if one.text and _signal(one, settings) is None]
        near = (i for i in unknown if nearest(headings[i].name, words_for(RECORD)))
        problems = [_lacking(table, listed(lacking, "and"), next(near, None))]
    if problems:
        raise ConfigError(table.name, problems)
    return found


def _lacking(table: Table, lacking: str, near: int | None) -> Problem:
    """What is said where columns are missing, of which one may be misspelt."""
    known = [TIME.name, "force", *(name for name in SIGNALS if name != "spring_force")]
    if near is None:
        hint = f"the first line says, for instance, '{_EXAMPLE}'; a configuration may name others (record: columns)"
        return Problem((), f"no column is called {lacking}", table.heading[0].place, hint)
    cell = table.heading[near]
    hint = (
        f"did you mean {nearest(cell.text, words_for(RECORD))!r}? A configuration may say what it is (record: columns)"
    )
    return Problem((), f"got {cell.text!r}, expected {listed(known)}, with the unit in brackets", cell.place, hint)


def _factor(name: str, unit: str, configured: str | None) -> float:
    """What numbers in a unit are multiplied with to be in SI. Raises QuantityError."""
    wanted = TIME.units if name == TIME.name else SIGNALS[name].units
    if configured is not None and unit and unit.translate(units.AS_TYPED) != configured.translate(units.AS_TYPED):
        raise QuantityError(f"the unit {configured}, as the configuration says", "remove one of the two")
    unit = configured or unit
    if wanted == "1" or not unit:
        if unit not in PURE:
            raise QuantityError("no unit", f"{name} is a pure number")
        return 1.0
    return units.si_value(f"1 {column_unit(unit, wanted)}", wanted)


# --- remarks and time -------------------------------------------------------------------------------------------------


def _conditions(table: Table) -> dict[str, Condition]:
    """Conditions that remarks give. Raises ConfigError for those that cannot be understood."""
    found: dict[str, Condition] = {}
    problems = []
    for remark in table.remarks:
        match = _REMARK.fullmatch(remark.text)
        name = condition_name(match[1]) if match else None
        if match is None:
            continue
        try:
            if name is not None:
                found[name] = condition(name, _number_or_text(name, match[2]))
            else:
                _check_remark(match[1])
        except QuantityError as error:
            problems.append(_refused(remark, error))
    if problems:
        raise ConfigError(table.name, problems)
    return found


def _speed_above(table: Table) -> dict[str, Condition]:
    """The speed of the drive that lines above the heading give, `Geschwindigkeit;10;mm/s`. Raises ConfigError."""
    found: dict[str, Condition] = {}
    for line in table.above:
        words = [cell.text for cell in line if cell.text]
        one = heading(words[0].strip(" :=")) if len(words) > 1 else None
        if one is None or one.kind != "speed" or one.label or not words[1][:1].isdigit():
            continue
        try:
            number = words[1].replace(",", ".")
            value = condition("drive_speed", f"{number} {' '.join(words[2:]) or one.unit}".strip())
            if found.get("drive_speed", value) != value:
                raise QuantityError("one speed")
            found["drive_speed"] = value
        except QuantityError as error:
            message = f"got {' '.join(words)!r}, expected {error.expected}"
            raise ConfigError(table.name, [Problem((), message, line[0].place, error.hint)]) from None
    return found


def _understood(columns: Mapping[str, tuple[int, float]], headings: Sequence[Heading]) -> str:
    """Which columns were read, in which units: `time in ms, spring_force in mN`."""
    units_read = {name: headings[position].unit for name, (position, _) in columns.items()}
    return ", ".join(f"{name} in {unit}" if unit else name for name, unit in units_read.items())


def _number_or_text(name: str, text: str) -> float | str:
    try:
        return text if name == MATERIAL else float(text)
    except ValueError:
        return text


def _check_remark(word: str) -> None:
    """Remarks may say anything, but a misspelt condition would be missed silently. Raises QuantityError."""
    if near := nearest(word.strip(), (MATERIAL, *CONDITIONS)):
        raise QuantityError(listed((MATERIAL, *CONDITIONS)), f"did you mean {near!r}?")


def _refused(remark: Cell, error: QuantityError) -> Problem:
    return Problem((), f"got {remark.text!r}, expected {error.expected}", remark.place, error.hint)


def _check_time(table: Table, time: NDArray[np.float64], column: int) -> None:
    """Raises ConfigError at the first sample that is not later than the one before."""
    falling = np.flatnonzero(np.diff(time) <= 0)
    if not falling.size:
        return
    row = int(falling[0]) + 1
    line, heading = line_of(table, row), table.heading[column]
    message = f"got {time[row]:.9g} s after {time[row - 1]:.9g} s, expected time to increase"
    hint = "sort the samples; if times are rounded, write more digits"
    raise ConfigError(table.name, [Problem((heading.text,), message, heading.place._replace(line=line), hint)])
