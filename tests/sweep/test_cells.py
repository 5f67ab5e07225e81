import numpy as np
import pytest
import xarray as xr

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


WRONG = {
    "missing": ({"mass": None}, ValueError, r"^mass is missing \(mass, kg\)"),
    "unknown": ({"belt_sped": 1.0}, TypeError, "'belt_sped' is not a parameter of a cell, .*; did you mean belt_speed"),
    "no number": ({"mass": [1.0, None]}, TypeError, r"mass: got \[1.0, None\], expected a number or .* '250 g'"),
    "another unit": ({"mass": "1 N"}, ValueError, r"^mass: got '1 N' \(force\), expected a mass such as '250 g'"),
    "a unit in a list": ({"stiffness": ["5 N/mm", "1,5 N/m"]}, ValueError, r"^stiffness\[1\]: got '1,5 N/m'.*decimal"),
    "a negative text": ({"mass": ["1 kg", "-2 g"]}, ValueError, r"^mass\[1\]: got '-2 g', expected a mass above 0 kg"),
    "text without unit": ({"a1": "1.2"}, ValueError, "^a1: got '1.2', expected a number .*remove the quotes"),
    "negative": ({"mass": -1.0}, ValueError, r"mass: got -1, expected a mass above 0 kg"),
    "second is zero": ({"stiffness": [1.0, 0.0]}, ValueError, r"stiffness\[1\]: got 0, .* above 0 N/m"),
    "not a number": ({"belt_speed": np.nan}, ValueError, r"belt_speed: got nan, expected a finite number in m/s"),
    "infinite": ({"velocity": np.inf}, ValueError, "velocity: got inf"),
    "static below start": ({"mu_static": 1.2}, ValueError, r"mu_static\[0\]: got 1\.2, .* mu_start = .* 1\.3"),
    "stop above start": ({"mu_stop": 1.4}, ValueError, r"mu_stop\[0\]: got 1\.4, expected at most mu_start .* 1\.3"),
    "start below zero": ({"a3": [0.1, -1.2]}, ValueError, r"a3\[1\]: got -1\.2, expected at least -a1 = -1: the curve"),
    "lengths": ({"mass": [1.0, 2.0], "a1": [1.0] * 3}, ValueError, r"do not fit together.* mass \(2,\), .*a1 \(3,\)"),
}  # fmt: skip


@pytest.mark.parametrize(("change", "kind", "message"), WRONG.values(), ids=WRONG)
def test_a_wrong_cell_is_refused_by_name(change, kind, message):
    given = {name: value for name, value in (PAIR | change).items() if value is not None}
    with pytest.raises(kind, match=message):
        as_cells(given)
