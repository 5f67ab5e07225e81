"""Runs of many small blocks, and what they compute counted."""

import contextlib
import itertools

import pytest

import stickslip
from helpers.configs import write_config
from helpers.runs import until
from stickslip.runs import work

SIDE, BLOCK = 30, 64  # 900 cells in 15 blocks of two rows


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(work, "_FEWEST", BLOCK)


@pytest.fixture
def config(tmp_path, small_blocks):
    return write_config(tmp_path, num=SIDE)


@pytest.fixture
def output(tmp_path):
    return tmp_path / "map.nc"


@pytest.fixture
def computed(monkeypatch):
    """Numbers of cells computed, one entry per call of the engine."""
    counts = []
    compute_range = work.compute_range

    def counting(cells, start, end, *rest):
        counts.append(end - start)
        return compute_range(cells, start, end, *rest)

    monkeypatch.setattr(work, "compute_range", counting)
    return counts


@pytest.fixture
def endless_block(monkeypatch):
    """Makes one block, by its place in the order computed, go on until the run is stopped."""
    compute_range = work.compute_range

    @contextlib.contextmanager
    def endless(place):
        turns = itertools.count()

        def compute(cells, start, end, options, stop, *rest):
            if next(turns) == place:
                until(lambda: stop[0])
            return compute_range(cells, start, end, options, stop, *rest)

        with monkeypatch.context() as patch:
            patch.setattr(work, "compute_range", compute)
            yield

    return endless


@pytest.fixture
def whole(config):
    """The map as computed in memory."""
    return stickslip.run(config)
