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

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from stickslip.dataset.build import NO_FILL
from stickslip.errors import ConfigError, Problem, QuantityError
from stickslip.files.tables import TextTable, line_of
from stickslip.files.targets import replaced
from stickslip.vocabulary import units
from stickslip.vocabulary.parameter import Parameter, Variable
from stickslip.vocabulary.quantities import listed, nearest
from stickslip_materials.fit.columns import HeadedTable, factor, stated
from stickslip_materials.fit.headings import Heading, words_for
from stickslip_materials.fit.words import RECORD
from stickslip_rig.quantities import COLUMNS, CONDITIONS, FORCES, LOAD, MATERIAL, SIGNALS, TIME
from stickslip_rig.settings import Condition, RecordSettings, condition, condition_name, signal_of
from stickslip_rig.signals import Floats

FEWEST_SAMPLES = 16
_EXAMPLE = "time [ms], force [N]"
_REMARK = re.compile(r"([A-Za-z][A-Za-z _-]{0,30})\s*[:=]\s*(.*)")
_ONE_SIGN = 0.1  # of the larger end of a column of one sign, what the other may reach past 0


def make_record(time: ArrayLike, signals: Mapping[str, ArrayLike], conditions: Mapping[str, Condition]) -> xr.Dataset:
    """Make a record from arrays in SI.

    Parameters
    ----------
    time
        s, increasing, at least 16 samples.
    signals
        By names of `quantities.SIGNALS`, each as long as `time`; a force there must be.
    conditions
        By names of `CONDITIONS` and `material`; they become scalar coordinates.

    Raises
    ------
    ValueError
        Where samples are too few, not finite, not of one length, or not in order.
    """
    times = np.asarray(time, np.float64)
    if times.ndim != 1 or times.size < FEWEST_SAMPLES:
        raise ValueError(f"time: got the shape {times.shape}, expected at least {FEWEST_SAMPLES} samples in a row")
    if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise ValueError("time: expected finite numbers that increase")
    if lacking := _lacking(signals):
        raise ValueError(f"no {lacking}")
    variables = {}
    for name, values in signals.items():
        array = np.asarray(values, np.int8 if name == "stick" else np.float64)
        if array.shape != times.shape or not np.isfinite(array).all():
            raise ValueError(f"{name}: expected {times.size} finite numbers, one for each sample")
        variables[name] = _variable(SIGNALS[name], array)
    coordinates = {"time": _variable(TIME, times, NO_FILL)}
    for name, value in conditions.items():
        text = xr.Variable((), str(value), {"long_name": MATERIAL})
        coordinates[name] = text if name == MATERIAL else _variable(CONDITIONS[name], np.float64(value), NO_FILL)
    return xr.Dataset(variables, coordinates)


def _variable(row: Variable | Parameter, values: ArrayLike, encoding: dict[str, None] | None = None) -> xr.Variable:
    attributes = {"units": row.units, "long_name": row.long_name}
    return xr.Variable(("time",) if np.ndim(values) else (), values, attributes, encoding)


def read_record(
    path: str | Path,
    settings: RecordSettings | None = None,
    conditions: Mapping[str, Condition] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Read the record in a CSV file.

    Parameters
    ----------
    path
        The file.
    settings
        Columns and units where the file does not name them.
    conditions
        Those that hold unless the file says otherwise, as for `make_record`; the material is the name of the file
        unless one of them names it.
    progress
        Called with how many bytes of a long file are read, and how many there are.

    Raises
    ------
    ConfigError
        With everything that is wrong, by line and column.
    """
    (record,) = _read(Path(path), settings or RecordSettings(), conditions, progress, several=False)
    return record


def read_records(
    path: str | Path,
    settings: RecordSettings | None = None,
    conditions: Mapping[str, Condition] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[xr.Dataset]:
    """Read the records in a CSV file in which the names of columns come again, as above each step; see `read_record`.

    The attribute `block` of each is what the line above it calls it, or its number; where there is one it is empty.
    """
    return list(_read(Path(path), settings or RecordSettings(), conditions, progress, several=True))


def _read(
    path: Path, settings: RecordSettings, conditions: Mapping[str, Condition] | None,
    progress: Callable[[int, int], None] | None, *, several: bool,
) -> Iterator[xr.Dataset]:  # fmt: skip
    """The record in a file, or that of each block."""

    def are_headings(columns: list[Heading]) -> bool:
        names = {_signal(column, settings) for column in columns}
        return TIME.name in names and bool(names & {*FORCES, "acceleration"})

    for headed in HeadedTable.read(path, _EXAMPLE, are_headings, RECORD, tuple(COLUMNS), several=several):
        block = headed.table.block
        known: dict[str, Condition] = {MATERIAL: f"{path.stem}, {block}" if block else path.stem, **(conditions or {})}
        yield _record(headed, settings, known, progress).assign_attrs(record_file=str(path), block=block)


def _record(
    headed: HeadedTable, settings: RecordSettings, known: dict[str, Condition],
    progress: Callable[[int, int], None] | None,
) -> xr.Dataset:  # fmt: skip
    """The record in a table. known : conditions that hold unless the table says otherwise."""
    table, headings = headed.table, headed.headings
    columns = headed.find(
        lambda column: _signal(column, settings),
        lambda name, column: _factor(name, column, settings.units.get(name)),
        "name the other column under record: ignore",
    )
    if lacking := _lacking(columns, TIME.name):
        raise _missing_column(headed, settings, lacking)
    if len(table.lines) < FEWEST_SAMPLES and not table.rest:
        message = f"{len(table.lines)} samples, expected at least {FEWEST_SAMPLES}"
        raise ConfigError(table.name, [Problem((), message)])
    signals = headed.values(columns, progress)
    time = signals.pop(TIME.name)
    _check_time(table, time, columns[TIME.name][0])
    remarks = _remarks(table)
    if load := _load(table, signals.pop(LOAD, np.zeros(1))):
        known[LOAD] = load
    known |= _stated(table, {*known, *(["drive_speed"] if "drive_velocity" in signals else [])}) | remarks
    names = {position: name for name, (position, _) in columns.items()}
    return make_record(time, signals, known).assign_attrs(
        title=str(known[MATERIAL]),
        not_used=[column.text for i, column in enumerate(headings) if i not in names and column.text],
        columns=[f"{name} in {headings[i].unit}" if headings[i].unit else name for i, name in names.items()],
    )  # fmt: skip


def write_record(record: xr.Dataset, path: Path) -> None:
    """Write a record as CSV that `read_record` reads: the same signals and conditions, to nine digits; time, whose
    steps are small, to twelve."""
    columns = {name: row for name, row in COLUMNS.items() if name in record.variables and record[name].dims}
    heading = ", ".join(name if v.units == "1" else f"{name} [{units.spelled(v.units)}]" for name, v in columns.items())
    remarks = []
    if MATERIAL in record.coords:
        remarks.append(f"# {MATERIAL}: {' '.join(str(record[MATERIAL].item()).split())}")
    for name, row in CONDITIONS.items():
        if name in record.coords:
            remarks.append(f"# {name}: {float(record[name]):.9g} {units.spelled(row.units)}".rstrip())
    table = np.stack([np.asarray(record[name].values, np.float64) for name in columns], axis=1)
    header, digits = "\n".join([*remarks, heading]), ["%.12g", *["%.9g"] * (len(columns) - 1)]
    with replaced(path) as temporary:
        np.savetxt(temporary, table, digits, delimiter=", ", header=header, comments="", encoding="utf-8")


def force_of(record: xr.Dataset) -> Floats:
    """The force a rig measures (N): that of the spring; where only friction is known, friction minus inertia.

    Without the mass or the acceleration, the friction force itself.
    """
    if "spring_force" in record:
        return np.asarray(record["spring_force"].values, np.float64)
    friction = np.asarray(record["friction_force"].values, np.float64)
    if not has_inertia(record):
        return friction
    return np.asarray(friction - float(record["mass"]) * record["acceleration"].values, np.float64)


def has_inertia(record: xr.Dataset) -> bool:
    """True if mass and acceleration of the specimen are known."""
    return "mass" in record.coords and "acceleration" in record


def acceleration_of(record: xr.Dataset) -> Floats:
    """The acceleration (m/s2) at each sample; 0 where it is not recorded."""
    if "acceleration" in record:
        return np.asarray(record["acceleration"].values, np.float64)
    return np.zeros(record.sizes["time"])


def condition_of(record: xr.Dataset, name: str) -> float | None:
    """A condition of the test as a number in SI, None where it is not known."""
    return float(record[name]) if name in record.coords else None


# --- the heading ------------------------------------------------------------------------------------------------------


def _signal(column: Heading, settings: RecordSettings) -> str | None:
    """The name of a column, by the settings, else by its heading; None if it has none."""
    if any(word in (column.name, column.text) for word in settings.ignore):
        return None
    return next((name for name, word in settings.columns.items() if column.is_called(word)), signal_of(column))


def _lacking(names: Mapping[str, object], *others: str) -> str:
    """The names that a record lacks of a force and others, in words; nothing if it has all."""
    lacking = [name for name in others if name not in names]
    lacking += [] if any(name in names for name in FORCES) else ["force"]
    return listed(lacking, "and") if lacking else ""


def _missing_column(headed: HeadedTable, settings: RecordSettings, lacking: str) -> ConfigError:
    """The error of a table without some columns, of which one may be misspelt."""
    for i, column in enumerate(headed.headings):
        near = nearest(column.name, words_for(RECORD)) if column.text else None
        if near and _signal(column, settings) is None:
            expected = f"{listed(['force' if name == 'spring_force' else name for name in COLUMNS])}, with a unit"
            hint = f"did you mean {near!r}? A configuration may say what it is (record: columns)"
            return headed.refused(i, expected, hint)
    hint = f"the first line says, for instance, '{_EXAMPLE}'; a configuration may name others (record: columns)"
    return headed.error(f"no column is called {lacking}", hint)


def _factor(name: str, column: Heading, configured: str | None) -> float:
    """The factor from the numbers of a column to SI. Raises QuantityError."""
    unit = column.unit
    if name == "friction_force" and not unit and not configured and column.kind == "mu":
        raise QuantityError("a unit: force or coefficient?", f"write '{column.name} [N]' for a force")
    if configured is not None and unit and unit.translate(units.AS_TYPED) != configured.translate(units.AS_TYPED):
        raise QuantityError(f"the unit {configured}, as the configuration says", "remove one of the two")
    return factor(name, configured or unit, COLUMNS[name].units)


# --- remarks and time -------------------------------------------------------------------------------------------------


def _load(table: TextTable, values: Floats) -> float:
    """The median of a column of normal force, which some instruments count negative. Raises ConfigError where its sign
    changes."""
    low, high = np.quantile(values, [0.05, 0.95]).tolist()
    if min(-low, high) > _ONE_SIGN * max(-low, high):
        message = f"the column of the normal force goes from {low:g} to {high:g} N"
        raise ConfigError.of(table.name, message, "name it under record: ignore, and give --load")
    return abs(float(np.median(values)))


def _stated(table: TextTable, known: Collection[str]) -> dict[str, float]:
    """Load and speed that lines above the heading give. Raises ConfigError for what is not understood, but for `known`
    conditions."""
    conditions: dict[str, float] = {}
    for name, kind in ((LOAD, "load"), ("drive_speed", "speed")):
        lines = table.above if kind == "speed" else [*((remark,) for remark in table.remarks), *table.above]
        hint = f"write its unit there, or give --{kind}"
        try:
            value = stated(table, kind, CONDITIONS[name], lines, only_numbers=kind == "speed", hint=hint)
        except ConfigError:
            if name not in known:
                raise
            continue
        conditions |= {name: value[0]} if value else {}
    return conditions


def _remarks(table: TextTable) -> dict[str, Condition]:
    """Conditions that remarks give. Raises ConfigError for those that cannot be understood."""
    conditions: dict[str, Condition] = {}
    problems = []
    for remark in table.remarks:
        if not (match := _REMARK.fullmatch(remark.text)):
            continue
        word, text = match.groups()
        try:
            if (name := condition_name(word)) is not None:
                conditions[name] = condition(name, text if name == MATERIAL else _number_or_text(text))
            elif near := nearest(word.strip(), (MATERIAL, *CONDITIONS)):  # which would be missed silently
                raise QuantityError(listed((MATERIAL, *CONDITIONS)), f"did you mean {near!r}?")
        except QuantityError as error:
            message = f"got {remark.text!r}, expected {error.expected}"
            problems.append(Problem((), message, remark.place, error.hint))
    if problems:
        raise ConfigError(table.name, problems)
    return conditions


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _check_time(table: TextTable, time: Floats, column: int) -> None:
    """Raises ConfigError at the first sample that is not later than the one before."""
    falling = np.flatnonzero(np.diff(time) <= 0)
    if not falling.size:
        return
    row = int(falling[0]) + 1
    line, heading = line_of(table, row), table.heading[column]
    message = f"got {time[row]:.9g} s after {time[row - 1]:.9g} s, expected time to increase"
    hint = "sort the samples; if times are rounded, write more digits"
    raise ConfigError(table.name, [Problem((heading.text,), message, heading.place._replace(line=line), hint)])
