"""Refinement of labels that are known without any kernel: boxes, what the bound of the audit is worth, full maps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.stats import binomtest

from stickslip.studies.refine import COMPUTED, CONFIDENCE, Audit, Painter, Tiles, drawn, labels_of, refine
from stickslip.studies.search import Boxes
from stickslip.vocabulary.quantities import REGIMES


def density(share: float, depth: int, dims: int) -> float:
    return 2.0 * share / 2.0 ** (depth * dims)


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


@pytest.mark.parametrize(("shape", "depth"), [((2048, 1000), 5), ((100, 130, 110), 4), ((2_000_000,), 8)])
def test_the_cost_of_a_smooth_border_grows_with_its_size_and_not_with_the_map(shape, depth):
    x = plane(shape)
    truth = np.where(sum(np.sqrt(a / n) for a, n in zip(x, shape, strict=True)) > 0.6 * len(shape), 1, 2)
    found, computed, _ = refined(truth.astype(np.int8), depth)
    assert (found == truth).all()
    border = max(shape) ** (len(shape) - 1)
    first = 2 * truth.size / 2 ** (depth * len(shape))
    assert computed.sum() < 1.3 * first + 40 * border


def test_the_bound_is_that_of_clopper_and_pearson():
    for tried, wrong in ((10, 0), (59, 0), (8000, 3), (200, 150), (5, 5)):
        exact = binomtest(wrong, tried, alternative="less").proportion_ci(CONFIDENCE, "exact").high
        assert Audit(tried, wrong, 10**6).bound == pytest.approx(exact, rel=1e-9)
    assert Audit(59, 0, 10**6).bound == pytest.approx(1 - 0.05 ** (1 / 59))
    assert (Audit(0, 0, 100).bound, Audit(0, 0, 0).bound) == (1.0, 0.0), "nothing known, nothing inferred"


def specks(count: int, seed: int, n: int = 257) -> np.ndarray:
    """A map whose few odd cells no box knows of, unless by chance."""
    truth = np.ones((n, n), np.int8)
    truth.ravel()[np.random.default_rng(seed).choice(n * n, count, replace=False)] = 2
    return truth


def audited(truth: np.ndarray, depth: int, share: float) -> tuple[Audit, float, float]:
    """The audit, the share of wrong cells among inferred ones when it was made, and that of the map after mending."""
    tile, flat = Tiles(truth.shape, (0, 1), depth).tile(0), truth.ravel()
    before, after = Boxes(tile.shape, depth), Boxes(tile.shape, depth)
    done = refine([tile], depth, density(0.0, depth, 2), lambda cells: flat[cells])
    before.learn(done.places, flat[done.places])
    done = refine([tile], depth, density(share, depth, 2), lambda cells: flat[cells])
    after.learn(done.places, flat[done.places])
    inferred = ~before.known.ravel()
    wrong = (before.inferred().ravel() != flat)[inferred].mean()
    return done.audits[0], wrong, (after.inferred().ravel() != flat).mean()


@pytest.mark.slow
def test_the_bound_holds_in_all_but_one_of_twenty_maps():
    """Conservative, as Clopper and Pearson are: at 95 %, 400 maps, at most 5 % + 3 standard errors below the truth."""
    found = [audited(specks(count, seed), 4, 2.0) for count in (10, 40, 160, 600) for seed in range(100)]
    assert sum(audit.tried for audit, _, _ in found) > 150_000
    missed = np.mean([audit.bound < wrong for audit, wrong, _ in found])
    assert missed <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / len(found))


def test_what_the_audit_finds_wrong_is_mended_with_its_surroundings():
    truth = np.ones((257, 257), np.int8)
    truth[1:8, 97:112] = 2  # inside boxes of 17 points, beside their centres
    truth[193:200, 49:64] = 2
    audit, before, after = audited(truth, 4, 20.0)
    assert audit.wrong > 0 and before > 0
    assert after == 0


def test_points_fall_on_every_cell_alike_and_only_on_cells_of_the_tile():
    tiles = Tiles((2000, 1500), (0, 1), 5)
    counts = []
    for number in range(tiles.count):
        tile = tiles.tile(number)
        places = drawn(tile, 0.02)
        assert (tiles.owners(tile.cells(places)) == number).all()
        assert places.size == pytest.approx(0.02 * tile.size, abs=5 * np.sqrt(0.02 * tile.size))
        counts.append(places.size)
        rows = np.unravel_index(places, tile.shape)[0] - tile.own[0].start
        halves = rows < (tile.own[0].stop - tile.own[0].start) / 2
        assert halves.mean() == pytest.approx(0.5, abs=0.03)
    assert len(set(counts)) == tiles.count  # each tile draws its own


STICK_SLIP, DAMPED, UNRESOLVED = (REGIMES.index(name) for name in ("stick_slip", "damped", "unresolved"))


def field(cells: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """A quantity that is linear in the indices of each refined dimension."""
    points = np.unravel_index(cells, shape)
    return sum((3.0 + i) * at for i, at in enumerate(points)) + 0.5


def painted(truth: np.ndarray, depth: int, dims: tuple[int, ...] | None = None, missing=()):
    """A painter of the map of these regimes; `sustained` cells have no period."""
    tiles, flat = Tiles(truth.shape, dims or tuple(range(truth.ndim)), depth), truth.ravel()

    def computed(number: int):
        if number in missing:
            return np.zeros(0, np.int64), {}
        tile = tiles.tile(number)
        found = refine([tile], depth, 0.001, lambda cells: labels_of(flat[cells]))
        cells = tile.cells(found.places)
        values = field(cells, truth.shape)
        results = {
            "regime": flat[cells], "steps": np.full(cells.size, 7, np.int32), "spring_force_max": values,
            "period": np.where(flat[cells] == STICK_SLIP, values, np.nan), "equilibrium_crossings": values,
        }  # fmt: skip
        return found.places, results

    def blank(count: int):
        floats = {name: np.full(count, np.nan) for name in ("spring_force_max", "period", "equilibrium_crossings")}
        flags = {"regime": np.zeros(count, np.int8), "computed": np.zeros(count, np.int8)}
        return {**flags, "steps": np.zeros(count, np.int32), **floats}

    return Painter(tiles, computed, blank)


def disc(shape: tuple[int, int]) -> np.ndarray:
    x, y = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
    truth = np.where(np.hypot(x - 50, y - 70) < 40, STICK_SLIP, DAMPED).astype(np.int8)
    truth[100:104, 90:95] = UNRESOLVED
    return truth


def test_metrics_of_inferred_cells_are_nan_and_those_of_computed_ones_their_own():
    truth = disc((120, 161))
    found = painted(truth, 3).cells(range(truth.size))
    computed = found["computed"] == COMPUTED
    assert 0.05 < computed.mean() < 0.4
    assert (found["regime"] == truth.ravel()).all()
    assert np.isnan(found["spring_force_max"][~computed]).all()
    assert (found["spring_force_max"] == field(np.arange(truth.size), truth.shape))[computed].all()
    assert (found["steps"] == np.where(computed, 7, 0)).all()


def test_a_map_is_the_same_however_it_is_cut_into_ranges():
    truth = np.repeat(disc((1100, 1060))[:, None, ::8], 2, axis=1)
    painter = painted(truth, 3, dims=(0, 2))
    whole = painter.cells(range(truth.size))
    parts = [painter.cells(range(a, min(a + 7777, truth.size))) for a in range(0, truth.size, 7777)]
    for name, values in whole.items():
        np.testing.assert_array_equal(np.concatenate([part[name] for part in parts]), values)


def test_tiles_of_which_nothing_is_known_are_not_computed():
    truth = disc((2049, 100))
    found = painted(truth, 3, missing=(1,)).cells(range(truth.size))
    regime = found["regime"].reshape(truth.shape)
    assert (regime[:1024] == truth[:1024]).all()
    assert (regime[1024:] == 0).all()
    assert (found["computed"].reshape(truth.shape)[1024:] != COMPUTED).all()
