"""Samples and drives that are none, columns that are not what they were taken for: in 35 teeth of known force."""

import numpy as np
import pytest

from stickslip_rig.api import features, make_record

STICKS, RATE, LOW, HIGH, LOAD = 35, 2000.0, 2.0, 4.0, 10.0
TIME = np.arange(7000) / RATE
STIFFNESS = (HIGH - LOW) / 0.09 / 0.01  # N/m: the drive moves at 10 mm/s


def teeth():
    """Sticks of 90 ms and slips of 10 ms, half a cosine, with 3 mN of noise."""
    phase = np.mod(TIME, 0.1)
    sticking, slipping = LOW + (HIGH - LOW) * phase / 0.09, 3.0 + np.cos(np.pi * (phase - 0.09) / 0.01)
    return np.where(phase < 0.09, sticking, slipping) + np.random.default_rng(7).normal(0.0, 0.003, TIME.size)


def shocks():
    """The acceleration in the slips, with noise."""
    slip = (np.mod(TIME, 0.1) - 0.09) / 0.01
    return np.where(slip > 0, -30.0 * np.cos(np.pi * slip), 0.0) + np.random.default_rng(1).normal(0.0, 0.1, TIME.size)


def evaluated(force, **more):
    signals = {name: more.pop(name) for name in list(more)}
    return features(make_record(TIME, {"spring_force": force} | signals, {"normal_load": LOAD, "drive_speed": 0.01}))


def remarks(found):
    return str(found["remarks"].item())


def assert_teeth(found):
    assert (int(found["sticks"]), int(found["drops"])) == (STICKS, STICKS - 1)
    assert float(found["static_friction"]) == pytest.approx(HIGH / LOAD, rel=0.005)
    assert float(found["dynamic_friction"]) == pytest.approx(3.0 / LOAD, rel=0.01)


def test_a_record_without_acceleration_has_what_the_force_says():
    found = evaluated(teeth())
    assert_teeth(found)
    assert remarks(found) == ""
    of_acceleration = [name for name in found.data_vars if "acceleration" in name or name == "peak_frequency"]
    assert len(of_acceleration) == 6 and np.isnan([found[name].values.min() for name in of_acceleration]).all()


@pytest.mark.parametrize("length", [1, 2, 5, 8])
@pytest.mark.parametrize("kind", ["zeros", "noisy zeros", "the last value", "up", "down"])
def test_samples_that_are_none_are_named_and_left_out(kind, length):
    random, force = np.random.default_rng(length), teeth()
    places = random.choice(np.arange(2, 175), 20, replace=False) * 40 + random.integers(0, 20, 20)
    for start in np.sort(places).tolist():
        part = force[start : start + length]
        part[:] = {
            "zeros": 0.0, "noisy zeros": random.normal(0.0, 0.01, length), "the last value": part[0],
            "up": part + 5.0, "down": part - 6.0,
        }[kind]  # fmt: skip
    found = evaluated(force)
    assert_teeth(found)
    if kind != "the last value" or length > 4:  # shorter ones are no more than noise
        assert remarks(found).startswith("use the numbers\ndropout: spring_force")


def test_zeros_beside_each_other_are_no_drops():
    force = teeth()
    force[np.random.default_rng(3).choice(TIME.size, TIME.size // 50, replace=False)] = 0.0
    assert_teeth(evaluated(force))


def test_what_is_left_out_of_the_acceleration_is_no_shock():
    acceleration = shocks()
    clean = evaluated(teeth(), acceleration=acceleration)
    acceleration[[300, 500, 4444]] = 400.0, -200.0, 300.0
    found = evaluated(teeth(), acceleration=acceleration)
    assert remarks(clean) == ""
    assert float(found["acceleration_max"]) == pytest.approx(float(clean["acceleration_max"]))
    assert "acceleration shows" in remarks(found)


DRIVES = {
    "10 um of noise": lambda place, random: {"drive_displacement": place + random.normal(0.0, 1e-5, place.size)},
    "an encoder of 5 um": lambda place, random: {"drive_displacement": np.round(place / 5e-6) * 5e-6},
    "an encoder of 1 mm": lambda place, random: {"drive_displacement": np.round(place / 1e-3) * 1e-3},
    "1 mm of noise": lambda place, random: {"drive_displacement": place + random.normal(0.0, 1e-3, place.size)},
    "its speed, noisy": lambda place, random: {"drive_velocity": 0.01 + random.normal(0.0, 0.005, place.size)},
    "its speed, lost in noise": lambda place, random: {"drive_velocity": 0.01 + random.normal(0.0, 1.0, place.size)},
    "zeros": lambda place, random: {"drive_displacement": np.where(np.arange(place.size) % 500 == 99, 0.0, place)},
}


@pytest.mark.parametrize("drive", DRIVES)
def test_a_noisy_drive_is_smoothed_or_not_used(drive):
    found = evaluated(teeth(), **DRIVES[drive](0.01 * TIME, np.random.default_rng(5)))
    assert_teeth(found)
    lost = ("an encoder of 1 mm", "1 mm of noise", "its speed, lost in noise")
    assert ("not used" in remarks(found)) == (drive in lost)


@pytest.mark.parametrize("noise", [0.0, 1e-6, 1e-5])
def test_the_displacement_of_the_specimen_is_not_taken_for_that_of_the_drive(noise):
    place = teeth() / STIFFNESS + np.random.default_rng(5).normal(0.0, noise, TIME.size)
    found = evaluated(teeth(), drive_displacement=place)
    assert_teeth(found)
    assert "drive_displacement turns back whenever the force drops" in remarks(found)


def test_sticks_and_drops_that_do_not_belong_together_are_said():
    """Spikes as long as a slip are no samples that one could leave out."""
    force = teeth()
    for start in range(100, 6900, 340):
        force[start : start + 20] += 5.0
    found = evaluated(force)
    assert int(found["drops"]) > 2 * int(found["sticks"])
    assert "columns: " in remarks(found) and remarks(found).startswith("check this before you use the numbers")
