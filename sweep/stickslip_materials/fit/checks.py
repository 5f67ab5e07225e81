"""Tables that are not the points they were taken for: records over time, parts under other conditions, units above."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stickslip.errors import ConfigError
from stickslip.files.tables import Cell, Table
from stickslip.vocabulary.display_units import is_column_unit
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.suggest import listed
from stickslip_materials.fit.columns import HeadedTable
from stickslip_materials.fit.roles import Role
from stickslip_materials.fit.words import plain

if TYPE_CHECKING:
    from stickslip_materials.fit.points import Columns

_MOST_SAMPLES = 10  # of a speed that follow each other, in a table of points
_RECORD = 8  # steps of time, of which most are alike in a record
_COURSE = re.compile(r"cycl|zykl|loop|schleife|run|lauf|repe|wiederh|pass|sweep|ramp|step|schritt|\bn[or]\b|index")
_CONDITION = 1.25  # ratio of friction by which two conditions are told from scatter


def check_record(headed: HeadedTable, rows: Sequence[Sequence[Cell]]) -> None:
    """Raises ConfigError for samples over time at steps of a speed: which are points, the steps tell."""
    kinds = {head.kind: i for i, head in reversed([*enumerate(headed.headings)])}
    speed = kinds.get("speed", kinds.get("rotation"))
    if "time" not in kinds or speed is None:
        return
    values = [row[speed].text for row in rows if speed < len(row)]
    steps = 1 + sum(a != b for a, b in itertools.pairwise(values))
    if len(values) >= _MOST_SAMPLES * steps:
        message = f"this is a record with {steps} steps of {headed.headings[speed].text!r}, expected a point of each"
        raise headed.error(message, "stickslip points RECORD -o points.csv averages them")


def check_waiting(headed: HeadedTable, roles: Sequence[Role], materials: dict[str, Columns]) -> None:
    """Raises ConfigError for friction over the time of a record, which is no time at rest."""
    over, mu = (headed.headings[role.position] for role in roles[:2])
    if over.is_waiting() or mu.kind == "static":
        return
    for points in materials.values():
        steps = np.diff(points["time"])
        usual = np.median(steps) if steps.size >= _RECORD else 0.0
        if points["time"].min() <= 0 or (usual > 0 and np.mean(np.abs(steps - usual) < 0.2 * usual) > 0.7):
            hint = (
                "a record becomes points by `stickslip points RECORD --plan PLAN`; call times at rest 'hold time [s]'"
            )
            raise headed.refused(roles[0].position, "hold times; this looks like a record over time", hint)


def check_conditions(
    headed: HeadedTable, rows: Sequence[Sequence[Cell]], used: set[int | None], points: Columns
) -> None:
    """Raises ConfigError where a column that is not used tells parts of very different friction at one speed."""
    along, mu = (points[name] for name in (*points,)[:2])
    for i, head in enumerate(headed.headings if mu.size == len(rows) else ()):  # no gaps
        texts = np.array([row[i].text if i < len(row) else "" for row in rows])
        values = list(dict.fromkeys(texts.tolist()))
        is_course = head.kind in ("sigma", "spread", "time", "direction") or _COURSE.search(plain(head.name))
        if i in used or is_course or not 1 < len(values) <= mu.size / 3:
            continue
        order = np.argsort(along, kind="stable")
        x, y, parts = along[order], mu[order], texts[order]
        first, others = parts == values[0], (parts != values[0]) & (y > 0)
        shared = others & (x >= x[first].min()) & (x <= x[first].max())
        ratios = np.interp(x[shared], x[first], y[first]) / y[shared]
        if ratios.size > 2 and (ratios.min() > _CONDITION or ratios.max() < 1 / _CONDITION):
            times = float(np.median(np.maximum(ratios, 1 / ratios)))
            expected = f"one of {listed(values, 'and')}: friction at one speed differs by a factor of {times:.2g}"
            raise headed.refused(i, expected, "keep the rows of one, or call the column 'material'")


def check_units_above(table: Table, column: Parameter) -> None:
    """Raises ConfigError where a line above the heading holds a unit that the heading lacks."""
    for cell in (cell for line in table.above for cell in line if is_column_unit(cell.text, column.units)):
        message = f"got the unit {cell.text!r} above the heading, expected it behind {column.name}"
        hint = f"write '{column.name} [{cell.text}]', or say --unit {cell.text}"
        raise ConfigError.of(table.name, message, hint, place=cell.place)
