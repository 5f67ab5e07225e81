"""What a motion is called, and that nothing gets a name by default."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from kernel_runs import ARTICLE, INF, NAN, block_of, cell, outcome, run
from stickslip_kernels import layout as at
from stickslip_kernels.regimes import ring_extremum

FLAT = (0.5, 0.0, 0.0, 1.0)


def test_slow_belt_on_the_articles_curve_stick_slips():
    found = outcome(0.1)
    assert (found.regime, found.status) == (at.STICK_SLIP, at.CYCLE_CLOSED)
    assert 0.0 < found.cycle_stick_time < found.period


def test_coexisting_motions_are_told_apart_by_the_start():
    """Design, section 4: at v = 0.4 sliding is stable, yet from stick the mass stick-slips for ever."""
    assert outcome(0.4).regime == at.STICK_SLIP
    mu = 1.0 + 0.04 + 0.3 * math.exp(-4.0)
    assert outcome(0.4, xi=mu, eta=0.01).regime == at.DAMPED


@pytest.mark.parametrize(("curve", "gamma", "regime"), [
    ((0.5, 0.3, 0.0, 1.0), 0.0, at.DAMPED),
    ((0.5, 2.5, 0.0, 1.0), 0.0, at.CREEP),
    ((0.5, 0.0, 0.0, 1.0), 2.5, at.CREEP),
    ((0.5, 0.0, 0.0, 1.0), 0.3, at.DAMPED),
])  # fmt: skip
def test_rising_friction_or_damping_settles(curve, gamma, regime):
    found = outcome(0.3, curve, gamma)
    assert (found.regime, found.status) == (regime, at.SETTLED)
    assert found.settling_time > 0.0
    assert math.isnan(found.period)


def test_settling_time_is_when_the_amplitude_enters_the_band_for_good():
    """On a straight rising line the amplitude decays like e^(-zeta tau), and the band is 1e-4 mu_start."""
    zeta, belt = 0.05, 0.3
    found = outcome(belt, (0.5, 2 * zeta, 0.0, 1.0), rtol=1e-9)
    assert found.settling_time == pytest.approx(math.log(belt / (1e-4 * 0.5)) / zeta, rel=0.02)


def test_crossings_are_extrema_outside_the_band_on_alternate_sides():
    """xi - xi* is at first -slope b; then extrema follow with the ratio e^(-pi zeta/sqrt(1 - zeta^2))."""
    zeta, belt = 0.3, 1.0
    found = outcome(belt, (0.5, 2 * zeta, 0.0, 1.0))
    omega = math.sqrt(1 - zeta**2)
    p, dp = -2 * zeta * belt, belt
    phase = math.atan2(dp, zeta * (dp + zeta * p) / omega + omega * p) % math.pi
    first = math.exp(-zeta * phase / omega) * (p * math.cos(phase) + (dp + zeta * p) / omega * math.sin(phase))
    expected = 1 + math.floor(math.log(first / (1e-4 * 0.5)) / (math.pi * zeta / omega))
    assert found.crossings == expected


def test_undamped_flat_friction_oscillates_for_ever():
    found = outcome(0.3, FLAT, xi=0.6, eta=0.3 - 1e-9)
    assert (found.regime, found.status) == (at.SUSTAINED, at.OSCILLATION_SUSTAINED)
    assert found.period == pytest.approx(2 * math.pi, rel=1e-5)
    assert found.cycle_heat == pytest.approx(0.5 * 0.3 * 2 * math.pi, rel=1e-5)


def test_a_little_damping_is_not_sustained():
    assert outcome(0.3, FLAT, 2e-4, xi=0.6, eta=0.1).regime == at.DAMPED


def test_a_belt_that_stands_still_never_breaks_away():
    found = outcome(0.0, xi=1.2)
    assert (found.regime, found.status) == (at.STUCK, at.NEVER_BREAKS_AWAY)
    assert math.isnan(found.breakaway_time)
    assert math.isnan(found.damping_ratio)


def test_a_mass_thrown_on_a_belt_that_stands_still_gets_stuck():
    assert outcome(0.0, xi=-4.0, eta=0.0).regime == at.STUCK


def test_a_horizon_before_the_verdict_leaves_it_open():
    for horizon in (5.0, 14.0):  # before the first break-away, and in the first slip
        found = outcome(0.1, horizon=horizon)
        assert (found.regime, found.status) == (at.UNRESOLVED, at.HORIZON_REACHED)


def test_a_spent_budget_leaves_it_open():
    found = outcome(0.1, max_steps=10)
    assert (found.regime, found.status, found.steps) == (at.UNRESOLVED, at.STEP_LIMIT, 10)


@pytest.mark.parametrize("row", [at.GAMMA, at.BELT, at.A1, at.A4, at.MU_STATIC, at.XI_START, at.HORIZON])
def test_a_cell_with_a_number_that_is_none_fails(row):
    column = cell(0.1)
    column[row] = NAN
    results = run(block_of(column))
    assert results[at.REGIME, 0] == at.FAILED
    assert results[at.STATUS, 0] == at.NOT_FINITE


@pytest.mark.parametrize("belt", [1e300, 1e-300])
def test_absurd_numbers_end_in_a_verdict_and_not_in_a_loop(belt):
    assert outcome(belt, max_steps=1e4).regime != at.NOT_COMPUTED


def test_zeno_ends_as_settled():
    """A hysteretic curve whose hold phases accumulate towards steady sliding, within a small budget."""
    found = outcome(0.3, (1.0, 0.1, 0.3, 0.1), 0.4, mu_stop=1.0, xi=1.05, eta=0.02, max_steps=5000)
    assert found.status == at.SETTLED


@pytest.mark.slow
def test_every_settled_cell_really_stays():
    """Whatever was called settled before its time never sticks again in the next three hundred radians."""
    generator = np.random.default_rng(7)
    columns = []
    for _ in range(600):
        a1, a2, a3, a4 = generator.uniform((0.3, 0.01, 0.02, 0.05), (1.2, 1.0, 0.6, 0.5))
        stop = generator.choice([NAN, generator.uniform(0.2, a1 + a3)])
        start = {"xi": generator.uniform(-2, 2), "eta": generator.uniform(-1, 1)}
        gamma = generator.choice([0.0, 0.1, 1.0])
        columns.append(cell(generator.uniform(0.05, 1.5), (a1, a2, a3, a4), gamma, mu_stop=stop, **start))
    cells = block_of(*columns)
    results = run(cells)
    settled = np.flatnonzero(results[at.STATUS] == at.SETTLED)
    assert settled.size > 100
    entered = results[at.SETTLING_TIME, settled]
    later = np.ascontiguousarray(cells[:, settled])
    later[at.HORIZON] = entered + 300.0
    until, beyond = later.copy(), run(later, early_stop=False)
    until[at.HORIZON] = entered + 1.0
    np.testing.assert_array_equal(beyond[at.STICKS], run(until, early_stop=False)[at.STICKS])
    mu = [a1 + a2 * b + a3 * math.exp(-b / a4) for a1, a2, a3, a4, b in later[[at.A1, at.A2, at.A3, at.A4, at.BELT]].T]
    hysteretic = ~np.isnan(later[at.MU_STOP])
    np.testing.assert_allclose(beyond[at.XI_END][~hysteretic], np.array(mu)[~hysteretic], atol=3e-4)


def test_metrics_do_not_depend_on_stopping_early():
    columns = [cell(b, curve, horizon=300.0) for b in (0.1, 0.3, 0.9) for curve in (ARTICLE, (0.5, 0.4, 0.0, 1.0))]
    early, full = (run(block_of(*columns), early_stop=stop) for stop in (True, False))
    decided = early[at.STATUS] != at.HORIZON_REACHED
    assert decided.all()
    rows = [at.REGIME, at.PERIOD, at.XI_MAX, at.XI_MIN, at.SPEED_MAX, at.CROSSINGS, at.SETTLING_TIME, at.CYCLE_HEAT]
    np.testing.assert_array_equal(early[rows], full[rows])


@given(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(0.01, 3.0))
def test_ring_extremum_is_the_next_of_the_linear_oscillator(p, dp, zeta):
    """Against the matrix exponential on a fine grid. An extremum at the very start is a matter of rounding."""
    assume(abs(dp) > 1e-3)
    found = ring_extremum(p, dp, zeta)
    times = np.linspace(0.0, 60.0, 60001)
    roots = np.roots([1.0, 2 * zeta, 1.0]).astype(complex)
    assume(abs(roots[0] - roots[1]) > 1e-3)
    second = (dp - roots[0] * p) / (roots[1] - roots[0])
    motion = ((p - second) * np.exp(roots[0] * times) + second * np.exp(roots[1] * times)).real
    turns = np.flatnonzero(np.diff(np.sign(np.diff(motion)))) + 1
    expected = motion[turns[0]] if turns.size and abs(motion[turns[0]]) > 1e-9 else 0.0
    assert found == pytest.approx(expected, abs=2e-6)


def test_no_regime_without_a_horizon_is_left_open_on_the_articles_map():
    cells = block_of(*(cell(b, gamma=g) for b in np.linspace(0.02, 1.2, 60) for g in (0.0, 0.05, 3.0)))
    assert set(run(cells)[at.REGIME]) == {at.STICK_SLIP, at.DAMPED, at.CREEP}
    assert np.isinf(cells[at.HORIZON]).all() and cell(0.1)[at.HORIZON] == INF
