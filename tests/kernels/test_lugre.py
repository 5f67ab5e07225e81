"""Contacts of bristles against reference cycles, an independent solver, linear theory and themselves.

tests/data/lugre.csv was solved without our code, by collocation (Radau IIA, order 13).
"""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from helpers.kernel_runs import columns_of, run
from helpers.nightly import few
from judge import memory
from stickslip.engine.compiling import kernels
from stickslip.theory import contacts
from stickslip.theory.curve import weakening
from stickslip_kernels import layout as at
from stickslip_kernels.layout import NO_STOPS, new_signals

TABLE = pd.read_csv(Path(__file__).parents[1] / "data" / "lugre.csv")
LAW, DELTA, GAUSSIAN = LAWS = ("lugre_stribeck", "lugre_stribeck_delta", "lugre_gaussian")
OTHERS = few([*LAWS, "lugre_rational", "lugre_cubic"], 1)


def draw(count, seed, law):
    """Over decades: rigid and soft contacts, damped or not, either direction, fading damping, elastic parts."""
    random = np.random.default_rng(seed)

    def some(share, values):
        return np.where(random.random(count) < share, values, 0.0)

    def decades(low, high):
        return 10 ** random.uniform(low, high, count)

    rows = {"gamma": some(0.7, decades(-4, 0)), "a2": some(0.5, decades(-3, 0))}
    rows |= {"a1": random.uniform(0.05, 0.6, count), "a3": random.uniform(0, 0.5, count), "a4": decades(-3, 0.5)}
    rows |= {"belt": decades(-4, 0.5) * random.choice([-1, 1, 1, 1], count)}
    rows |= {"delta": random.choice([1.0, 1.3, 2.0, 3.0], count) if law == DELTA else 1.0}
    rows |= {"contact_stiffness": (stiffness := decades(-0.5, 7))}
    rows |= {"contact_damping": some(0.7, decades(-2, 0.3) * np.sqrt(stiffness))}
    rows |= {
        "contact_damping_rate": some(0.4, decades(-2, 3)),
        "elastic_part": some(0.4, random.uniform(0, 0.95, count)),
    }
    return columns_of(**rows)


def judged(cells):
    """What the judge says of bristles on Stribeck's curve: answers by their names in `judge.memory`."""
    rows = np.zeros((cells.shape[1], memory.ROWS))
    rows[:, memory.KIND] = memory.BRISTLES
    for name in ("BELT", "GAMMA", "A1", "A3", "A4", "DELTA"):
        rows[:, getattr(memory, name)] = cells[getattr(at, name)]
    rows[:, memory.S_0], rows[:, memory.S_1] = cells[at.CONTACT_STIFFNESS], cells[at.CONTACT_DAMPING]
    return dict(zip(memory.NAMES, memory.judge_memory(rows).T, strict=True))


def slopes(cells, law):
    """E, S and r of cells, in kernel units."""
    b = np.abs(cells[at.BELT])
    of_curve = {"gaussian": "stribeck_delta"}.get(law.removeprefix("lugre_"), law.removeprefix("lugre_"))
    shape, slope = weakening(of_curve, b / cells[at.A4], np.where(law == GAUSSIAN, 2.0, cells[at.DELTA]))
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


@pytest.mark.parametrize(("law", "delta"), [(LAW, 1.0), pytest.param(GAUSSIAN, 2.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("rtol", "off"), [(1e-6, 1e-5), (1e-8, 1e-7)])
def test_reference_cycles(rtol, off, law, delta):
    p = TABLE[TABLE["delta"] == delta]
    impedance = np.sqrt(p["k"] * p["m"])
    speed = (p["Fc"] / impedance).to_numpy()
    cells = columns_of(
        gamma=p["c"] / impedance, belt=p["v_b"] / speed, a1=1.0, a2=p["s2"] / impedance, a3=p["Fs"] / p["Fc"] - 1.0,
        a4=p["vs"] / speed, delta=delta, contact_stiffness=p["s0"] / p["k"], contact_damping=p["s1"] / impedance,
    )  # fmt: skip
    found, cycles = run(cells, rtol, law=law), p["period"].notna()
    np.testing.assert_array_equal(found[at.REGIME], np.where(cycles, at.STICK_SLIP, at.DAMPED))
    slowest = found[at.SLOWEST_SLIP] * speed
    for ours, exact, most in (
        (found[at.PERIOD] * np.sqrt(p["m"] / p["k"]), "period", off),
        (found[at.CYCLE_XI_MAX] * p["Fc"], "kx_max", off), (found[at.CYCLE_XI_MIN] * p["Fc"], "kx_min", off),
        (slowest, "w_min", 10 * off), (found[at.CYCLE_SPEED_RANGE] * speed + slowest, "w_max", 10 * off),
    ):  # fmt: skip
        np.testing.assert_allclose(ours[cycles], p[exact][cycles], rtol=most)


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
    fade, part = own
    (cell,) = columns_of(
        gamma=0.05, a1=0.3, a3=0.2, a4=0.1, contact_stiffness=300.0, contact_damping=8.0, contact_damping_rate=fade,
        elastic_part=part,
    ).T  # fmt: skip
    table = np.array([[2.0, 0.0, 0.1], [9.0, 0.2, 0.0], [4.0, 0.2, -0.1], [9.0, -0.2, 0.0], [2.0, -0.2, 0.1]])
    starts = np.concatenate([[0.0], np.cumsum(table[:, 0])])

    def belt(t):
        n = min(int(np.searchsorted(starts, t, "right")) - 1, 4)
        return table[n, 1] + table[n, 2] * (t - starts[n]), table[n, 2]

    samples, end = 261, starts[-1]
    results, signals = new_signals(1), np.full((at.SIGNAL_ROWS, samples), np.nan)
    runs = np.array([[0.0, samples, 0.0, end / (samples - 1)]])
    cells, drive = np.ascontiguousarray(cell[:, None]), (table, np.array([[0.0, 5.0]]))
    kernels(LAW, signals=True).run_signals(
        cells, 1e-8, 1e6, np.zeros(1, np.int64), drive, results, runs, signals, NO_STOPS
    )

    def within(begin, close):
        return motion(cell, LAW, lambda t: belt(min(max(t, begin), close - 1e-12)))

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
    cells = draw(64, 11, LAW)
    cells[at.GAMMA] += 0.02
    found = run(cells, max_steps=2e4, law=LAW)
    for c in (0, 13, 63):
        np.testing.assert_array_equal(
            run(np.ascontiguousarray(cells[:, [c]]), max_steps=2e4, law=LAW)[:, 0], found[:, c]
        )
    cells[at.BELT] *= -1.0
    mirrored = run(cells, max_steps=2e4, law=LAW)
    np.testing.assert_array_equal(mirrored[at.REGIME], found[at.REGIME])
    np.testing.assert_allclose(mirrored[at.PERIOD], found[at.PERIOD], rtol=1e-9)
    np.testing.assert_allclose(mirrored[at.CYCLE_XI_MAX], -found[at.CYCLE_XI_MIN], rtol=1e-9)
    np.testing.assert_allclose(mirrored[at.SLOWEST_SLIP], found[at.SLOWEST_SLIP], rtol=1e-9)


@pytest.mark.parametrize("start", [0.0, 0.3])
def test_under_a_belt_at_rest_the_mass_comes_to_rest_where_bristles_hold_it(start):
    cell = columns_of(gamma=0.1, a1=0.2, a3=0.2, a4=0.1, contact_stiffness=50.0, contact_damping=2.0, xi_start=start)
    found = run(cell, law=LAW)
    assert (found[at.REGIME, 0], found[at.STATUS, 0]) == (at.STUCK, at.NEVER_BREAKS_AWAY)
    assert 0.0 <= found[at.XI_END, 0] <= start


def test_soft_bristles_settle_when_the_judge_says_they_do():
    """Steps by series are long: the start counts for the band, and no swing inside a step is lost (twice above b)."""
    cells = columns_of(
        a1=0.25, a3=0.05, belt=[0.0061, 0.4, 0.05], a4=0.016, gamma=[0.14, 0.02, 0.1],
        contact_stiffness=[0.1, 0.3, 0.5], contact_damping=[0.7, 0.1, 0.5],
    )  # fmt: skip
    exact = judged(cells)
    assert (exact["REGIME"] == memory.SETTLES).all()
    for rtol, off in ((1e-6, 1e-3), (1e-9, 1e-5)):
        found = run(cells, rtol, law=LAW)
        np.testing.assert_allclose(found[at.SETTLING_TIME], exact["SETTLING"], rtol=off)
        np.testing.assert_array_equal(found[at.CROSSINGS], exact["CROSSINGS"])
        np.testing.assert_allclose(found[at.SPEED_MAX], exact["WHOLE_FASTEST"], rtol=10.0 * rtol)


def test_cycles_of_several_loops_are_told_from_one():
    """The same period at any tolerance: bristles that ring after a slip move u up and down on the way."""
    cells = columns_of(
        belt=[0.00021150588, 0.0005688386], gamma=[0.002025231, 0.06051622], a1=[0.3118492, 0.5724762],
        a2=[0.0, 0.0046428968], a3=[0.3152671, 0.27711696], a4=[0.0070648, 0.0032845067],
        contact_stiffness=[56419.77, 1283.315], contact_damping=[58.27276, 6.521557], elastic_part=[0.0, 0.88123486],
    )  # fmt: skip
    tight, loose = (run(cells, rtol, law=LAW)[at.PERIOD] for rtol in (1e-8, 1e-5))
    np.testing.assert_allclose(tight, [2973.9, 906.96], rtol=1e-4)  # as SciPy's Radau has them
    np.testing.assert_allclose(loose, tight, rtol=1e-5)


def test_a_cycle_may_have_dozens_of_loops():
    """One stick phase, and 41 more loops of bristles that ring: the judge's loops, by collocation, recur after 42."""
    cell = columns_of(
        belt=0.00028815071530217034, gamma=0.09438332458477933, a1=0.25728737996572193, a3=0.4274718664219288,
        a4=0.003984205346525726, contact_stiffness=64.68149411427521, contact_damping=0.03901448338363578,
        xi_start=0.27448242001725054, eta_start=0.0007909185208526057,
    )  # fmt: skip
    found = run(cell, max_steps=5e4, law=LAW)
    assert found[at.REGIME, 0] == at.STICK_SLIP and found[at.STATUS, 0] == at.CYCLE_CLOSED
    assert found[at.PERIOD, 0] == pytest.approx(10720.943802790702 / 4.0, rel=1e-6)


@pytest.mark.slow
def test_ever_stiffer_bristles_are_the_rigid_contact():
    """Canudas' contact, from 1e5 N/m to 1e12: 2.3 %, 0.077 %, and on with the square root."""
    stiffness = np.array([1e5, 1e7, 1e9, 1e12]) / 2.0
    curve = {"belt": 0.1 * 2**0.5, "a1": 1.0, "a2": 0.4 / 2**0.5, "a3": 0.5, "a4": 0.001 * 2**0.5, "delta": 2.0}
    rigid = run(columns_of(**curve, mu_static=1.5, mu_stop=np.nan, ageing_time=1.0), 1e-9, law="gaussian")
    cells = columns_of(**curve, contact_stiffness=stiffness, contact_damping=stiffness**0.5)
    for rtol in (1e-5, 1e-6, 1e-8):
        found = run(cells, rtol, law=GAUSSIAN)
        assert (found[at.REGIME] == at.STICK_SLIP).all()
        off = found[at.PERIOD] / rigid[at.PERIOD] - 1.0
        np.testing.assert_allclose(off, [-2.297e-2, -7.65e-4, -6.9e-5, -1.43e-6], rtol=0.02, atol=1e-7)
        for row in (at.SPEED_MAX, at.XI_MAX, at.CYCLE_XI_MAX, at.CYCLE_XI_MIN):
            assert abs(found[row, 3] / rigid[row, 0] - 1.0) < 3e-6


def test_a_cycle_is_one_only_once_its_load_recurs_as_its_range_does():
    """Soft bristles come to their cycle in a spiral, whose range of load stands still on the way (found by the
    adversary): the period is the judge's, by collocation, not that of a loop before.
    """
    cells = columns_of(
        belt=0.12980446165231596, gamma=0.003988269715012044, a1=0.5093362421076164, a3=0.4735977698453192,
        a4=0.24046196, contact_stiffness=2.1401648203591,
    )  # fmt: skip
    (period,) = judged(cells)["PERIOD"]
    for rtol in (1e-5, 1e-6, 1e-8):
        assert run(cells, rtol, law=LAW)[at.PERIOD, 0] == pytest.approx(period, rel=10.0 * rtol)


def test_bristles_that_ring_while_the_load_creeps_are_no_cycle():
    """A slow belt: the load creeps for thousands of turns of the ringing, which is at the noise of the steps."""
    cells = columns_of(
        belt=np.array([1e-6, 1e-7, 1e-8]) * 2.236, a1=0.25, a3=0.2, a4=0.0447, contact_stiffness=200.0,
        contact_damping=4.47,
    )  # fmt: skip
    assert (contacts.small_motions(1.0, 1.0, slopes(cells, LAW)).growth > 0.0).all()
    found = run(cells, max_steps=6e4, law=LAW)
    assert (found[at.REGIME] != at.SUSTAINED).all()  # unstable at a crawl: undecided, or stick-slip
