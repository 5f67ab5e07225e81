"""Ranges of cells as hyper-rectangles, and as chunks."""

from math import prod

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.runs.output import part_of
from stickslip.runs.work import Blocks, Shard, blocks_of, blocks_of_chunks, chunks_of


@given(st.lists(st.integers(1, 60), min_size=1, max_size=3).map(tuple), st.integers(1, 500))
def test_the_chunks_of_any_file_are_blocks(shape, most):
    chunks = tuple(min(n, max(1, most // prod(shape[i + 1 :]))) for i, n in enumerate(shape))  # as writing._chunks
    blocks = blocks_of_chunks(chunks, shape)
    check(blocks, shape)
    for number in range(blocks.count):
        cells, numbers = blocks.cells(number), np.arange(prod(shape)).reshape(shape)
        origin, extent = part_of(cells, shape)
        assert all(
            first % chunk == 0 and (size == chunk or first + size == length)
            for first, size, chunk, length in zip(origin, extent, chunks, shape, strict=True)
        )
        part = tuple(slice(first, first + size) for first, size in zip(origin, extent, strict=True))
        np.testing.assert_array_equal(numbers[part].ravel(), cells)


def check(blocks, shape):
    """Blocks are all cells in order, and each cell is in its block."""
    ranges = [blocks.cells(number) for number in range(blocks.count)]
    np.testing.assert_array_equal(np.concatenate(ranges), np.arange(prod(shape)))
    assert all(blocks.at(cells[0]) == blocks.at(cells[-1]) == number for number, cells in enumerate(ranges))


lengths = st.one_of(st.integers(1, 9), st.integers(1, 3000))


@given(st.lists(lengths, max_size=4).map(tuple).filter(lambda shape: prod(shape) < 300_000), st.integers(1, 300))
def test_the_blocks_of_a_map_are_chunks(shape, weight):
    blocks = blocks_of(shape, weight)
    check(blocks, shape)
    chunks = chunks_of(blocks, shape)
    assert chunks is not None and blocks_of_chunks(chunks, shape) == blocks


@given(st.integers(1, 10**8), st.integers(1, 50))
def test_shards_share_out_every_block_once(size, count):
    blocks = blocks_of((size,))
    shared = [set(Shard(i, count).blocks(blocks)) for i in range(1, count + 1)]
    assert set().union(*shared) == set(range(blocks.count)) and sum(map(len, shared)) == blocks.count
    assert max(map(len, shared)) - min(map(len, shared)) <= 1


@pytest.mark.parametrize("shards", [2, 3, 4, 5, 8, 10])
@pytest.mark.parametrize(("rows", "in_row"), [(20, 4), (64, 3), (16, 8), (100, 1), (19, 6)])
def test_shards_of_eight_blocks_and_more_cost_alike_wherever_the_expensive_blocks_lie(rows, in_row, shards):
    whole = Blocks(rows * in_row * 10, 10, in_row * 10)
    dealt = [Shard(i, shards).blocks(whole) for i in range(1, shards + 1)]
    for cost in (
        lambda b: 1.0 + 7.0 * (b % in_row == in_row - 1),
        lambda b: 1.0 + b,
        lambda b: 1.0 + (b // in_row) ** 2,
    ):
        costs = [sum(map(cost, one)) for one in dealt]
        assert max(costs) < 1.6 * sum(costs) / shards
