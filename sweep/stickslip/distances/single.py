"""The nearest border below and above the value of one parameter, in every cell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.borders.search import Brackets, Looked, Scan, search_lines
from stickslip.distances.reach import Reach
from stickslip.distances.regimes import Floats, Integers, Labels, Search, decided

SIDES = ("below", "above")


@dataclass(frozen=True, eq=False)
class Borders:
    """The nearest borders of n cells: (n, 2), below and above the value; NaN, and regime 0, where there is none.

    low, high : the last bracket in SI. change : of the side beyond, as `Reach` measures it. beyond : regime there.
    """

    low: Floats
    high: Floats
    change: Floats
    beyond: Labels


def nearest(
    search: Search, reach: Reach, home: Labels, into: list[int] | None, points: int, tolerance: float
) -> Borders:
    """The first change of regime on the way down and up.

    home : regimes of the cells as they are; those that are undecided have no border. into : codes of the regimes to be
    entered; None for any other. points : places looked at first on either side, evenly spaced in the change.
    """
    size = home.size
    room = np.stack(reach.room)

    def labels_at(line: Integers, place: Floats) -> Looked:
        cell = line // 2
        up = line % 2
        change = place * room[up, cell] * np.where(up == 1, 1.0, -1.0)
        return search.looked(cell, {reach.name: reach.at(change, cell)}, into)

    searched = np.flatnonzero(decided(home))
    lines = np.repeat(2 * searched, 2) + np.tile([0, 1], searched.size)
    lines = lines[room[lines % 2, lines // 2] > 0]
    scan = Scan(0.0, 1.0, points + 1, "linear")
    found, _ = search_lines(lines.size, scan, tolerance, lambda line, place: labels_at(lines[line], place))
    found["line"] = lines[found["line"]]
    return _table(first_entries(found, into), search, reach, size)


def first_entries(found: Brackets, into: list[int] | None) -> Brackets:
    """The first bracket of each line; with `into`, whose labels are 0 and 1, the first that enters."""
    entries = found if into is None else found[found["above"] == 1]
    _, first = np.unique(entries["line"], return_index=True)
    return entries[first]


def _table(found: Brackets, search: Search, reach: Reach, size: int) -> Borders:
    """First brackets as tables (n, 2)."""
    cell, up = found["line"] // 2, found["line"] % 2
    sign = np.where(up == 1, 1.0, -1.0)
    room = np.stack(reach.room)[up, cell]
    near, far = (reach.at(found[end] * room * sign, cell) for end in ("low", "high"))
    low, high, change = (np.full((size, 2), np.nan) for _ in range(3))
    low[cell, up], high[cell, up] = np.minimum(near, far), np.maximum(near, far)
    change[cell, up] = found["high"] * room * sign
    beyond = np.zeros((size, 2), np.int8)
    beyond[cell, up] = search.regimes(cell, {reach.name: far})
    return Borders(low, high, change, beyond)
