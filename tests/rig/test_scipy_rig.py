"""The independent rig of tests/helpers/scipy_rig.py against closed forms, and the features of what it records."""

import functools

import numpy as np
import pytest

from helpers.nightly import few
from helpers.scipy_rig import Rig, trapezoidal
from stickslip_rig.api import Risk, features, find_sticks, make_record
from stickslip_rig.evaluation import risk_inputs

MASS, STIFFNESS, LOAD, SPEED = 0.1, 5000.0, 10.0, 0.01
SIGNALS = ("spring_force", "friction_force", "acceleration", "drive_velocity", "stick")


@functools.cache
def rig(curve, strokes=2, damping=1.0, static=np.nan, dwell=0.0, ramp=0.02, beta=0.0, stroke=0.01):
    segments = trapezoidal(stroke, SPEED, ramp, dwell, strokes)
    return Rig(segments, MASS, STIFFNESS, damping, LOAD, curve, static, beta)


def recorded(simulated, rate=5000, keep=SIGNALS, noise=0.0, **conditions):
    time, signals = simulated.sample(rate)
    random = np.random.default_rng(9)
    found = {name: signals[name] for name in keep}
    for name, scale in (("spring_force", 1.0), ("acceleration", 5.0)):
        if name in found:
            found[name] = found[name] + random.normal(0, noise * scale, time.size)
    return make_record(time, found, {"normal_load": LOAD, "drive_speed": SPEED} | conditions)


DRY = (0.5, 0.0, 0.4, 0.004)
FELT = (0.28, 0.0, 0.12, 0.004)
SMOOTH = (0.2, 2.0, 0.0, 0.002)
COULOMB = (0.3, 0.0, 0.0, 1.0)
COULOMB_STATIC = 0.45


# --- the reference itself ---------------------------------------------------------------------------------------------


def test_energy_is_balanced():
    random = np.random.default_rng(11)
    for _ in range(6):
        curve = (random.uniform(0.1, 0.5), random.uniform(0, 2), random.uniform(0, 0.4), random.uniform(0.002, 0.02))
        segments = trapezoidal(0.006, random.uniform(0.005, 0.02), 0.03, random.uniform(0, 0.1), 2, wait=0.05)
        made = Rig(segments, random.uniform(0.02, 0.3), random.uniform(1e3, 2e4), random.uniform(0, 3), LOAD, curve,
                   beta=0.02, t0=0.1)  # fmt: skip
        assert made.breakaways and abs(made.balance()) < 1e-8


def test_coulombs_cycle_has_its_closed_form():
    """Section 1.1 of any textbook: D = (mu_s - mu_k) N/k; stick 2 D/v, slip (2/w)(pi - atan(D w/v)); no damping."""
    simulated = rig(COULOMB, strokes=1, damping=0.0, static=COULOMB_STATIC)
    drop, omega = (COULOMB_STATIC - COULOMB[0]) * LOAD / STIFFNESS, np.sqrt(STIFFNESS / MASS)
    stick, slip = 2 * drop / SPEED, (2 / omega) * (np.pi - np.arctan(drop * omega / SPEED))
    steady = [t for t in simulated.breakaways if 0.15 < t < 0.9]
    assert np.diff(steady) == pytest.approx(np.full(len(steady) - 1, stick + slip), rel=1e-8)
    restick = [min(t for t in simulated.resticks if t > b) - b for b in steady]
    assert restick == pytest.approx([slip] * len(steady), rel=1e-7)
    found = features(recorded(simulated, 20_000).sel(time=slice(0.15, 0.9)))  # the drive at its full speed
    assert float(found["static_friction"]) == pytest.approx(COULOMB_STATIC, rel=2e-3)
    assert float(found["dynamic_friction"]) == pytest.approx(COULOMB[0], rel=5e-3)
    assert float(found["time_to_sliding"]) == pytest.approx(slip / 2, rel=0.02)
    largest = omega * np.sqrt(SPEED**2 + (drop * omega) ** 2)
    assert float(found["acceleration_max"]) == pytest.approx(largest, rel=2e-3)
    assert float(found["drop_max"]) == pytest.approx(2 * STIFFNESS * np.hypot(drop, SPEED / omega), rel=2e-3)


def test_a_slow_rig_draws_coulombs_loop():
    """Without a drop of friction: heat per stroke is the force times the distance slipped."""
    simulated = rig(COULOMB, strokes=4, stroke=0.01)
    found = features(recorded(simulated, 5000))
    force = COULOMB[0] * LOAD
    slipped = 0.01 - 2 * force / STIFFNESS  # each stroke but the first first unloads the spring, and loads it
    _, _, _, work, heat, _ = simulated.y
    assert heat == pytest.approx(force * (3 * slipped + 0.01 - force / STIFFNESS), rel=1e-3)
    assert float(found["energy_per_stroke"]) == pytest.approx(work / 4, rel=1e-4)


# --- what is found in its records -------------------------------------------------------------------------------------


@pytest.mark.parametrize("curve", [DRY, FELT, SMOOTH], ids=["dry", "felt", "smooth"])
@pytest.mark.parametrize("noise", few([0.02, 0.0], 1))
@pytest.mark.parametrize("known", [("drive_velocity",), ()], ids=["drive known", "force alone"])
def test_sticks_found_in_the_force_are_those_of_the_simulation(curve, noise, known):
    simulated = rig(curve)
    true = recorded(simulated)
    found = recorded(simulated, keep=("spring_force", "acceleration", *known), noise=noise)
    flags = true["stick"].values.astype(bool)
    sticks = find_sticks(found)
    assert abs(sticks.count - find_sticks(true).count) <= 1
    assert np.mean(sticks.flags() == flags) > 0.9  # a phase found ends at the peak of the force, a little later
    one, other = features(true), features(found)
    # Where friction rises with speed nothing breaks away: what the rig reads is the force at the end of loading.
    static = 0.2 if curve == SMOOTH else 0.04
    for name, tolerance in (("static_force", static), ("dynamic_force", 0.08)):
        assert float(other[name]) == pytest.approx(float(one[name]), rel=tolerance), name
    assert abs(int(one["drops"]) - int(other["drops"])) <= 1


def test_a_friction_force_serves_as_well_where_the_mass_is_known():
    simulated = rig(FELT)
    true = find_sticks(recorded(simulated))
    found = find_sticks(recorded(simulated, keep=("friction_force", "acceleration"), mass=MASS))
    assert abs(found.count - true.count) <= 1


@pytest.mark.parametrize("curve, low, high", [(DRY, 7, 7), (FELT, 6, 7), (SMOOTH, 1, 3)], ids=["dry", "felt", "smooth"])
def test_the_default_risk_model_meets_the_public_anchors(curve, low, high):
    """A test of six strokes of 20 mm at 10 mm/s and 10 N: 7 for heavy stick-slip, green for none."""
    simulated = rig(curve, strokes=6, stroke=0.02, ramp=0.05, damping=2.0 if curve != SMOOTH else 5.0)
    found = features(recorded(simulated))
    assert low <= int(Risk().number(risk_inputs(found))) <= high
