"""Pairs of features and measured RPN, from the tables that people have: features, or the names of records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from stickslip.config.risk import HIGHEST, INPUTS, LOWEST
from stickslip.errors import ConfigError, Place, Problem, QuantityError
from stickslip.files.tables import Cell, Table, cells, numbers, read_table
from stickslip.fit.headings import heading, plain
from stickslip.fit.uncertainty import Floats
from stickslip.rig.calibration import Calibration, calibrate
from stickslip.rig.defects import reason_of
from stickslip.rig.evaluation import features, risk_inputs
from stickslip.rig.quantities import FEATURES
from stickslip.rig.records import read_record
from stickslip.rig.settings import Settings
from stickslip.vocabulary import units
from stickslip.vocabulary.suggest import listed

RPN = "rpn"
_FILES = ("file", "record")  # headings of a column that names records
_NO_FEATURES = "it has no features"


def calibrate_file(path: Path, settings: Settings | None = None, scales: bool = False) -> Calibration:
    """Fit the risk model to the pairs of a table: CSV or Excel.

    Its column `rpn` holds the measured numbers; a row without one is left out. The features are either columns named
    as in `FEATURES` with their units, as `rig features -o` writes them, or those of the records that a column `file`
    (or `record`) names, relative to the table's folder, computed with `settings`. Records of which a feature is not
    determined are left out, and named in `omitted`. Raises ConfigError.
    """
    settings = settings or Settings()
    table = read_table(path, "sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn", "pairs")
    at, rows = _positions(table), list(cells(table))
    used = [i for i, row in enumerate(rows) if len(row) <= at[RPN] or row[at[RPN]].text]
    column = next((at[name] for name in _FILES if name in at), None)
    omitted = []
    if has_features := all(name in at for name in INPUTS):
        spoiled = [i for i in used if _is_spoiled(rows[i], at)]
        names = [f"row {i + 1}" if column is None else rows[i][column].text for i in spoiled]
        omitted = [f"{name} ({_remark(rows[i], at)})" for name, i in zip(names, spoiled, strict=True)]
        used = [i for i in used if i not in spoiled]
    table, rows = replace(table, lines=tuple(table.lines[i] for i in used)), [rows[i] for i in used]
    if not rows:
        raise ConfigError(table.name, [Problem((RPN,), "no row has a number in this column, and features")])
    rpn = numbers(table, [at[RPN]])[at[RPN]]
    _check_numbers(table.name, [row[at[RPN]] for row in rows], rpn, LOWEST, HIGHEST)
    names = [] if column is None else [row[column].text for row in rows]
    if has_features:
        inputs = _inputs(table, rows, at)
    else:
        evaluated = _evaluated(table, rows, at, column, path.parent, settings)
        inputs = {name: np.array([float(risk_inputs(row)[name]) for row in evaluated]) for name in INPUTS}
        known = np.isfinite(np.stack([*inputs.values()])).all(axis=0)
        omitted = [f"{names[i]} ({reason_of(str(evaluated[i]['remarks'].item()))})" for i in np.flatnonzero(~known)]
        inputs, rpn = {name: values[known] for name, values in inputs.items()}, rpn[known]
        names = [names[i] for i in np.flatnonzero(known)]
    try:
        return replace(calibrate(inputs, rpn, settings.risk, scales, names), omitted=tuple(omitted))
    except ValueError as error:
        hint = f"left out: {'; '.join(omitted)}" if omitted else None
        raise ConfigError(str(path), [Problem((), str(error), hint=hint)]) from None


def _inputs(table: Table, rows: Sequence[Sequence[Cell]], at: Mapping[str, int]) -> dict[str, Floats]:
    """The inputs of the model from columns of features, in SI. Raises ConfigError."""
    columns = {name: at[_filled(table, rows, at, f"{name}_limited") or name] for name in INPUTS}
    read = numbers(table, [*columns.values()])
    for position in columns.values():
        _check_numbers(table.name, [row[position] for row in rows], read[position], 0.0, np.inf)
    return {name: read[i] * _factor(table, i, FEATURES[name].units) for name, i in columns.items()}


def _evaluated(
    table: Table, rows: Sequence[Sequence[Cell]], at: Mapping[str, int], column: int | None, folder: Path,
    settings: Settings,
) -> list[xr.Dataset]:  # fmt: skip
    """The features of the records that a column names. Raises ConfigError."""
    if column is None or any(name in at for name in INPUTS):
        lacking = listed([name for name in INPUTS if name not in at], "and")
        hint = "or name a record in each row, in a column 'file'; its features are computed"
        raise ConfigError(table.name, [Problem((), f"no column is called {lacking}", table.heading[0].place, hint)])
    files = [row[column] for row in rows]
    if lost := [cell for cell in files if not (folder / cell.text).is_file()]:
        wrong = [Problem((_FILES[0],), f"got {cell.text!r}, expected a file in {folder}", cell.place) for cell in lost]
        raise ConfigError(table.name, wrong)
    records = (read_record(folder / cell.text, settings.record, settings.conditions) for cell in files)
    return [features(record, settings.features) for record in records]


def _is_spoiled(row: Sequence[Cell], at: Mapping[str, int]) -> bool:
    """True if a row of `rig features` lacks a feature: all are empty, or its remarks say why one is."""
    texts = [row[at[name]].text if at[name] < len(row) else "" for name in INPUTS]
    return not any(texts) or (not all(texts) and _remark(row, at) != _NO_FEATURES)


def _remark(row: Sequence[Cell], at: Mapping[str, int]) -> str:
    """The reason why the features of a row are not determined."""
    text = row[at["remarks"]].text if at.get("remarks", len(row)) < len(row) else ""
    return reason_of(text) or _NO_FEATURES


def _check_numbers(name: str, cells: Sequence[Cell], values: Floats, low: float, high: float) -> None:
    """Raises ConfigError at the first number outside of its bounds. name : of the table."""
    for i in np.flatnonzero(~((values >= low) & (values <= high)))[:1]:
        bounds = f">= {low:g}" if np.isinf(high) else f"from {low:g} to {high:g}"
        raise ConfigError(name, [Problem((), f"got {cells[i].text}, expected a number {bounds}", cells[i].place)])


def _positions(table: Table) -> dict[str, int]:
    """The columns by name. Raises ConfigError if there is none of numbers, or one twice."""
    positions: dict[str, int] = {}
    for i, cell in enumerate(table.heading):
        name = plain(heading(cell.text, ()).name).replace(" ", "_")
        if name in positions and name in (RPN, *_FILES, *INPUTS):
            raise ConfigError(table.name, [Problem((), f"got the column {name} twice, expected it once", cell.place)])
        positions[name] = i
    if RPN in positions:
        return positions
    hint = (
        "model_rpn is computed by this program: put the measured numbers beside it"
        if "model_rpn" in positions
        else None
    )
    message = "no column is called rpn, expected the measured risk priority numbers, 1 to 10"
    raise ConfigError(table.name, [Problem((), message, table.heading[0].place, hint)])


def _filled(table: Table, rows: Sequence[Sequence[Cell]], at: Mapping[str, int], name: str) -> str | None:
    """A column that has numbers; None if it has none, or is not there. Raises ConfigError if only some rows have."""
    texts = [row[at[name]].text for row in rows if len(row) > at[name]] if name in at else []
    if any(texts) and not all(texts):
        place = Place(table.lines[texts.index("")][0], 1)
        hint = "compute the features of all records with the same --bandwidth"
        raise ConfigError(table.name, [Problem((name,), "empty here, and not in other rows", place, hint)])
    return name if any(texts) else None


def _factor(table: Table, position: int, unit: str) -> float:
    """The factor from the numbers of a column to SI; those without a unit are in SI. Raises ConfigError."""
    cell = table.heading[position]
    written = heading(cell.text, ()).unit
    try:
        return units.si_value(f"1 {written}", unit) if written not in ("", "1", "-") else 1.0
    except QuantityError as error:
        message = f"got {cell.text!r}, expected the unit of {units.kind(unit)}"
        raise ConfigError(table.name, [Problem((), message, cell.place, error.hint)]) from None
