"""Pairs of features and measured RPN, from the tables that `rig features -o` writes and people add a column to."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from stickslip.errors import ConfigError, Problem
from stickslip.files.tables import cells, read_table
from stickslip.vocabulary.suggest import listed
from stickslip_materials.fit.columns import HeadedTable, factor
from stickslip_materials.fit.headings import Heading
from stickslip_materials.fit.words import plain
from stickslip_rig.calibration import Calibration, calibrate
from stickslip_rig.defects import reason_of
from stickslip_rig.quantities import FEATURES
from stickslip_rig.risk import HIGHEST, INPUTS, LOWEST, Risk

RPN = "rpn"
_NAMES = {RPN, "model_rpn", "remarks", "record", *INPUTS, *(f"{name}_limited" for name in INPUTS)}
_EXAMPLE = "sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn"


def calibrate_file(path: Path, start: Risk | None = None) -> Calibration:
    """Fit the risk model to the pairs of a table: CSV or Excel.

    Its column `rpn` holds the measured numbers; a row without one is left out. The features are columns named as in
    `FEATURES` with their units, as `rig features -o` writes them; the band-limited ones where there are any. Records of
    which a feature is not determined are left out, and named in `omitted`. start : its scales hold. Raises ConfigError.
    """
    headed = HeadedTable(read_table(path, _EXAMPLE, "pairs"), ())
    columns, width = _columns(headed), len(headed.headings)
    rows = list(cells(headed.table))
    texts = [{name: row[i].text for name, (i, _) in columns.items()} if len(row) == width else None for row in rows]
    limited = {name: f"{name}_limited" for name in INPUTS}
    taken = {name: columns[limited[name] if any(row and row.get(limited[name]) for row in texts) else name]
             for name in INPUTS}  # fmt: skip
    used, omitted = [], []
    for i, (row, text) in enumerate(zip(rows, texts, strict=True)):
        if text is None or (text[RPN] and all(row[position].text for position, _ in taken.values())):
            used.append(i)  # also a row of another length, which is refused below
        elif text[RPN]:
            reason = reason_of(text.get("remarks", "")) or "a feature is empty"
            omitted.append(f"{text.get('record', f'row {i + 1}')} ({reason})")
    headed.table = replace(headed.table, lines=tuple(headed.table.lines[i] for i in used))
    hint = f"left out: {'; '.join(omitted)}" if omitted else None
    if not used:
        raise ConfigError(headed.table.name, [Problem((RPN,), "no row has a number and features", hint=hint)])
    taken |= {RPN: columns[RPN]}
    numbers = headed.values(taken)
    for name, (position, _) in taken.items():
        low, high = (LOWEST, HIGHEST) if name == RPN else (0.0, np.inf)
        for i in np.flatnonzero(~((numbers[name] >= low) & (numbers[name] <= high)))[:1].tolist():
            bounds, cell = f">= {low:g}" if np.isinf(high) else f"from {low:g} to {high:g}", rows[used[i]][position]
            problem = Problem((), f"got {cell.text}, expected a number {bounds}", cell.place)
            raise ConfigError(headed.table.name, [problem])
    names = [(texts[i] or {}).get("record", f"row {i + 1}") for i in used]
    try:
        return replace(calibrate(numbers, numbers[RPN], start, names), omitted=tuple(omitted))
    except ValueError as error:
        raise ConfigError(str(path), [Problem((), str(error), hint=hint)]) from None


def _columns(headed: HeadedTable) -> Mapping[str, tuple[int, float]]:
    """Position and factor to SI of the columns by name. Raises ConfigError, also if one is missing."""

    def name_of(column: Heading) -> str | None:
        name = plain(column.name).replace(" ", "_")
        return name if name in _NAMES else None

    def factor_of(name: str, column: Heading) -> float:
        return factor(name, column.unit, FEATURES[name].units) if name in FEATURES else 1.0

    columns = headed.find(name_of, factor_of, "remove one of the two columns")
    if lacking := [name for name in (RPN, *INPUTS) if name not in columns]:
        hint = "model_rpn is computed by this program: put the measured numbers beside it, in a column rpn"
        raise headed.error(f"no column is called {listed(lacking, 'and')}", hint if RPN in lacking else None)
    return columns
