"""The Taylor step against SciPy at tight tolerance, its coefficients against series by mpmath, and its own check."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.nightly import few
from helpers.slip_step import DROP, GAMMA, RATE, SLOPE, W0, Y0, B, end_of_step, exact, lanes
from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck import taylor
from stickslip_kernels.contacts.stribeck.laws import LAWS, RECURRENCES

RTOL = 1e-9
WITH_SERIES = [name for name, tag in LAWS.items() if type(tag) in RECURRENCES]
EVERY_LAW = pytest.mark.parametrize("law", few(WITH_SERIES, ["stribeck"]))
SHAPES = {
    "stribeck": lambda z: mpmath.exp(-z),
    "rational": lambda z: 1 / (1 + z),
    "gaussian": lambda z: mpmath.exp(-z * z),
    "cubic": lambda z: 1 - 3 * z / 2 + z**3 / 2,
}


def series(base, count, s, lane=0):
    return s[base + lane :: at.WIDTH][:count]


@EVERY_LAW
def test_coefficients_are_the_derivatives_of_the_motion(law):
    """Products of series in 40 digits, written independently: the series of the shape, composed with the motion."""
    s = lanes(law)
    taylor.expand(LAWS[law], s)
    with mpmath.workdps(40):
        y, w = [mpmath.mpf(Y0)], [mpmath.mpf(W0)]
        shape = mpmath.taylor(SHAPES[law], mpmath.mpf(RATE) * w[0], at.ORDER)
        for n in range(at.ORDER):
            powers, total = [mpmath.mpf(1)] + [mpmath.mpf(0)] * n, [mpmath.mpf(0)] * (n + 1)
            step = [mpmath.mpf(0)] + [RATE * c for c in w[1:]]  # rate (w - w0), which has no constant term
            for m in range(n + 1):
                total = [a + b * shape[m] for a, b in zip(total, powers, strict=True)]
                powers = [sum(powers[j] * step[k - j] for j in range(k + 1)) for k in range(n + 1)]
            w.append((y[n] - (GAMMA + SLOPE) * w[n] - DROP * total[n]) / (n + 1))
            y.append(((B if n == 0 else 0) - w[n]) / (n + 1))
        expected = [float(c) for c in w]
    assert series(at.SERIES, at.ORDER + 1, s) == pytest.approx(expected, rel=1e-12)
    slopes = [n * c for n, c in enumerate(expected)][1:]
    assert series(at.SERIES_DW, at.ORDER, s) == pytest.approx(slopes, rel=1e-12)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("gamma", [0.0, 0.05, 2.0])
@EVERY_LAW
def test_a_step_is_as_exact_as_asked(law, rtol, gamma):
    s = lanes(law, gamma=gamma)
    taylor.try_step(LAWS[law], s, rtol)
    h = s[at.TAKEN]
    assert s[at.GOOD] == 1.0 and 0.01 < h <= s[at.LONGEST]
    assert end_of_step(s) == pytest.approx(exact(h, law, gamma=gamma), abs=rtol + 1e-13)


@EVERY_LAW
def test_a_step_ends_with_the_horizon_and_no_later_than_allowed(law):
    for s in (lanes(law, end=0.01), lanes(law, step=0.01)):
        taylor.try_step(LAWS[law], s, RTOL)
        assert s[at.TAKEN] == 0.01
        assert end_of_step(s) == pytest.approx(exact(0.01, law), rel=1e-14)


@EVERY_LAW
def test_a_step_whose_series_disagrees_with_the_equations_or_is_no_number_is_refused(law):
    s = lanes(law)
    taylor.expand(LAWS[law], s)
    taylor.choose_step(s, RTOL)
    s[at.TAKEN : at.TAKEN + at.WIDTH] = 4.0  # far beyond the radius of convergence
    taylor.sum_series(s)
    taylor.judge_step(LAWS[law], s)
    assert s[at.GOOD] == 0.0 and s[at.STEP] == 2.0
    s = lanes(law, w=np.nan)
    taylor.try_step(LAWS[law], s, RTOL)
    assert s[at.GOOD] == 0.0 and not s[at.STEP] >= at.SMALLEST_STEP


@pytest.mark.slow
def test_a_step_across_a_gaussian_zone_that_neither_end_shows_is_refused():
    """Its series and the equations agree at both ends, twenty a4 above standstill and below."""
    s = lanes("gaussian", y=-2.0, w=0.02, rate=1e3)
    taylor.expand(LAWS["gaussian"], s)
    taylor.choose_step(s, 1e-6)
    s[at.TAKEN : at.TAKEN + at.WIDTH] = 0.02
    taylor.sum_series(s)
    series_end = s[at.DW_NEW]
    taylor.judge_step(LAWS["gaussian"], s)
    assert s[at.W_NEW] < -0.01 and s[at.DW_NEW] == pytest.approx(series_end, rel=1e-9)
    assert s[at.GOOD] == 0.0 and s[at.STEP] == 0.01


@EVERY_LAW
@given(w=st.floats(0.0, 2.0), y=st.floats(-1.0, 1.0), rtol=st.sampled_from([1e-5, 1e-8]))
def test_steps_from_anywhere_are_as_exact_as_asked(law, w, y, rtol):
    s = lanes(law, y=y, w=w)
    for _ in range(8):  # two coefficients small by chance: the step is halved
        taylor.try_step(LAWS[law], s, rtol)
        if s[at.GOOD] == 1.0:
            break
    assert s[at.GOOD] == 1.0
    y1, w1, dw1, _ = exact(s[at.TAKEN], law, y=y, w=w)
    assert end_of_step(s)[:3] == pytest.approx((y1, w1, dw1), abs=10 * rtol)
