"""Sampled shares and searched disturbances, against the exact ones and against each other."""

import numpy as np
import pytest

from stickslip.engine import Options, stop_flag
from stickslip.studies.attractors import Attractors, find_attractors
from stickslip.studies.attractors.sampled import critical_disturbances, sampled_shares
from stickslip.studies.attractors.starts import Motions, steady_state
from stickslip.vocabulary.cells import Cells, as_cells, taken
from stickslip.vocabulary.flags import REGIMES, SHARE_METHODS

UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
ARTICLE = UNIT | {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
SAMPLED = SHARE_METHODS.index("sampled")


def box(samples=256, seed=1):
    return Attractors(displacement=(0.0, 2.0), velocity=(-1.0, 1.0), samples=samples, seed=seed)


BOX = box()


def find(cells, box=BOX, **options):
    full = as_cells(cells)
    items = range(full["mass"].size)
    return find_attractors(Cells.of(full), items, box, Options(**options), stop_flag())


def plain_cells(count):
    """Cells with an unstable cycle or without, of curves and dampers drawn at random."""
    draw = np.random.default_rng(14)
    curve = {"a1": draw.uniform(0.3, 1.2, count), "a2": draw.uniform(0.0, 0.1, count)}
    curve |= {"a3": draw.uniform(0.2, 0.6, count), "a4": draw.uniform(0.1, 0.3, count)}
    more = {"damping": draw.uniform(0.0, 0.1, count), "belt_speed": draw.uniform(0.3, 0.9, count)}
    return UNIT | curve | more


def test_sampled_shares_of_plain_cells_are_the_exact_ones_within_three_standard_errors():
    cells = plain_cells(40)
    exact = find(cells)
    assert (exact["share_method"] != SAMPLED).all()
    assert ((exact["settling_share"] > 0) & (exact["settling_share"] < 1)).sum() >= 10
    shares = sampled_shares(as_cells(cells), box(512), Motions(Options(), stop_flag()))
    assert (np.abs(shares.share - exact["settling_share"]) <= 3 * shares.error).all()
    some = (exact["settling_share"] > 0.02) & (exact["settling_share"] < 0.98)
    binomial = np.sqrt(exact["settling_share"] * (1 - exact["settling_share"]) / 512)
    assert np.median(shares.error[some] / binomial[some]) < 0.7  # what Sobol points are for


@pytest.mark.slow
def test_searched_disturbances_of_plain_cells_are_those_of_their_unstable_cycle():
    cells = plain_cells(40)
    exact, full, work = find(cells), as_cells(cells), Motions(Options(rtol=1e-8), stop_flag())
    some = np.isfinite(exact["unstable_period"])
    part = taken(full, some)
    found = critical_disturbances(part, steady_state(part, Options()), work)
    for name, values in found.items():
        np.testing.assert_allclose(values, exact[f"critical_{name}"][some], rtol=3e-6)


@pytest.mark.parametrize(
    ("more", "law"),
    [
        ({"mu_stop": 1.1}, "stribeck"),
        ({"a2": -0.01, "damping": 0.05}, "stribeck"),
        pytest.param({"delta": 1.5}, "stribeck_delta", marks=pytest.mark.slow),
    ],
)
def test_other_curves_are_sampled_and_say_so(more, law):
    found = find(ARTICLE | more | {"belt_speed": [0.2, 0.5, 2.0]}, law=law)
    assert (found["share_method"] == SAMPLED).all() and (found["share_error"] > 0).all()
    assert np.isnan(found["unstable_period"]).all()
    assert (found["settling_share_low"] <= found["settling_share"]).all()
    assert found["settling_share"][0] == 0.0 and found["settling_share"][2] == 1.0
    assert found["critical_shock"][0] == 0.0 and found["critical_shock"][2] == np.inf


def test_a_hysteretic_curve_has_its_own_bistable_band():
    """From sticking it keeps up stick-slip where sliding is stable already, and a searched shock parts the two."""
    cell = ARTICLE | {"mu_stop": 1.1, "belt_speed": 0.5}
    found = find(cell)
    assert [REGIMES[found[f"regime_from_{start}"][0]] for start in ("stick", "sliding")] == ["stick_slip", "damped"]
    full, work = as_cells(cell), Motions(Options(), stop_flag())
    steady = steady_state(full, Options())
    for way, sign in (("along", 1), ("against", -1)):
        shock = sign * found[f"critical_shock_{way}"]
        ends = [REGIMES[work.regimes(full, steady, share * shock)[0]] for share in (0.9999, 1.0001)]
        assert ends == ["damped", "stick_slip"]


def test_undecided_starting_states_are_bounds():
    """With a step budget that is too small nothing is known, and that is said."""
    found = find(ARTICLE | {"mu_stop": 1.1, "belt_speed": 0.5}, max_steps=3)
    assert found["settling_share_low"][0] < 0.5 < found["settling_share_high"][0]
    assert found["coexisting"][0] & (1 << (REGIMES.index("unresolved") - 1))
    assert np.isnan(found["critical_shock"][0])


def test_a_belt_at_rest_has_no_steady_sliding():
    found = find(ARTICLE | {"belt_speed": 0.0})
    assert REGIMES[found["regime_from_stick"][0]] == "stuck"
    assert REGIMES[found["regime_from_sliding"][0]] == "not_computed"
    assert found["settling_share"][0] == 0.0 and np.isnan(found["critical_shock"][0])
