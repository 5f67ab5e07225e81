import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from helpers.maps import plane
from stickslip.dataset import coarse
from stickslip.dataset.coarse import chunks
from stickslip.vocabulary.quantities import REGIMES


def array(values) -> xr.DataArray:
    return xr.DataArray(values, dims=("y", "x"))


def pixels(values, pixel):
    """Every pixel by itself, the slow and obvious way."""
    (rows, columns), (down, across) = values.shape, pixel
    return [[values[i : i + down, j : j + across] for j in range(0, columns, across)] for i in range(0, rows, down)]


SHAPES = st.tuples(st.integers(1, 17), st.integers(1, 17))
PIXELS = st.tuples(st.integers(1, 5), st.integers(1, 5))


@given(shape=SHAPES, pixel=PIXELS, seed=st.integers(0, 9), most=st.sampled_from([1, 20, 10**6]))
def test_a_pixel_of_flags_is_its_mode_and_mixed_if_it_holds_others(shape, pixel, seed, most):
    values = np.random.default_rng(seed).integers(0, 3, shape).astype(np.int8)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coarse, "MOST_VALUES", most)
        found = coarse.flags(array(values), pixel)
    assert found.present == tuple(np.unique(values))
    for i, row in enumerate(pixels(values, pixel)):
        for j, cells in enumerate(row):
            assert found.values[i, j] == np.bincount(cells.ravel()).argmax()
            assert pixel == (1, 1) or found.mixed[i, j] == (np.unique(cells).size > 1)


@given(shape=SHAPES, pixel=PIXELS, seed=st.integers(0, 9), most=st.sampled_from([1, 20, 10**6]))
def test_a_pixel_of_numbers_is_the_mean_of_those_that_are_finite(shape, pixel, seed, most):
    chance = np.random.default_rng(seed)
    values = np.where(chance.random(shape) < 0.4, np.nan, chance.random(shape))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coarse, "MOST_VALUES", most)
        found = coarse.numbers(array(values), pixel).values
    for i, row in enumerate(pixels(values, pixel)):
        for j, cells in enumerate(row):
            finite = cells[np.isfinite(cells)]
            np.testing.assert_allclose(found[i, j], finite.mean() if finite.size else np.nan)


@given(shape=SHAPES, pixel=PIXELS)
def test_the_cell_in_the_middle_of_a_pixel_is_one_of_its_cells(shape, pixel):
    values = np.arange(shape[0] * shape[1], dtype=float).reshape(shape)
    found = coarse.centres(array(values), pixel)
    for i, row in enumerate(pixels(values, pixel)):
        for j, cells in enumerate(row):
            assert found[i, j] == cells[cells.shape[0] // 2, cells.shape[1] // 2]


def test_pixels_are_as_small_as_the_page_allows():
    assert coarse.pixel_for((540, 720), (540, 720)) == (1, 1)
    assert coarse.pixel_for((541, 10_000_000), (540, 720)) == (2, 13_889)
    assert coarse.pixel_for((1, 1), (540, 720)) == (1, 1)


@given(
    lengths=st.lists(st.integers(1, 9), min_size=0, max_size=4),
    chunk=st.integers(1, 4),
    most=st.sampled_from([1, 4, 30, 10**6]),
)
def test_chunks_cover_every_cell_once_along_stored_ones(lengths, chunk, most):
    dims = [f"d{i}" for i in range(len(lengths))]
    ds = xr.DataArray(np.zeros(lengths, np.int64), dims=dims)
    counted = ds.copy()
    lazy = ds.chunk(chunk) if dims else ds
    for found in chunks(lazy, most):
        counted[found] += 1
        size = np.prod([part.stop - part.start for part in found.values()])
        assert size <= max(most, chunk ** len(lengths))
        assert all(part.start % chunk == 0 for part in found.values())
    assert (counted == 1).all()


def test_regimes_that_occur_are_counted_and_their_shares_add_up():
    ds = plane(4, 5)
    ds["regime"][:] = REGIMES.index("stick_slip")
    ds["regime"][0] = REGIMES.index("creep")
    found = coarse.summary(ds)
    assert {name: share.cells for name, share in found.items()} == {"stick_slip": 15, "creep": 5}
    assert sum(share.fraction for share in found.values()) == pytest.approx(1.0)
