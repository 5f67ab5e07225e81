"""Contacts with memory, through the front door: calls, configurations, trajectories."""

import numpy as np
import pytest

import stickslip
from helpers.data import cases
from helpers.nightly import few
from stickslip.api.cells import time_span
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError

PAIR = {"mass": 1.0, "stiffness": 2e4, "normal_load": 10.0}
PAIR |= {"mu_0": 0.6, "v_0": 1e-6, "a": 0.01, "b": 0.018, "D_c": 1e-6}
LAWS = ("rate_state_ageing", "rate_state_slip")
CONFIG = """
system: {mass: 1 kg, normal_load: 10 N}
friction: {law: rate_state_ageing, mu_0: 0.6, v_0: 1 um/s, a: 0.010, b: 0.018, D_c: 1 um}
axes:
  stiffness: [20 N/mm, 100 N/mm]
  belt_speed: [1 um/s, 10 mm/s]
"""
BRISTLES = {
    "mass": 0.1, "stiffness": 5000.0, "damping": 1.0, "normal_load": 10.0, "a1": 0.25, "a2": 0.0, "a3": 0.2, "a4": 0.02,
    "contact_stiffness": 1e6, "contact_damping": 100.0,
}  # fmt: skip


def test_a_configuration_is_a_map_with_linear_theory_beside_it():
    ds = stickslip.run(parse_config(CONFIG))
    assert ds["regime"].values.tolist() == [[1, 1], [2, 1]]
    np.testing.assert_allclose(ds["critical_stiffness"].sel(belt_speed=1e-6), 80000.8)
    np.testing.assert_allclose(ds["critical_stiffness"].sel(belt_speed=1e-2), 80079999.99999999)
    cycle = ds.isel(stiffness=0, belt_speed=1)
    np.testing.assert_allclose(cycle["slip_per_cycle"], cycle["period"] * 1e-2)
    np.testing.assert_allclose(cycle["stress_drop"], (cycle["cycle_force_max"] - cycle["cycle_force_min"]) / 10.0)
    assert (np.sign(ds["growth_rate"]).values == [[1, 1], [-1, 1]]).all()
    again = stickslip.evaluate(PAIR | {"belt_speed": 1e-2}, law=LAWS[0])
    for name in ("period", "slip_speed_min", "growth_rate", "growth_frequency", "energy_per_cycle"):
        np.testing.assert_array_equal(again[name][0], cycle[name])


STEPPED = {
    "mass": 1e-6, "stiffness": 1e8, "normal_load": 10.0, "mu_0": 0.6, "v_0": 1e-6, "a": 0.010, "b": 0.015, "D_c": 2e-6,
}  # fmt: skip


@pytest.mark.parametrize("law", few(LAWS, 1))
def test_after_a_hold_the_peak_of_friction_has_grown_with_its_logarithm(law):
    """By b per e-fold; between the limits of a stiff spring and of one that gives way it is less by a constant."""
    held = np.geomspace(1e3, 1e9, 7)
    cells = STEPPED | {"belt_speed": 1e-5, "displacement": 5e-8, "contact_time": held}
    peaks = stickslip.evaluate(cells, law=law, rtol=1e-8)["spring_force_max"].values / STEPPED["normal_load"]
    slope = np.diff(peaks) / np.diff(np.log(held))
    np.testing.assert_allclose(slope, STEPPED["b"], rtol=1e-2 if law == LAWS[1] else 1e-4)


def test_attractors_of_it_are_sampled():
    cells = PAIR | {"belt_speed": 1e-4, "stiffness": [2e4, 1e5]}
    steady = (0.6 - 0.008 * np.log(100.0)) * 10.0 / 1e5
    found = stickslip.attractors(
        cells, {"displacement": (0.5 * steady, 1.5 * steady), "velocity": (-1e-4, 9e-5)}, law=LAWS[0], samples=64
    )
    np.testing.assert_array_equal(found["settling_share"], [0.0, 1.0])
    assert found["regime_from_stick"].values.tolist() == [1, 2]
    assert found["regime_from_sliding"].values.tolist() == [1, 2]


@cases("sweep.yaml")
def test_a_parameter_of_another_law_names_that_law(changes, law, message):
    with pytest.raises(TypeError, match=message):
        stickslip.evaluate(PAIR | {"belt_speed": 1e-2} | changes, law=law)


# --- bristles ---------------------------------------------------------------------------------------------------------


def bristle_config(friction="", axes="contact_stiffness: [10 N/mm, 1 N/um]"):
    return f"""
system: {{mass: 100 g, damping: 1 N s/m, normal_load: 10 N, stiffness: 5 N/mm}}
friction: {{a1: 0.25, a2: 0, a3: 0.2, a4: 20 mm/s, contact_damping: 100 N s/m{friction}}}
axes:
  belt_speed: [20 mm/s, 1 m/s]
  {axes}
"""


def test_the_stiffness_of_the_contact_chooses_its_model():
    """The second belt is quiet; the first is the reference cell L9."""
    ds = stickslip.run(parse_config(bristle_config()))
    assert ds["regime"].sel(contact_stiffness=1e6).values.tolist() == [1, 2]
    cycle = ds.sel(contact_stiffness=1e6, belt_speed=0.02)
    assert float(cycle["period"]) == pytest.approx(0.054840572932607135, rel=1e-6)
    assert float(cycle["presliding_displacement"]) == pytest.approx(4.5e-6)
    assert float(cycle["growth_rate"]) == pytest.approx(175.09265744758096) and np.isinf(cycle["critical_stiffness"])
    assert (np.sign(ds["damping_ratio"]) == -np.sign(ds["growth_rate"])).all()
    again = stickslip.evaluate(BRISTLES | {"belt_speed": 0.02})
    for name in ("period", "slip_speed_min", "growth_frequency", "energy_per_cycle", "steps"):
        np.testing.assert_array_equal(again[name][0], cycle[name])


def test_a_contact_that_is_not_given_or_none_is_rigid():
    given = bristle_config().replace(", contact_damping: 100 N s/m", ", contact_stiffness: none")
    rigid = parse_config(
        given.replace("contact_stiffness: [10 N/mm, 1 N/um]", "a3: [0.1, 0.2]").replace("a3: 0.2, ", "")
    )
    assert rigid.friction.law == "stribeck"
    assert "presliding_displacement" not in stickslip.run(rigid)


def test_a_curve_as_it_is_measured_may_have_bristles():
    measured = bristle_config().replace(
        "a1: 0.25, a2: 0, a3: 0.2", "mu_start: 0.45, mu_reversal: 0.3, v_reversal: 80 mm/s"
    )
    config = parse_config(measured)
    assert config.friction.law == "lugre_stribeck"
    assert (stickslip.run(config)["presliding_displacement"].sel(contact_stiffness=1e6) == 4.5e-6).all()


def test_attractors_serve_bristles():
    both = stickslip.attractors(
        BRISTLES | {"belt_speed": [0.02, 1.0]}, {"displacement": (0.0, 1e-3), "velocity": (-0.1, 0.015)}, samples=64
    )
    np.testing.assert_array_equal(both["settling_share"], [0.0, 1.0])


@cases("sweep.yaml")
def test_what_such_contacts_cannot_be_is_said(text, message):
    with pytest.raises(ConfigError) as error:
        parse_config(text)
    assert message in str(error.value)


def test_stick_slip_that_never_repeats_is_told():
    """Soft bristles without damping of their own ring from one slip to the next."""
    soft = {"a3": 0.05, "stiffness": 500.0, "contact_stiffness": 2e4, "contact_damping": 0.0, "belt_speed": 0.043}
    found = stickslip.evaluate(BRISTLES | soft)
    assert (found["regime"].values[0], found["status"].values[0]) == (1, 17) and np.isnan(found["period"].values[0])
    assert 0.0 < float(found["displacement_amplitude"][0]) < 10.0 / 500.0
    assert 0.0 < time_span(found).duration < 10.0
