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
from stickslip.rig.analysis.defects import reason_of
from stickslip.rig.analysis.table import features, risk_inputs
from stickslip.rig.quantities import FEATURES
from stickslip.rig.records.record import read_record
from stickslip.rig.risk import HIGHEST, INPUTS, LOWEST
from stickslip.rig.settings import Settings
from stickslip.vocabulary import units
from stickslip.vocabulary.suggest import listed

RPN = "rpn"
_FILES = ("file", "record")  # headings of a column that names records
_NO_FEATURES = "it has no features"


def calibrate_file(path: Path, settings: Settings | None = None, scales: bool = False) -> Calibration:
    """The risk model fitted to the pairs of a table: CSV or Excel.

    Its column `rpn` holds the measured numbers; a row without one is left out. The features are either columns named
    as in `FEATURES` with their units, as `rig features -o` writes them, or those of the records that a column `file`
    (or `record`) names, relative to the table's folder, computed with `settings`. Records of which a feature is not
    determined are left out, and named in `omitted`. Raises ConfigError.
    """
    how = settings or Settings()
    table = read_table(path, "sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn", "pairs")
    inputs, rpn, names, omitted = _pairs(table, path.parent, how)
    try:
        return replace(calibrate(inputs, rpn, how.risk, scales, names), omitted=tuple(omitted))
    except ValueError as error:
        hint = f"left out: {'; '.join(omitted)}" if omitted else None
        raise ConfigError(str(path), [Problem((), str(error), hint=hint)]) from None


def _pairs(table: Table, folder: Path, how: Settings) -> tuple[dict[str, Floats], Floats, list[str], list[str]]:
    """Features by name, in SI, the numbers, the names of the pairs, and what is left out. Raises ConfigError."""
    at = _positions(table)
    rows = list(cells(table))
    given = [i for i, row in enumerate(rows) if len(row) <= at[RPN] or row[at[RPN]].text]
    column = next((at[name] for name in _FILES if name in at), None)
    has_features = all(name in at for name in INPUTS)
    spoiled = [i for i in given if has_features and _is_spoiled(rows[i], at)]
    omitted = [f"{_name(rows[i], column, i)} ({_remark(rows[i], at)})" for i in spoiled]
    given = [i for i in given if i not in spoiled]
    table, rows = replace(table, lines=tuple(table.lines[i] for i in given)), [rows[i] for i in given]
    if not rows:
        raise ConfigError(table.name, [Problem((RPN,), "no row has a number in this column, and features")])
    rpn = numbers(table, [at[RPN]])[at[RPN]]
    _check(table.name, [row[at[RPN]] for row in rows], rpn, LOWEST, HIGHEST)
    names = [] if column is None else [row[column].text for row in rows]
    if has_features:
        used = [_filled(table, rows, at, f"{name}_limited") or name for name in INPUTS]
        read = numbers(table, [at[name] for name in used])
        for name in used:
            _check(table.name, [row[at[name]] for row in rows], read[at[name]], 0.0, np.inf)
        factors = [_factor(table, at[name], FEATURES[name].units) for name in used]
        return {n: read[at[u]] * f for n, u, f in zip(INPUTS, used, factors, strict=True)}, rpn, names, omitted
    if column is None or any(name in at for name in INPUTS):
        lacking = listed([name for name in INPUTS if name not in at], "and")
        hint = "or name a record in each row, in a column 'file'; its features are computed"
        raise ConfigError(table.name, [Problem((), f"no column is called {lacking}", table.heading[0].place, hint)])
    lost = [row[column] for row in rows if not (folder / row[column].text).is_file()]
    if lost:
        wrong = [Problem((_FILES[0],), f"got {cell.text!r}, expected a file in {folder}", cell.place) for cell in lost]
        raise ConfigError(table.name, wrong)
    records = [read_record(folder / name, how.record, how.conditions) for name in names]
    found = [features(record, how.features) for record in records]
    inputs = {name: np.array([float(risk_inputs(one)[name]) for one in found]) for name in INPUTS}
    known = np.isfinite(np.stack([*inputs.values()])).all(axis=0)
    omitted = [
        f"{name} ({reason_of(str(one['remarks'].item()))})"
        for name, one, good in zip(names, found, known.tolist(), strict=True)
        if not good
    ]
    names = [name for name, good in zip(names, known.tolist(), strict=True) if good]
    return {name: values[known] for name, values in inputs.items()}, rpn[known], names, omitted


def _is_spoiled(row: Sequence[Cell], at: Mapping[str, int]) -> bool:
    """Whether a row of `rig features` lacks a feature: all are empty, or its remarks say why one is."""
    texts = [row[at[name]].text if at[name] < len(row) else "" for name in INPUTS]
    return not any(texts) or (not all(texts) and _remark(row, at) != _NO_FEATURES)


def _remark(row: Sequence[Cell], at: Mapping[str, int]) -> str:
    """Why the features of a row are not determined."""
    text = row[at["remarks"]].text if at.get("remarks", len(row)) < len(row) else ""
    return reason_of(text) or _NO_FEATURES


def _name(row: Sequence[Cell], column: int | None, i: int) -> str:
    return f"row {i + 1}" if column is None else row[column].text


def _check(name: str, cells: Sequence[Cell], values: Floats, low: float, high: float) -> None:
    """Raises ConfigError at the first number outside of its bounds. name : of the table."""
    wrong = np.flatnonzero(~((values >= low) & (values <= high)))
    if wrong.size:
        cell, bounds = cells[int(wrong[0])], f">= {low:g}" if np.isinf(high) else f"from {low:g} to {high:g}"
        raise ConfigError(name, [Problem((), f"got {cell.text}, expected a number {bounds}", cell.place)])


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
