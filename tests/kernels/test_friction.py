import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kernel_runs import ARTICLE
from stickslip_kernels.friction import line_slope, speed_of_slope, stribeck, stribeck_slope

coefficients = st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.floats(0.01, 2.0))


@given(st.floats(0.0, 5.0), coefficients)
def test_stribeck_is_equation_2(w, a):
    a1, a2, a3, a4 = a
    assert stribeck(w, *a) == pytest.approx(a1 + a2 * w + a3 * math.exp(-w / a4), rel=1e-14)


@given(st.floats(0.1, 5.0), coefficients)
def test_slope_is_the_derivative_of_the_curve(w, a):
    step = 1e-5 * a[3]
    difference = (stribeck(w + step, *a) - stribeck(w - step, *a)) / (2 * step)
    assert stribeck_slope(w, *a[1:]) == pytest.approx(difference, abs=1e-5)


def test_the_articles_curve_has_its_minimum_where_the_article_says():
    v_min = speed_of_slope(0.0, *ARTICLE[1:])
    assert v_min == pytest.approx(0.340, abs=5e-4)
    assert stribeck(v_min, *ARTICLE) == pytest.approx(1.0440, abs=5e-5)
    assert stribeck(0.0, *ARTICLE) == pytest.approx(1.3)


@given(st.floats(-3.0, 1.9), coefficients)
def test_speed_of_slope_inverts_the_slope(slope, a):
    w = speed_of_slope(slope, *a[1:])
    if 0.0 < w < math.inf:
        assert stribeck_slope(w, *a[1:]) == pytest.approx(slope, abs=1e-9)
    elif w == 0.0:
        assert stribeck_slope(0.0, *a[1:]) >= slope - 1e-9
    else:
        assert stribeck_slope(1e3, *a[1:]) <= slope + 1e-9


def test_the_line_of_equation_2a_joins_reversal_and_stop():
    slope = line_slope(0.3, 1.05, 1.2)
    assert 1.2 + slope * 0.3 == pytest.approx(1.05)
