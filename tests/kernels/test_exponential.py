import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip_kernels.exponential import exp, log, rough_exp2, rough_log2


@given(st.floats(-708.0, 700.0))
def test_exp_is_that_of_libm_to_rounding(x):
    assert math.isclose(exp(x), math.exp(x), rel_tol=1e-15)


@given(st.floats(-2.0, 2.0))
def test_exp_is_exact_to_rounding_near_zero(x):
    assert math.isclose(exp(x), math.exp(x), rel_tol=5e-16)


def test_exp_of_zero_is_one():
    assert exp(0.0) == 1.0


@given(st.floats(-1e300, 1e300))
def test_exp_saturates_instead_of_overflowing(x):
    assert exp(-708.0) <= exp(x) <= exp(700.0)


@given(st.floats(1e-300, 1e300), st.sampled_from([-1.0, 1.0]))
def test_rough_log2_is_a_little_below_that_of_the_size(x, sign):
    assert -0.087 < rough_log2(sign * x) - math.log2(x) < 1e-9


@pytest.mark.parametrize(("x", "least", "most"), [(0.0, -1023, -1023), (5e-324, -1023, -1022), (math.inf, 1024, 1024)])
def test_rough_log2_of_what_has_no_logarithm(x, least, most):
    assert least <= rough_log2(x) <= most


def test_rough_log2_of_nan_is_beyond_all_numbers():
    assert rough_log2(math.nan) > 1024


@given(st.floats(-1000.0, 1000.0))
def test_rough_exp2_is_good_to_one_per_cent(x):
    assert math.isclose(rough_exp2(x), 2.0**x, rel_tol=0.01)


@given(st.floats(1e-300, 1e300))
def test_log_is_that_of_libm_to_rounding(x):
    assert math.isclose(log(x), math.log(x), rel_tol=1e-15, abs_tol=4e-16)


@given(st.floats(0.5, 2.0))
def test_log_near_one_is_exact_to_rounding(x):
    assert math.isclose(log(x), math.log(x), rel_tol=1e-14, abs_tol=3e-16)


def test_log_of_zero_is_very_negative():
    assert log(0.0) < -700.0
