"""How far cells are from a border, against closed forms and SciPy's own minimisation over them."""

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import minimize

import stickslip
from stickslip import theory
from stickslip.config.reader import parse_config
from stickslip.engine import stop_flag
from stickslip.studies.changes import MarginSearch, checked, reach_of
from stickslip.vocabulary.cells import as_cells
from stickslip.vocabulary.quantities import REGIMES

COULOMB = {"mass": 2.0, "stiffness": 50.0, "damping": 3.0, "normal_load": 3.0, "belt_speed": 0.01,
           "a1": 0.3, "a2": 0.0, "a3": 0.0, "a4": 1.0, "mu_static": 0.45}  # fmt: skip
PAIR = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": 0.7,
        "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}  # fmt: skip
STICK_SLIP, DAMPED, CREEP = (REGIMES.index(name) for name in ("stick_slip", "damped", "creep"))
DESIGN = ("belt_speed", "normal_load", "stiffness", "damping")


def critical_speed(cell):
    """The belt speed at which stick-slip of this Coulomb pair ends."""
    return float(theory.critical_speed(
        *(cell[name] for name in ("mass", "stiffness", "damping", "normal_load")), cell["mu_static"], cell["a1"]
    ))  # fmt: skip


def test_margins_along_single_parameters_end_at_the_critical_speed():
    ds = stickslip.margins(COULOMB, joint=False)
    one = ds.isel(cell=0)
    at = {
        str(name).removeprefix("margin_"): float(one[name]) for name in one.data_vars if str(name).startswith("margin_")
    }
    assert set(at) == {*DESIGN, "mass", "mu_static"}
    speed = critical_speed(COULOMB)
    assert at["belt_speed"] == pytest.approx(speed - 0.01, rel=1e-9)
    assert float(one["ratio_belt_speed"]) == pytest.approx(speed / 0.01, rel=1e-9)
    assert at["normal_load"] == pytest.approx(3.0 * 0.01 / speed - 3.0, rel=1e-9)
    assert at["mu_static"] == pytest.approx(0.15 * 0.01 / speed - 0.15, rel=1e-8)
    for name in ("damping", "stiffness", "mass"):
        there = COULOMB | {name: COULOMB[name] + at[name]}
        if not np.isnan(at[name]):
            assert critical_speed(there) == pytest.approx(0.01, rel=1e-7)
    assert at["damping"] > 0 and np.isnan(at["mass"])


def test_the_cheapest_change_of_four_parameters_is_that_of_a_minimisation_over_the_closed_form():
    """Also from damping 0.5 and a cost that makes stiffening twice as dear."""
    cell, costs = COULOMB | {"damping": 0.5, "belt_speed": 0.03}, np.array([1.0, 1.0, 2.0, 1.0])

    def changed(q):
        return cell | {name: cell[name] * np.exp(x) for name, x in zip(DESIGN, q / costs, strict=True)}

    def surplus(q):
        one = changed(q)
        return np.log(one["belt_speed"] / critical_speed(one))

    starts = [np.array([1.0, 0.1, 0.1, 0.1]), np.array([0.1, 0.1, 0.1, 1.0]), np.array([0.3, -0.3, 0.3, 0.3])]
    bounds = [(-2.3 * cost, 2.3 * cost) for cost in costs]
    best = min(
        (minimize(lambda q: q @ q, start, bounds=bounds, constraints={"type": "eq", "fun": surplus},
                  method="SLSQP", options={"ftol": 1e-14, "maxiter": 300}) for start in starts),
        key=lambda found: found.fun if found.success and abs(surplus(found.x)) < 1e-7 else np.inf,
    )  # fmt: skip
    ds = stickslip.margins(cell, DESIGN, {"stiffness": 2.0}).isel(cell=0)
    assert float(ds["joint_cost"]) == pytest.approx(np.sqrt(best.fun), rel=1e-6)
    for name in DESIGN:
        assert float(ds[f"joint_{name}"]) == pytest.approx(changed(best.x)[name], rel=1e-3)
    assert int(ds["joint_checked"]) == DAMPED


def test_both_sides_are_told_where_the_regime_changes_on_both():
    """Between the borders to stick-slip (below) and to creep or another regime along damping."""
    ds = stickslip.margins(PAIR | {"damping": 0.1}, ("damping",), within=30, joint=False).isel(cell=0)
    below, above = ds["border_damping"].values
    assert below < 0.1 < above
    assert ds["beyond_damping"].values.tolist() == [STICK_SLIP, CREEP]
    assert float(ds["margin_damping"]) == pytest.approx(below - 0.1 if 0.1 / below < above / 0.1 else above - 0.1)
    only = stickslip.margins(PAIR | {"damping": 0.1}, ("damping",), within=30, into=("stick_slip",), joint=False).isel(
        cell=0
    )
    assert np.isnan(only["border_damping"].values[1]) and only["beyond_damping"].values.tolist() == [STICK_SLIP, 0]


def test_proposals_are_simulated_a_little_past_the_border():
    cells = PAIR | {"belt_speed": [0.5, 0.7, 0.9], "mu_stop": 1.0}
    ds = stickslip.margins(cells, ("belt_speed", "mu_stop", "damping"))
    for name in ("belt_speed", "mu_stop", "damping"):
        for side in ("below", "above"):
            values, found = ds[f"proposed_{name}"].sel(side=side), ds[f"checked_{name}"].sel(side=side).values
            for i in np.flatnonzero(values.notnull().values):
                one = {key: float(ds[key][i]) for key in ("belt_speed", "mu_stop", "damping")}
                there = stickslip.evaluate(PAIR | one | {name: float(values[i])})
                assert there["regime"].item() == found[i]
            border = ds[f"border_{name}"].sel(side=side)
            np.testing.assert_allclose(np.abs(values / border - 1), np.where(border.notnull(), 0.01, np.nan), rtol=0.02)
    joint = {name: ds[f"joint_proposed_{name}"].values for name in ("belt_speed", "mu_stop", "damping")}
    np.testing.assert_array_equal(stickslip.evaluate(PAIR | joint)["regime"], ds["joint_checked"])


def test_no_proposal_is_a_cell_that_is_impossible():
    """mu_stop is at most friction at break-away, a1 + 0.3: 1 % further in both it would be more."""
    cell = as_cells(PAIR | {"mu_stop": 1.2})
    search = MarginSearch(cell, stickslip.Options(), stop_flag())
    reaches = [reach_of(name, cell, 10.0) for name in ("mu_stop", "a1")]
    regimes, values = checked(search, reaches, np.log([[1.249 / 1.2, 0.95]]), 0.01)
    np.testing.assert_allclose(values, [[1.249, 0.95]])
    assert REGIMES[regimes[0]] != "not_computed"


def test_margins_of_a_cell_do_not_depend_on_the_others():
    cells = PAIR | {"belt_speed": [0.5, 0.7, 0.9], "mu_stop": 1.0}
    together = stickslip.margins(cells, ("belt_speed", "mu_stop", "damping"))
    for i in range(3):
        one = PAIR | {"belt_speed": cells["belt_speed"][i], "mu_stop": 1.0}
        alone = stickslip.margins(one, ("belt_speed", "mu_stop", "damping"))
        xr.testing.assert_equal(alone.isel(cell=0), together.isel(cell=i))


def test_no_border_within_reach_is_no_error_and_is_said():
    ds = stickslip.margins(PAIR | {"belt_speed": 0.3}, ("stiffness", "mass"), within=1.5)
    assert np.isnan(ds["margin_stiffness"]).all() and np.isnan(ds["joint_cost"]).all()
    assert (ds["joint_checked"] == 0).all()


def test_static_friction_goes_down_to_friction_at_breakaway_and_no_further():
    ds = stickslip.margins(COULOMB | {"mu_stop": 0.2}, ("mu_static", "mu_stop", "a1"), joint=False).isel(cell=0)
    assert ds["border_mu_static"].sel(side="below") > 0.3
    proposed = ds["proposed_mu_static"].sel(side="below")
    assert proposed >= 0.3


SECTION = """
system: {mass: 1, normal_load: 1, belt_speed: 0.7}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes: {stiffness: [0.5, 1, 2]}
margins: {parameters: [belt_speed, damping], within: {belt_speed: [0.1, 2 m/s], damping: 5}, tolerance: 1e-6}
"""


def test_a_section_asks_for_what_the_call_computes(tmp_path):
    (tmp_path / "margins.yaml").write_text(SECTION)
    ds = stickslip.run(tmp_path / "margins.yaml", tmp_path / "margins.nc")
    plain = parse_config(SECTION[: SECTION.index("margins")])
    called = stickslip.margins(
        plain, ("belt_speed", "damping"), within={"belt_speed": (0.1, 2.0), "damping": 5.0}, tolerance=1e-6, joint=False
    )
    xr.testing.assert_equal(ds.load(), called)
    assert np.isfinite(ds["margin_belt_speed"]).all()
