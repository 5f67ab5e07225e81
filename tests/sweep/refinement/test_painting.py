"""Full maps from what was computed of tiles, without any kernel."""

from __future__ import annotations

import numpy as np

from stickslip.studies.boxes import Tiles, refine
from stickslip.studies.refine import COMPUTED, Painter, labels_of
from stickslip.vocabulary.flags import REGIMES

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
