"""exp, log and their rough relatives against libm."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip_kernels.arithmetic import exp, log, rough_exp2, rough_log2


@given(st.floats(-708.0, 700.0), st.floats(-2.0, 2.0), st.floats(-1e300, 1e300))
def test_exp_is_that_of_libm_to_rounding_and_saturates_beyond(x, small, any_size):
    assert math.isclose(exp(x), math.exp(x), rel_tol=1e-15)
    assert math.isclose(exp(small), math.exp(small), rel_tol=5e-16) and exp(0.0) == 1.0
    assert exp(-708.0) <= exp(any_size) <= exp(700.0)


@given(st.floats(1e-300, 1e300), st.floats(0.5, 2.0))
def test_log_is_that_of_libm_to_rounding(x, near_one):
    assert math.isclose(log(x), math.log(x), rel_tol=1e-15, abs_tol=4e-16)
    assert math.isclose(log(near_one), math.log(near_one), rel_tol=1e-14, abs_tol=3e-16)
    assert log(0.0) < -700.0


@given(st.floats(1e-300, 1e300), st.sampled_from([-1.0, 1.0]), st.floats(-1000.0, 1000.0))
def test_rough_ones_are_good_to_a_few_per_cent(x, sign, power):
    assert -0.087 < rough_log2(sign * x) - math.log2(x) < 1e-9
    assert math.isclose(rough_exp2(power), 2.0**power, rel_tol=0.01)


@pytest.mark.parametrize(
    ("x", "least", "most"),
    [(0.0, -1023, -1023), (5e-324, -1023, -1022), (math.inf, 1024, 1024), (math.nan, 1024.1, math.inf)],
)
def test_rough_log2_of_what_has_no_logarithm(x, least, most):
    assert least <= rough_log2(x) <= most
