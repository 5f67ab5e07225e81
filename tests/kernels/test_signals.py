"""What a rig shows of its motion, against closed forms and against SciPy."""

import math

import numpy as np
import pytest

from helpers.nightly import few
from helpers.rig_runs import drive_of, outcome, random_contact, random_drive, strokes
from helpers.scipy_rig import Rig, trapezoidal
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.laws import LAWS


def random_rig(seed):
    """A rig in SI: its drive and the other arguments of `Rig`."""
    random = np.random.default_rng(seed)
    stroke = 0.004 * 10.0 ** random.uniform(0.0, 0.5)
    speed = min(10.0 ** random.uniform(-2.3, -1.0), stroke / 0.06)
    segments = trapezoidal(stroke, speed, 0.05, random.choice([0.0, 0.1]), 2, random.choice([0.0, 0.2]))
    a1, a3, a4 = random.uniform(0.1, 0.4), random.uniform(0.05, 0.4), 10.0 ** random.uniform(-2.0, -1.0)
    contact = {
        "mass": 10.0 ** random.uniform(-1.5, -0.5), "stiffness": 10.0 ** random.uniform(3.6, 4.3),
        "damping": random.choice([0.0, 2.0]), "load": random.uniform(5.0, 20.0),
        "curve": (a1, random.choice([0.0, 0.5]), a3, a4),
    }  # fmt: skip
    if random.random() < 0.5:
        contact |= {"mu_static": a1 + a3 + random.uniform(0.0, 0.1), "beta": random.choice([0.0, 0.02]), "t0": 0.5}
    return segments, contact


@pytest.mark.parametrize("seed", few(range(20), 8))
def test_motion_is_that_of_scipy(seed):
    segments, contact = random_rig(seed)
    expected = Rig(segments, **contact)
    frequency = math.sqrt(expected.stiffness / expected.mass)
    impedance = math.sqrt(expected.stiffness * expected.mass)
    speed = expected.load / impedance
    a1, a2, a3, a4 = expected.curve
    drive = np.array([(t * frequency, v / speed, a / (speed * frequency)) for t, v, a in segments])
    samples = 2001
    found = outcome(
        drive, samples, rtol=1e-10, curve=(a1, a2 * speed, a3, a4 / speed), gamma=expected.damping / impedance,
        mu_static=expected.mu_static, ageing=expected.beta / math.log(10.0), ageing_time=expected.t0 * frequency,
    )  # fmt: skip
    assert found.status == at.HORIZON_REACHED
    assert (found.slips, found.sticks) == (len(expected.breakaways), len(expected.resticks) + 1)
    assert found.slips > 0
    np.testing.assert_allclose(found.breakaways / frequency, expected.breakaways, rtol=1e-8)
    np.testing.assert_allclose(found.resticks / frequency, expected.resticks, rtol=1e-8)

    _, signals = expected.sample(frequency * (samples - 1) / found.time_end)
    for row, name, unit in (
        (at.SIGNAL_XI, "spring_force", expected.load),
        (at.SIGNAL_ETA, "velocity", speed),
        (at.SIGNAL_FRICTION, "friction_force", expected.load),
    ):
        same, other = found.signals[row, :-1] * unit, signals[name][: samples - 1]  # SciPy leaves out the very end
        apart = np.abs(same - other) > 1e-7 * np.abs(other).max()
        assert apart.sum() <= (2 if row == at.SIGNAL_FRICTION else 0)  # a sample on a corner of the drive

    work, heat, damped = expected.y[3:]
    energy = expected.load * speed / frequency
    kernel = np.array([found.drive_work, found.friction_heat, found.damper_heat]) * energy
    np.testing.assert_allclose(kernel, [work, heat, damped], rtol=1e-7, atol=1e-9 * abs(work))
    assert abs(expected.balance()) < 1e-9


def test_a_slow_drive_draws_the_loop_of_coulomb_friction():
    """Over the displacement of the belt the force rises with slope one, the stiffness, to the plateau at +-mu. Each
    stroke S
    slides S - 2 mu, after 2 mu of climbing: the loop encloses 2 mu (S - 2 mu)."""
    mu, speed, plateau, ramp = 0.4, 1e-3, 2000.0, 2.0
    contact = {"curve": (mu, 0.0, 0.0, 1.0), "gamma": 0.3}
    stroke = speed * (plateau + ramp)
    first, whole = (outcome(strokes(speed, ramp, plateau, count=n), 8001, **contact) for n in (2, 4))
    area = 2.0 * mu * (stroke - 2.0 * mu)
    assert whole.drive_work - first.drive_work == pytest.approx(area, rel=3.0 * speed)
    xi, _, friction, mode = whole.signals
    assert (xi.max(), xi.min()) == pytest.approx((mu, -mu), abs=3.0 * speed)
    last = whole.time > 0.5 * whole.time_end
    climbing = last & (mode == at.STICK) & (np.abs(friction) < 0.9 * mu)
    steps = np.diff(xi[climbing]) / np.diff(whole.time[climbing])
    assert np.median(np.abs(steps)) == pytest.approx(speed, rel=1e-9)
    sliding = last & (mode == at.RISE)
    np.testing.assert_allclose(np.abs(xi[sliding]), mu, atol=3.0 * speed)


@pytest.mark.parametrize(("drive", "contact", "largest", "within"), [
    # From the break-away on w' = d cos t + b sin t, d = 0.2 being mu_static - mu_kinetic: u'' = -w'.
    (drive_of((60.0, 0.0), start=0.05), {"curve": (0.4, 0.0, 0.0, 1.0), "mu_static": 0.6}, math.hypot(0.2, 0.05), 1e-9),
    # Just after a break-away w' is mu_static less what the curve starts with; a damper leaves it no time to grow.
    (drive_of((30.0, 0.0), start=0.05), {"curve": (0.3, 0.0, 0.1, 10.0), "gamma": 1.0, "mu_static": 0.6}, 0.2, 1e-12),
    # A belt that runs off drags the specimen no faster than friction can: its own acceleration is 50.
    (drive_of((0.1, 50.0), (5.0, 0.0)), {"curve": (0.4, 0.0, 0.0, 1.0)}, 0.4, 1e-9),
], ids=["Coulomb slip", "jump at break-away", "belt that runs off"])  # fmt: skip
def test_the_largest_acceleration_is_the_closed_form(drive, contact, largest, within):
    assert outcome(drive, rtol=1e-10, **contact).acceleration_max == pytest.approx(largest, rel=within)


@pytest.mark.parametrize("hysteretic", [False, True], ids=["plain", "hysteretic"])
@pytest.mark.parametrize("law", few(LAWS, 1))
def test_largest_acceleration_is_that_of_a_dense_look(law, hysteretic):
    """Never below it, beyond what the integration allows; above it by a jump between two samples at most."""
    random = np.random.default_rng(9)
    close = 0
    for _ in range(15):
        drive, contact = random_drive(random), random_contact(random, law, hysteretic)
        found = outcome(drive, 40_001, rtol=1e-9, law=law, **contact)
        xi, eta, friction, _ = found.signals
        sampled = np.abs(friction - contact["gamma"] * eta - xi).max()
        assert sampled <= found.acceleration_max * (1.0 + 1e-6) + 1e-9
        close += sampled >= 0.99 * found.acceleration_max
    assert close >= 13


@pytest.mark.parametrize("samples", [2, 7, 1000, 1001])
@pytest.mark.parametrize("law", few(LAWS, 1))
def test_every_sample_is_taken_to_the_very_end(law, samples):
    random = np.random.default_rng(10)
    for n in range(20):
        drive, contact = random_drive(random), random_contact(random, law, n % 2 == 0)
        found = outcome(drive, samples, law=law, **contact)
        assert not np.isnan(found.signals).any()
        end = found.signals[:2, -1]
        np.testing.assert_allclose(end, (found.xi_end, found.eta_end), atol=1e-9)


def test_samples_do_not_disturb_the_motion_and_may_start_later():
    drive, contact = strokes(0.3, 1.0, 12.0, dwell=2.0, count=3), {"gamma": 0.05, "mu_stop": 0.9}
    none, whole = outcome(drive, **contact), outcome(drive, 193, **contact)
    late = outcome(drive, 193 - 29, start=7.25, **contact)
    assert whole.time[29] == pytest.approx(7.25)
    np.testing.assert_allclose(late.signals, whole.signals[:, 29:], atol=1e-12)
    for one in (none, late):
        np.testing.assert_array_equal(one.values, whole.values)
