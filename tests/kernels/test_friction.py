"""Every law: its slope is a derivative, and the speeds of a given slope are where they should be."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import njit

from helpers.kernel_runs import ARTICLE, block_of, cell
from stickslip_kernels.contacts.stribeck import friction
from stickslip_kernels.contacts.stribeck.laws import LAWS

SHAPES = {
    "stribeck": lambda z, delta: math.exp(-z),
    "stribeck_delta": lambda z, delta: math.exp(-(z**delta)),
    "rational": lambda z, delta: 1 / (1 + z),
    "cubic": lambda z, delta: 1 - 1.5 * z + 0.5 * z**3,
    "gaussian": lambda z, delta: math.exp(-z * z),
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


def test_every_law_has_a_shape_to_be_tested_against():
    assert set(SHAPES) == set(LAWS)


@every_law
@given(st.floats(0.0, 5.0), curves, exponents)
def test_coefficient_is_the_formula_of_the_law(law, w, a, delta):
    a1, a2, a3, a4 = a
    expected = a1 + a2 * w + a3 * SHAPES[law](w / a4, delta)
    size = a1 + a2 * w + a3 * (1 + (w / a4) ** 3 if law == "cubic" else 1)
    assert coefficient(LAWS[law], block_of(cell(0.1, a, delta=delta)), w) == pytest.approx(expected, abs=1e-14 * size)


@every_law
@given(curves, exponents)
def test_friction_starts_at_a1_plus_a3(law, a, delta):
    assert coefficient(LAWS[law], block_of(cell(0.1, a, delta=delta)), 0.0) == pytest.approx(a[0] + a[2], rel=1e-15)


@every_law
@given(st.floats(0.1, 4.0), curves, exponents)
def test_slope_is_the_derivative_of_the_curve(law, z, a, delta):
    tag, cells, step = LAWS[law], block_of(cell(0.1, a, delta=delta)), 1e-5 * a[3]
    w = z * a[3]
    difference = (coefficient(tag, cells, w + step) - coefficient(tag, cells, w - step)) / (2 * step)
    assert slope_at(tag, cells, w) == pytest.approx(difference, abs=1e-5 * (1 + a[2] / a[3]))


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
    beyond = np.linspace(w, w + 5 * a[3], 200)
    assert all(slope_at(tag, cells, v) >= slope - size for v in beyond)


def test_the_articles_curve_has_its_minimum_where_the_article_says():
    tag, cells = LAWS["stribeck"], block_of(cell(0.1, ARTICLE))
    v_min = speed_of_slope(tag, cells, 0.0)
    assert v_min == pytest.approx(0.340119738, abs=1e-9)
    assert coefficient(tag, cells, v_min) == pytest.approx(1.044011974, abs=1e-9)


def test_exponent_one_is_the_plain_exponential():
    cells = block_of(cell(0.1))
    for w in np.linspace(0, 2, 30):
        plain, general = (coefficient(LAWS[law], cells, w) for law in ("stribeck", "stribeck_delta"))
        assert general == pytest.approx(plain, rel=1e-14)


def test_a_curve_that_only_rises_has_its_minimum_at_zero_speed():
    assert speed_of_slope(LAWS["stribeck"], block_of(cell(0.1, (0.5, 0.2, 0.0, 1.0))), 0.0) == 0.0


def test_the_line_of_equation_2a_joins_reversal_and_stop():
    slope = friction.line_slope(0.3, 1.05, 1.2)
    assert 1.2 + slope * 0.3 == pytest.approx(1.05)


def test_a_slope_of_almost_nothing_ends_the_search():
    """Near the smallest double the exponential has a floor, under which no slope can be found."""
    for a2 in (5e-324, 1e-308, 1e-295):
        assert speed_of_slope(LAWS["stribeck_delta"], block_of(cell(0.1, (1.0, a2, 0.3, 0.1), delta=3.0)), 0.0) > 0.0
