"""Rate-and-state contacts against reference cycles, linear theory and themselves.

tests/data/rate_and_state.csv was solved without our code, by collocation (Radau IIA, order 13).
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from helpers.kernel_runs import NAN, run
from helpers.nightly import few
from stickslip.theory import contacts
from stickslip_kernels import layout as at
from stickslip_kernels.rosenbrock import RODAS_5P

TABLE = Path(__file__).parents[1] / "data" / "rate_and_state.csv"
NAMES = ("N", "m", "k", "c", "v_b", "mu0", "v0", "a", "b", "Dc")
LAWS = {"ageing": "rate_state_ageing", "slip": "rate_state_slip"}
EVERY_LAW = pytest.mark.parametrize("law", few(LAWS, 1))


def table(law):
    """Reference cells with mass, and their numbers."""
    listed = csv.DictReader(TABLE.read_text().splitlines())
    rows = [row for row in listed if row["law"] == law and float(row["m"]) > 0.0]
    numbers = {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0] if name not in WORDS}
    return [row["id"] for row in rows], numbers


WORDS = ("id", "law", "regime", "note")


def columns(p, xi=0.0, eta=NAN):
    """Cells in kernel units from columns of the table."""
    per_speed = np.sqrt(p["k"] * p["m"]) / p["N"]
    cells = np.zeros((at.CELL_ROWS, p["k"].size))
    cells[at.GAMMA], cells[at.BELT] = p["c"] / np.sqrt(p["k"] * p["m"]), p["v_b"] * per_speed
    cells[at.OWN_0], cells[at.OWN_1], cells[at.OWN_2] = p["mu0"], p["a"], p["b"]
    cells[at.OWN_3], cells[at.OWN_4] = p["Dc"] * p["k"] / p["N"], p["v0"] * per_speed
    cells[at.XI_START], cells[at.ETA_START], cells[at.HORIZON] = xi, eta, np.inf
    return cells


def draw(count, seed):
    """Over decades; half of them near where steady sliding loses its stability."""
    random = np.random.default_rng(seed)
    low = {"N": 0, "m": -2, "c": -4, "v_b": -7, "mu0": -1, "v0": -7, "a": -2.5, "b": -2.5, "Dc": -7}
    high = {"N": 3, "m": 2, "c": 1, "v_b": -1, "mu0": 0, "v0": -5, "a": -1.5, "b": -1.2, "Dc": -5}
    p = {name: 10 ** random.uniform(low[name], high[name], count) for name in low}
    p["c"][::3] = 0.0
    p["k"] = 10 ** random.uniform(2, 6, count)
    critical = contacts.critical_stiffness(p["m"], slopes(p))
    near = (random.random(count) < 0.5) & (critical > 0.0)
    side = random.choice([-1.0, 1.0], count) * 10 ** random.uniform(-2, -0.5, count)
    p["k"] = np.where(near, critical * (1.0 + side), p["k"])
    return p


def slopes(p):
    return contacts.rate_state_slopes(*(p[name] for name in ("c", "N", "v_b", "a", "b", "Dc")))


def growth(p):
    return contacts.small_motions(p["m"], p["k"], slopes(p))


def test_the_nodes_of_the_method_follow_from_its_matrices():
    """Those that Steinebach lists."""
    nodes, weights = RODAS_5P.nodes_and_time_weights()
    known = (0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0)
    np.testing.assert_allclose(nodes, known, atol=2e-14)
    known = (0.2119375631942901, -0.4238751263885803, -0.3384627126235924, 1.8046452872882734, 2.325825639765069)
    np.testing.assert_allclose(weights, (*known, 0.0, 0.0, 0.0), atol=2e-14)


@pytest.mark.parametrize(("rtol", "off"), [(1e-6, 1e-5), (1e-8, 1e-7)])
@EVERY_LAW
def test_reference_cycles(law, rtol, off):
    names, p = table(law)
    found, cycles = run(columns(p), rtol, law=LAWS[law]), np.isfinite(p["period"])
    assert [name for name, cycle in zip(names, cycles, strict=True) if not cycle] == ["S7"] * (law == "slip")
    assert (found[at.REGIME, ~cycles] == at.DAMPED).all()
    sticks = np.exp(p["ln_w_min_over_vb"]) < 1e-3
    np.testing.assert_array_equal(found[at.REGIME, cycles], np.where(sticks, at.STICK_SLIP, at.SUSTAINED)[cycles])
    speed, time = p["N"] / np.sqrt(p["k"] * p["m"]), np.sqrt(p["m"] / p["k"])
    slowest, least = found[at.SLOWEST_SLIP] * speed, p["ln_w_min_over_vb"]
    for ours, exact, most in (
        (found[at.PERIOD] * time, p["period"], off), (found[at.CYCLE_XI_MAX] * p["N"], p["F_max"], off),
        (found[at.CYCLE_XI_MIN] * p["N"], p["F_min"], off), (np.log(slowest / p["v_b"]), least, 10 * off),
        (found[at.CYCLE_SPEED_RANGE] * speed + slowest, p["w_max"], 10 * off),
    ):  # fmt: skip
        np.testing.assert_allclose(ours[cycles], exact[cycles], rtol=most)


def test_a_cycle_without_mass_is_the_limit_of_small_masses():
    """Q1, quasi-dynamic, in proportion to the mass: at mass numbers m v^2/(a N D_c) of 2e-10 and 2e-13."""
    (row,) = (row for row in csv.DictReader(TABLE.read_text().splitlines()) if float(row["m"]) == 0.0)
    known = {name: float(row[name]) for name in (*NAMES, "period", "w_max", "w_min")}
    p = {name: np.full(2, known[name]) for name in NAMES} | {"m": np.array([1.0, 1e-3])}
    found = run(columns(p), 1e-8, law=LAWS["ageing"])
    time, speed = np.sqrt(p["m"] / p["k"]), p["N"] / np.sqrt(p["k"] * p["m"])
    slowest = found[at.SLOWEST_SLIP] * speed
    for ours, exact, per_mass in (
        (found[at.PERIOD] * time, known["period"], 1.2e-3), (slowest, known["w_min"], 1e-2),
        (found[at.CYCLE_SPEED_RANGE] * speed + slowest, known["w_max"], 1e-2),
    ):  # fmt: skip
        np.testing.assert_array_less(np.abs(ours / exact - 1.0), per_mass * p["m"] + 1e-6)


@EVERY_LAW
def test_steady_sliding_is_the_answer_only_where_small_motions_decay(law):
    p = draw(600, 3)
    found = run(columns(p), max_steps=3e4, law=LAWS[law])
    rests = np.isin(found[at.REGIME], (at.DAMPED, at.CREEP))
    assert rests.sum() > 150 and np.isin(found[at.REGIME], (at.STICK_SLIP, at.SUSTAINED)).sum() > 150
    assert (growth(p).growth[rests] < 0.0).all()
    assert np.isin(found[at.REGIME], (at.FAILED, at.STUCK, at.NOT_COMPUTED)).sum() == 0
    assert (found[at.REGIME] == at.UNRESOLVED).mean() < 0.08  # they grow, or shrink, by a tolerance a loop


@EVERY_LAW
def test_small_motions_do_as_linear_theory_says(law):
    """Started a thousandth off steady sliding: they come to rest, or to a cycle."""
    p = draw(300, 4)
    mu = p["mu0"] + (p["a"] - p["b"]) * np.log(p["v_b"] / p["v0"])
    p = {name: values[mu > 0.05] for name, values in p.items()}
    mu, speed = mu[mu > 0.05], np.sqrt(p["k"] * p["m"]) / p["N"]
    found = run(columns(p, mu * (1.0 + 1e-3 * p["a"]), 1e-3 * p["v_b"] * speed), max_steps=3e4, law=LAWS[law])
    decay, decided = growth(p).growth < 0.0, found[at.REGIME] != at.UNRESOLVED
    assert decided.mean() > 0.95 and 0.1 < decay.mean() < 0.9
    rests = np.isin(found[at.REGIME], (at.DAMPED, at.CREEP))
    np.testing.assert_array_equal(rests[decided], decay[decided])


@EVERY_LAW
def test_regimes_near_the_critical_stiffness_are_those_of_a_tighter_tolerance(law):
    p, random = draw(500, 11), np.random.default_rng(1)
    critical = contacts.critical_stiffness(p["m"], slopes(p))
    p = {name: values[critical > 0.0] for name, values in p.items()}
    side = random.choice([-1.0, 1.0], p["k"].size) * 10 ** random.uniform(-3, -1, p["k"].size)
    p["k"] = critical[critical > 0.0] * (1.0 + side)
    found, tight = (run(columns(p), rtol, max_steps=steps, law=LAWS[law]) for rtol, steps in ((1e-6, 3e4), (1e-8, 1e5)))
    both = (found[at.REGIME] != at.UNRESOLVED) & (tight[at.REGIME] != at.UNRESOLVED)
    assert both.mean() > 0.75
    np.testing.assert_array_equal(found[at.REGIME, both], tight[at.REGIME, both])
    cycles = both & np.isin(found[at.REGIME], (at.STICK_SLIP, at.SUSTAINED))
    np.testing.assert_allclose(found[at.PERIOD, cycles], tight[at.PERIOD, cycles], rtol=1e-3)


@EVERY_LAW
def test_loops_with_much_inertia_are_few_steps_by_series(law):
    """Rosenbrock steps are five times as many here."""
    p = draw(300, 12)
    p["v_b"] = np.sqrt(100.0 * p["a"] * p["N"] * p["Dc"] / p["m"])
    p["k"] = 0.7 * contacts.critical_stiffness(p["m"], slopes(p))
    p = {name: values[p["k"] > 0.0] for name, values in p.items()}
    found, tight = (run(columns(p), rtol, max_steps=3e4, law=LAWS[law]) for rtol in (1e-6, 1e-9))
    cycles = np.isin(found[at.REGIME], (at.STICK_SLIP, at.SUSTAINED)) & (tight[at.REGIME] == found[at.REGIME])
    assert cycles.mean() > 0.95 and found[at.STEPS].mean() < 1000.0
    np.testing.assert_allclose(found[at.PERIOD, cycles], tight[at.PERIOD, cycles], rtol=1e-6)


@EVERY_LAW
def test_motions_that_hardly_grow_or_shrink_end_as_linear_theory_says(law):
    """Inertia so large that thousands of loops change little; from a tenth of the belt speed off to rest or a cycle."""
    ratio, speed = (axis.ravel() for axis in np.meshgrid([0.3, 0.8, 1.25, 3.0], np.geomspace(3e-3, 8e-3, 8)))
    one = dict(zip(NAMES, (10.0, 1.0, 0.0, 0.0, 0.0, 0.6, 1e-6, 0.01, 0.018, 1e-6), strict=True))
    p = {name: np.full(speed.size, value) for name, value in one.items()} | {"v_b": speed}
    p["k"] = ratio * contacts.critical_stiffness(p["m"], slopes(p))
    mu, unit = p["mu0"] + (p["a"] - p["b"]) * np.log(speed / p["v0"]), np.sqrt(p["k"] * p["m"]) / p["N"]
    cells = columns(p, mu, 0.1 * speed * unit)
    found = run(cells, max_steps=1e5, law=LAWS[law])
    small = growth(p)
    assert (np.abs(small.growth / small.frequency) < 0.02).all()
    rests = np.isin(found[at.REGIME], (at.DAMPED, at.CREEP))
    np.testing.assert_array_equal(rests, small.growth < 0.0)
    assert np.isin(found[at.REGIME, ~rests], (at.STICK_SLIP, at.SUSTAINED)).all()
    # Of the amplitude, 0.1 of the belt speed, a ten-thousandth of the largest is left; friction is not linear at first.
    left = np.log(1e-4) / small.growth[rests] * np.sqrt(p["k"] / p["m"])[rests]
    np.testing.assert_allclose(found[at.SETTLING_TIME, rests], left, rtol=0.4)


@EVERY_LAW
def test_the_regime_alone_is_that_of_all_metrics(law):
    cells = columns(draw(400, 21))
    alone, found = (
        run(cells, max_steps=3e4, until=until, law=LAWS[law]) for until in (at.UNTIL_REGIME, at.UNTIL_METRICS)
    )
    np.testing.assert_array_equal(alone[at.REGIME], found[at.REGIME])
    cycles = np.isin(found[at.REGIME], (at.STICK_SLIP, at.SUSTAINED))
    assert (alone[at.STEPS, cycles] <= found[at.STEPS, cycles]).all() and alone[at.STEPS].sum() < found[at.STEPS].sum()


@EVERY_LAW
def test_speeds_of_plates_are_no_smaller_matter(law):
    """Ten times softer and stiffer than critical, from 1e-13 to 1e-6 m/s."""
    speeds = np.repeat(10.0 ** np.arange(-13.0, -5.0), 2)
    one = dict(zip(NAMES, (10.0, 1.0, 0.0, 0.0, 0.0, 0.6, 1e-6, 0.01, 0.018, 1e-6), strict=True))
    p = {name: np.full(speeds.size, value) for name, value in one.items()} | {"v_b": speeds}
    p["k"] = np.tile([8e3, 8e5], speeds.size // 2)
    found = run(columns(p), law=LAWS[law])
    rests = np.isin(found[at.REGIME], (at.DAMPED, at.CREEP))
    np.testing.assert_array_equal(rests, np.tile([False, True], speeds.size // 2))
    assert np.isin(found[at.REGIME, ::2], (at.STICK_SLIP, at.SUSTAINED)).all()


def test_a_cell_is_the_same_in_any_company():
    p = draw(200, 5)
    cells, order = columns(p), np.random.default_rng(6).permutation(200)
    whole, alone = (
        run(cells, max_steps=1e4, law=LAWS["ageing"]),
        run(cells[:, :1].copy(), max_steps=1e4, law=LAWS["ageing"]),
    )
    mixed = run(np.ascontiguousarray(cells[:, order]), max_steps=1e4, law=LAWS["ageing"])
    np.testing.assert_array_equal(mixed, whole[:, order])
    np.testing.assert_array_equal(alone[:, 0], whole[:, 0])
