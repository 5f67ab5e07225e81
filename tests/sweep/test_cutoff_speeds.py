"""Cut-offs of rate-and-state friction: against the formula as it is usually written, and SciPy.

mu_* - a ln(1 + v_1/w) + b ln(1 + v_2 theta/D_c), with mu_* such that friction in steady sliding at v_0 is mu_0.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

import stickslip
from stickslip import engine
from stickslip.config.grid import build_grid
from stickslip.engine import Options
from stickslip.vocabulary.cells import as_cells

LAWS = ("rate_state_ageing", "rate_state_slip")
CUTS = ("direct_cutoff_speed", "evolution_cutoff_speed")
ROCK = {
    "mass": 1.0, "stiffness": 2e4, "normal_load": 10.0, "mu_0": 0.6, "v_0": 1e-6, "a": 0.010, "b": 0.018, "D_c": 1e-6,
    "belt_speed": 1e-4,
}  # fmt: skip


def friction(p, slip, state):
    """Of slip speeds and states, which may be complex."""
    v_1, v_2 = (1e15 if np.isnan(p[name]) else p[name] for name in CUTS)
    constant = p["mu_0"] + p["a"] * np.log1p(v_1 / p["v_0"]) - p["b"] * np.log1p(v_2 / p["v_0"])
    return constant - p["a"] * np.log(1.0 + v_1 / slip) + p["b"] * np.log(1.0 + v_2 * state / p["D_c"])


def draw(n, seed):
    random = np.random.default_rng(seed)

    def decades(low, high):
        return 10.0 ** random.uniform(low, high, n)

    p = {"normal_load": decades(-1, 4), "D_c": decades(-7, -3), "a": decades(-3, -1.3), "belt_speed": decades(-7, 0)}
    p |= {name: np.where(random.random(n) < 0.8, p["belt_speed"] * decades(-3, 3), np.nan) for name in CUTS}
    p |= {"b": p["a"] * random.uniform(0.2, 4.0, n), "mu_0": np.full(n, 0.6), "v_0": decades(-8, -3)}
    p["mass"] = decades(-6, 3) * p["a"] * p["normal_load"] * p["D_c"] / p["belt_speed"] ** 2
    p["stiffness"] = decades(-2, 2) * p["b"] * p["normal_load"] / p["D_c"]
    p["damping"] = np.where(random.random(n) < 0.5, 0.0, decades(-3, 0)) * p["a"] * p["normal_load"] / p["belt_speed"]
    return p


def single(p, i):
    return {name: float(values[i]) for name, values in p.items()}


def growth(p, law, stiffness):
    """The leading eigenvalue of small motions in spring force, ln w and ln theta: of complex differences."""
    m, v, load, distance, step = p["mass"], p["belt_speed"], p["normal_load"], p["D_c"], 1e-30

    def rates(force, slip, state):
        w, theta = v * np.exp(slip), distance / v * np.exp(state)
        z = w * theta / distance
        pull = force - p["damping"] * w - load * friction(p, w, theta)
        follows = (1.0 - z) / theta if law == LAWS[0] else -w / distance * np.log(z)
        return stiffness * (v - w), pull / (m * w), follows

    steady = p["damping"] * v + load * friction(p, v, distance / v)
    moved = np.array([steady, 0.0, 0.0]) + 1j * step * np.diag([load, 1.0, 1.0])
    columns = [np.imag(rates(*one)) / step for one in moved]
    roots = np.linalg.eigvals(np.array(columns).T / np.array([[load], [1.0], [1.0]]))
    return roots[np.argmax(roots.real)], np.abs(roots).max()


def test_friction_in_steady_sliding_is_that_of_the_formula():
    p = draw(10_000, 1)
    ours = engine.friction_at_belt_speed(as_cells(p, LAWS[0]), Options(law=LAWS[0]))
    exact = np.array(
        [
            friction(one, one["belt_speed"], one["D_c"] / one["belt_speed"])
            for one in (single(p, i) for i in range(10_000))
        ]
    )
    np.testing.assert_allclose(ours, exact, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("law", LAWS)
def test_linear_theory_is_that_of_the_equations_of_motion(law):
    """Growth of random cells, and the stiffness where it vanishes."""
    p, borders = draw(300, 2), 0
    cells, options = as_cells(p, law), Options(law=law)
    rates, turns, critical = (
        engine.by_theory(name, cells, options) for name in ("growth_rate", "growth_frequency", "critical_stiffness")
    )
    for i in range(300):
        one = single(p, i)
        leading, largest = growth(one, law, one["stiffness"])
        assert abs(rates[i] - leading.real) < 1e-8 * largest and abs(turns[i] - abs(leading.imag)) < 1e-6 * largest
        if (
            critical[i] > 0.0
            and one["mass"] * one["belt_speed"] ** 2 > 1e-3 * one["a"] * one["normal_load"] * one["D_c"]
        ):
            found = brentq(
                lambda k, one=one: growth(one, law, k)[0].real,
                0.9 * critical[i],
                1.1 * critical[i],
                xtol=1e-300,
                rtol=1e-13,
            )
            assert found == pytest.approx(critical[i], rel=1e-8)
            borders += 1
    assert borders > 30


@pytest.mark.parametrize("law", LAWS)
def test_cells_without_cut_offs_keep_their_kernels(law):
    system = {name: ROCK[name] for name in ("mass", "stiffness", "normal_load", "belt_speed")}
    pair = {name: ROCK[name] for name in ("mu_0", "v_0", "a", "b", "D_c")} | {"law": law}
    for along, names in (
        ({"stiffness": [1e4, 2e4]}, {law}),
        ({CUTS[0]: ["1 mm/s", "1 m/s"]}, {f"{law}_cut_off"}),
        ({CUTS[1]: ["none", "1 m/s"]}, {law, f"{law}_cut_off"}),
    ):
        axes = {name: {"values": values} for name, values in along.items()}
        fixed = {name: value for name, value in system.items() if name not in axes}
        config = stickslip.load_config({"system": fixed, "friction": pair, "axes": axes})
        assert set(engine.kernels_for(build_grid(config), Options(law=law))) == names
