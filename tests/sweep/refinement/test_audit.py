"""The audit of refined maps: what its bound is worth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest

from stickslip.studies.boxes import CONFIDENCE, Audit, Boxes, Tiles, density, drawn, refine


def test_the_bound_is_that_of_clopper_and_pearson():
    for tried, wrong in ((10, 0), (59, 0), (8000, 3), (200, 150), (5, 5)):
        exact = binomtest(wrong, tried, alternative="less").proportion_ci(CONFIDENCE, "exact").high
        assert Audit(tried, wrong, 10**6).bound == pytest.approx(exact, rel=1e-9)
    assert Audit(59, 0, 10**6).bound == pytest.approx(1 - 0.05 ** (1 / 59))


def test_without_points_nothing_is_known_and_without_inferred_cells_nothing_is_wrong():
    assert Audit(0, 0, 100).bound == 1.0
    assert Audit(0, 0, 0).bound == 0.0


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
