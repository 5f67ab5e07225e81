"""Measured tables as friction curves, against SciPy's splines and SciPy's integration of the motion on them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

import stickslip
from helpers import scipy_oscillator
from helpers.data import cases
from helpers.scipy_oscillator import Oscillator
from stickslip.config.reader import parse_config
from stickslip.engine import Options
from stickslip.engine.dispatch import friction_at_belt_speed
from stickslip.errors import ConfigError, ExtrapolationWarning
from stickslip.vocabulary.cells import as_cells

RANDOM = np.random.default_rng(11)
DRY = np.array([0.0, 0.004, 0.01, 0.03, 0.08, 0.2, 0.4, 1.0]), np.array([0.41, 0.39, 0.36, 0.31, 0.29, 0.3, 0.32, 0.37])
NOISY = np.linspace(0.01, 1.2, 25), 0.3 + 0.2 * np.exp(-np.linspace(0, 8, 25)) + RANDOM.normal(0, 0.008, 25)
CLOSE = np.linspace(0.99, 1.01, 200), 0.3 + 0.1 * np.sin(np.linspace(0.0, 20.0, 200))  # in one place
THREE = np.array([0.0, 0.1, 0.4]), np.array([0.5, 0.3, 0.35])
UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": 0.1}
YAML = """
system: {{mass: 100 g, normal_load: 10 N, damping: 2 N s/m}}
friction: {}
axes:
  stiffness: {{start: 0.5 N/mm, stop: 50 N/mm, num: 4, spacing: log}}
  belt_speed: {{start: 1 mm/s, stop: 200 mm/s, num: 5}}
"""
FELT = "{speed: [1 mm/s, 10 mm/s, 60 mm/s], mu: [0.398, 0.347, 0.288]}"


@dataclass
class OnCurve(Oscillator):
    """The oscillator on any curve, which starts at the friction of standstill."""

    friction: Callable | None = None

    def __post_init__(self):
        self.curve = (0.0, 0.0, float(self.friction(0.0)), 0.02)
        super().__post_init__()

    def stribeck(self, w):
        return self.friction(w)


def curve_of(points, monotone, speed=1.0):
    """Friction over the slip speed in units of `speed`, as SciPy has it between the points."""
    w, mu = points
    spline = (PchipInterpolator if monotone else CubicSpline)(w, mu)
    return lambda v: spline(np.clip(v * speed, w[0], w[-1]))


def ends(cell, law, horizon, rtol):
    found = stickslip.evaluate(cell, law=law, horizon=horizon, early_stop=False, rtol=rtol)
    return np.array([float(found[name][0]) for name in ("displacement_end", "velocity_end", "sticks")])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::stickslip.errors.ExtrapolationWarning")
@pytest.mark.parametrize(
    ("points", "monotone", "stiffness", "belt"),
    [(DRY, False, 1.0, 0.05), (DRY, True, 30.0, 0.003), (NOISY, False, 0.1, 0.1), (THREE, False, 300.0, 0.02),
     pytest.param(NOISY, True, 3.0, 0.5, marks=pytest.mark.slow),
     pytest.param(DRY, False, 1e3, 0.001, marks=pytest.mark.slow)],
)  # fmt: skip
def test_the_motion_on_a_table_is_that_of_scipy(points, monotone, stiffness, belt):
    rate = stiffness**0.5
    law, horizon = stickslip.Table(*points, monotone=monotone), 12.0 + 1.2 / (belt * rate)
    exact = OnCurve(belt * rate, horizon, gamma=0.02, friction=curve_of(points, monotone, 1.0 / rate))
    cell = UNIT | {"stiffness": stiffness, "belt_speed": belt, "damping": 0.02 * rate}
    sticks = sum(mode == "stick" for _, mode, _, _ in exact.phases)
    for rtol in (1e-6, 1e-8):
        x, v, count = ends(cell, law, horizon / rate, rtol)
        assert x * stiffness == pytest.approx(exact.xi, abs=10 * rtol)
        assert v * rate == pytest.approx(exact.eta, abs=10 * rtol)
        assert count == sticks


@pytest.mark.parametrize(("points", "monotone"), [(NOISY, False), (NOISY, True), (CLOSE, False)])
def test_friction_and_its_slope_are_those_of_the_spline(points, monotone):
    law, w = (
        stickslip.Table(*points, monotone=monotone),
        np.r_[np.geomspace(1e-4, 5.0, 400), np.linspace(0.98, 1.02, 99)],
    )
    spline = (PchipInterpolator if monotone else CubicSpline)(*points)
    cells = as_cells(UNIT | {"belt_speed": w, "damping": 0.3}, law)
    found = friction_at_belt_speed(cells, Options(law=law))
    np.testing.assert_allclose(found, curve_of(points, monotone)(w), rtol=1e-12)
    inside = (w > points[0][0]) & (w < points[0][-1])
    with pytest.warns(ExtrapolationWarning):
        ratio = stickslip.evaluate(UNIT | {"belt_speed": w, "damping": 0.3}, law=law)["damping_ratio"].values
    np.testing.assert_allclose(ratio, 0.15 + 0.5 * np.where(inside, spline(w, 1), 0.0), atol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize(("belt", "x", "w"), [(0.05, 0.9, 0.25), (0.6, 0.3, 0.95)])
def test_a_narrow_spike_is_not_stepped_over(belt, x, w, monkeypatch):
    """On the way up, where it holds the slip back, and in a trough between two fast ends of a step.

    SciPy passes over it in steps of 0.02.
    """
    monkeypatch.setattr(scipy_oscillator, "LONGEST_STEP", 3e-4)
    speeds = np.array([0.0, 0.3, 0.4, 0.4005, 0.401, 0.5, 2.0])
    plain, spike = np.array([1.0, *[0.3] * 6]), np.array([1.0, 0.3, 0.3, 1.5, 0.3, 0.3, 0.3])
    exact = OnCurve(belt, 2.5, xi=x, eta=belt - w, friction=curve_of((speeds, spike), monotone=True))
    cell = UNIT | {"belt_speed": belt, "displacement": x, "velocity": belt - w}
    found, without = (ends(cell, stickslip.Table(speeds, mu, monotone=True), 2.5, 1e-6) for mu in (spike, plain))
    assert found[:2] == pytest.approx((exact.xi, exact.eta), abs=1e-5)
    assert abs(without[0] - found[0]) > 1e-4  # it matters


@pytest.mark.slow
def test_hysteresis_on_a_table_begins_at_its_least_friction():
    horizon = 60.0
    exact = OnCurve(0.05, horizon, mu_stop=0.33, friction=curve_of(DRY, monotone=False))
    assert {mode for _, mode, _, _ in exact.phases} >= {"fast", "fall", "stick"}
    cell = UNIT | {"belt_speed": 0.05, "mu_stop": 0.33}
    x, v, _ = ends(cell, stickslip.Table(*DRY), horizon, 1e-8)
    assert (x, v) == pytest.approx((exact.xi, exact.eta), abs=1e-6)


@pytest.mark.slow
def test_a3_scales_a_table_and_a4_stretches_it():
    law, belts = stickslip.Table(*DRY), np.array([0.01, 0.05, 0.3])
    twice = stickslip.evaluate(UNIT | {"belt_speed": belts, "a3": 0.82}, law=law)
    load = stickslip.evaluate(UNIT | {"belt_speed": belts, "normal_load": 2.0}, law=law)
    np.testing.assert_allclose(twice["spring_force_max"], load["spring_force_max"], rtol=1e-12)
    wide = stickslip.evaluate(UNIT | {"belt_speed": 3.0 * belts, "a4": 3.0, "mass": 1.0 / 9.0}, law=law)
    same = stickslip.evaluate(UNIT | {"belt_speed": belts}, law=law)
    np.testing.assert_allclose(wide["spring_force_max"], same["spring_force_max"], rtol=1e-12)
    np.testing.assert_allclose(wide["period"], same["period"] / 3.0, rtol=1e-12)


@pytest.mark.parametrize(("w", "mu", "message"), [
    ([0.0, 0.1, 0.1], [0.4, 0.3, 0.3], "got 0.3 at 0.1 m/s, expected rising"),
    ([0.0, 0.2, 0.1], [0.4, 0.3, 0.3], "got 0.3 at 0.1 m/s"),
    ([0.0, np.nan, 0.1], [0.4, 0.3, 0.3], "got 0.3 at nan"),
    ([0.0, 0.1], [0.4, np.nan], "got nan at 0.1"),
    ([0.0, 0.1], [0.4, 0.0], "got 0 at 0.1 m/s"),
    ([-0.1, 0.1], [0.4, 0.3], "got 0.4 at -0.1 m/s"),
    ([0.1], [0.4], "expected 2 to 200"),
    (np.linspace(0, 1, 201), np.ones(201), "expected 2 to 200"),
    ([0.0, 0.1, 0.2], [0.4, 0.3], "expected two lists alike"),
    ([0.0, 0.1, 0.11, 1.0], [0.9, 0.01, 0.9, 0.9], "falls below 0 between them; take monotone=True"),
])  # fmt: skip
def test_points_that_are_no_curve_are_refused(w, mu, message):
    with pytest.raises(ValueError, match=message):
        stickslip.Table(w, mu)


def test_speeds_with_units_are_converted():
    assert stickslip.Table(["10 mm/s", "0.2 m/s"], [0.4, 0.3]) == stickslip.Table([0.01, 0.2], [0.4, 0.3])


@cases("sweep.yaml")
def test_wrong_tables_in_a_configuration_are_refused(friction, message):
    with pytest.raises((ConfigError, OSError), match=message):
        parse_config(YAML.format(friction))


@pytest.mark.slow
def test_bristles_on_a_table_are_those_on_its_curve():
    w = np.concatenate([[0.0], np.geomspace(1e-4, 2.0, 149)])
    law = stickslip.Table(w, 0.25 + 0.2 * np.exp(-w / 0.02))
    contact = {"contact_stiffness": 2e4, "contact_damping": 5.0, "damping": 1.0, "normal_load": 10.0}
    cells = {"mass": 0.1, "stiffness": [1e3, 1e4, 1e5], "belt_speed": 0.02} | contact
    table = stickslip.evaluate(cells, law=law)
    exact = stickslip.evaluate(cells | {"a1": 0.25, "a2": 0.0, "a3": 0.2, "a4": 0.02})
    np.testing.assert_array_equal(table["regime"], exact["regime"])
    np.testing.assert_allclose(table["critical_stiffness"], exact["critical_stiffness"], rtol=1e-3)
    np.testing.assert_allclose(table["spring_force_max"], exact["spring_force_max"], rtol=1e-4)
