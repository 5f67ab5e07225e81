import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip_kernels.polynomial import deflated, derivative, hermite, minus, root, scaled, value

numbers = st.floats(-3.0, 3.0).map(lambda x: round(x, 6))
polynomials = st.tuples(*[numbers] * 6)


@given(polynomials, st.floats(0.1, 10.0))
def test_hermite_recovers_a_quintic_from_its_ends(p, h):
    of_time = np.polynomial.Polynomial([c / h**n for n, c in enumerate(p)])
    ends = [f(t) for t in (0.0, h) for f in (of_time, of_time.deriv(), of_time.deriv(2))]
    assert hermite(h, *ends) == pytest.approx(p, abs=1e-9)


@given(polynomials, st.floats(0.0, 1.0), numbers, numbers)
def test_arithmetic_is_that_of_numpy(p, theta, level, factor):
    expected = np.polynomial.Polynomial(p)
    assert value(p, theta) == pytest.approx(expected(theta), abs=1e-12)
    assert value(derivative(p), theta) == pytest.approx(expected.deriv()(theta), abs=1e-12)
    assert value(minus(scaled(p, factor), level), theta) == pytest.approx(factor * expected(theta) - level, abs=1e-12)


@given(polynomials, st.floats(0.001, 3.0))
def test_root_is_one(p, at_end):
    p = (-at_end, *p[1:5], 0.0)
    p = (*p[:5], at_end - sum(p))  # from -at_end at theta = 0 to at_end at theta = 1
    theta = root(p, 0.0, 1.0)
    assert 0.0 <= theta <= 1.0
    nearby = np.array([value(p, t) for t in (max(theta - 1e-6, 0.0), min(theta + 1e-6, 1.0))])
    assert abs(value(p, theta)) < 1e-10 or nearby.prod() <= 0.0


def test_without_a_change_of_sign_the_end_returns():
    assert root((1.0, 0.0, 1.0, 0.0, 0.0, 0.0), 0.0, 1.0) == 1.0


@given(st.floats(0.1, 0.9), st.integers(1, 2))
def test_deflation_takes_away_the_zero_one_stands_on(where, multiplicity):
    zeros = np.polynomial.Polynomial.fromroots([0.0] * multiplicity + [where]).coef
    p = tuple(float(c) for c in zeros) + (0.0,) * (6 - len(zeros))
    assert root(deflated(p), 0.0, 1.0) == pytest.approx(where, abs=1e-10)
