"""Results of laws that this process does not know, and what else is given as a law and is none."""

import numpy as np
import pytest

import stickslip
from stickslip.config.reader import make_config

SYSTEM, CURVE = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}, {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
CELL = SYSTEM | CURVE | {"belt_speed": 0.1}
AGAIN = "registered in another process, call register_law here"


@pytest.fixture(params=["run", "evaluate"])
def foreign(request, tmp_path):
    """A result as another process leaves it that registered its law: the name is all that this one sees of it."""
    if request.param == "run":
        ds = stickslip.run({"system": SYSTEM, "friction": CURVE, "axes": {"belt_speed": [0.1, 0.2]}}).load()
    else:
        ds = stickslip.evaluate(CELL | {"belt_speed": [0.1, 0.2]})
    ds.attrs["configuration"] = ds.attrs["configuration"].replace("stribeck", "elsewhere")
    assert "elsewhere" in ds.attrs["configuration"]
    ds.to_netcdf(tmp_path / "map.nc")
    return ds


def test_what_needs_the_law_names_register_law(foreign):
    at = {"cell": 0} if "cell" in foreign.dims else {"belt_speed": 0.1}
    assert foreign.stickslip.cell(**at)["belt_speed"] == 0.1
    calls = [lambda: foreign.stickslip.simulate(**at)]
    for call in calls if "cell" in foreign.dims else [*calls, lambda: foreign.stickslip.configuration]:
        with pytest.raises(ValueError, match=AGAIN):
            call()


@pytest.mark.parametrize("law, remedy", [
    (lambda z, delta: 1.0 / (1.0 + z), "register_law"), ([[0.0, 1.0], [0.3, 0.2]], "Table"),
    ((np.array([0.0, 1.0]), np.array([0.3, 0.2])), "Table"), ({"speed": [0, 1], "mu": [0.3, 0.2]}, "Table"),
    ("elsewhere", "register_law"),
])  # fmt: skip
def test_what_is_given_as_a_law_is_told_how_it_becomes_one(law, remedy):
    along = {"along": "belt_speed", "between": (0.1, 1.0)}
    calls = [
        lambda: stickslip.evaluate(CELL, law=law),
        lambda: stickslip.simulate(CELL, duration=1.0, law=law),
        lambda: stickslip.border(SYSTEM | CURVE, **along, law=law),
        lambda: make_config({"system": SYSTEM | {"belt_speed": 0.1}, "friction": CURVE | {"law": law}}),
    ]
    for call in calls:
        with pytest.raises(ValueError, match=rf"\b{remedy}\(" if remedy == "Table" else remedy):
            call()


def test_a_cell_comes_first_in_simulate_as_in_other_calls():
    by_name = stickslip.simulate(duration=10.0, **CELL)
    cells = stickslip.evaluate(CELL | {"belt_speed": [0.1, 0.2]})
    for motion in (
        stickslip.simulate(CELL, duration=10.0), stickslip.simulate(cells.isel(cell=0), duration=10.0),
        stickslip.simulate(CELL | {"belt_speed": 9.0}, duration=10.0, belt_speed=0.1),
    ):  # fmt: skip
        for name in by_name.variables:
            np.testing.assert_array_equal(motion[name], by_name[name])
    with pytest.raises(ValueError, match="one trajectory"):
        stickslip.simulate(cells, duration=10.0)
