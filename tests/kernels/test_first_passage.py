"""The moment a load passes what the contact bears, against a dense look at the excess."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from stickslip_kernels.contacts.stribeck.stick import first_passage

RATES = st.one_of(st.just(0.0), st.floats(1e-3, 2.0).flatmap(lambda x: st.sampled_from([x, -x])))
GROWTHS = st.one_of(st.just(0.0), st.floats(1e-3, 0.5))
LEFT = 5.0
TINY = 1e-12


def excess(load, rate, alpha, limit, growth, later, t):
    return load + rate * t + 0.5 * alpha * t * t - limit - growth * np.log1p(t / later)


@settings(max_examples=400)
@given(st.floats(-2.0, 2.0), RATES, RATES, st.floats(0.05, 1.5), GROWTHS, st.floats(0.01, 10.0))
def test_it_is_the_first_time_at_which_the_load_exceeds_the_limit(load, rate, alpha, limit, growth, later):
    case = (load, rate, alpha, limit, growth, later)
    found = first_passage(*case, LEFT)
    times = np.union1d(np.linspace(0.0, LEFT, 4001), LEFT * np.geomspace(1e-9, 1.0, 400))
    over = excess(*case, times)
    if found == math.inf:
        assert over.max() <= TINY
        return
    assert 0.0 <= found <= LEFT
    assert over[times < found].max(initial=-1.0) <= TINY
    here = excess(*case, found)
    assert here == pytest.approx(0.0, abs=TINY) if found > 0.0 else here >= -TINY
    # and it goes on rising there
    assert excess(*case, min(found * (1.0 + 1e-4) + 1e-6, LEFT)) > -TINY or found == pytest.approx(LEFT)


@settings(max_examples=200)
@given(st.floats(0.05, 2.0), st.floats(0.1, 2.0), st.floats(0.1, 1.5), st.floats(-1e-9, 1e-9))
def test_a_load_that_only_just_touches_the_limit_passes_it_if_it_is_above(rate, alpha, limit, over):
    """Rising at `rate`, slowed by `alpha`: the peak lies at rate/alpha, rate^2/(2 alpha) higher."""
    assume(abs(over) > 1e-13 and rate / alpha < LEFT)
    load = limit + over - 0.5 * rate * rate / alpha
    found = first_passage(load, rate, -alpha, limit, 0.0, 1.0, LEFT)
    if over < 0.0:
        assert found == math.inf
    else:
        assert found == pytest.approx(rate / alpha - math.sqrt(2.0 * over / alpha), rel=1e-3, abs=1e-7)
        assert rate - alpha * found > 0.0


@pytest.mark.parametrize("ulps", range(-4, 5))
def test_a_load_at_the_limit_but_for_rounding_is_not_above_it(ulps):
    load = 0.4 + ulps * math.ulp(0.4)
    for rate, alpha, passes in ((-0.1, 0.0, math.inf), (-0.1, 0.1, 2.0), (0.1, 0.0, 0.0)):
        assert first_passage(load, rate, alpha, 0.4, 0.0, 1.0, LEFT) == pytest.approx(passes, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize(("case", "left", "passes"), [
    ((0.5, -1.0, -1.0, 0.4, 0.0), LEFT, 0.0),  # above it already
    ((0.4, 0.0, 0.0, 0.4, 0.0), LEFT, math.inf), ((0.4, 0.0, 0.0, 0.4, 0.1), LEFT, math.inf),  # a steady load
    ((0.3, 1.0, 1.0, 0.4, 0.0), 0.0, math.inf),  # no time
])  # fmt: skip
def test_what_passes_now_or_never(case, left, passes):
    assert first_passage(*case, 1.0, left) == passes


@given(st.floats(0.01, 1.0), st.floats(0.0, 0.39), st.floats(0.01, 0.2), st.floats(0.1, 5.0))
def test_under_a_limit_that_grows_a_steady_rise_passes_where_it_meets_it(rate, load, growth, later):
    """The equation of a steady rise put back in."""
    found = first_passage(load, rate, 0.0, 0.4, growth, later, 1e4)
    assert load + rate * found == pytest.approx(0.4 + growth * math.log1p(found / later), rel=1e-12)
