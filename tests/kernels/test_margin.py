"""`restick_margin`: the least slip speed of the slip after break-away, continued below zero, against SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers.kernel_runs import ARTICLE, block_of, cell, outcome, run
from helpers.nightly import few
from helpers.scipy_oscillator import SHAPES, TIGHT, Oscillator
from stickslip_kernels import layout as at

DISTANCES = 10.0 ** np.arange(-9.0, -1.5, 0.5)  # from a border, relative


def margin_by_scipy(belt, curve, gamma, mu_static, law="stribeck", delta=1.0):
    """Plain curve: the first trough of w after break-away, or the depth of the trough that sticking replaces."""
    a1, a2, a3, a4 = curve

    def motion(_, state):
        u, w = state
        return [belt - w, u + gamma * (belt - w) - a1 - a2 * w - a3 * SHAPES[law](w / a4, delta)]

    def turns(_, state):
        return motion(0, state)[1]

    def stands(_, state):
        return state[1]

    turns.terminal, turns.direction = True, 1
    stands.terminal, stands.direction = True, -1
    birth = 1e-3 * min(1.0, a4 / belt)
    away = solve_ivp(motion, (0, birth), [mu_static - gamma * belt, 0.0], **TIGHT)
    longest = min(0.05, a4)
    end = solve_ivp(motion, (0, 100), away.y[:, -1], events=(stands, turns), max_step=longest, **TIGHT)
    if len(end.t_events[0]):
        u = end.y_events[0][0][0]
        return -((a1 + a3 - u - gamma * belt) ** 2) / (2 * belt)
    return end.y_events[1][0][1]


def random_cells(n, law, seed):
    """Belt speeds, drops and widths of the curve over decades, with and without damper and more static friction."""
    draw = np.random.default_rng(seed)
    for _ in range(n):
        drop = 10 ** draw.uniform(-1.5, 0)
        belt = drop * 10 ** draw.uniform(-1, 1.5)
        a1, a2 = draw.uniform(0.2, 1.0), draw.choice([0.0, 0.05 * drop / belt])
        curve = (a1, a2, drop, belt * 10 ** draw.uniform(-2, 0.5))
        if law == "cubic":  # friction would fall below zero further out
            curve = (1.0, 0.0, drop, max(curve[3], 1.2 * belt))
        gamma = draw.choice([0.0, 10 ** draw.uniform(-3, -0.5)])
        more = draw.choice([0.0, 0.2 * drop])
        if curve[0] + drop > 1.1 * gamma * belt:  # else the damper tears it away
            yield belt, curve, gamma, curve[0] + drop + more


@pytest.mark.parametrize("law", few(SHAPES, ("stribeck",)))
def test_margin_is_the_first_trough_of_the_slip_speed_or_the_depth_of_the_one_sticking_replaces(law):
    delta = 2.0 if law == "stribeck_delta" else 1.0
    cases = list(random_cells(12, law, 7))
    found = run(block_of(*(cell(b, c, g, s, delta=delta) for b, c, g, s in cases)), rtol=1e-10, law=law)
    sides = set()
    for case, margin, regime in zip(cases, found[at.RESTICK_MARGIN], found[at.REGIME], strict=True):
        exact = margin_by_scipy(*case, law, delta)
        assert margin == pytest.approx(exact, rel=1e-7, abs=1e-9 * case[0]), case
        assert (margin < 0) == (regime == at.STICK_SLIP), case
        sides.add(margin < 0)
    assert sides == {True, False}


def test_on_a_hysteretic_curve_margin_is_the_least_trough_on_the_line_or_the_depth_of_the_one_it_replaces():
    draw, sides = np.random.default_rng(3), []
    while len(sides) < 12:
        belt, gamma, mu_stop = 10 ** draw.uniform(-0.7, 0.1), draw.choice([0.0, 0.05]), draw.uniform(1.0, 1.3)
        exact = Oscillator(belt, 40.0 + 2.6 / belt, gamma=gamma, mu_stop=mu_stop)
        slip = [n for n, phase in enumerate(exact.phases) if phase[1] == "stick"][:2]
        troughs = [belt - v for _, name, _, v in exact.phases[1:] if name in ("hold", "rise") and v != belt]
        if len(slip) == 2:  # re-stuck, from a fall
            _, _, xi, _ = exact.phases[slip[1]]
            assert exact.phases[slip[1] - 1][1] == "fall"
            expected = -((mu_stop - xi - gamma * belt) ** 2) / (2 * belt)
        elif troughs:
            expected = min(troughs)
        else:
            continue
        found = outcome(belt, gamma=gamma, mu_stop=mu_stop, rtol=1e-10)
        assert found.restick_margin == pytest.approx(expected, rel=1e-7, abs=1e-9)
        sides.append(found.restick_margin < 0)
    assert 3 < sum(sides) < 9


def border_of(make, low, high, law):
    """Where cells stop to stick-slip between two belt speeds, by the regimes of 64 cells, again and again."""
    for _ in range(10):
        belts = np.linspace(low, high, 64)
        sticks = run(block_of(*map(make, belts)), rtol=1e-12, law=law)[at.REGIME] == at.STICK_SLIP
        last = np.flatnonzero(sticks)[-1]
        low, high = belts[last], belts[min(last + 1, 63)]
    return 0.5 * (low + high)


@pytest.mark.parametrize(("law", "extra", "between"), [
    ("stribeck", {}, (0.3, 2.0)),
    ("stribeck", {"gamma": 0.05}, (0.3, 2.0)),
    ("stribeck", {"mu_static": 1.4}, (0.3, 2.0)),
    ("stribeck", {"mu_stop": 1.1}, (0.3, 2.0)),
    ("stribeck", {"mu_stop": 1.2, "gamma": 0.03}, (0.3, 2.0)),
    ("stribeck", {"curve": (1.0, 0.1, 0.3, 0.01)}, (0.05, 2.0)),
    ("stribeck", {"curve": (0.3, 0.0, 0.0, 1.0), "mu_static": 0.45, "gamma": 0.1}, (0.01, 3.0)),
    pytest.param("stribeck_delta", {"delta": 2.0}, (0.05, 2.0), marks=pytest.mark.slow),
    pytest.param("rational", {}, (0.05, 2.0), marks=pytest.mark.slow),
])  # fmt: skip
def test_margin_has_a_simple_zero_where_stick_slip_ends_by_grazing(law, extra, between):
    def make(belt):
        return cell(belt, **extra)

    border = border_of(make, *between, law)
    belts = border * np.concatenate([1 - DISTANCES[::-1], 1 + DISTANCES])
    found = run(block_of(*map(make, belts)), rtol=1e-12, law=law)
    margin, below = found[at.RESTICK_MARGIN], belts < border
    np.testing.assert_array_equal(found[at.REGIME] == at.STICK_SLIP, below)
    np.testing.assert_array_equal(margin < 0, below)
    assert (np.diff(margin) > 0).all()
    slope = margin / (belts - border)
    near = np.abs(belts / border - 1) < 2e-8  # alike on both sides, but for weakening friction
    _, _, a3, a4 = extra.get("curve", ARTICLE)
    stick_time = np.sqrt(-2 * margin[near & below][::-1] / border)
    off = np.abs(slope[near & below][::-1] / slope[near & ~below] - 1)
    assert (off < 0.02 + 0.5 * a3 / a4 * stick_time).all()
    at_border = np.interp(0.0, margin[near], belts[near])
    assert at_border == pytest.approx(border, rel=1e-9)


def test_the_margin_of_a_slip_that_settles_without_a_trough_is_the_belt_speed():
    """Across the damping at which the trough sinks into the approach, it passes there without a jump."""
    found = run(block_of(*(cell(0.5, (1.0, a2, 0.0, 1.0), mu_static=1.1) for a2 in np.linspace(0.5, 3.0, 200))), 1e-9)
    margin = found[at.RESTICK_MARGIN]
    assert (np.diff(margin) >= -1e-9).all() and np.diff(margin).max() < 0.05
    assert (margin[-50:] == 0.5).all() and margin[0] < 0.49


def test_margin_is_below_zero_exactly_where_a_cell_stick_slips_whatever_the_friction():
    draw, n = np.random.default_rng(11), 3000
    cells = []
    for _ in range(n):
        hysteretic, ageing = draw.random() < 0.4, draw.random() < 0.3
        belt = 10 ** draw.uniform(-2, 1)
        curve = (1.0, draw.choice([0.0, 0.1]), 10 ** draw.uniform(-1.5, 0.5), 10 ** draw.uniform(-2, 0))
        more = {"mu_stop": draw.uniform(0.8, 1 + curve[2])} if hysteretic else {}
        more |= {"ageing": 10 ** draw.uniform(-3, -1), "ageing_time": 10 ** draw.uniform(-2, 1)} if ageing else {}
        mu_static = curve[0] + curve[2] * draw.choice([1, 1.3])
        cells.append(cell(belt, curve, draw.choice([0.0, 0.03, 0.3]), mu_static, **more))
    found = run(block_of(*cells), 1e-8)
    margin, regime = found[at.RESTICK_MARGIN], found[at.REGIME]
    known = (regime != at.UNRESOLVED) & ~np.isnan(found[at.BREAKAWAY_TIME])
    assert known.mean() > 0.9 and not np.isnan(margin[known]).any()
    np.testing.assert_array_equal(margin[known] < 0, regime[known] == at.STICK_SLIP)
    assert np.isnan(margin[~known]).all()


@pytest.mark.parametrize("start", [
    {"belt": 0.9, "xi": 1.0, "eta": 0.2},  # settles as it began, in slip
    {"belt": 0.0, "xi": 0.5},  # sticks for ever
    {"belt": 2.0, "gamma": 1.0},  # torn away at once
    {"belt": 0.3, "horizon": 3.0},  # not seen to its end
])  # fmt: skip
def test_without_a_slip_after_a_break_away_there_is_no_margin(start):
    assert np.isnan(outcome(**start).restick_margin)


def test_a_cell_that_starts_in_slip_has_the_margin_of_the_cycle_it_ends_in():
    assert outcome(0.3, xi=3.0, eta=-1.0).restick_margin == pytest.approx(outcome(0.3).restick_margin, rel=1e-5)
