import numpy as np
import pytest
import xarray as xr

from helpers.data import cases
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.models import STRIBECK
from stickslip.vocabulary.quantities import PARAMETERS_OF

PAIR = {"mass": 1.0, "stiffness": 10.0, "normal_load": 1.0, "belt_speed": 0.1}
PAIR |= {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}


def test_defaults_complete_a_cell():
    cells = as_cells(PAIR)
    assert list(cells) == list(PARAMETERS_OF[STRIBECK])
    assert all(values.shape == (1,) and values.dtype == np.float64 for values in cells.values())
    assert cells["damping"] == 0.0 and cells["displacement"] == 0.0
    assert all(np.isnan(cells[name]) for name in ("mu_stop", "mu_static", "velocity"))


def test_arrays_broadcast_and_are_flattened_with_the_last_dimension_fastest():
    cells = as_cells(PAIR | {"stiffness": np.array([[1.0], [2.0]]), "belt_speed": [0.1, 0.2, 0.3]})
    np.testing.assert_array_equal(cells["stiffness"], [1, 1, 1, 2, 2, 2])
    np.testing.assert_array_equal(cells["belt_speed"], [0.1, 0.2, 0.3] * 2)
    np.testing.assert_array_equal(cells["mass"], np.ones(6))


def test_a_dataset_gives_its_variables_and_its_coordinates():
    ds = xr.Dataset({"a1": ("belt_speed", [1.0, 1.1])}, {"belt_speed": [0.1, 0.2], "stiffness": [5.0, 6.0, 7.0]})
    ds = ds.assign({name: PAIR[name] for name in ("mass", "normal_load", "a2", "a3", "a4")}).assign_coords(note="x")
    cells = as_cells(ds)
    assert cells["mass"].size == 6
    assert set(zip(cells["belt_speed"], cells["a1"], strict=True)) == {(0.1, 1.0), (0.2, 1.1)}


@cases("sweep.yaml")
def test_a_wrong_cell_is_refused_by_name(change, kind, message):
    given = {name: value for name, value in (PAIR | change).items() if value is not None}
    with pytest.raises({"TypeError": TypeError, "ValueError": ValueError}[kind], match=message):
        as_cells(given)
