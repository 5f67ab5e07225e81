"""Large arrays piece by piece, so that what is read of a file never exceeds a few dozen megabytes.

A slab is a piece that is whole along the last dimensions, like the chunks of our files; slabs of a lazy array are cut
along its chunks where that is possible, so that no chunk is read twice.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from itertools import product
from math import prod

import xarray as xr

MOST_VALUES = 2**21  # of a slab: 16 MiB of float64

Slab = dict[Hashable, slice]


def slabs(array: xr.DataArray, most: int = MOST_VALUES) -> Iterator[Slab]:
    """Pieces of at most `most` values (or of one chunk) that make up the array, in the order of its cells."""
    chunks = array.chunksizes
    steps = _steps(array.dims, array.sizes, {dim: max(lengths) for dim, lengths in chunks.items()}, most)
    return pieces(array.sizes, dict(zip(array.dims, steps, strict=True)))


def pieces(lengths: Mapping[Hashable, int], steps: Mapping[Hashable, int]) -> Iterator[Slab]:
    """Ranges of `steps` points along each dimension, the last ones shorter; the last dimension runs fastest."""
    starts = (range(0, length, steps[dim]) for dim, length in lengths.items())
    for corner in product(*starts):
        places = zip(lengths.items(), corner, strict=True)
        yield {dim: slice(start, min(start + steps[dim], length)) for (dim, length), start in places}


def _steps(
    dims: Sequence[Hashable], lengths: Mapping[Hashable, int], chunks: Mapping[Hashable, int], most: int
) -> list[int]:
    """Points per slab along each dimension: one chunk, and more from the last dimension on while there is room."""
    steps = [min(chunks.get(dim, 1), max(1, lengths[dim])) for dim in dims]
    for i in reversed(range(len(dims))):
        length = max(1, lengths[dims[i]])
        room = most // prod(steps[:i] + steps[i + 1 :])
        steps[i] = length if room >= length else max(steps[i], room // steps[i] * steps[i])
        if steps[i] < length:
            break
    return steps
