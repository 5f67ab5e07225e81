"""Contacts of bristles against reference cycles, an independent solver, linear theory and themselves.

tests/data/lugre.csv was solved without our code, by collocation (Radau IIA, order 13).
"""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers import adversary_memory
from helpers.kernel_runs import NAN, run
from judge import memory as memory_judge
from stickslip.engine.compiled import kernels
from stickslip.theory import contacts
from stickslip.theory.curve import weakening
from stickslip_kernels import layout as at
from stickslip_kernels.allocate import NO_STOPS, new_signals

TABLE = Path(__file__).parents[1] / "data" / "lugre.csv"
LAWS = ("lugre_stribeck", "lugre_stribeck_delta", "lugre_gaussian", "lugre_rational", "lugre_cubic")
OTHERS = [LAWS[0], *(pytest.param(law, marks=pytest.mark.slow) for law in LAWS[1:])]


def draw(count, seed, law):
    """Over decades: rigid and soft contacts, damped or not, either direction, fading damping, elastic parts."""
    random = np.random.default_rng(seed)

    def some(share, values):
        return np.where(random.random(count) < share, values, 0.0)

    def decades(low, high):
        return 10 ** random.uniform(low, high, count)

    cells = np.zeros((at.CELL_ROWS, count))
    cells[at.GAMMA], cells[at.A2] = some(0.7, decades(-4, 0)), some(0.5, decades(-3, 0))
    cells[at.A1], cells[at.A3], cells[at.A4] = (
        random.uniform(0.05, 0.6, count),
        random.uniform(0, 0.5, count),
        decades(-3, 0.5),
    )
    cells[at.BELT] = decades(-4, 0.5) * random.choice([-1, 1, 1, 1], count)
    cells[at.DELTA] = random.choice([1.0, 1.3, 2.0, 3.0], count) if law == LAWS[1] else 1.0
    cells[at.ETA_START], cells[at.HORIZON] = NAN, np.inf
    cells[at.CONTACT_STIFFNESS] = decades(-0.5, 7)
    cells[at.CONTACT_DAMPING] = some(0.7, decades(-2, 0.3) * np.sqrt(cells[at.CONTACT_STIFFNESS]))
    cells[at.CONTACT_DAMPING_RATE] = some(0.4, decades(-2, 3))
    cells[at.ELASTIC_PART] = some(0.4, random.uniform(0, 0.95, count))
    return cells


def slopes(cells, law):
    """E, S and r of cells, in kernel units."""
    b = np.abs(cells[at.BELT])
    of_curve = {"gaussian": "stribeck_delta"}.get(law.removeprefix("lugre_"), law.removeprefix("lugre_"))
    shape, slope = weakening(of_curve, b / cells[at.A4], np.where(law == LAWS[2], 2.0, cells[at.DELTA]))
    damping = cells[at.CONTACT_DAMPING] * np.exp(-((cells[at.CONTACT_DAMPING_RATE] * b) ** 2))
    level, fall = cells[at.A1] + cells[at.A3] * shape, cells[at.A3] / cells[at.A4] * slope
    return contacts.lugre_slopes(cells[at.GAMMA], b, level, fall, cells[at.A2], cells[at.CONTACT_STIFFNESS], damping)


def motion(cell, law, belt=None):
    """The equations of motion, written down once more. belt : its speed over time, and its acceleration."""
    gamma, steady, a1, a2, a3, a4, delta = cell[[at.GAMMA, at.BELT, at.A1, at.A2, at.A3, at.A4, at.DELTA]]
    s_0, s_1, fade, part = cell[[at.CONTACT_STIFFNESS, at.CONTACT_DAMPING, at.CONTACT_DAMPING_RATE, at.ELASTIC_PART]]
    name = law.removeprefix("lugre_")
    exponent = 2.0 if name == "gaussian" else delta
    belt = belt or (lambda t: (steady, 0.0))

    def derivatives(t, state):
        u, w, f = state
        b, acceleration = belt(t)
        shape = weakening("stribeck_delta" if name == "gaussian" else name, abs(w) / a4, exponent)[0]
        q = np.sign(w) * f / (a1 + a3 * shape)
        ramp = min(max((q - part) / (1.0 - part), 0.0), 1.0)
        alpha = 1.0 if part == 0.0 else 0.5 + 0.5 * np.sin(np.pi * (ramp - 0.5))
        give = w * (1.0 - alpha * q)
        friction = f + s_1 * np.exp(-((fade * w) ** 2)) * give + a2 * w
        return b - w, acceleration + u + gamma * (b - w) - friction, s_0 * give

    return derivatives


@pytest.mark.parametrize(("law", "delta"), [(LAWS[0], "1.0"), pytest.param(LAWS[2], "2.0", marks=pytest.mark.slow)])
@pytest.mark.parametrize(("rtol", "off"), [(1e-6, 1e-5), (1e-8, 1e-7)])
def test_reference_cycles(rtol, off, law, delta):
    rows = [row for row in csv.DictReader(TABLE.read_text().splitlines()) if row["delta"] == delta]
    p = {
        name: np.array([float(row[name] or "nan") for row in rows])
        for name in rows[0]
        if name not in ("id", "regime", "note")
    }
    cells, impedance = np.zeros((at.CELL_ROWS, len(rows))), np.sqrt(p["k"] * p["m"])
    speed = p["Fc"] / impedance
    cells[at.GAMMA], cells[at.BELT], cells[at.A1], cells[at.A2] = (
        p["c"] / impedance,
        p["v_b"] / speed,
        1.0,
        p["s2"] / impedance,
    )
    cells[at.A3], cells[at.A4], cells[at.DELTA] = p["Fs"] / p["Fc"] - 1.0, p["vs"] / speed, p["delta"]
    cells[at.CONTACT_STIFFNESS], cells[at.CONTACT_DAMPING] = p["s0"] / p["k"], p["s1"] / impedance
    cells[at.ETA_START], cells[at.HORIZON] = NAN, np.inf
    found, cycles = run(cells, rtol, law=law), np.isfinite(p["period"])
    np.testing.assert_array_equal(found[at.REGIME], np.where(cycles, at.STICK_SLIP, at.DAMPED))
    slowest = found[at.SLOWEST_SLIP] * speed
    for ours, exact, most in (
        (found[at.PERIOD] * np.sqrt(p["m"] / p["k"]), p["period"], off),
        (found[at.CYCLE_XI_MAX] * p["Fc"], p["kx_max"], off),
        (found[at.CYCLE_XI_MIN] * p["Fc"], p["kx_min"], off), (slowest, p["w_min"], 10 * off),
        (found[at.CYCLE_SPEED_RANGE] * speed + slowest, p["w_max"], 10 * off),
    ):  # fmt: skip
        np.testing.assert_allclose(ours[cycles], exact[cycles], rtol=most)


@pytest.mark.parametrize("law", OTHERS)
def test_motion_is_that_of_scipy(law):
    """Through break-away, slip, and bristles that ring, over decades."""
    cells = draw(24, 77, law)
    random = np.random.default_rng(5)
    load = cells[at.A1] + cells[at.A3]
    cells[at.HORIZON] = np.minimum(3.0 * load / np.abs(cells[at.BELT]), 500.0) * random.uniform(0.3, 1.0, 24) + 5.0
    found = run(cells, 1e-8, until=at.UNTIL_HORIZON, law=law)
    assert (found[at.STATUS] == at.HORIZON_REACHED).all()
    for cell, of_cell, scale in zip(cells.T, found.T, load, strict=True):
        if of_cell[at.STEPS] > 1000:
            continue  # rings for long, which takes SciPy minutes
        b, end = cell[at.BELT], cell[at.HORIZON]
        tight = {"rtol": 1e-9, "atol": 1e-9 * np.array([scale, abs(b), scale]), "max_step": end / 50}
        u, w, _ = solve_ivp(motion(cell, law), (0.0, end), (0.0, 0.0, 0.0), "Radau", **tight).y[:, -1]
        assert of_cell[at.XI_END] == pytest.approx(u, abs=3e-6 * scale)
        assert b - of_cell[at.ETA_END] == pytest.approx(w, rel=3e-6, abs=3e-6 * abs(b))


@pytest.mark.slow
@pytest.mark.parametrize("own", [(2.0, 0.3), (0.0, 0.0)], ids=["implicit", "series"])
def test_motion_under_a_belt_that_turns_round_is_that_of_scipy(own):
    law, cell = LAWS[0], draw(1, 0, LAWS[0])[:, 0]
    cell[[at.GAMMA, at.A1, at.A2, at.A3, at.A4]] = 0.05, 0.3, 0.0, 0.2, 0.1
    cell[[at.CONTACT_STIFFNESS, at.CONTACT_DAMPING, at.CONTACT_DAMPING_RATE, at.ELASTIC_PART]] = 300.0, 8.0, *own
    table = np.array([[2.0, 0.0, 0.1], [9.0, 0.2, 0.0], [4.0, 0.2, -0.1], [9.0, -0.2, 0.0], [2.0, -0.2, 0.1]])
    starts = np.concatenate([[0.0], np.cumsum(table[:, 0])])

    def belt(t):
        n = min(int(np.searchsorted(starts, t, "right")) - 1, 4)
        return table[n, 1] + table[n, 2] * (t - starts[n]), table[n, 2]

    samples, end = 261, starts[-1]
    results, signals = new_signals(1), np.full((at.SIGNAL_ROWS, samples), np.nan)
    runs = np.array([[0.0, samples, 0.0, end / (samples - 1)]])
    cells, drive = np.ascontiguousarray(cell[:, None]), (table, np.array([[0.0, 5.0]]))
    kernels(law, signals=True).run_signals(
        cells, 1e-8, 1e6, np.zeros(1, np.int64), drive, results, runs, signals, NO_STOPS
    )

    def within(begin, close):
        return motion(cell, law, lambda t: belt(min(max(t, begin), close - 1e-12)))

    exact, state = [np.zeros((3, 1))], np.zeros(3)
    times = np.linspace(0.0, end, samples)
    for begin, close in zip(starts[:-1], starts[1:], strict=True):
        inside = times[(times > begin + 1e-9) & (times <= close + 1e-9)]
        solved = solve_ivp(
            within(begin, close), (begin, close), state, "Radau", np.append(inside[:-1], close),
            rtol=1e-9, atol=1e-11, max_step=0.2,
        )  # fmt: skip
        exact.append(solved.y)
        state = solved.y[:, -1]
    u, w, _ = np.concatenate(exact, axis=1)
    np.testing.assert_allclose(signals[at.SIGNAL_XI], u, atol=1e-6)
    np.testing.assert_allclose(signals[at.SIGNAL_ETA], np.array([belt(t)[0] for t in times]) - w, atol=1e-5)


@pytest.mark.parametrize("law", OTHERS)
def test_steady_sliding_is_the_answer_only_where_small_motions_decay(law):
    cells = draw(500, 3, law)
    found = run(cells, max_steps=3e4, law=law)
    rests = np.isin(found[at.REGIME], (at.DAMPED, at.CREEP))
    assert rests.sum() > 100 and np.isin(found[at.REGIME], (at.STICK_SLIP, at.SUSTAINED)).sum() > 100
    assert (contacts.small_motions(1.0, 1.0, slopes(cells, law)).growth[rests] < 0.0).all()
    assert np.isin(found[at.REGIME], (at.FAILED, at.STUCK, at.NOT_COMPUTED)).sum() == 0
    damped = (cells[at.CONTACT_DAMPING] > 0.1 * np.sqrt(cells[at.CONTACT_STIFFNESS])) & (cells[at.GAMMA] > 0.01)
    assert (found[at.REGIME, damped] == at.UNRESOLVED).mean() < 0.05  # the others ring for long, or are chaotic


def test_a_cell_is_the_same_wherever_it_is_and_in_a_mirror():
    cells = draw(64, 11, LAWS[0])
    cells[at.GAMMA] += 0.02
    found = run(cells, max_steps=2e4, law=LAWS[0])
    for c in (0, 13, 63):
        np.testing.assert_array_equal(
            run(np.ascontiguousarray(cells[:, [c]]), max_steps=2e4, law=LAWS[0])[:, 0], found[:, c]
        )
    cells[at.BELT] *= -1.0
    mirrored = run(cells, max_steps=2e4, law=LAWS[0])
    np.testing.assert_array_equal(mirrored[at.REGIME], found[at.REGIME])
    np.testing.assert_allclose(mirrored[at.PERIOD], found[at.PERIOD], rtol=1e-9)
    np.testing.assert_allclose(mirrored[at.CYCLE_XI_MAX], -found[at.CYCLE_XI_MIN], rtol=1e-9)
    np.testing.assert_allclose(mirrored[at.SLOWEST_SLIP], found[at.SLOWEST_SLIP], rtol=1e-9)


@pytest.mark.parametrize("steps", [0.0, 0.3])
def test_under_a_belt_at_rest_the_mass_comes_to_rest_where_bristles_hold_it(steps):
    cells = draw(1, 1, LAWS[0])
    cells[[at.BELT, at.GAMMA, at.A1, at.A2, at.CONTACT_STIFFNESS, at.CONTACT_DAMPING], 0] = (
        0.0,
        0.1,
        0.2,
        0.0,
        50.0,
        2.0,
    )
    cells[at.XI_START] = steps
    found = run(cells, law=LAWS[0])
    assert (found[at.REGIME, 0], found[at.STATUS, 0]) == (at.STUCK, at.NEVER_BREAKS_AWAY)
    assert 0.0 <= found[at.XI_END, 0] <= steps


def test_soft_bristles_settle_when_the_judge_says_they_do():
    """Steps by series are long: the start counts for the band, and no swing inside a step is lost (twice above b)."""
    cells = np.zeros((at.CELL_ROWS, 3))
    cells[at.A1], cells[at.A3], cells[at.DELTA] = 0.25, 0.05, 1.0
    cells[at.BELT] = 0.0061, 0.4, 0.05
    cells[at.A4], cells[at.GAMMA] = 0.016, np.array([0.14, 0.02, 0.1])
    cells[at.CONTACT_STIFFNESS], cells[at.CONTACT_DAMPING] = np.array([0.1, 0.3, 0.5]), np.array([0.7, 0.1, 0.5])
    cells[at.ETA_START], cells[at.HORIZON] = NAN, np.inf
    p = np.zeros((3, memory_judge.ROWS))
    for row, values in (
        (memory_judge.BELT, at.BELT), (memory_judge.GAMMA, at.GAMMA), (memory_judge.A1, at.A1),
        (memory_judge.A3, at.A3), (memory_judge.A4, at.A4), (memory_judge.S_0, at.CONTACT_STIFFNESS),
        (memory_judge.S_1, at.CONTACT_DAMPING), (memory_judge.DELTA, at.DELTA),
    ):  # fmt: skip
        p[:, row] = cells[values]
    p[:, memory_judge.KIND] = memory_judge.BRISTLES
    exact = memory_judge.judge_memory(p)
    assert (exact[:, memory_judge.REGIME] == memory_judge.SETTLES).all()
    for rtol, off in ((1e-6, 1e-3), (1e-9, 1e-5)):
        found = run(cells, rtol, law=LAWS[0])
        np.testing.assert_allclose(found[at.SETTLING_TIME], exact[:, memory_judge.SETTLING], rtol=off)
        np.testing.assert_array_equal(found[at.CROSSINGS], exact[:, memory_judge.CROSSINGS])
        np.testing.assert_allclose(found[at.SPEED_MAX], exact[:, memory_judge.WHOLE_FASTEST], rtol=10.0 * rtol)


def test_cycles_of_several_loops_are_told_from_one():
    """The same period at any tolerance: bristles that ring after a slip move u up and down on the way."""
    cells = np.zeros((at.CELL_ROWS, 2))
    cells[[at.BELT, at.GAMMA, at.A1, at.A3, at.A4, at.DELTA], 0] = (
        0.00021150588,
        0.002025231,
        0.3118492,
        0.3152671,
        0.0070648,
        1.0,
    )
    cells[[at.CONTACT_STIFFNESS, at.CONTACT_DAMPING], 0] = 56419.77, 58.27276
    cells[[at.BELT, at.GAMMA, at.A1, at.A3, at.A4, at.DELTA], 1] = (
        0.0005688386,
        0.06051622,
        0.5724762,
        0.27711696,
        0.0032845067,
        1.0,
    )
    cells[[at.A2, at.CONTACT_STIFFNESS, at.CONTACT_DAMPING, at.ELASTIC_PART], 1] = (
        0.0046428968,
        1283.315,
        6.521557,
        0.88123486,
    )
    cells[at.ETA_START], cells[at.HORIZON] = NAN, np.inf
    tight, loose = run(cells, 1e-8, law=LAWS[0]), run(cells, 1e-5, law=LAWS[0])
    np.testing.assert_allclose(tight[at.PERIOD], [2973.9, 906.96], rtol=1e-4)  # as SciPy's Radau has them
    np.testing.assert_allclose(loose[at.PERIOD], tight[at.PERIOD], rtol=1e-5)


def test_a_cycle_may_have_dozens_of_loops():
    """One stick phase, and 41 more loops of bristles that ring: the judge's loops, by collocation, recur after 42."""
    cells = np.zeros((at.CELL_ROWS, 1))
    cells[[at.BELT, at.GAMMA, at.A1, at.A3, at.A4, at.DELTA], 0] = (
        0.00028815071530217034, 0.09438332458477933, 0.25728737996572193, 0.4274718664219288, 0.003984205346525726, 1.0,
    )  # fmt: skip
    cells[at.CONTACT_STIFFNESS], cells[at.CONTACT_DAMPING] = 64.68149411427521, 0.03901448338363578
    cells[at.XI_START], cells[at.ETA_START], cells[at.HORIZON] = 0.27448242001725054, 0.0007909185208526057, np.inf
    found = run(cells, max_steps=5e4, law=LAWS[0])
    assert found[at.REGIME, 0] == at.STICK_SLIP and found[at.STATUS, 0] == at.CYCLE_CLOSED
    assert found[at.PERIOD, 0] == pytest.approx(10720.943802790702 / 4.0, rel=1e-6)


@pytest.mark.slow
def test_the_judge_finds_the_largest_acceleration_between_its_samples():
    """A peak just after the start: DOP853 at 1e-12 has 0.9164991587574 m/s2."""
    cell = {
        "mass": 10.297950532599097, "stiffness": 302.0667341376537, "normal_load": 211.0604033352879,
        "belt_speed": -0.26407360793465956, "damping": 35.720093056264886, "a1": 0.1760085137839149,
        "a2": 0.007916049974693978, "a3": 0.48752974785126824, "a4": 4.230984755325421, "delta": 2.1397764769079712,
        "contact_stiffness": 211749.10525533473, "contact_damping_speed": 27.022804335570477,
    }  # fmt: skip
    verdict = adversary_memory.judged({name: np.array([value]) for name, value in cell.items()}, "stribeck_delta")
    assert verdict["acceleration_max"][0] == pytest.approx(0.9164991587574, rel=1e-11)


@pytest.mark.slow
def test_ever_stiffer_bristles_are_the_rigid_contact():
    """Canudas' contact, from 1e5 N/m to 1e12: 2.3 %, 0.077 %, and on with the square root."""
    stiffness = np.array([1e5, 1e7, 1e9, 1e12])
    cells = np.zeros((at.CELL_ROWS, 4))
    cells[at.BELT], cells[at.A1], cells[at.A2], cells[at.A3], cells[at.A4] = (
        0.1 * 2**0.5,
        1.0,
        0.4 / 2**0.5,
        0.5,
        0.001 * 2**0.5,
    )
    cells[at.MU_STATIC], cells[at.DELTA], cells[at.MU_STOP], cells[at.AGEING_TIME] = 1.5, 2.0, NAN, 1.0
    cells[at.ETA_START], cells[at.HORIZON] = NAN, np.inf
    rigid = run(np.ascontiguousarray(cells[:, :1]), 1e-9, law="gaussian")
    cells[at.MU_STOP] = 0.0
    cells[at.CONTACT_STIFFNESS], cells[at.CONTACT_DAMPING] = stiffness / 2.0, (stiffness / 2.0) ** 0.5
    for rtol in (1e-5, 1e-6, 1e-8):
        found = run(cells, rtol, law=LAWS[2])
        assert (found[at.REGIME] == at.STICK_SLIP).all()
        off = found[at.PERIOD] / rigid[at.PERIOD] - 1.0
        np.testing.assert_allclose(off, [-2.297e-2, -7.65e-4, -6.9e-5, -1.43e-6], rtol=0.02, atol=1e-7)
        for row in (at.SPEED_MAX, at.XI_MAX, at.CYCLE_XI_MAX, at.CYCLE_XI_MIN):
            assert abs(found[row, 3] / rigid[row, 0] - 1.0) < 3e-6


def test_a_cycle_is_one_only_once_its_load_recurs_as_its_range_does():
    """Soft bristles come to their cycle in a spiral, whose range of load stands still on the way (found by the
    adversary): the period is the judge's, by collocation, not that of a loop before.
    """
    cells = np.zeros((at.CELL_ROWS, 1))
    cells[[at.BELT, at.GAMMA, at.A1, at.A3, at.A4, at.DELTA], 0] = (
        0.12980446165231596, 0.003988269715012044, 0.5093362421076164, 0.4735977698453192, 0.24046196, 1.0,
    )  # fmt: skip
    cells[at.CONTACT_STIFFNESS], cells[at.ETA_START], cells[at.HORIZON] = 2.1401648203591, NAN, np.inf
    p = np.zeros(memory_judge.ROWS)
    p[[memory_judge.KIND, memory_judge.BELT, memory_judge.GAMMA, memory_judge.S_0]] = (
        memory_judge.BRISTLES, *cells[[at.BELT, at.GAMMA, at.CONTACT_STIFFNESS], 0],
    )  # fmt: skip
    for row, values in ((memory_judge.A1, at.A1), (memory_judge.A3, at.A3), (memory_judge.A4, at.A4)):
        p[row] = cells[values, 0]
    p[memory_judge.DELTA] = 1.0
    exact = memory_judge.judge_memory([p])[0]
    for rtol in (1e-5, 1e-6, 1e-8):
        found = run(cells, rtol, law=LAWS[0])
        assert found[at.PERIOD, 0] == pytest.approx(exact[memory_judge.PERIOD], rel=10.0 * rtol)


def test_bristles_that_ring_while_the_load_creeps_are_no_cycle():
    """A slow belt: the load creeps for thousands of turns of the ringing, which is at the noise of the steps."""
    cells = np.zeros((at.CELL_ROWS, 3))
    cells[at.BELT], cells[at.A1], cells[at.A3], cells[at.A4] = np.array([1e-6, 1e-7, 1e-8]) * 2.236, 0.25, 0.2, 0.0447
    cells[at.CONTACT_STIFFNESS], cells[at.CONTACT_DAMPING], cells[at.DELTA] = 200.0, 4.47, 1.0
    cells[at.ETA_START], cells[at.HORIZON] = NAN, np.inf
    assert (contacts.small_motions(1.0, 1.0, slopes(cells, LAWS[0])).growth > 0.0).all()
    found = run(cells, max_steps=6e4, law=LAWS[0])
    assert (found[at.REGIME] != at.SUSTAINED).all()  # unstable at a crawl: undecided, or stick-slip
