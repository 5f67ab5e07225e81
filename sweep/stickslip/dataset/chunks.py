"""Large arrays chunk by chunk, so that what is read of a file never exceeds a few dozen megabytes.

A chunk read here is whole along the last dimensions, like those our files are stored in, and consists of whole stored
chunks of a lazy array where that is possible, so that none of them is read twice.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from itertools import product
from math import prod

import xarray as xr

MOST_VALUES = 2**21  # of a chunk: 16 MiB of float64

Chunk = dict[Hashable, slice]


def chunks(array: xr.DataArray, most: int = MOST_VALUES) -> Iterator[Chunk]:
    """Chunks of at most `most` values (or of one stored chunk) that make up the array, in the order of its cells."""
    stored = {dim: max(lengths) for dim, lengths in array.chunksizes.items()}
    stored = stored or array.encoding.get("preferred_chunks", {})  # of a file that is read without dask
    steps = _steps(array.dims, array.sizes, stored, most)
    return cut(array.sizes, dict(zip(array.dims, steps, strict=True)))


def cut(lengths: Mapping[Hashable, int], steps: Mapping[Hashable, int]) -> Iterator[Chunk]:
    """Ranges of `steps` points along each dimension, the last ones shorter; the last dimension runs fastest."""
    starts = (range(0, length, steps[dim]) for dim, length in lengths.items())
    for corner in product(*starts):
        places = zip(lengths.items(), corner, strict=True)
        yield {dim: slice(start, min(start + steps[dim], length)) for (dim, length), start in places}


def _steps(
    dims: Sequence[Hashable], lengths: Mapping[Hashable, int], stored: Mapping[Hashable, int], most: int
) -> list[int]:
    """Points per chunk along each dimension: a stored chunk, and more from the last dimension on if there is room."""
    steps = [min(stored.get(dim, 1), max(1, lengths[dim])) for dim in dims]
    for i in reversed(range(len(dims))):
        length = max(1, lengths[dims[i]])
        room = most // prod(steps[:i] + steps[i + 1 :])
        steps[i] = length if room >= length else max(steps[i], room // steps[i] * steps[i])
        if steps[i] < length:
            break
    return steps
