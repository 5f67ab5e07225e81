"""Shares, unstable cycles and critical disturbances: exact ones against SciPy, closed forms and published numbers,
sampled and searched ones against these."""

import numpy as np
import pytest
from scipy.optimize import brentq

from helpers.nightly import few
from helpers.unstable_cycle import Cycle, least_slip_speed
from stickslip.engine import Options, compute_range, stop_flag
from stickslip.studies.attractors import Attractors, AttractorStudy, critical_disturbances, sampled_shares
from stickslip.studies.exact import Motions, steady_state
from stickslip.theory import unstable_amplitude
from stickslip.vocabulary.cells import Cells, as_cells, taken
from stickslip.vocabulary.quantities import REGIMES, SHARE_METHODS

UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
BSTAB = UNIT | {"damping": 0.1, "a1": 0.5, "a2": 0.0, "a3": 0.5, "a4": 0.5}


def box_of(displacement, velocity):
    return Attractors(displacement=displacement, velocity=velocity)


BSTAB_BOX = box_of((-2.0, 2.0), (0.0, 2.0))
ARTICLE = UNIT | {"damping": 0.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
EXACT = SHARE_METHODS.index("exact")
# bSTAB's friction case, as pyBasin's tests hold it (main_friction_v_study.json): share of 2,000 starting states that go
# to the fixed point, and its standard error, over belt speeds from 0.8 to 2.225.
SPEEDS = 0.8 + 0.075 * np.arange(20)
PUBLISHED = np.array([0, 0, 0, 0, 0, 0.018, 0.08, 0.1535, 0.226, 0.298, 0.382, 0.45, 0.5085, 0.568, 1, 1, 1, 1, 1, 1])


def find(cells, box=BSTAB_BOX, **options):
    full = as_cells(cells)
    return AttractorStudy(Cells.of(full), box, Options(**options)).compute(range(full["mass"].size), stop_flag())


def test_shares_are_those_published_for_bstab_within_three_of_their_standard_errors():
    found = find(BSTAB | {"belt_speed": SPEEDS})
    assert (found["share_method"] == EXACT).all() and not found["share_error"].any()
    error = np.sqrt(PUBLISHED * (1 - PUBLISHED) / 2000)
    assert (np.abs(found["settling_share"] - PUBLISHED) <= 3 * error).all()


CASES = {
    "bSTAB, small cycle": (BSTAB, 1.16),
    "bSTAB": (BSTAB, 1.5),
    "bSTAB, near the fold": (BSTAB, 1.83),
    "article": (ARTICLE, 0.5),
    "article, near the fold": (ARTICLE, 0.79),
    "strong friction": (UNIT | {"damping": 0.2, "a1": 0.5, "a2": 0.0, "a3": 2.0, "a4": 0.5}, 1.6),
}


@pytest.mark.parametrize("case", few(CASES, 3))
def test_share_and_cycle_are_those_of_scipy_backwards_in_time(case):
    """A box that cuts the cycle on all four sides; agreement to 1e-6 is asked, a hundred times better is found."""
    cell, belt_speed = CASES[case]
    curve = tuple(cell[f"a{i}"] for i in range(1, 5))
    ours = find(cell | {"belt_speed": belt_speed})
    assert ours["share_method"][0] == EXACT
    cycle = Cycle(belt_speed, curve, cell["damping"], guess=float(ours["critical_shift_along"][0]))
    x, v = cycle.states()
    middle, reach, top = 0.5 * (x.max() + x.min()), 0.4 * np.ptp(x), 0.4 * np.ptp(v)
    for box in (
        box_of((-20.0, 20.0), (-20.0, 20.0)), box_of((middle - reach, middle + reach), (-top, 0.9 * top)),
        box_of((middle, 20.0), (0.0, 20.0)), box_of((x.max() + 1.0, x.max() + 2.0), (-1.0, 1.0)),  # a quarter; beyond
        box_of((middle, middle + 0.1 * reach), (0.0, 0.1 * top)),  # inside
    ):  # fmt: skip
        share = find(cell | {"belt_speed": belt_speed}, box)["settling_share"][0]
        assert share == pytest.approx(cycle.share(box.displacement, box.velocity), rel=1e-6)
    assert ours["unstable_period"][0] == pytest.approx(cycle.period, rel=1e-6)
    assert ours["unstable_amplitude"][0] == pytest.approx(0.5 * np.ptp(x), rel=1e-6)
    assert ours["unstable_velocity_amplitude"][0] == pytest.approx(0.5 * np.ptp(v), rel=1e-6)
    assert ours["critical_shift_along"][0] == pytest.approx(cycle.reach, rel=1e-6)
    assert ours["critical_shift_against"][0] == pytest.approx(cycle.steady - x.min(), rel=1e-6)
    for name, half in (("along", v > 0), ("against", v < 0)):
        order = np.argsort(x[half])
        shock = abs(np.interp(cycle.steady, x[half][order], v[half][order]))
        assert ours[f"critical_shock_{name}"][0] == pytest.approx(shock, rel=1e-6)


@pytest.mark.parametrize(("cell", "near_harmonic"), [(BSTAB, 1.8413920), (ARTICLE, 0.80335)])
def test_bistability_ends_at_the_fold_slightly_below_the_near_harmonic_one(cell, near_harmonic):
    """The fold by a root of SciPy at 1e-12; there the share jumps to 1."""
    curve = tuple(cell[f"a{i}"] for i in range(1, 5))
    fold = brentq(
        lambda speed: least_slip_speed(speed, curve, cell["damping"]),
        0.98 * near_harmonic, near_harmonic, xtol=1e-14, rtol=1e-12,
    )  # fmt: skip
    assert 0.99 * near_harmonic < fold < near_harmonic
    found = find(cell | {"belt_speed": fold * (1.0 + np.array([-1e-6, -1e-8, 1e-8, 1e-6]))}, rtol=1e-12)
    assert (found["share_method"] == EXACT).all()
    below, near, *above = found["settling_share"]
    assert below < 0.9 and near == pytest.approx(below, rel=1e-4) and above == [1.0, 1.0]


def test_shocks_just_below_and_above_the_critical_ones_part_what_becomes_of_sliding():
    cells = as_cells(ARTICLE | {"belt_speed": np.linspace(0.36, 0.79, 12)})
    found = find(cells)
    steady = 1.0 + 0.1 * cells["belt_speed"] + 0.3 * np.exp(-cells["belt_speed"] / 0.1)
    for way, sign in (("along", 1.0), ("against", -1.0)):
        for kind in ("shock", "shift"):
            for share, ends in ((1 - 1e-6, True), (1 + 1e-6, False)):
                change = sign * share * found[f"critical_{kind}_{way}"]
                x, v = (steady, change) if kind == "shock" else (steady + change, 0.0 * change)
                start = cells | {"displacement": x, "velocity": v}
                regimes = compute_range(Cells.of(start), 0, 12, Options(rtol=1e-10), stop_flag())["regime"]
                assert (np.isin(regimes, [REGIMES.index("damped"), REGIMES.index("creep")]) == ends).all()


def test_nothing_settles_where_steady_sliding_is_unstable_and_everything_where_nothing_feeds_a_vibration():
    found = find(ARTICLE | {"belt_speed": [0.2, 0.34, 0.9, 3.0]})
    assert found["settling_share"].tolist() == [0, 0, 1, 1]
    assert found["critical_shock"].tolist() == found["critical_shift"].tolist() == [0, 0, np.inf, np.inf]
    assert np.isnan(found["unstable_period"]).all()


def test_a_belt_that_runs_the_other_way_mirrors_the_plane():
    box, mirrored = box_of((-0.5, 2.0), (-0.3, 1.0)), box_of((-2.0, 0.5), (-1.0, 0.3))
    ours, other = find(ARTICLE | {"belt_speed": 0.5}, box), find(ARTICLE | {"belt_speed": -0.5}, mirrored)
    for name, values in ours.items():
        assert other[name] == pytest.approx(values, rel=1e-9, nan_ok=True), name


def test_the_cycle_is_found_next_to_the_loss_of_stability_where_it_attracts_too_slowly_to_wait_for():
    """There it is that of harmonic balance: v_H = a4 ln(1/g) with g = a4 c/(N a3) = 0.1."""
    speed = 0.5 * np.log(10.0) * (1.0 + np.array([1e-6, 1e-5, 1e-4]))
    found = find(BSTAB | {"belt_speed": speed})
    expected = unstable_amplitude(speed, 0.0, 0.5, 0.5, 0.1, 1.0)
    assert found["unstable_velocity_amplitude"] == pytest.approx(expected, rel=1e-3)
    assert found["unstable_velocity_amplitude"][0] < 0.006


def test_static_friction_and_ageing_do_not_move_the_unstable_cycle():
    """Inside it the contact never sticks."""
    plain = find(ARTICLE | {"belt_speed": 0.6})
    for more in ({"mu_static": 1.5}, {"ageing_rate": 0.1, "ageing_time": 0.1}):
        aged = find(ARTICLE | {"belt_speed": 0.6} | more)
        assert aged["share_method"][0] == EXACT
        assert aged["settling_share"] == pytest.approx(plain["settling_share"], rel=1e-12)


# --- sampled ----------------------------------------------------------------------------------------------------------


SAMPLED = SHARE_METHODS.index("sampled")


def sampling(samples=256, seed=1):
    return Attractors(displacement=(0.0, 2.0), velocity=(-1.0, 1.0), samples=samples, seed=seed)


BOX = sampling()


def plain_cells(count):
    """Cells with an unstable cycle or without, of curves and dampers drawn at random."""
    draw = np.random.default_rng(14)
    curve = {"a1": draw.uniform(0.3, 1.2, count), "a2": draw.uniform(0.0, 0.1, count)}
    curve |= {"a3": draw.uniform(0.2, 0.6, count), "a4": draw.uniform(0.1, 0.3, count)}
    more = {"damping": draw.uniform(0.0, 0.1, count), "belt_speed": draw.uniform(0.3, 0.9, count)}
    return UNIT | curve | more


def test_sampled_shares_of_plain_cells_are_the_exact_ones_within_three_standard_errors():
    cells = plain_cells(40)
    exact = find(cells, BOX)
    assert (exact["share_method"] != SAMPLED).all()
    assert ((exact["settling_share"] > 0) & (exact["settling_share"] < 1)).sum() >= 10
    shares, _ = sampled_shares(as_cells(cells), sampling(512), Motions(Options(), stop_flag()))
    assert (np.abs(shares["settling_share"] - exact["settling_share"]) <= 3 * shares["share_error"]).all()
    some = (exact["settling_share"] > 0.02) & (exact["settling_share"] < 0.98)
    binomial = np.sqrt(exact["settling_share"] * (1 - exact["settling_share"]) / 512)
    assert np.median(shares["share_error"][some] / binomial[some]) < 0.7  # what Sobol points are for


@pytest.mark.slow
def test_searched_disturbances_of_plain_cells_are_those_of_their_unstable_cycle():
    cells = plain_cells(40)
    exact, full, work = find(cells, BOX), as_cells(cells), Motions(Options(rtol=1e-8), stop_flag())
    some = np.isfinite(exact["unstable_period"])
    part = taken(full, some)
    found = critical_disturbances(part, steady_state(part, Options()), work)
    for name, values in found.items():
        np.testing.assert_allclose(values, exact[name][some], rtol=3e-6)


@pytest.mark.parametrize(
    ("more", "law"),
    [
        ({"mu_stop": 1.1}, "stribeck"),
        ({"a2": -0.01, "damping": 0.05}, "stribeck"),
        pytest.param({"delta": 1.5}, "stribeck_delta", marks=pytest.mark.slow),
    ],
)
def test_other_curves_are_sampled_and_say_so(more, law):
    found = find(ARTICLE | more | {"belt_speed": [0.2, 0.5, 2.0]}, BOX, law=law)
    assert (found["share_method"] == SAMPLED).all() and (found["share_error"] > 0).all()
    assert np.isnan(found["unstable_period"]).all()
    assert (found["settling_share_low"] <= found["settling_share"]).all()
    assert found["settling_share"][0] == 0.0 and found["settling_share"][2] == 1.0
    assert found["critical_shock"][0] == 0.0 and found["critical_shock"][2] == np.inf


def test_a_hysteretic_curve_has_its_own_bistable_band():
    """From sticking it keeps up stick-slip where sliding is stable already, and a searched shock parts the two."""
    cell = ARTICLE | {"mu_stop": 1.1, "belt_speed": 0.5}
    found = find(cell, BOX)
    assert [REGIMES[found[f"regime_from_{start}"][0]] for start in ("stick", "sliding")] == ["stick_slip", "damped"]
    full, work = as_cells(cell), Motions(Options(), stop_flag())
    steady = steady_state(full, Options())
    for way, sign in (("along", 1), ("against", -1)):
        shock = sign * found[f"critical_shock_{way}"]
        ends = [REGIMES[work.regimes(full, steady, share * shock)[0]] for share in (0.9999, 1.0001)]
        assert ends == ["damped", "stick_slip"]


def test_undecided_starting_states_are_bounds():
    """With a step budget that is too small nothing is known, and that is said."""
    found = find(ARTICLE | {"mu_stop": 1.1, "belt_speed": 0.5}, BOX, max_steps=3)
    assert found["settling_share_low"][0] < 0.5 < found["settling_share_high"][0]
    assert found["coexisting"][0] & (1 << (REGIMES.index("unresolved") - 1))
    assert np.isnan(found["critical_shock"][0])


def test_a_belt_at_rest_has_no_steady_sliding():
    found = find(ARTICLE | {"belt_speed": 0.0}, BOX)
    assert REGIMES[found["regime_from_stick"][0]] == "stuck"
    assert REGIMES[found["regime_from_sliding"][0]] == "not_computed"
    assert found["settling_share"][0] == 0.0 and np.isnan(found["critical_shock"][0])
