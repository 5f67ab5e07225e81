"""Count of the finished items of a study, and columns of several ranges in one."""

from collections.abc import Sequence
from math import exp
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.config.studies import Moved
from stickslip.engine import Results

_SURE = 0.8  # of the cells that items are expected to take: up to here their share is what is done


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
            return self._done + sum(self._share(*one) for one in self._under_way.values())

    def _share(self, items: int, cells: int) -> float:
        """Return how many of some items so many cells are; where they take more than expected, less than all."""
        if self._each <= 1:
            return min(cells, items)
        share = cells / (self._each * items)
        return items * (share if share < _SURE else 1.0 - (1.0 - _SURE) * exp((_SURE - share) / (1.0 - _SURE)))


def joined(parts: Sequence[Results]) -> Results:
    """Columns of several ranges, end to end."""
    columns: dict[str, list[NDArray[Any]]] = {}
    for part in parts:
        for name, values in part.items():
            columns.setdefault(name, []).append(values)
    return {name: np.concatenate(values) for name, values in columns.items()}
