"""Refinement of labels that are known without any kernel."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from stickslip.studies.boxes import Audit, Boxes, Tiles, density, refine


def refined(truth: np.ndarray, depth: int, share: float = 0.0, dims: tuple[int, ...] | None = None):
    """The full map that refinement makes of these labels, which cells it computed, and its audit."""
    dims = tuple(range(truth.ndim)) if dims is None else dims
    tiles, flat = Tiles(truth.shape, dims, depth), truth.ravel()
    whole, computed, audits = np.full(flat.size, 99, np.int8), np.zeros(flat.size, bool), []
    for number in range(tiles.count):
        tile = tiles.tile(number)
        done = refine([tile], depth, density(share, depth, len(dims)), lambda cells: flat[cells])
        audits += done.audits
        assert np.unique(done.places).size == done.places.size
        boxes = Boxes(tile.shape, depth)
        boxes.learn(done.places, flat[tile.cells(done.places)])
        assert boxes.wanted().size == 0
        own = np.flatnonzero(tiles.owners(tile.cells(np.arange(boxes.known.size))) == number)
        cells = tile.cells(own)
        assert (whole[cells] == 99).all()  # tiles do not overlap
        assert (tiles.owners(cells) == number).all()
        assert (tile.places(cells) == own).all()
        whole[cells], computed[cells] = boxes.inferred().ravel()[own], boxes.known.ravel()[own]
    assert (whole != 99).all()  # and leave nothing out
    return whole.reshape(truth.shape), computed.reshape(truth.shape), Audit(*map(sum, zip(*audits, strict=True)))


def plane(shape: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    return np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")


SHAPES = [(2,), (33,), (100,), (1025,), (2, 2), (33, 33), (40, 67), (100, 130), (17, 20, 23), (9, 34, 12)]


@pytest.mark.parametrize("shape", SHAPES)
def test_a_depth_of_zero_computes_everything(shape):
    truth = np.random.default_rng(1).integers(1, 6, shape).astype(np.int8)
    found, computed, audit = refined(truth, 0, share=1.0)
    assert computed.all()
    assert (found == truth).all()
    assert (audit.tried, audit.inferred, audit.bound) == (0, 0, 0.0)


@given(
    hnp.array_shapes(min_dims=1, max_dims=3, min_side=2, max_side=24).flatmap(
        lambda shape: hnp.arrays(np.int8, shape, elements=st.sampled_from([-7, 1, 2, 3]), fill=st.just(np.int8(1)))
    ),
    st.integers(0, 4),
    st.sampled_from([0.0, 1.0]),
)
@settings(max_examples=150, deadline=None)
def test_whatever_the_labels_are_computed_cells_have_their_own_and_no_inferred_one_is_undecided(truth, depth, share):
    found, computed, _ = refined(truth, depth, share)
    assert (found == truth)[computed].all()
    assert (found[~computed] > 0).all()


@given(st.sampled_from(SHAPES), st.integers(1, 5), st.data())
@settings(max_examples=80, deadline=None)
def test_half_planes_are_exact(shape, depth, data):
    normal = [data.draw(st.floats(-1, 1)) for _ in shape]
    through = [data.draw(st.floats(0, n)) for n in shape]
    side = sum(a * (x - x0) for a, x, x0 in zip(normal, plane(shape), through, strict=True))
    truth = np.where(side > 0, 1, 2).astype(np.int8)
    assert (refined(truth, depth)[0] == truth).all()


@given(st.floats(40, 150), st.floats(-20, 220), st.floats(-20, 180), st.integers(1, 4))
@settings(max_examples=40, deadline=None)
def test_circles_wider_than_a_few_boxes_are_exact(radius, x0, y0, depth):
    x, y = plane((200, 161))
    truth = np.where(np.hypot(x - x0, y - y0) < radius, 1, 2).astype(np.int8)
    inside = (0 <= x0 < 200) and (0 <= y0 < 161)
    found, _, _ = refined(truth, depth)
    # The cap that a large circle just dips into the map is no wider than a box, and may be seen by none.
    assert (found == truth).all() if inside else (found != truth).sum() <= 4**depth


def test_a_border_is_followed_into_the_next_tile():
    """A bulge through the edge of a tile that no corner and no centre of the neighbour sees."""
    truth = np.ones((1025, 2049), np.int8)
    x, y = plane(truth.shape)
    truth[np.hypot(x - 496, y - 1012) < 14] = 2  # to column 1025 between rows 480 and 512; the tile ends at 1024
    assert (truth[:, 1024:][::32, ::32] == 1).all() and (truth[:, 1024:][16::32, 16::32] == 1).all()
    found, _, _ = refined(truth, 5)
    assert (found == truth).all()


def test_lists_are_looped_over_and_only_ranges_have_boxes():
    truth = np.ones((3, 70, 2, 80), np.int8)
    x, y = plane((70, 80))
    for i, j in product(range(3), range(2)):
        truth[i, :, j, :] = np.where(x > 10 + 20 * i + 7 * j + y / 9, i + 1, 5)
    found, computed, _ = refined(truth, 4, dims=(1, 3))
    assert (found == truth).all()
    assert computed.mean() < 0.4


@pytest.mark.parametrize(("shape", "depth"), [((2048, 1000), 5), ((100, 130, 110), 4), ((2_000_000,), 8)])
def test_the_cost_of_a_smooth_border_grows_with_its_size_and_not_with_the_map(shape, depth):
    x = plane(shape)
    truth = np.where(sum(np.sqrt(a / n) for a, n in zip(x, shape, strict=True)) > 0.6 * len(shape), 1, 2)
    found, computed, _ = refined(truth.astype(np.int8), depth)
    assert (found == truth).all()
    border = max(shape) ** (len(shape) - 1)
    first = 2 * truth.size / 2 ** (depth * len(shape))
    assert computed.sum() < 1.3 * first + 40 * border
