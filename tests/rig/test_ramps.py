"""Friction in slow ramps of the drive, up and down: of signals made by hand, whose mean over the speeds is known."""

import numpy as np
import pytest

from stickslip_rig.api import features, make_record

RATE, LOW, HIGH, LOAD, GAP = 1000.0, 0.001, 0.1, 10.0, 0.05


def curve(speed):
    return 0.2 + 0.12 * np.exp(-speed / 0.02)


def loops(number, lasting, noise=0.0, plateau=0.0, measured="drive_velocity"):
    """Triangles of speed, with friction GAP lower on the way down."""
    up, top = np.linspace(LOW, HIGH, round(lasting * RATE)), np.full(round(plateau * RATE), HIGH)
    speed = np.tile(np.concatenate([up, top, up[::-1]]), number)
    time, random = np.arange(speed.size) / RATE, np.random.default_rng(number)
    force = LOAD * np.where(np.gradient(speed) >= 0, curve(speed), curve(speed) - GAP)
    drive = speed if measured == "drive_velocity" else np.cumsum(speed) / RATE
    drive = drive + random.normal(0.0, noise / 20.0 if measured == "drive_velocity" else noise * 1e-5, speed.size)
    signals = {"spring_force": force + random.normal(0.0, noise * LOAD, speed.size), measured: drive}
    return features(make_record(time, signals, {"normal_load": LOAD}))


def mean_friction():
    """Over the speeds but a tenth at either end, in closed form."""
    a, b = LOW + 0.1 * (HIGH - LOW), HIGH - 0.1 * (HIGH - LOW)
    return 0.2 + 0.12 * 0.02 * (np.exp(-a / 0.02) - np.exp(-b / 0.02)) / (b - a)


@pytest.mark.parametrize("measured", ["drive_velocity", "drive_displacement"])
@pytest.mark.parametrize(("number", "noise", "plateau"), [(1, 0.0, 0.0), (3, 0.0, 0.0), (3, 0.01, 0.5)])
def test_friction_of_slow_ramps_is_that_of_their_branches(measured, number, noise, plateau):
    found = loops(number, 5.0, noise, plateau, measured)
    assert float(found["friction_speeding_up"]) == pytest.approx(mean_friction(), rel=3e-3)
    assert float(found["friction_slowing_down"]) == pytest.approx(mean_friction() - GAP, rel=6e-3)


def test_drives_that_reverse_have_no_slow_ramps():
    found = loops(10, 0.2)
    assert np.isnan([found["friction_speeding_up"], found["friction_slowing_down"]]).all()


def test_stick_slip_in_a_ramp_is_no_friction_of_sliding():
    time = np.arange(12_000) / RATE
    speed = np.interp(time, [0.0, 6.0, 12.0], [LOW, HIGH, LOW])
    force = np.where(time < 6.0, 3.0, 2.0 + np.mod(time, 0.1) / 0.05)
    found = features(make_record(time, {"spring_force": force, "drive_velocity": speed}, {"normal_load": LOAD}))
    assert float(found["friction_speeding_up"]) == pytest.approx(0.3)
    assert np.isnan(float(found["friction_slowing_down"]))
