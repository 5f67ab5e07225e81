"""What a motion is called, and that nothing gets a name by default."""

import math

import numpy as np
import pytest

from helpers.kernel_runs import ARTICLE, INF, NAN, block_of, cell, outcome, run
from stickslip_kernels import layout as at

FLAT, LINE = (0.5, 0.0, 0.0, 1.0), (0.5, 0.3, 0.0, 1.0)
MU = 1.0 + 0.04 + 0.3 * math.exp(-4.0)  # of the article's curve at 0.4, where sliding and stick-slip coexist
CASES = {
    "the article's curve, slowly": ({"belt": 0.1}, at.STICK_SLIP, at.CYCLE_CLOSED),
    "coexisting motions, from stick": ({"belt": 0.4}, at.STICK_SLIP, at.CYCLE_CLOSED),
    "coexisting motions, from sliding": ({"belt": 0.4, "xi": MU, "eta": 0.01}, at.DAMPED, at.SETTLED),
    "friction rises": ({"belt": 0.3, "curve": LINE}, at.DAMPED, at.SETTLED),
    "friction rises steeply": ({"belt": 0.3, "curve": (0.5, 2.5, 0.0, 1.0)}, at.CREEP, at.SETTLED),
    "damped strongly": ({"belt": 0.3, "curve": FLAT, "gamma": 2.5}, at.CREEP, at.SETTLED),
    "damped": ({"belt": 0.3, "curve": FLAT, "gamma": 0.3}, at.DAMPED, at.SETTLED),
    "damped a little": ({"belt": 0.3, "curve": FLAT, "gamma": 2e-4, "xi": 0.6, "eta": 0.1}, at.DAMPED, at.SETTLED),
    "undamped": ({"belt": 0.3, "curve": FLAT, "xi": 0.6, "eta": 0.3 - 1e-9}, at.SUSTAINED, at.NEUTRAL_RINGING),
    "undamped inside the band": ({"belt": 0.9, "curve": (1.0, 0.0, 0.0, 1.0), "xi": 1.00005, "eta": 0.0}, at.SUSTAINED,
                                 at.NEUTRAL_RINGING),
    "a belt at rest": ({"belt": 0.0, "xi": 1.2}, at.STUCK, at.NEVER_BREAKS_AWAY),
    "thrown on a belt at rest": ({"belt": 0.0, "xi": -4.0, "eta": 0.0}, at.STUCK, at.NEVER_BREAKS_AWAY),
    "thrown on it, hysteretic": ({"belt": 0.0, "xi": 4.0, "mu_stop": 0.0}, at.STUCK, at.NEVER_BREAKS_AWAY),
    "horizon before break-away": ({"belt": 0.1, "horizon": 5.0}, at.UNRESOLVED, at.HORIZON_REACHED),
    "horizon in the first slip": ({"belt": 0.1, "horizon": 14.0}, at.UNRESOLVED, at.HORIZON_REACHED),
    "budget spent": ({"belt": 0.1, "max_steps": 10}, at.UNRESOLVED, at.STEP_LIMIT),
    # Hold phases accumulate towards steady sliding, within a small budget.
    "Zeno": ({"belt": 0.3, "gamma": 0.4, "mu_stop": 1.0, "xi": 1.05, "eta": 0.02, "max_steps": 5000}, at.DAMPED,
             at.SETTLING_OBSERVED),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_motion_is_called_what_it_is(name):
    given_cell, regime, status = CASES[name]
    found = outcome(**given_cell)
    assert (found.regime, found.status) == (regime, status)
    assert (found.period > found.cycle_stick_time) == (regime in (at.STICK_SLIP, at.SUSTAINED))
    assert (found.settling_time > 0.0) == (regime in (at.DAMPED, at.CREEP))
    assert found.steps <= given_cell.get("max_steps", np.inf)
    if regime == at.STUCK:
        assert math.isnan(found.damping_ratio)
    if status == at.NEUTRAL_RINGING:
        assert found.period == pytest.approx(2 * math.pi, rel=1e-5)
        assert found.cycle_heat == pytest.approx(given_cell["curve"][0] * given_cell["belt"] * found.period, rel=1e-5)


def test_settling_time_is_when_the_amplitude_enters_the_band_for_good():
    """On a straight rising line the distance decays like e^(-zeta tau), and the band is 1e-4 of that at the start."""
    zeta = 0.05
    found = outcome(0.3, (0.5, 2 * zeta, 0.0, 1.0), rtol=1e-9)
    assert found.settling_time == pytest.approx(math.log(1e4) / zeta, rel=0.01)


def test_crossings_are_extrema_outside_the_band_on_alternate_sides():
    """xi - xi* is at first -slope b; then extrema follow with the ratio e^(-pi zeta/sqrt(1 - zeta^2))."""
    zeta, belt = 0.3, 1.0
    found = outcome(belt, (0.5, 2 * zeta, 0.0, 1.0))
    omega = math.sqrt(1 - zeta**2)
    p, dp = -2 * zeta * belt, belt
    phase = math.atan2(dp, zeta * (dp + zeta * p) / omega + omega * p) % math.pi
    first = math.exp(-zeta * phase / omega) * (p * math.cos(phase) + (dp + zeta * p) / omega * math.sin(phase))
    expected = 1 + math.floor(math.log(first / (1e-4 * math.hypot(p, dp))) / (math.pi * zeta / omega))
    assert found.crossings == expected


@pytest.mark.parametrize("row", [at.GAMMA, at.BELT, at.A1, at.A4, at.MU_STATIC, at.XI_START, at.HORIZON])
def test_a_cell_with_a_number_that_is_none_fails(row):
    column = cell(0.1)
    column[row] = NAN
    results = run(block_of(column))
    assert results[at.REGIME, 0] == at.FAILED
    assert results[at.STATUS, 0] == at.NOT_FINITE


STEEP = {"curve": (1.0, 0.05, 0.1, 1.0), "mu_stop": 0.2, "belt": 0.002}  # a slow belt on a steep, stiff line


def test_a_slip_that_sinks_to_the_belt_speed_on_the_line_stays_there():
    """The equilibrium on the line, by formula; a trough above the belt speed does not exist."""
    early, late = outcome(**STEEP), outcome(**STEEP, horizon=2e4, until=at.UNTIL_HORIZON)
    assert (early.regime, late.status) == (at.CREEP, at.HORIZON_REACHED)
    w_reversal = late.speed_max
    mu_reversal = 1.0 + 0.05 * w_reversal + 0.1 * math.exp(-w_reversal)
    assert late.mu_reversal == pytest.approx(mu_reversal, rel=1e-9)
    assert late.xi_end == pytest.approx(0.2 + (mu_reversal - 0.2) / w_reversal * 0.002, rel=1e-7)
    assert late.xi_end == pytest.approx(0.63230514, rel=1e-7)
    assert early.settling_time == pytest.approx(outcome(**STEEP, rtol=1e-10).settling_time, rel=1e-5)
    assert early.settling_time > 1000.0


def test_a_nearly_closed_gap_of_speed_does_not_start_an_endless_hold():
    stops = np.linspace(0.6, 0.66, 100)
    cells = block_of(*(cell(1.5, (0.6, 0.0, 0.12, 1.0), 2.0, mu_stop=m) for m in stops))
    loose, tight = run(cells), run(cells, rtol=1e-9)
    for results in (loose, tight):
        assert np.isin(results[at.REGIME], [at.DAMPED, at.CREEP]).all()
        assert (results[at.SETTLING_TIME] < 1e3).all()
    np.testing.assert_allclose(loose[at.SETTLING_TIME], tight[at.SETTLING_TIME], rtol=1e-4)


@pytest.mark.parametrize("start", [
    {"belt": 0.3, "eta": 0.1 + 0.2}, {"belt": 0.3, "eta": 0.3 - 1e-13}, {"belt": 0.1, "xi": -1.3 - 1e-13},
    {"belt": 0.1, "xi": -1.30001}, {"belt": 0.1, "xi": 1.2, "eta": 0.1 - 1e-7},
    {"belt": 0.1, "xi": 1.2, "eta": 0.1 - 1e-12},
])  # fmt: skip
def test_a_hysteretic_start_next_to_zero_slip_ends_in_the_cycle_of_its_neighbours(start):
    """The line from a tiny slip speed is as steep as one likes."""
    found, usual = outcome(**start, mu_stop=1.1), outcome(start["belt"], mu_stop=1.1)
    assert found.regime == usual.regime == at.STICK_SLIP
    assert found.period == pytest.approx(usual.period, rel=1e-6)


def test_the_metrics_of_a_cycle_do_not_remember_the_start():
    """mu_reversal and the crossings included: a map over the starting state shows one value per attractor."""
    stick, thrown = outcome(0.1, mu_stop=1.1), outcome(0.1, mu_stop=1.1, xi=-3.0, eta=0.05)
    for name in ("period", "mu_reversal", "xi_max", "xi_min", "cycle_heat", "crossings"):
        assert getattr(thrown, name) == pytest.approx(getattr(stick, name), rel=1e-6), name


def test_crossings_count_from_break_away_on():
    curve = (1.0, 1.6153312156673154, 0.0, 1.0)
    start = {"xi": 1.6929226106986421, "eta": -1.986517466054629}
    stick, thrown = outcome(0.14157028520416648, curve), outcome(0.14157028520416648, curve, **start)
    assert (thrown.regime, thrown.crossings) == (stick.regime, stick.crossings) == (at.DAMPED, 2)


def test_a_failed_cell_has_no_final_state():
    column = cell(0.1, (1.0, 0.1, 0.3, 1e-30), horizon=30.0)
    results = run(block_of(column), until=at.UNTIL_HORIZON)
    assert results[at.REGIME, 0] == at.FAILED
    assert np.isnan(results[[at.XI_END, at.ETA_END], 0]).all()


def test_metrics_do_not_depend_on_stopping_early():
    curves = ARTICLE, (0.5, 0.4, 0.0, 1.0)
    columns = [cell(b, curve, horizon=2e4, mu_stop=m) for b in (0.1, 0.3, 0.9) for curve in curves for m in (NAN, 0.5)]
    columns.append(cell(**STEEP, horizon=3e4))
    early, full = (run(block_of(*columns), until=end) for end in (at.UNTIL_METRICS, at.UNTIL_HORIZON))
    decided = early[at.STATUS] != at.HORIZON_REACHED
    assert decided.all()
    rows = [at.REGIME, at.PERIOD, at.XI_MAX, at.XI_MIN, at.SPEED_MAX, at.CROSSINGS, at.CYCLE_HEAT]
    np.testing.assert_array_equal(early[rows], full[rows])
    # turn by turn to the horizon, else by the amplitude map
    np.testing.assert_allclose(early[at.SETTLING_TIME], full[at.SETTLING_TIME], rtol=1e-6)


def test_no_regime_without_a_horizon_is_left_open_on_the_articles_map():
    cells = block_of(*(cell(b, gamma=g) for b in np.linspace(0.02, 1.2, 60) for g in (0.0, 0.05, 3.0)))
    assert set(run(cells)[at.REGIME]) == {at.STICK_SLIP, at.DAMPED, at.CREEP}
    assert np.isinf(cells[at.HORIZON]).all() and cell(0.1)[at.HORIZON] == INF
