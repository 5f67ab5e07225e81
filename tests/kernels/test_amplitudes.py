"""Settling by the amplitude map: as when every turn is followed, and as SciPy has it. Cycles: test_first_returns.py."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers.kernel_runs import NAN, block_of, cell, outcome, run
from helpers.nightly import few
from stickslip_kernels import layout as at

BAND_SHARE = 1e-4
LAWS = few(["stribeck", "stribeck_delta", "gaussian", "rational", "cubic"], 1)


def draw(law, count, hysteretic=False):
    """Cells over decades whose steady sliding is weakly damped."""
    random = np.random.default_rng(sum(map(ord, law)))
    columns = []
    while len(columns) < count:
        a2, a3, a4 = 10 ** random.uniform([-2.5, -1.5, -1.5], [-0.5, 0.0, 0.3])
        gamma = 10 ** random.uniform(-3.5, -1.0)
        column = cell(
            10 ** random.uniform(-1.0, 0.7), (0.3, a2, a3, a4), gamma=gamma, delta=random.uniform(1.0, 2.5),
            mu_stop=0.3 + a3 * random.uniform(0.3, 1.0) if hysteretic else NAN,
        )  # fmt: skip
        ratio = run(block_of(column), max_steps=1, law=law)[at.DAMPING_RATIO, 0]
        if 3e-4 < ratio < 0.1:
            columns.append(column)
    return block_of(*columns)


def weakly_damped(law, rtol, hysteretic=False):
    """What is mapped of cells that settle, and the same followed: a run to the horizon follows every turn."""
    cells = draw(law, 60, hysteretic)
    mapped = run(cells, rtol, law=law)
    settled = mapped[at.REGIME] == at.DAMPED
    assert settled.sum() > 15
    cells, mapped = np.ascontiguousarray(cells[:, settled]), mapped[:, settled]
    cells[at.HORIZON] = 1.05 * (mapped[at.SETTLING_TIME] + np.fmax(mapped[at.BREAKAWAY_TIME], 0.0)) + 50.0
    return mapped, run(cells, 1e-10, until=at.UNTIL_HORIZON, law=law)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_settling_is_that_of_motions_whose_turns_are_followed(law, rtol):
    mapped, followed = weakly_damped(law, rtol)
    for row in (at.REGIME, at.CROSSINGS, at.XI_SETTLED):
        np.testing.assert_array_equal(mapped[row], followed[row])
    off = np.abs(mapped[at.SETTLING_TIME] / followed[at.SETTLING_TIME] - 1.0)
    assert (off <= 3.0 * rtol / followed[at.DAMPING_RATIO]).all()  # an error of the loss in a loop, over that loss
    for row in (at.XI_MAX, at.XI_MIN, at.SPEED_MAX, at.ACCELERATION_MAX):
        np.testing.assert_allclose(mapped[row], followed[row], rtol=30.0 * rtol, atol=30.0 * rtol)


def test_on_a_hysteretic_curve_too():
    mapped, followed = weakly_damped("stribeck", 1e-6, hysteretic=True)
    np.testing.assert_array_equal(mapped[at.CROSSINGS], followed[at.CROSSINGS])
    np.testing.assert_allclose(mapped[at.SETTLING_TIME], followed[at.SETTLING_TIME], rtol=3e-5)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-11])
def test_a_map_that_is_refused_costs_no_settling_time(rtol):
    """Its steps once counted as those of the loops, so that the way to the band seemed too long."""
    belts, turns = np.linspace(0.85, 1.3, 200), np.random.default_rng(0).uniform(1.0, 4.0, 200)
    found = run(block_of(*(cell(b * 10 ** (0.5 * k), (1.0, 0.1 * 10 ** (-0.5 * k), 0.3, 0.1 * 10 ** (0.5 * k)))
                           for b, k in zip(belts, turns, strict=True))), rtol, max_steps=1e5)  # fmt: skip
    assert (found[at.STATUS] == at.SETTLED).all() and not np.isnan(found[at.SETTLING_TIME]).any()


@pytest.mark.parametrize(("b", "a2", "a3", "a4", "gamma"), [
    (1.0, 0.1, 0.3, 0.1, 0.0), (2.0, 0.05, 0.2, 0.25, 0.0), (3.0, 0.0, 0.05, 0.3, 0.013),
])  # fmt: skip
def test_settling_is_that_of_scipy(b, a2, a3, a4, gamma):
    """The last time at which the motion is outside the settling band, and the turns outside of it."""
    found = run(block_of(cell(b, (0.3, a2, a3, a4), gamma=gamma)))[:, 0]

    def mu(w):
        return 0.3 + a2 * w + a3 * np.exp(-w / a4)

    def motion(_, state):
        u, v = state
        return [v, mu(b - v) - u - gamma * v]

    assert found[at.REGIME] == at.DAMPED
    steady, start = mu(b), np.array([0.3 + a3 - gamma * b, b])
    band = BAND_SHARE * np.hypot(start[0] - steady, b)
    away = np.array([start[0] + 1e-9, b * (1.0 - 1e-12)])
    end = 1.1 * found[at.SETTLING_TIME] + 20.0

    def leaves(_, state):
        return np.hypot(state[0] - steady, state[1]) - band

    def turns(_, state):
        return state[1]

    tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.2}
    solved = solve_ivp(motion, (0.0, end), away, events=[leaves, turns], **tight)
    assert found[at.SETTLING_TIME] == pytest.approx(solved.t_events[0][-1], rel=1e-5)
    extremes = solved.y_events[1][:, 0] - steady
    assert found[at.CROSSINGS] == pytest.approx(np.count_nonzero(np.abs(extremes) > band), abs=1)


LONG = {"belt": 3.0, "curve": (0.3, 0.0, 0.05, 0.3), "gamma": 0.013}  # hundreds of turns


def test_a_motion_of_hundreds_of_turns_takes_fewer_steps_than_turns_in_either_direction():
    found, backwards = (outcome(**LONG | {"belt": belt}) for belt in (3.0, -3.0))
    assert found.regime == at.DAMPED and found.crossings > 400 and found.steps < 0.6 * found.crossings
    for name in ("settling_time", "crossings", "steps"):
        assert getattr(backwards, name) == getattr(found, name)
    assert backwards.xi_settled == -found.xi_settled


def test_a_horizon_or_a_budget_on_the_way_ends_the_motion_there():
    horizon = 0.5 * outcome(**LONG).settling_time
    found, followed = (
        outcome(**LONG, horizon=horizon),
        outcome(**LONG, horizon=horizon, rtol=1e-10, until=at.UNTIL_HORIZON),
    )
    assert found.regime == at.UNRESOLVED and found.status == at.HORIZON_REACHED
    assert (found.xi_end, found.eta_end) == pytest.approx((followed.xi_end, followed.eta_end), abs=1e-5)
    for most in range(250, 420, 7):  # while the map is measured
        found = outcome(**LONG, max_steps=most)
        assert found.regime == at.DAMPED or found.status in (at.STEP_LIMIT, at.SETTLING_CERTAIN)
        assert abs(found.xi_end - 0.3) < 3.1


@pytest.mark.parametrize("law, start", [
    ((0.14951472361028434, 0.006636843187612295, 0.2753473876403419, 0.1917615437748621), (0.68395, 0.287481)),
    ((0.2684647225202667, 0.013013203769213978, 0.3600559217493875, 0.08138232136028141), (-0.0233615, -0.0813776)),
])  # fmt: skip
def test_motions_that_grow_into_stick_slip_have_its_period(law, start):
    """A map that began where loops grow met standstill, and left the time of a half loop behind."""
    belt, gamma, mu_static = (0.740963833, 0.0293643, 0.424862111) if start[0] > 0 else (0.50605, 0.0, 0.911364934)
    beside, from_rest = (
        run(block_of(cell(belt, law, gamma, mu_static, **state)))[:, 0]
        for state in ({"xi": start[0], "eta": start[1]}, {})
    )
    for row in (at.REGIME, at.PERIOD, at.CYCLE_STICK_TIME, at.RESTICK_MARGIN):
        np.testing.assert_allclose(beside[row], from_rest[row], rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_no_period_is_shorter_than_its_stick_phase(law):
    random, columns = np.random.default_rng(3), []
    for _ in range(40_000):
        a3, a4, belt = 10 ** random.uniform([-1.5, -2.0, -2.0], [-0.2, 0.5, 0.5])
        columns.append(cell(belt, (0.3, 10 ** random.uniform(-4.0, -1.0), a3, a4), 10 ** random.uniform(-4.0, -0.5),
                            xi=0.3 + random.normal(0.0, 2.0 * belt), eta=random.normal(0.0, belt)))  # fmt: skip
    found = run(block_of(*columns), max_steps=2e4, law=law)
    sticks = found[at.REGIME] == at.STICK_SLIP
    assert (found[at.PERIOD, sticks] > found[at.CYCLE_STICK_TIME, sticks]).all()
