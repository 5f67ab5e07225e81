"""Count of the finished items of a study, and columns of several ranges in one."""

from collections.abc import Sequence
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.config.studies import Moved
from stickslip.engine import Results

_MOST = 0.95  # of items that may take more cells than expected, until they are done


class Meter:
    """Count of finished items, by many threads; those under way by the share of the cells they may take.

    cells_each : as that of a study. done : items found finished.
    """

    def __init__(self, cells_each: int, done: int = 0) -> None:
        self._each, self._done, self._lock = cells_each, done, Lock()
        self._under_way: dict[int, tuple[int, int]] = {}  # items and cells, by number of the block

    def watch(self, number: int, items: int) -> Moved:
        """Return what computing a block of so many items calls with cells computed."""

        def moved(cells: int) -> None:
            with self._lock:
                self._under_way[number] = items, self._under_way.get(number, (items, 0))[1] + cells

        return moved

    def end(self, number: int, items: int) -> None:
        """Count a block as done, or with no items as none."""
        with self._lock:
            self._under_way.pop(number, None)
            self._done += items

    @property
    def items(self) -> float:
        """Items done; a whole number where no block is under way, or where an item is a cell."""
        with self._lock:
            return self._done + sum(self._share(*block) for block in self._under_way.values())

    def _share(self, items: int, cells: int) -> float:
        """Return how many of some items so many cells are; where they take more than expected, not yet all."""
        return min(cells / max(self._each, 1), items if self._each <= 1 else _MOST * items)


def joined(parts: Sequence[Results]) -> Results:
    """Columns of several ranges, end to end."""
    columns: dict[str, list[NDArray[Any]]] = {}
    for part in parts:
        for name, values in part.items():
            columns.setdefault(name, []).append(values)
    return {name: np.concatenate(values) for name, values in columns.items()}
