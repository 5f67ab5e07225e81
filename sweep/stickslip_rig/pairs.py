"""Pairs of features and measured RPN, from the tables that people have: features, or the names of records."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

from stickslip.errors import ConfigError, Place, Problem
from stickslip.files.tables import Cell, Table, cells, read_table
from stickslip.vocabulary.suggest import listed
from stickslip_materials.fit.columns import HeadedTable, factor
from stickslip_materials.fit.headings import Heading
from stickslip_materials.fit.uncertainty import Floats
from stickslip_materials.fit.words import plain
from stickslip_rig.calibration import Calibration, calibrate
from stickslip_rig.defects import reason_of
from stickslip_rig.evaluation import features, risk_inputs
from stickslip_rig.quantities import FEATURES
from stickslip_rig.records import read_record
from stickslip_rig.risk import HIGHEST, INPUTS, LOWEST
from stickslip_rig.settings import Settings

RPN = "rpn"
_MODEL = "model_rpn"
_FILES = ("file", "record")  # headings of a column that names records
_NAMES = {RPN, _MODEL, "remarks", *_FILES, *INPUTS, *(f"{name}_limited" for name in INPUTS)}
_EXAMPLE = "sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn"
_NO_FEATURES = "it has no features"


def calibrate_file(path: Path, settings: Settings | None = None) -> Calibration:
    """Fit the risk model to the pairs of a table: CSV or Excel.

    Its column `rpn` holds the measured numbers; a row without one is left out. The features are either columns named
    as in `FEATURES` with their units, as `rig features -o` writes them, or those of the records that a column `file`
    (or `record`) names, relative to the table's folder, computed with `settings`. Records of which a feature is not
    determined are left out, and named in `omitted`. Raises ConfigError.
    """
    settings = settings or Settings()
    headed = HeadedTable(read_table(path, _EXAMPLE, "pairs"), ())
    columns = _columns(headed)
    table, at = headed.table, {name: i for name, (i, _) in columns.items()}
    rows = list(cells(table))
    used = [i for i, row in enumerate(rows) if len(row) <= at[RPN] or row[at[RPN]].text]
    column = next((at[name] for name in _FILES if name in at), None)
    omitted = []
    if has_features := all(name in at for name in INPUTS):
        spoiled = [i for i in used if _is_spoiled(rows[i], at)]
        names = [f"row {i + 1}" if column is None else rows[i][column].text for i in spoiled]
        omitted = [f"{name} ({_remark(rows[i], at)})" for name, i in zip(names, spoiled, strict=True)]
        used = [i for i in used if i not in spoiled]
    headed.table, rows = replace(table, lines=tuple(table.lines[i] for i in used)), [rows[i] for i in used]
    if not rows:
        raise ConfigError(table.name, [Problem((RPN,), "no row has a number in this column, and features")])
    rpn = headed.values({RPN: columns[RPN]})[RPN]
    _check_numbers(table.name, [row[at[RPN]] for row in rows], rpn, LOWEST, HIGHEST)
    names = [] if column is None else [row[column].text for row in rows]
    if has_features:
        inputs = _inputs(headed, rows, columns)
    else:
        evaluated = _evaluated(headed, rows, at, column, path.parent, settings)
        inputs = {name: np.array([float(risk_inputs(row)[name]) for row in evaluated]) for name in INPUTS}
        known = np.isfinite(np.stack([*inputs.values()])).all(axis=0)
        omitted = [f"{names[i]} ({reason_of(str(evaluated[i]['remarks'].item()))})" for i in np.flatnonzero(~known)]
        inputs, rpn = {name: values[known] for name, values in inputs.items()}, rpn[known]
        names = [names[i] for i in np.flatnonzero(known)]
    try:
        return replace(calibrate(inputs, rpn, settings.risk, names), omitted=tuple(omitted))
    except ValueError as error:
        hint = f"left out: {'; '.join(omitted)}" if omitted else None
        raise ConfigError(str(path), [Problem((), str(error), hint=hint)]) from None


def _inputs(
    headed: HeadedTable, rows: Sequence[Sequence[Cell]], columns: Mapping[str, tuple[int, float]]
) -> dict[str, Floats]:
    """The inputs of the model from columns of features, in SI. Raises ConfigError."""
    used = {name: columns[_filled(headed.table, rows, columns, f"{name}_limited") or name] for name in INPUTS}
    values = headed.values(used)
    for name, (position, _) in used.items():
        _check_numbers(headed.table.name, [row[position] for row in rows], values[name], 0.0, np.inf)
    return values


def _evaluated(
    headed: HeadedTable, rows: Sequence[Sequence[Cell]], at: Mapping[str, int], column: int | None, folder: Path,
    settings: Settings,
) -> list[xr.Dataset]:  # fmt: skip
    """The features of the records that a column names. Raises ConfigError."""
    if column is None or any(name in at for name in INPUTS):
        lacking = listed([name for name in INPUTS if name not in at], "and")
        hint = "or name a record in each row, in a column 'file'; its features are computed"
        raise headed.error(f"no column is called {lacking}", hint)
    files = [row[column] for row in rows]
    if lost := [cell for cell in files if not (folder / cell.text).is_file()]:
        wrong = [Problem((_FILES[0],), f"got {cell.text!r}, expected a file in {folder}", cell.place) for cell in lost]
        raise ConfigError(headed.table.name, wrong)
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


def _columns(headed: HeadedTable) -> dict[str, tuple[int, float]]:
    """Position and factor to SI of the columns by name. Raises ConfigError, also if there is none of numbers."""

    def name_of(column: Heading) -> str | None:
        name = plain(column.name).replace(" ", "_")
        return name if name in _NAMES else None

    def factor_of(name: str, column: Heading) -> float:
        return factor(name, column.unit, FEATURES[name].units) if name in FEATURES else 1.0

    columns = headed.find(name_of, factor_of, "remove one of the two columns")
    if RPN in columns:
        return columns
    hint = "model_rpn is computed by this program: put the measured numbers beside it"
    message = "no column is called rpn, expected the measured risk priority numbers, 1 to 10"
    raise headed.error(message, hint if _MODEL in columns else None)


def _filled(
    table: Table, rows: Sequence[Sequence[Cell]], columns: Mapping[str, tuple[int, float]], name: str
) -> str | None:
    """A column that has numbers; None if it has none, or is not there. Raises ConfigError if only some rows have."""
    if name not in columns:
        return None
    position = columns[name][0]
    texts = [row[position].text for row in rows if len(row) > position]
    if any(texts) and not all(texts):
        place = Place(table.lines[texts.index("")][0], 1)
        hint = "compute the features of all records with the same --bandwidth"
        raise ConfigError(table.name, [Problem((name,), "empty here, and not in other rows", place, hint)])
    return name if any(texts) else None
