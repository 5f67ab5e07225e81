"""What a run computes: a map, borders, samples; in blocks that any thread, shard or cluster may compute."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, prod
from threading import Lock
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.engine import Options, Results, StopFlag

Moved = Callable[[int], None]
_SURE = 0.8  # of the cells that items are expected to take: up to here their share is what is done


@dataclass(frozen=True)
class Finished:
    """The results of a range of items; complete : False if computing was stopped on the way, and they are no use."""

    results: Results
    complete: bool = True


class Study(ABC):
    """Items in a row, any range of which can be computed by itself, anywhere, any number of times, to the same bits.

    name : of the result, for people ("map"). counted : what its items are ("cells", "lines").
    dims, shape : of the items, the last index running fastest. options : of the integration.
    cells_each : about how many cells an item takes. weight : blocks have so many times fewer items than those of a map.
    ragged : whether columns may have other lengths than the range has items.
    is_array : whether its columns, of all items, are the variables of the result; then blocks are chunks of its file.
    columns : names and types of the results of a range: int8, int32 or float64, flat.
    """

    name: str
    counted: str
    cells_each: int = 1
    weight: int = 1
    ragged: bool = False
    is_array: bool = False
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    options: Options
    columns: Mapping[str, np.dtype[Any]]

    def described(self) -> str:
        """`57,600 cells: stiffness (240) x belt_speed (240)`."""
        size = prod(self.shape)
        axes = " x ".join(f"{dim} ({length})" for dim, length in zip(self.dims, self.shape, strict=True))
        return f"{size:,} {self.counted if size != 1 else self.counted.removesuffix('s')}" + (
            f": {axes}" if axes else ""
        )

    @property
    def kernels(self) -> tuple[str, ...]:
        """Names of the kernels that are known to be needed, to be compiled before the first item is computed."""
        return (self.options.law,)

    @abstractmethod
    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """The results of a range of items, by the calling thread alone.

        stop : once it is raised, computing ends within milliseconds. moved : called with cells computed, now and then.
        """

    @abstractmethod
    def blank(self, items: range) -> Results:
        """Return what stands for a range of items that is not computed."""

    @abstractmethod
    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The labelled result from ranges of items, in order and without gaps.

        parts : each is read when it is asked for, so that going through them once holds one at a time.
        """


class Meter:
    """How many items are done, counted from many threads; those under way by the share of the cells they may take.

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
