"""Static friction that grows with contact time: break-away to high precision, cycles by iteration with SciPy."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import njit

from helpers.kernel_runs import block_of, cell, outcome
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck import stick


@njit
def dwell(cells, load, rate, age):
    static, growth, scale = stick.static_friction(cells, 0, age), cells[at.AGEING, 0], cells[at.AGEING_TIME, 0]
    return stick.steady_passage(load, rate, static, growth, scale + age)


@njit
def limit(cells, age):
    return stick.static_friction(cells, 0, age)


def exact_dwell(load, rate, static, growth, scale, age):
    """The last zero of load + rate t - static - growth ln(1 + (age + t)/scale), by Lambert W with 40 digits."""
    with mpmath.workdps(40):
        load, rate, static, growth, scale, age = map(mpmath.mpf, (load, rate, static, growth, scale, age))
        # With s = 1 + (age + t)/scale: s e^(-s rate scale/growth) = e^((load - static - rate (scale + age))/growth).
        slope = rate * scale / growth
        right = mpmath.exp((load - static - rate * (scale + age)) / growth)
        s = -mpmath.lambertw(-slope * right, -1) / slope
        return (mpmath.re(s) - 1) * scale - age


@given(
    st.floats(-2.0, 1.29),
    st.floats(1e-3, 2.0),
    st.floats(1e-3, 0.5),
    st.floats(1e-3, 10.0),
    st.sampled_from([0.0, 0.1, 30.0]),
)
def test_break_away_is_exact_to_rounding(load, rate, growth, scale, age):
    cells = block_of(cell(0.1, ageing=growth, ageing_time=scale))
    found = dwell(cells, load, rate, age)
    expected = exact_dwell(load, rate, 1.3, growth, scale, age)
    # Where the load hardly outpaces friction as it meets it, rounding of the load itself moves the time.
    pace = rate - growth / (scale + age + float(expected))
    assume(pace > 0.05 * rate)
    assert abs(mpmath.mpf(found) - expected) <= 1e-12 * expected


PUBLISHED = {"curve": (0.2, 0.0, 0.1, 1.0), "ageing": 0.02 / math.log(10)}


def test_the_published_example_is_met():
    """N = 10, k = 1000, v = 1e-3, mu0 = 0.3, beta = 0.02 per decade, t0 = 0.1, start at 1 N: 2.275137760859198 s."""
    cells = block_of(cell(0.1, **PUBLISHED, ageing_time=0.1))
    assert dwell(cells, 1.0 / 10, 1000 * 1e-3 / 10, 0.0) == pytest.approx(2.275137760859198, rel=1e-14)


def test_a_load_at_the_limit_waits_only_if_friction_first_grows_faster():
    """The trap: t = 0 is a zero, and the true one comes later (0.547898 s)."""
    faster, slower = block_of(cell(0.1, **PUBLISHED, ageing_time=1e-3)), block_of(cell(0.1, ageing=0.01))
    assert dwell(faster, limit(faster, 0.0), 0.1, 0.0) == pytest.approx(0.547898, abs=5e-7)
    assert dwell(slower, limit(slower, 0.0), 0.5, 0.0) == 0.0


def test_waiting_longer_breaks_away_higher_by_the_logarithm():
    waits = np.array([0.0, 1.0, 10.0, 100.0, 1000.0])
    found = [outcome(0.05, ageing=0.02, ageing_time=0.5, contact=t) for t in waits]
    loads = np.array([0.05 * f.breakaway_time for f in found])
    times = np.array([f.breakaway_time for f in found])
    np.testing.assert_allclose(loads, 1.3 + 0.02 * np.log1p((waits + times) / 0.5), rtol=1e-13)
