"""Whole rigs: the drive in segments, reversed, in many lanes; and what is left where a rig cannot be computed."""

import numpy as np
import pytest

from helpers.nightly import few
from helpers.rig_runs import cut, drive_of, imbalance, outcome, random_contact, random_drive, rig, run, strokes
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.laws import LAWS

BOTH = pytest.mark.parametrize("hysteretic", [False, True], ids=["plain", "hysteretic"])
EVERY_LAW = pytest.mark.parametrize("law", few(LAWS, 1))
NUMBERS = sorted({*range(at.RIG_ROWS)} - {at.RIG_STATUS, at.RIG_STEPS, at.RIG_STEPS_TAKEN})
EXTREME = {"curve": (0.5, 0.1, 0.3, 0.7), "mu_stop": 0.45}


def assert_same(found, expected, rtol):
    """The same results and signals; friction jumps where the contact breaks away, so it is left to the others."""
    np.testing.assert_allclose(found.values[NUMBERS], expected.values[NUMBERS], rtol=rtol, atol=rtol)
    for row in (at.SIGNAL_XI, at.SIGNAL_ETA):
        np.testing.assert_allclose(found.signals[row], expected.signals[row], rtol=0, atol=rtol)


@pytest.mark.parametrize("off", [None, 0.0, 1e-15, -1e-15, 1e-13, -1e-13, 1e-12, -1e-12, 1e-9, -1e-9])
@BOTH
@EVERY_LAW
def test_cutting_segments_anywhere_and_at_the_very_events_changes_nothing(law, hysteretic, off):
    random = np.random.default_rng(3)
    for _ in range(12):
        drive, contact = random_drive(random), random_contact(random, law, hysteretic)
        whole = outcome(drive, samples=100, rtol=1e-10, law=law, **contact)
        events = np.concatenate([whole.breakaways, whole.resticks])
        at_random = random.uniform(0.0, drive[:, at.SEGMENT_TIME].sum(), 25)
        pieces = cut(drive, at_random if off is None else (1.0 + off) * events)
        assert_same(outcome(pieces, samples=100, rtol=1e-10, law=law, **contact), whole, 2e-7)


@pytest.mark.parametrize("later", [0.1, 3e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 0.0, -1e-12])
@BOTH
@EVERY_LAW
def test_a_slip_the_drive_stops_at_once_is_as_if_it_had_not_been(law, hysteretic, later):
    """The belt stops accelerating shortly after break-away. Slip that has just begun reverses: on a hysteretic
    curve along a line as steep as you like, on a plain one it may stick again. The later motion knows no jump."""
    contact = EXTREME if hysteretic else {"curve": EXTREME["curve"]}
    accelerating = np.sqrt(2.0 * (0.8 - 0.03) / 0.03)  # until alpha + xi is 0.8
    found = outcome(drive_of((accelerating + later, 0.03), (10.0, 0.0)), law=law, delta=2.0, rtol=1e-9, **contact)
    never = outcome(drive_of((accelerating - 1e-9, 0.03), (10.0, 0.0)), law=law, delta=2.0, rtol=1e-9, **contact)
    assert (found.status, never.status) == (at.HORIZON_REACHED, at.HORIZON_REACHED)
    assert found.steps < 2000
    moved = (found.xi_end - never.xi_end, found.eta_end - never.eta_end)
    assert moved == pytest.approx((0.0, 0.0), abs=2.0 * abs(later) + 1e-7)


@pytest.mark.parametrize("drop", [-1.0, -0.1, -1e-3, 1e-3, 0.1])
@pytest.mark.parametrize("off", [0.0, 1e-15, -1e-15, 1e-14, -1e-14, 1e-9])
@BOTH
def test_friction_obeys_its_law_where_the_drive_turns_at_a_break_away(hysteretic, off, drop):
    """Where w' must jump from zero to below it, slip must not be let go on backwards."""
    random = np.random.default_rng(5)
    for _ in range(6):
        contact = random_contact(random, "stribeck", hysteretic)
        drive = strokes(0.3, 2.0, 6.0, dwell=1.0, count=3)
        breakaway = outcome(drive, **contact).breakaways[0]
        drive = cut(drive, [breakaway * (1.0 + off)])
        turned = drive[:, at.SEGMENT_ALPHA].copy()
        corner = np.searchsorted(np.cumsum(drive[:, at.SEGMENT_TIME]), breakaway - 1e-6) + 1
        turned[corner:] += drop
        drive = drive_of(*zip(drive[:, at.SEGMENT_TIME], turned, strict=True))
        found = outcome(drive, samples=500, rtol=1e-8, **contact)
        assert found.status == at.HORIZON_REACHED
        assert abs(imbalance(drive, found)) < 1e-6
        xi, eta, friction, mode = found.signals
        slip = belt_at(drive, found.time) - eta
        sliding = np.isin(mode, (at.RISE, at.FAST)) & (np.abs(slip) > 1e-7)
        a1, a2, a3, a4 = contact["curve"]
        curve = np.sign(slip) * (a1 + a2 * np.abs(slip) + a3 * np.exp(-np.abs(slip) / a4))
        np.testing.assert_allclose(friction[sliding], curve[sliding], atol=1e-9)


def belt_at(drive, time):
    ends = np.cumsum(drive[:, at.SEGMENT_TIME])
    n = np.minimum(np.searchsorted(ends, time), len(drive) - 1)
    return drive[n, at.SEGMENT_BELT] + (time - ends[n] + drive[n, at.SEGMENT_TIME]) * drive[n, at.SEGMENT_ALPHA]


def test_a_stick_phase_that_ends_as_the_belt_stops_is_one():
    """The load jumps by the acceleration of a belt that brakes, and is at rest afterwards: nothing grazes here."""
    drive = drive_of((17.0, 0.0), (1.0, -0.1), (5.0, 0.0), start=0.1)
    found = outcome(drive, curve=(0.3, 0.0, 0.1, 0.1), gamma=0.2)
    starts, ends, loads = found.stops.T
    assert starts[2] < 16.0
    assert (ends[2], loads[2]) == pytest.approx((18.0, 0.4), rel=1e-12)
    assert found.sticks == found.slips + 1
    assert found.stick_time == pytest.approx((ends - starts).sum(), rel=1e-12)


# --- symmetry, lanes ------------------------------------------------------------------------------------------------


@BOTH
@EVERY_LAW
def test_everything_turns_round_with_the_drive(law, hysteretic):
    random = np.random.default_rng(6)
    for _ in range(20):
        drive, contact = random_drive(random), random_contact(random, law, hysteretic)
        xi = random.uniform(-0.3, 0.3)
        there = outcome(drive, samples=100, law=law, xi=xi, **contact)
        back = outcome(drive * [1.0, -1.0, -1.0], samples=100, law=law, xi=-xi, **contact)
        mirrored, signals = there.values.copy(), -there.signals
        mirrored[[at.RIG_XI_END, at.RIG_ETA_END]] *= -1.0
        signals[at.SIGNAL_MODE] *= -1.0
        np.testing.assert_array_equal(back.values, mirrored)
        np.testing.assert_array_equal(back.signals, signals)
        np.testing.assert_array_equal(back.stops[:, :2], there.stops[:, :2])
        np.testing.assert_array_equal(back.stops[:, at.STOP_LOAD], -there.stops[:, at.STOP_LOAD])


@EVERY_LAW
def test_numbers_do_not_depend_on_lane_neighbours_or_block(law):
    random = np.random.default_rng(7)
    drives = [random_drive(random) for _ in range(100)]
    contacts = [random_contact(random, law, n % 2 == 0) for n in range(100)]
    columns = [rig(**contact) for contact in contacts]
    results, signals = run(columns, drives, samples=40, law=law)
    order = random.permutation(100)
    shuffled, reordered = run([columns[n] for n in order], [drives[n] for n in order], samples=40, law=law)
    np.testing.assert_array_equal(shuffled, results[:, order])
    np.testing.assert_array_equal(reordered, signals[order])
    for n in range(0, 100, 9):
        alone, own = run([columns[n]], [drives[n]], samples=40, law=law)
        np.testing.assert_array_equal(alone[:, 0], results[:, n])
        np.testing.assert_array_equal(own[0], signals[n])


# --- energy ---------------------------------------------------------------------------------------------------------


@BOTH
@EVERY_LAW
def test_work_of_the_drive_is_heat_and_stored_energy(law, hysteretic):
    """Work is added up from the law of friction, not from the motion, so this finds errors of either. A Runge-Kutta
    step at 1e-6 may step over the peak of a steep curve as a slip ends: up to 1e-4, once in some hundred rigs."""
    random, rtol = np.random.default_rng(8), 1e-6 if law == "stribeck" else 1e-8
    for _ in range(300):
        drive, contact = random_drive(random), random_contact(random, law, hysteretic)
        xi = random.uniform(-0.3, 0.3)
        found = outcome(drive, rtol=rtol, law=law, xi=xi, **contact)
        assert found.status == at.HORIZON_REACHED
        if found.slips:
            assert abs(imbalance(drive, found, xi)) < 1e-6
        else:
            assert found.friction_heat == 0.0 and np.isnan(found.breakaway_time)
            assert found.stick_time == pytest.approx(found.time_end, rel=1e-12)


@EVERY_LAW
def test_energy_is_balanced_on_steep_curves_at_the_default_tolerance(law):
    """Under the Gaussian law it was off by 1.5e-4."""
    random = np.random.default_rng(5)
    for _ in range(60):
        drive, contact = random_drive(random), random_contact(random, law, False)
        a1, a2, a3, a4 = contact["curve"]
        steep = contact | {"curve": (a1, a2, a3, a4 * random.uniform(0.03, 1.0)), "delta": random.uniform(1.0, 4.0)}
        assert abs(imbalance(drive, outcome(drive, law=law, **steep))) < 2e-6


# --- what cannot be computed ----------------------------------------------------------------------------------------


def test_a_rig_out_of_steps_says_so_and_leaves_what_it_did_not_reach():
    drive = strokes(0.3, 1.0, 20.0, count=6)
    whole = outcome(drive, samples=400)
    found = outcome(drive, samples=400, max_steps=40)
    assert (found.status, found.steps) == (at.STEP_LIMIT, 40)
    assert np.isnan([found.xi_end, found.eta_end]).all()
    missing = np.isnan(found.signals).any(axis=0)
    reached = np.argmax(missing)
    assert 0 < reached < 300
    assert missing[reached:].all()
    np.testing.assert_array_equal(found.signals[:, :reached], whole.signals[:, :reached])


def test_nonsense_is_not_finite_and_a_stopped_block_not_computed():
    assert outcome(strokes(0.3, 1.0, 5.0), gamma=np.nan).status == at.NOT_FINITE
    results, _ = run([rig()] * 3, [strokes(1.0, 1.0, 9.0)] * 3, samples=5, stop=1)
    assert (results[at.RIG_STATUS] == at.NOT_RUN).all()
    assert run([], [])[0].shape == (at.RIG_ROWS, 0)
