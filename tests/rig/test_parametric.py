"""A simulated rig as a function of its parameters, and the parameters recovered from its records."""

import numpy as np
import pytest

from helpers.rig_cases import data, rig
from stickslip.errors import ConfigError, NotReachedError
from stickslip_rig.api import RigTests, features, identify, make_rig, simulator

CURVE = {"a1": None, "a2": None, "a3": None, "mu_start": 0.4, "mu_reversal": 0.3, "v_reversal": 0.1}
RIG = {"drive": {"stroke": 0.006, "waiting_time": 0.0, "dwell": 0.0}, "friction": {"ageing_rate": None} | CURVE}
NOISE = {"force_noise": 0.02, "acceleration_noise": 0.2}
TRUTH = {"mu_start": 0.4, "mu_reversal": 0.3}


def test_the_record_of_a_simulator_is_that_of_the_test():
    made = rig(axes={"normal_load": [5.0, 10.0], "g": {"zip": {"a1": [0.1, 0.2], "mu_stop": ["none", 0.1]}}},
               system={"normal_load": None}, friction={"a1": None}, sensor={"rate": 500.0})  # fmt: skip
    (expected,) = RigTests(made).tests([2])
    found = simulator(made, ["a3"], 2)({"a3": 0.12})
    assert found.drop_vars("material").equals(expected.record.drop_vars("material"))
    assert not simulator(made, ["a3"], 2)({"a3": 0.2}).equals(found)


def test_names_numbers_and_parameters_are_checked():
    with pytest.raises(ValueError, match="names: got mu_start, expected some of mass, stiffness"):
        simulator(rig(), ["mu_start", "a1"])
    with pytest.raises(IndexError, match="test 1 of 1"):
        simulator(rig(), ["a1"], 1)
    simulate = simulator(rig(), ["a1"])
    with pytest.raises(ValueError, match="parameters: got a1 and a3, expected a1"):
        simulate({"a1": 0.1, "a3": 0.2})
    with pytest.raises(ConfigError, match="a1"):
        simulate({"a1": -0.1})
    with pytest.raises(NotReachedError, match="a1 = 0.1: the step budget ran out"):
        simulator(rig(solver={"max_steps": 20}), ["a1"])({"a1": 0.1})


def measured(seed, keep):
    """A record with noise, of the signals that a rig measures."""
    (test,) = RigTests(make_rig(data(**RIG, sensor={"seed": 1000 + seed, **NOISE}))).tests([0])
    return test.record[list(keep)]


KEPT = {
    "flags": ("spring_force", "acceleration", "stick", "drive_velocity"),
    "force and drive": ("spring_force", "acceleration", "drive_velocity"),
    "force alone": ("spring_force", "acceleration"),
}


@pytest.mark.slow
@pytest.mark.parametrize("keep", list(KEPT))
def test_friction_is_identified_from_records_with_noise(keep):
    """From a start 15 to 20 % away. Standard deviations of the features come from repetitions, as a user would do.

    Features of the simulated record have noise of their own, of the same size, and both records show an event up to a
    sample late, within which the force grows by stiffness x speed / rate; repetitions of one motion do not show that.
    """
    names = ("static_force", "dynamic_force", "drop_mean")
    repeated = [features(measured(seed, KEPT[keep])) for seed in range(20, 40)]
    late = 5000.0 * 0.01 / 2000.0 / np.sqrt(12)
    sigma = {name: np.hypot(np.sqrt(2) * np.std([found[name] for found in repeated], ddof=1), late) for name in names}
    start = {"mu_start": 0.46, "mu_reversal": 0.25}
    for seed in range(3):
        simulate = simulator(make_rig(data(**RIG, sensor={"seed": seed, **NOISE})), list(TRUTH))
        found = identify(simulate, measured(seed, KEPT[keep]), start, names=names, sigma=sigma)
        assert found.converged
        for name, true in TRUTH.items():
            assert abs(found.estimates[name] - true) < 3 * found.standard_error[name], (seed, name)
            assert found.standard_error[name] < 0.02 * true
