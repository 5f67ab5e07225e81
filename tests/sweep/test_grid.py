import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.config.grid import build_grid
from stickslip.config.reader import make_config
from stickslip.dataset.build import map_dataset
from stickslip.vocabulary.models import STRIBECK
from stickslip.vocabulary.models.stribeck import coefficients
from stickslip.vocabulary.quantities import PARAMETERS_OF, VARIABLES

SYSTEM = {"mass": 1.0, "stiffness": 10.0, "normal_load": 5.0, "belt_speed": 0.1, "damping": 0.5}
CURVE = {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
MEASURED = {"mu_start": 0.4, "mu_reversal": 0.3, "v_reversal": 0.2, "a4": 0.05}


def grid_of(axes=None, curve=CURVE):
    """The grid of an ordinary oscillator with these axes."""
    axes = axes or {}
    varied = set(axes) | {name for spec in axes.values() if isinstance(spec, dict) for name in spec.get("zip", ())}
    system = {name: value for name, value in SYSTEM.items() if name not in varied}
    friction = {name: value for name, value in curve.items() if name not in varied}
    return build_grid(make_config({"system": system, "friction": friction, "axes": axes}))


def test_no_axes_are_one_cell():
    grid = grid_of()
    assert (grid.dims, grid.shape, grid.size, list(grid.coords)) == ((), (), 1, [])
    assert list(grid.fixed) == list(PARAMETERS_OF[STRIBECK])
    assert {name: len(values) for name, values in grid[0:1].items()} == dict.fromkeys(PARAMETERS_OF[STRIBECK], 1)


def test_the_last_dimension_runs_fastest():
    grid = grid_of({"mass": [1, 2], "belt_speed": [0.1, 0.2, 0.3]})
    assert (grid.dims, grid.shape, grid.size) == (("mass", "belt_speed"), (2, 3), 6)
    cells = grid[0:6]
    assert list(cells["mass"]) == [1, 1, 1, 2, 2, 2]
    assert list(cells["belt_speed"]) == [0.1, 0.2, 0.3] * 2
    assert list(cells["stiffness"]) == [10.0] * 6


def test_spacing_is_linear_or_logarithmic_and_ends_are_exact():
    axes = {
        "mass": {"start": 0.1, "stop": 0.7, "num": 4},
        "stiffness": {"start": 0.1, "stop": 100, "num": 4, "spacing": "log"},
    }
    mass, stiffness = grid_of(axes).coords
    assert mass.values == pytest.approx([0.1, 0.3, 0.5, 0.7]) and (mass.values[0], mass.values[-1]) == (0.1, 0.7)
    assert stiffness.values == pytest.approx([0.1, 1, 10, 100])
    assert (stiffness.values[0], stiffness.values[-1]) == (0.1, 100.0)
    assert (mass.spacing, stiffness.spacing) == ("linear", "log")


def test_coordinates_carry_units_and_names_of_their_quantities():
    (speed,) = grid_of({"belt_speed": [0.1, 0.2]}).coords
    assert (speed.name, speed.dim, speed.units, speed.long_name) == ("belt_speed", "belt_speed", "m s-1", "belt speed")
    assert (speed.spacing, speed.labels) == ("values", None)


def test_a_group_shares_a_dimension():
    grid = grid_of({"oil": {"zip": {"mass": [1, 2], "a1": [0.5, 0.6]}, "labels": ["thin", "thick"]}, "damping": [0, 1]})
    assert (grid.dims, grid.shape) == (("oil", "damping"), (2, 2))
    assert [(c.name, c.dim, c.labels) for c in grid.coords[:2]] == [
        ("mass", "oil", ("thin", "thick")), ("a1", "oil", ("thin", "thick"))
    ]  # fmt: skip
    cells = grid[0:4]
    assert (list(cells["mass"]), list(cells["a1"])) == ([1, 1, 2, 2], [0.5, 0.5, 0.6, 0.6])


def test_values_with_words_are_indexed_by_labels():
    """NaN cannot be an index, and CF forbids it in a coordinate variable."""
    grid = grid_of({"velocity": ["sticking", 0.0, 0.25]})
    (velocity,) = grid.coords
    assert (velocity.name, velocity.dim) == ("velocity", "velocity_case")
    assert velocity.labels == ("sticking", "0.0 m/s", "0.25 m/s")
    ds = map_dataset(grid, {"regime": np.ones(3)}, {})
    assert float(ds["velocity"].sel(velocity_case="0.25 m/s")) == 0.25


def test_no_coordinate_is_named_like_a_result():
    """A dataset cannot hold mu_reversal as given beside mu_reversal as it occurred."""
    grid = grid_of({"mu_reversal": [0.2, 0.3]}, MEASURED)
    assert [(c.name, c.dim) for c in grid.coords] == [("mu_reversal_of_curve", "mu_reversal_of_curve")]
    ds = map_dataset(grid, {"regime": np.ones(2), "mu_reversal": np.ones(2)}, {})
    assert list(ds["mu_reversal_of_curve"].values) == [0.2, 0.3]
    assert not {c.name for c in grid.coords} & set(VARIABLES)


# --- the measured form of the curve -----------------------------------------------------------------------------------


def curve(w, a1, a2, a3, a4):
    return a1 + a2 * w + a3 * np.exp(-w / a4)


@given(st.floats(0.01, 2.0), st.floats(0.01, 0.99), st.floats(1e-3, 1.0), st.floats(0.2, 30.0))
def test_the_curve_goes_through_what_was_measured(mu_start, share, a4, r):
    mu_reversal, v_reversal = mu_start * share, r * a4
    a1, a2, a3 = coefficients(mu_start, mu_reversal, v_reversal, a4)
    assert a1 + a3 == pytest.approx(mu_start, rel=1e-12)
    assert curve(v_reversal, a1, a2, a3, a4) == pytest.approx(mu_reversal, rel=1e-9, abs=1e-9 * a3)
    slope = a2 - a3 / a4 * np.exp(-r)
    assert slope == pytest.approx(0.0, abs=1e-9 * a3 / a4)


def test_a_measured_curve_that_does_not_vary_becomes_fixed_coefficients():
    grid = grid_of({"mass": [1, 2]}, MEASURED)
    assert {"a1", "a2", "a3", "a4"} < set(grid.fixed) <= set(PARAMETERS_OF[STRIBECK])
    assert grid.fixed["a1"] + grid.fixed["a3"] == pytest.approx(0.4)
    assert grid[0:2]["a1"] == pytest.approx([grid.fixed["a1"]] * 2)


@pytest.mark.parametrize("varied", ["mu_start", "mu_reversal", "v_reversal", "a4"])
def test_a_measured_curve_that_varies_is_converted_cell_by_cell(varied):
    values = [MEASURED[varied], MEASURED[varied] * 0.95]
    grid = grid_of({varied: sorted(values)}, MEASURED)
    assert not {"a1", "a2", "a3", varied} & set(grid.fixed)
    cells = grid[0:2]
    for i, value in enumerate(sorted(values)):
        expected = coefficients(**MEASURED | {varied: value})
        assert [cells[name][i] for name in ("a1", "a2", "a3")] == pytest.approx(list(map(float, expected)))


# --- ranges of cells --------------------------------------------------------------------------------------------------


@given(st.data())
def test_a_range_of_cells_is_that_part_of_the_whole(data):
    axes = {"mass": [1, 2, 3], "mu_stop": ["none", 0.5], "oil": {"zip": {"a4": [0.1, 0.2], "damping": [0, 3]}}}
    grid = grid_of(axes)
    start = data.draw(st.integers(0, grid.size))
    stop = data.draw(st.integers(start, grid.size))
    whole, part = grid[:], grid[start:stop]
    for name, values in part.items():
        assert np.array_equal(values, whole[name][start:stop], equal_nan=True)
        assert values.dtype == np.float64 and values.flags.c_contiguous and values.flags.writeable


def test_a_block_of_a_huge_grid_costs_a_block():
    """1e10 cells: an array of them would be 80 GB."""
    axes = {name: {"start": 0.5, "stop": 1, "num": 100_000} for name in ("mass", "belt_speed")}
    grid = grid_of(axes)
    assert grid.size == 10**10
    last = grid[grid.size - 2 : grid.size]
    assert (last["mass"][-1], last["belt_speed"][-1]) == (1.0, 1.0) and last["belt_speed"][0] < 1.0
