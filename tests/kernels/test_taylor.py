"""The Taylor step against SciPy at tight tolerance, its coefficients against series by mpmath, and its own check."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.slip_step import DROP, GAMMA, RATE, SLOPE, W0, Y0, B, end_of_step, exact, lanes
from stickslip_kernels import layout as at
from stickslip_kernels import taylor
from stickslip_kernels.laws import LAWS

RTOL = 1e-9
LAW = LAWS["stribeck"]


def series(base, count, s, lane=0):
    return s[base + lane :: at.WIDTH][:count]


def test_coefficients_are_the_derivatives_of_the_motion():
    """Products of series in 40 digits, written independently: x by the exponential series, not by x' = -rate x w'."""
    s = lanes()
    taylor.expand(s)
    with mpmath.workdps(40):
        y, w = [mpmath.mpf(Y0)], [mpmath.mpf(W0)]
        for n in range(at.ORDER):
            powers, total = [mpmath.mpf(1)] + [mpmath.mpf(0)] * n, [mpmath.mpf(0)] * (n + 1)
            step = [mpmath.mpf(0)] + [-RATE * c for c in w[1:]]  # -rate (w - w0), which has no constant term
            for m in range(n + 1):
                total = [a + b / mpmath.factorial(m) for a, b in zip(total, powers, strict=True)]
                powers = [sum(powers[j] * step[k - j] for j in range(k + 1)) for k in range(n + 1)]
            x = DROP * mpmath.exp(-RATE * w[0]) * total[n]
            w.append((y[n] - (GAMMA + SLOPE) * w[n] - x) / (n + 1))
            y.append(((B if n == 0 else 0) - w[n]) / (n + 1))
        expected = [float(c) for c in w]
    assert series(at.SERIES, at.ORDER + 1, s) == pytest.approx(expected, rel=1e-12)
    slopes = [n * c for n, c in enumerate(expected)][1:]
    assert series(at.SERIES_DW, at.ORDER, s) == pytest.approx(slopes, rel=1e-12)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("gamma", [0.0, 0.05, 2.0])
def test_a_step_is_as_exact_as_asked(rtol, gamma):
    s = lanes(gamma=gamma)
    taylor.try_step(LAW, s, rtol)
    h = s[at.TAKEN]
    assert s[at.GOOD] == 1.0 and 0.01 < h <= taylor.LONGEST
    assert end_of_step(s) == pytest.approx(exact(h, gamma=gamma), abs=rtol + 1e-13)


def test_the_step_follows_the_tolerance_to_the_power_of_its_order():
    sizes = []
    for rtol in (1e-10, 1e-8):
        s = lanes()
        taylor.try_step(LAW, s, rtol)
        sizes.append(s[at.TAKEN])
    assert np.log(sizes[1] / sizes[0]) / np.log(100.0) == pytest.approx(1 / at.ORDER, abs=0.01)


def test_a_step_ends_with_the_horizon_and_no_later_than_allowed():
    for s in (lanes(end=0.01), lanes(step=0.01)):
        taylor.try_step(LAW, s, RTOL)
        assert s[at.TAKEN] == 0.01
        assert end_of_step(s) == pytest.approx(exact(0.01), rel=1e-14)


def test_a_step_whose_series_disagrees_with_the_equations_is_refused_and_halved():
    s = lanes()
    taylor.expand(s)
    taylor.choose_step(s, RTOL)
    s[at.TAKEN : at.TAKEN + at.WIDTH] = 4.0  # far beyond the radius of convergence
    taylor.sum_series(s)
    taylor.judge_step(s)
    assert s[at.GOOD] == 0.0 and s[at.STEP] == 2.0


def test_what_is_not_a_number_is_never_good():
    s = lanes(w=np.nan)
    taylor.try_step(LAW, s, RTOL)
    assert s[at.GOOD] == 0.0 and not s[at.STEP] >= at.SMALLEST_STEP


@given(st.floats(0.0, 2.0), st.floats(-1.0, 1.0), st.sampled_from([1e-5, 1e-8]))
def test_steps_from_anywhere_are_as_exact_as_asked(w, y, rtol):
    s = lanes(y=y, w=w)
    taylor.try_step(LAW, s, rtol)
    if s[at.GOOD] == 0.0:  # two coefficients small by chance: the step is halved
        taylor.try_step(LAW, s, rtol)
    assert s[at.GOOD] == 1.0
    y1, w1, dw1, _ = exact(s[at.TAKEN], y=y, w=w)
    assert end_of_step(s)[:3] == pytest.approx((y1, w1, dw1), abs=10 * rtol)
