"""Pairs of features and measured RPN, from the tables that people have: features, or the names of records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from stickslip.errors import ConfigError, Place, Problem, QuantityError
from stickslip.files.tables import Cell, Table, cells, numbers, read_table
from stickslip.fit.headings import heading, plain
from stickslip.fit.uncertainty import Floats
from stickslip.rig.analysis.calibrate import Calibration, calibrate
from stickslip.rig.analysis.table import features, risk_inputs
from stickslip.rig.quantities import FEATURES
from stickslip.rig.records.record import read_record
from stickslip.rig.risk import INPUTS
from stickslip.rig.settings import Settings
from stickslip.vocabulary import units
from stickslip.vocabulary.words import listed

RPN = "rpn"
_FILES = ("file", "record")  # headings of a column that names records


def calibrate_file(path: Path, settings: Settings | None = None, scales: bool = False) -> Calibration:
    """The risk model fitted to the pairs of a table: CSV or Excel.

    Its column `rpn` holds the measured numbers; a row without one is left out. The features are either columns named
    as in `FEATURES` with their units, as `rig features -o` writes them, or those of the records that a column `file`
    (or `record`) names, relative to the table's folder, computed with `settings`. Raises ConfigError.
    """
    how = settings or Settings()
    table = read_table(path, "sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn", "pairs")
    inputs, rpn, names = _pairs(table, path.parent, how)
    try:
        return calibrate(inputs, rpn, how.risk, scales, names)
    except ValueError as error:
        raise ConfigError(str(path), [Problem((), str(error))]) from None


def _pairs(table: Table, folder: Path, how: Settings) -> tuple[dict[str, Floats], Floats, list[str]]:
    """Features by name, in SI, the numbers and the names of the pairs. Raises ConfigError."""
    at = _positions(table)
    rows = list(cells(table))
    given = [i for i, row in enumerate(rows) if len(row) <= at[RPN] or row[at[RPN]].text]
    table, rows = replace(table, lines=tuple(table.lines[i] for i in given)), [rows[i] for i in given]
    if not rows:
        raise ConfigError(table.name, [Problem((RPN,), "no row has a number in this column")])
    rpn = numbers(table, [at[RPN]])[at[RPN]]
    column = next((at[name] for name in _FILES if name in at), None)
    names = [] if column is None else [row[column].text for row in rows]
    if all(name in at for name in INPUTS):
        used = [_filled(table, rows, at, f"{name}_limited") or name for name in INPUTS]
        read = numbers(table, [at[name] for name in used])
        factors = [_factor(table, at[name], FEATURES[name].units) for name in used]
        return {n: read[at[u]] * f for n, u, f in zip(INPUTS, used, factors, strict=True)}, rpn, names
    if column is None or any(name in at for name in INPUTS):
        lacking = listed([name for name in INPUTS if name not in at], "and")
        hint = "or name a record in each row, in a column 'file'; its features are computed"
        raise ConfigError(table.name, [Problem((), f"no column is called {lacking}", table.heading[0].place, hint)])
    lost = [row[column] for row in rows if not (folder / row[column].text).is_file()]
    if lost:
        wrong = [Problem((_FILES[0],), f"got {cell.text!r}, expected a file in {folder}", cell.place) for cell in lost]
        raise ConfigError(table.name, wrong)
    records = [read_record(folder / name, how.record, how.conditions) for name in names]
    found = [risk_inputs(features(record, how.features)) for record in records]
    return {name: np.array([float(one[name]) for one in found]) for name in INPUTS}, rpn, names


def _positions(table: Table) -> dict[str, int]:
    """The columns by name. Raises ConfigError if there is none of numbers, or one twice."""
    found: dict[str, int] = {}
    for i, cell in enumerate(table.heading):
        name = plain(heading(cell.text, ()).name).replace(" ", "_")
        if name in found and name in (RPN, *_FILES, *INPUTS):
            raise ConfigError(table.name, [Problem((), f"got the column {name} twice, expected it once", cell.place)])
        found[name] = i
    if RPN in found:
        return found
    hint = "model_rpn is computed by this program: put the measured numbers beside it" if "model_rpn" in found else None
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
    """What the numbers of a column are multiplied with to be in SI; those without a unit are. Raises ConfigError."""
    cell = table.heading[position]
    written = heading(cell.text, ()).unit
    try:
        return units.si_value(f"1 {written}", unit) if written not in ("", "1", "-") else 1.0
    except QuantityError as error:
        message = f"got {cell.text!r}, expected the unit of {units.kind(unit)}"
        raise ConfigError(table.name, [Problem((), message, cell.place, error.hint)]) from None
