"""Rate-and-state contacts against reference cycles, linear theory and themselves.

tests/data/rate_and_state.csv was solved without our code, by collocation (Radau IIA, order 13).
"""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from helpers.kernel_runs import NAN, columns_of, run
from helpers.nightly import few
from stickslip.theory import contacts
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.implicit import RODAS_5P

TABLE = pd.read_csv(Path(__file__).parents[1] / "data" / "rate_and_state.csv")
NAMES = ("N", "m", "k", "c", "v_b", "mu0", "v0", "a", "b", "Dc")
LAWS = {"ageing": "rate_state_ageing", "slip": "rate_state_slip"}
EVERY_LAW = pytest.mark.parametrize("law", few(LAWS.values(), 1))
PLATE = dict(zip(NAMES, (10.0, 1.0, 0.0, 0.0, 0.0, 0.6, 1e-6, 0.01, 0.018, 1e-6), strict=True))
CYCLES, RESTS = (at.STICK_SLIP, at.SUSTAINED), (at.DAMPED, at.CREEP)


def columns(p, xi=0.0, eta=NAN):
    """Cells in kernel units from columns of the table."""
    root = np.sqrt(p["k"] * p["m"])
    return columns_of(
        gamma=p["c"] / root, belt=p["v_b"] * root / p["N"], own_0=p["mu0"], own_1=p["a"], own_2=p["b"],
        own_3=p["Dc"] * p["k"] / p["N"], own_4=p["v0"] * root / p["N"], xi_start=xi, eta_start=eta,
    )  # fmt: skip


def units(p):
    """What a time and a speed of the kernels are in SI."""
    return np.sqrt(p["m"] / p["k"]), p["N"] / np.sqrt(p["k"] * p["m"])


def plates(n, **values):
    """So many cells, but for some quantities."""
    return {name: np.full(n, value) for name, value in PLATE.items()} | values


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
@pytest.mark.parametrize("law", few(LAWS, 1))
def test_reference_cycles(law, rtol, off):
    p = TABLE[(TABLE["law"] == law) & (TABLE["m"] > 0.0)]
    found, cycles = run(columns(p), rtol, law=LAWS[law]), p["period"].notna().to_numpy()
    assert p["id"][~cycles].tolist() == ["S7"] * (law == "slip")
    assert (found[at.REGIME, ~cycles] == at.DAMPED).all()
    sticks = np.exp(p["ln_w_min_over_vb"]) < 1e-3
    np.testing.assert_array_equal(found[at.REGIME, cycles], np.where(sticks, *CYCLES)[cycles])
    time, speed = units(p)
    slowest = found[at.SLOWEST_SLIP] * speed
    for ours, exact, most in (
        (found[at.PERIOD] * time, "period", off), (found[at.CYCLE_XI_MAX] * p["N"], "F_max", off),
        (found[at.CYCLE_XI_MIN] * p["N"], "F_min", off), (np.log(slowest / p["v_b"]), "ln_w_min_over_vb", 10 * off),
        (found[at.CYCLE_SPEED_RANGE] * speed + slowest, "w_max", 10 * off),
    ):  # fmt: skip
        np.testing.assert_allclose(ours[cycles], p[exact][cycles], rtol=most)


def test_a_cycle_without_mass_is_the_limit_of_small_masses():
    """Q1, quasi-dynamic, in proportion to the mass: at mass numbers m v^2/(a N D_c) of 2e-10 and 2e-13."""
    ((_, known),) = TABLE[TABLE["m"] == 0.0].iterrows()
    p = {name: np.full(2, float(known[name])) for name in NAMES} | {"m": np.array([1.0, 1e-3])}
    found, (time, speed) = run(columns(p), 1e-8, law=LAWS["ageing"]), units(p)
    slowest = found[at.SLOWEST_SLIP] * speed
    for ours, exact, per_mass in (
        (found[at.PERIOD] * time, known["period"], 1.2e-3), (slowest, known["w_min"], 1e-2),
        (found[at.CYCLE_SPEED_RANGE] * speed + slowest, known["w_max"], 1e-2),
    ):  # fmt: skip
        np.testing.assert_array_less(np.abs(ours / exact - 1.0), per_mass * p["m"] + 1e-6)


@EVERY_LAW
def test_steady_sliding_is_the_answer_only_where_small_motions_decay(law):
    p = draw(600, 3)
    found = run(columns(p), max_steps=3e4, law=law)
    rests = np.isin(found[at.REGIME], RESTS)
    assert rests.sum() > 150 and np.isin(found[at.REGIME], CYCLES).sum() > 150
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
    found = run(columns(p, mu * (1.0 + 1e-3 * p["a"]), 1e-3 * p["v_b"] * speed), max_steps=3e4, law=law)
    decay, decided = growth(p).growth < 0.0, found[at.REGIME] != at.UNRESOLVED
    assert decided.mean() > 0.95 and 0.1 < decay.mean() < 0.9
    rests = np.isin(found[at.REGIME], RESTS)
    np.testing.assert_array_equal(rests[decided], decay[decided])


@EVERY_LAW
def test_motions_that_hardly_grow_or_shrink_end_as_linear_theory_says(law):
    """Inertia so large that thousands of loops change little; from a tenth of the belt speed off to rest or a cycle."""
    ratio, speed = (axis.ravel() for axis in np.meshgrid([0.3, 0.8, 1.25, 3.0], np.geomspace(3e-3, 8e-3, 8)))
    p = plates(speed.size, v_b=speed)
    p["k"] = ratio * contacts.critical_stiffness(p["m"], slopes(p))
    mu, unit = p["mu0"] + (p["a"] - p["b"]) * np.log(speed / p["v0"]), 1.0 / units(p)[1]
    cells = columns(p, mu, 0.1 * speed * unit)
    found = run(cells, max_steps=1e5, law=law)
    small = growth(p)
    assert (np.abs(small.growth / small.frequency) < 0.02).all()
    rests = np.isin(found[at.REGIME], RESTS)
    np.testing.assert_array_equal(rests, small.growth < 0.0)
    assert np.isin(found[at.REGIME, ~rests], CYCLES).all()
    # Of the amplitude, 0.1 of the belt speed, a ten-thousandth of the largest is left; friction is not linear at first.
    left = np.log(1e-4) / small.growth[rests] * np.sqrt(p["k"] / p["m"])[rests]
    np.testing.assert_allclose(found[at.SETTLING_TIME, rests], left, rtol=0.4)


@EVERY_LAW
def test_the_regime_alone_is_that_of_all_metrics(law):
    cells = columns(draw(400, 21))
    alone, found = (run(cells, max_steps=3e4, until=until, law=law) for until in (at.UNTIL_REGIME, at.UNTIL_METRICS))
    np.testing.assert_array_equal(alone[at.REGIME], found[at.REGIME])
    cycles = np.isin(found[at.REGIME], CYCLES)
    assert (alone[at.STEPS, cycles] <= found[at.STEPS, cycles]).all() and alone[at.STEPS].sum() < found[at.STEPS].sum()


@EVERY_LAW
def test_speeds_of_plates_are_no_smaller_matter(law):
    """Ten times softer and stiffer than critical, from 1e-13 to 1e-6 m/s."""
    speeds = np.repeat(10.0 ** np.arange(-13.0, -5.0), 2)
    p = plates(speeds.size, v_b=speeds, k=np.tile([8e3, 8e5], speeds.size // 2))
    found = run(columns(p), law=law)
    rests = np.isin(found[at.REGIME], RESTS)
    np.testing.assert_array_equal(rests, np.tile([False, True], speeds.size // 2))
    assert np.isin(found[at.REGIME, ::2], CYCLES).all()


def test_a_cell_is_the_same_in_any_company():
    """Those of one form among those of the other, where slip may rest or turn round, too."""
    cells, order = columns(draw(200, 5)), np.random.default_rng(6).permutation(200)
    cells[at.ETA_START, ::3] = 1.5 * cells[at.BELT, ::3]
    whole = run(cells, max_steps=1e4, law=LAWS["ageing"])
    mixed = run(np.ascontiguousarray(cells[:, order]), max_steps=1e4, law=LAWS["ageing"])
    np.testing.assert_array_equal(mixed, whole[:, order])
    for i in (0, 1):
        alone = run(np.ascontiguousarray(cells[:, [i]]), max_steps=1e4, law=LAWS["ageing"])
        np.testing.assert_array_equal(alone[:, 0], whole[:, i])


# --- slip that may rest or turn round ---


@EVERY_LAW
def test_belts_that_run_backwards_give_the_mirror_image_to_the_bit(law):
    """By either form: a quarter of the cells start at rest on the belt."""
    cells = columns(draw(300, 9))
    cells[at.ETA_START, ::4] = cells[at.BELT, ::4]
    there = run(cells, max_steps=2e4, law=law)
    cells[[at.BELT, at.XI_START, at.ETA_START]] *= -1.0
    back = run(cells, max_steps=2e4, law=law)
    mirrored = back.copy()
    for high, low in ((at.XI_MAX, at.XI_MIN), (at.CYCLE_XI_MAX, at.CYCLE_XI_MIN)):
        mirrored[high], mirrored[low] = -back[low], -back[high]
    for row in (at.XI_END, at.ETA_END, at.XI_SETTLED):
        mirrored[row] = -back[row]
    np.testing.assert_array_equal(mirrored, there)


@EVERY_LAW
def test_cells_from_rest_on_the_belt_come_to_the_cycles_of_the_logarithms(law):
    """Where friction stays above 20 a both forms are the same law; starts differ, with much inertia steps too."""
    p = draw(500, 14)
    cells = columns(p)
    found = run(cells, 1e-7, max_steps=4e4, law=law)
    cells[at.ETA_START] = cells[at.BELT]
    from_rest = run(cells, 1e-7, max_steps=4e4, law=law)
    cycles = np.isin(found[at.REGIME], CYCLES) & (found[at.STATUS] != at.IRREGULAR)
    cycles &= found[at.CYCLE_XI_MIN] > 20.0 * p["a"]
    same = cycles & (from_rest[at.REGIME] == found[at.REGIME])
    assert same.sum() > 0.9 * cycles.sum() > 40
    for row, off in ((at.PERIOD, 1e-5), (at.CYCLE_XI_MAX, 1e-6), (at.CYCLE_XI_MIN, 1e-6), (at.CYCLE_HEAT, 1e-5)):
        np.testing.assert_allclose(from_rest[row, same], found[row, same], rtol=off)
    rests = np.isin(found[at.REGIME], RESTS) & (found[at.XI_SETTLED] > 20.0 * p["a"])
    assert np.isin(from_rest[at.REGIME, rests], RESTS).mean() > 0.9
    both = rests & np.isfinite(from_rest[at.XI_SETTLED])
    np.testing.assert_allclose(from_rest[at.XI_SETTLED, both], found[at.XI_SETTLED, both], rtol=1e-12)


@EVERY_LAW
def test_the_largest_acceleration_counts_that_at_rest_on_the_belt(law):
    """There nothing but the load acts, and only for a moment."""
    cells = columns(draw(300, 21), 10 ** np.random.default_rng(22).uniform(-3.0, 1.0, 300))
    cells[at.ETA_START] = cells[at.BELT]
    found = run(cells, max_steps=2e4, law=law)
    whole = np.isin(found[at.REGIME], RESTS)  # of cycles the extremes are theirs
    load = cells[at.XI_START] + cells[at.GAMMA] * cells[at.BELT]
    assert whole.sum() > 100
    assert (found[at.ACCELERATION_MAX, whole] >= load[whole]).all()
    assert (found[at.ACCELERATION_MAX, whole] == load[whole]).any()  # often nothing later is as steep


@EVERY_LAW
def test_no_cell_fails_where_a_heavy_mass_shoots_past_the_belt(law):
    """Thrown a hundred belt speeds past it, so far that the spring pulls backwards harder than friction holds."""
    p = plates(40, m=np.full(40, 1e3), v_b=np.full(40, 1e-2), k=np.geomspace(1e2, 1e6, 40))
    thrown = columns(p, 0.5, -p["v_b"] * np.geomspace(1.0, 1e4, 40) / units(p)[1])
    for cells in (thrown, columns(p, -2.0)):  # more than friction from the start
        found = run(cells, max_steps=2e4, law=law)
        assert not np.isin(found[at.REGIME], (at.FAILED, at.NOT_COMPUTED)).any()
