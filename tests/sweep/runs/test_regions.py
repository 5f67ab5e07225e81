"""Ranges of cells as hyper-rectangles, and as chunks."""

from math import prod

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stickslip.files import writing
from stickslip.runs.blocks import Shard, blocks_of
from stickslip.runs.regions import aligned, extent, regions

shapes = st.lists(st.integers(1, 7), max_size=4).map(tuple)


@given(shapes, st.data())
def test_regions_are_the_cells_of_the_range_in_their_order(shape, data):
    size = prod(shape)
    start = data.draw(st.integers(0, size))
    stop = data.draw(st.integers(start, size))
    numbers = np.arange(size).reshape(shape)
    found = regions(start, stop, shape)
    parts = [numbers[region].ravel() for region in found]
    np.testing.assert_array_equal(np.concatenate(parts) if parts else [], np.arange(start, stop))
    assert len(found) <= max(1, 2 * len(shape) - 1)
    assert all(extent(region) == numbers[region].shape for region in found)


@given(st.lists(st.integers(1, 60), min_size=1, max_size=3).map(tuple), st.integers(1, 500))
def test_aligned_ranges_are_one_chunk_each(shape, most):
    chunks = tuple(min(n, max(1, most // prod(shape[i + 1 :]))) for i, n in enumerate(shape))  # as store._chunks
    ranges = aligned(shape, chunks)
    np.testing.assert_array_equal(np.concatenate(list(ranges)), np.arange(prod(shape)))
    for cells in ranges:
        (region,) = regions(cells.start, cells.stop, shape)
        for side, chunk, length in zip(region, chunks, shape, strict=True):
            assert side.start % chunk == 0 and side.stop in (side.start + chunk, length)


def test_the_chunks_of_files_are_of_that_kind():
    for shape in [(50, 1000, 1000), (3, 7), (10**6, 2), (5, 131_073), (2, 2, 2, 99_999)]:
        assert all(len(regions(r.start, r.stop, shape)) == 1 for r in aligned(shape, writing._chunks(shape)))


@given(st.integers(1, 10**12))
def test_blocks_are_neither_too_small_nor_too_large_nor_too_few(size):
    blocks = blocks_of(size)
    assert blocks.count * blocks.length >= size > (blocks.count - 1) * blocks.length
    assert 4096 <= blocks.length <= 131_072
    assert blocks.count <= 256 or blocks.length == 131_072
    assert blocks.cells(blocks.count - 1).stop == size


@given(st.integers(1, 10**8), st.integers(1, 50))
def test_shards_share_out_every_block_once(size, count):
    blocks = blocks_of(size)
    shared = [set(Shard(i, count).blocks(blocks)) for i in range(1, count + 1)]
    assert set().union(*shared) == set(range(blocks.count)) and sum(map(len, shared)) == blocks.count
    assert max(map(len, shared)) - min(map(len, shared)) <= 1
