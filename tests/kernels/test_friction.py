"""Every law: its formula, its slope, and the speeds of a given slope."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import njit

from helpers.kernel_runs import ARTICLE, block_of, cell
from stickslip_kernels.contacts.stribeck import friction
from stickslip_kernels.contacts.stribeck.laws import LAWS

SHAPES = {
    "stribeck": lambda z, delta: mpmath.exp(-z),
    "stribeck_delta": lambda z, delta: mpmath.exp(-(z**delta)),
    "rational": lambda z, delta: 1 / (1 + z),
    "cubic": lambda z, delta: 1 - 1.5 * z + 0.5 * z**3,
    "gaussian": lambda z, delta: mpmath.exp(-z * z),
}


@njit
def coefficient(law, cells, w):
    return friction.coefficient(law, cells, 0, w)


@njit
def slope_at(law, cells, w):
    return friction.coefficient_slope(law, cells, 0, w)


@njit
def speed_of_slope(law, cells, slope):
    return friction.speed_of_slope(law, cells, 0, slope)


curves = st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.floats(0.01, 2.0), st.floats(0.01, 2.0))
exponents = st.floats(1.0, 4.0)
every_law = pytest.mark.parametrize("law", LAWS)


@every_law
@given(st.floats(0.0, 5.0), curves, exponents)
def test_coefficient_and_slope_are_those_of_the_formula_of_the_law(law, w, a, delta):
    a1, a2, a3, a4 = a
    tag, cells = LAWS[law], block_of(cell(0.1, a, delta=delta))
    size = a1 + a2 * w + a3 * (1 + (w / a4) ** 3 if law == "cubic" else 1)
    expected = a1 + a2 * w + a3 * float(SHAPES[law](w / a4, delta))
    assert coefficient(tag, cells, w) == pytest.approx(expected, abs=1e-14 * size)
    assert coefficient(tag, cells, 0.0) == pytest.approx(a1 + a3, rel=1e-15)
    z = w / a4
    assume(0.01 < z < 50.0)
    slope = a2 + a3 / a4 * float(mpmath.diff(lambda z: SHAPES[law](z, delta), z))
    assert slope_at(tag, cells, w) == pytest.approx(slope, rel=1e-9, abs=1e-9 * (1 + a3 / a4) * (1 + z**2))


@every_law
@given(st.floats(-3.0, 1.9), curves, exponents)
def test_speed_of_slope_is_the_last_place_with_that_slope(law, slope, a, delta):
    tag, cells = LAWS[law], block_of(cell(0.1, a, delta=delta))
    w = speed_of_slope(tag, cells, slope)
    size = 1e-7 * (1 + abs(slope) + a[2] / a[3])
    if w == math.inf:
        assert slope_at(tag, cells, 1e3 * a[3]) <= slope + size
        return
    assume(w < 100 * a[3])
    if w > 0.0:
        assert slope_at(tag, cells, w) == pytest.approx(slope, abs=size)
    assert all(slope_at(tag, cells, v) >= slope - size for v in np.linspace(w, w + 5 * a[3], 200))


def test_the_articles_curve_has_its_minimum_where_the_article_says():
    tag, cells = LAWS["stribeck"], block_of(cell(0.1, ARTICLE))
    v_min = speed_of_slope(tag, cells, 0.0)
    assert v_min == pytest.approx(0.340119738, abs=1e-9)
    assert coefficient(tag, cells, v_min) == pytest.approx(1.044011974, abs=1e-9)
    assert speed_of_slope(tag, block_of(cell(0.1, (0.5, 0.2, 0.0, 1.0))), 0.0) == 0.0  # it only rises
    for a2 in (5e-324, 1e-308, 1e-295):  # near the smallest double the exponential has a floor
        assert speed_of_slope(LAWS["stribeck_delta"], block_of(cell(0.1, (1.0, a2, 0.3, 0.1), delta=3.0)), 0.0) > 0.0
