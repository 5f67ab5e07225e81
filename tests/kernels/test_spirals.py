"""The regime alone: decided as soon as it is certain, and that of the whole motion."""

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from helpers.kernel_runs import NAN, block_of, cell, run
from helpers.nightly import few
from helpers.unstable_cycle import Cycle
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.laws import LAWS, relaxation


def draw(law, count, seed):
    """Cells over decades, half of them near where steady sliding loses its stability, half of them in motion."""
    random, columns = np.random.default_rng([seed, *map(ord, law)]), []
    for _ in range(count):
        a1, a3, belt = random.uniform(0.05, 0.6), random.uniform(0.02, 0.6), 10 ** random.uniform(-2.0, 0.7)
        a2, a4, gamma = 10 ** random.uniform([-4.0, -2.5, -5.0], [0.0, 0.7, 0.7])
        if random.random() < 0.15 and law != "cubic":
            a2, a3 = random.choice([-1.0, 1.0], 2) * (a2, a3)
        if random.random() < 0.5:
            steepest = a3 / a4 * np.exp(-belt / a4)
            gamma = max(0.0, (steepest - a2) * (1.0 + random.choice([-1.0, 1.0]) * 10 ** random.uniform(-4.0, -0.3)))
        moving = random.random() < 0.5
        columns.append(cell(
            belt, (a1, a2, a3, a4), gamma, mu_static=max(a1 + a3, 0.01) * random.choice([1.0, 1.3]),
            mu_stop=a1 * random.uniform(0.3, 1.5) if random.random() < 0.3 else NAN, delta=random.uniform(1.0, 2.5),
            ageing=0.05 * (random.random() < 0.15), xi=random.uniform(-3.0, 3.0) if moving else 0.0,
            eta=random.uniform(-2.0, 2.0) * belt if moving else NAN,
        ))  # fmt: skip
    return block_of(*columns)


def compare(law, count, seed):
    """Alone against followed to the end."""
    cells = draw(law, count, seed)
    full, alone = (run(cells, until=until, max_steps=2e4, law=law) for until in (at.UNTIL_METRICS, at.UNTIL_REGIME))
    decided = full[at.REGIME] != at.UNRESOLVED
    np.testing.assert_array_equal(alone[at.REGIME, decided], full[at.REGIME, decided])
    sticks = decided & (full[at.REGIME] == at.STICK_SLIP)
    np.testing.assert_allclose(alone[at.RESTICK_MARGIN, sticks], full[at.RESTICK_MARGIN, sticks], rtol=1e-4)
    off = (alone[at.RESTICK_MARGIN] - full[at.RESTICK_MARGIN])[decided] / np.abs(cells[at.BELT, decided])
    assert np.nanmax(np.abs(off)) < 1e-4
    damped = decided & (full[at.REGIME] == at.DAMPED)
    assert damped.sum() > count / 20 and alone[at.STEPS, damped].sum() < 0.9 * full[at.STEPS, damped].sum()


@pytest.mark.parametrize("law", few(LAWS, 1))
def test_the_regime_alone_is_that_of_the_motion_followed_to_its_end(law):
    compare(law, 1500, 1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("law", LAWS)
def test_the_same_of_many(law, seed):
    compare(law, 20_000, 100 + seed)


@pytest.mark.parametrize("law", LAWS)
def test_the_slope_is_concave_from_its_relaxation_on_and_no_sooner(law):
    @njit
    def begins(tag, delta):
        return relaxation(tag, delta)

    def slope(z, delta):
        z = z + 1e-30j
        shape = {
            "stribeck": np.exp(-z), "gaussian": np.exp(-(z**2)), "stribeck_delta": np.exp(-(z**delta)),
            "rational": 1.0 / (1.0 + z), "cubic": 1.0 - 1.5 * z + 0.5 * z**3,
        }  # fmt: skip
        return shape[law].imag / 1e-30

    for delta in (1.0, 1.3, 2.0, 3.5):
        start, h = begins(LAWS[law], delta), 1e-3
        if law == "cubic":
            assert start == np.inf  # convex everywhere
            continue
        z = start + np.linspace(2.0 * h, 8.0, 400)
        assert (slope(z - h, delta) + slope(z + h, delta) <= 2.0 * slope(z, delta) + 1e-14).all()
        if start > 0.0:
            z = start * 0.98
            assert slope(z - h, delta) + slope(z + h, delta) > 2.0 * slope(z, delta)


def test_on_either_side_of_the_unstable_cycle():
    """SciPy finds the cycle backwards in time."""
    belt, curve, gamma = 0.2, (0.3, 0.05, 0.2, 0.1), 0.25
    cycle = Cycle(belt, curve, gamma, 0.19)
    inside, outside = (
        cell(belt, curve, gamma, xi=cycle.steady + cycle.reach * (1.0 + off), eta=0.0) for off in (-1e-7, 1e-7)
    )
    found = run(block_of(inside, outside), 1e-9, until=at.UNTIL_REGIME)
    assert found[at.REGIME].tolist() == [at.DAMPED, at.STICK_SLIP]


@pytest.mark.slow
def test_a_slip_that_shrinks_about_steady_sliding_that_repels_is_sustained_at_once():
    """SciPy's loops shrink from outside and grow from inside, so slowly that no loop shows where they end."""
    belt, (a1, a2, a3, a4) = 3.3791907, (0.2428919, 0.0836061, 0.4298576, 4.3711071)
    found = run(block_of(cell(belt, (a1, a2, a3, a4), mu_static=0.74627997)), until=at.UNTIL_REGIME, law="gaussian")
    assert (found[at.REGIME], found[at.STATUS]) == (at.SUSTAINED, at.SLIP_CYCLE)
    assert found[at.STEPS] < 100

    def friction(w):
        return a1 + a2 * w + a3 * np.exp(-((w / a4) ** 2))

    def motion(_, state):
        return [state[1], friction(belt - state[1]) - state[0]]

    def at_rest(_, state):
        return state[1]

    at_rest.direction = -1.0

    def change(x, v):
        tight = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.1}
        done = solve_ivp(motion, (0.0, 130.0), [x, v], events=at_rest, **tight)
        turns = done.y_events[0][:, 0] - friction(belt)
        return turns[-1] - turns[1]

    assert change(0.74627997, belt) < 0.0 < change(friction(belt) + 0.05, 0.0)
