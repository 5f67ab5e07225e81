"""Maps with more cells than a plot has pixels, reduced block by block.

A block of n x m cells becomes one value that stands for all of them: the most frequent flag, with a mark where the
block holds others as well, or the mean of the cells that have a value. Nothing is skipped, so a thin regime shows at
least as a mark; and cells are read tile by tile, so any map can be drawn in little memory.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.slabs import MOST_VALUES, Slab, pieces

Block = tuple[int, int]  # rows and columns of cells


@dataclass(frozen=True)
class Coarse:
    """One value per block, shape (blocks down, blocks across).

    mixed : where a block holds more than one flag; None for numbers, and where every block is one cell.
    present : the flags of all cells, ascending, also those that are nowhere the most frequent; empty for numbers.
    """

    values: NDArray[Any]
    mixed: NDArray[np.bool_] | None = None
    present: tuple[int, ...] = ()


def block_for(shape: tuple[int, int], most: tuple[int, int]) -> Block:
    """The smallest block with which no more than `most` of them lie on a side."""
    rows, columns = (max(1, ceil(length / limit)) for length, limit in zip(shape, most, strict=True))
    return rows, columns


def flags(array: xr.DataArray, block: Block) -> Coarse:
    """The most frequent flag of every block (of equally frequent ones that with the lower code), and which are mixed.

    array : integers over two dimensions.
    """
    if block == (1, 1):
        cells = array.values
        return Coarse(cells, None, tuple(np.unique(cells).tolist()))
    found: set[int] = set()
    values, mixed = _blank(array.shape, block, array.dtype), _blank(array.shape, block, np.dtype(np.bool_))
    for place, cells in _tiles(array, block):
        present = np.unique(cells)
        counts = np.stack([_sums(cells == code, block, np.int32) for code in present])
        values[place] = present[counts.argmax(axis=0)]
        mixed[place] = np.count_nonzero(counts, axis=0) > 1
        found |= set(present.tolist())
    return Coarse(values, mixed, tuple(sorted(found)))


def numbers(array: xr.DataArray, block: Block) -> Coarse:
    """The mean of every block over its cells with a finite value; NaN where there is none.

    array : numbers over two dimensions.
    """
    if block == (1, 1):
        return Coarse(array.values.astype(np.float64, copy=False))
    means = _blank(array.shape, block, np.dtype(np.float64))
    for place, cells in _tiles(array, block):
        finite = np.isfinite(cells)
        counts = _sums(finite, block, np.int32)
        with np.errstate(invalid="ignore", over="ignore"):  # 0/0 is what NaN means here
            means[place] = _sums(np.where(finite, cells, 0.0), block, np.float64) / counts
    return Coarse(means)


def centres(array: xr.DataArray, block: Block) -> NDArray[np.float64]:
    """The value at the cell in the middle of every block (`middles`): exact, where a mean would be blurred."""
    values = _blank(array.shape, block, np.dtype(np.float64))
    for place, cells in _tiles(array, block):
        rows, columns = (middles(n, step) for n, step in zip(cells.shape, block, strict=True))
        values[place] = cells[np.ix_(rows, columns)]
    return values


def middles(length: int, step: int) -> NDArray[np.intp]:
    """Which cell lies in the middle of each block along an axis; the last block may be short."""
    starts = np.arange(0, length, step)
    return (starts + np.minimum(starts + step, length)) // 2


def _blank(shape: tuple[int, ...], block: Block, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Room for one value per block."""
    return np.zeros([ceil(length / step) for length, step in zip(shape, block, strict=True)], dtype)


def _tiles(array: xr.DataArray, block: Block) -> Iterator[tuple[tuple[slice, ...], NDArray[Any]]]:
    """Where in the blocks each tile belongs, and its cells. A tile is made of whole blocks."""
    across = max(1, MOST_VALUES // block[0] // block[1]) * block[1]
    down = max(1, MOST_VALUES // block[0] // min(across, array.shape[1])) * block[0]
    for slab in pieces(array.sizes, dict(zip(array.dims, (down, across), strict=True))):
        yield _place(slab, block), array.isel(slab).values


def _place(slab: Slab, block: Block) -> tuple[slice, ...]:
    steps = zip(slab.values(), block, strict=True)
    return tuple(slice(part.start // step, ceil(part.stop / step)) for part, step in steps)


def _sums(cells: NDArray[Any], block: Block, dtype: type[np.generic]) -> NDArray[Any]:
    """The sum of every block; those at the ends may be short."""
    (rows, columns), (down, across) = block, (ceil(n / step) for n, step in zip(cells.shape, block, strict=True))
    if cells.shape != (down * rows, across * columns):
        whole = np.zeros((down * rows, across * columns), cells.dtype)
        whole[: cells.shape[0], : cells.shape[1]] = cells
        cells = whole
    columnwise = cells.reshape(down, rows, across * columns).sum(axis=1, dtype=dtype)  # first down: the sum is shorter
    return np.asarray(columnwise.reshape(down, across, columns).sum(axis=2))
