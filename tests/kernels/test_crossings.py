"""Crossings and extrema that many lanes ask for at once are those of one lane."""

import numpy as np
import pytest

from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.laws import LAWS
from stickslip_kernels.crossings import find_crossings
from stickslip_kernels.dense import speed
from stickslip_kernels.observers.tops import find_tops
from stickslip_kernels.roots import passage_in_lane

RANDOM = np.random.default_rng(5)
ASKING = np.flatnonzero(RANDOM.random(at.WIDTH) < 0.4)  # more than one group


def steps(first, spread):
    """A buffer with another polynomial of w in every lane, over a step of length 1; the polynomials."""
    s, polynomials = np.zeros(at.LANE_NUMBERS), []
    for i in range(at.WIDTH):
        p = np.polynomial.Polynomial(np.array(first) + spread * RANDOM.uniform(-1.0, 1.0, len(first)))
        polynomials.append(p)
        for n, c in enumerate(p.coef):
            s[at.SERIES + n * at.WIDTH + i] = c
        s[[at.W + i, at.DW + i, at.JERK + i]] = p(0.0), p.deriv()(0.0), p.deriv(2)(0.0)
        s[[at.W_NEW + i, at.DW_NEW + i, at.JERK_NEW + i]] = p(1.0), p.deriv()(1.0), p.deriv(2)(1.0)
        s[at.TAKEN + i], s[at.B + i] = 1.0, 0.7
    return s, polynomials


def test_crossings_are_those_of_the_scalar_search():
    s, polynomials = steps([0.0, 1.0, 0.2, -0.1, 0.05, 0.02], 0.05)
    for i in range(at.WIDTH):
        s[at.LEVEL + i], s[at.SIDE + i] = 0.5, 1.0
    s[at.CROSSES + ASKING] = 1.0
    find_crossings(s)
    assert np.count_nonzero(s[at.CROSSES : at.CROSSES + at.WIDTH]) == len(ASKING) > 8
    for i in ASKING:
        t, rise, _, _ = passage_in_lane(s, i, 0.5, 1.0, 1.0, speed(s, i, 1.0))
        assert s[at.CROSS_LEVEL + i] == 0.5
        assert (s[at.CROSS_TIME + i], s[at.CROSS_RISE + i]) == pytest.approx((t, rise), rel=1e-14)
        assert s[at.CROSS_FALLEN + i] == pytest.approx(polynomials[i].integ(2)(t), rel=1e-13)


def test_a_crossing_that_the_lanes_miss_is_left_to_the_scalar_search():
    """A step that is far from its series: nothing between its ends crosses."""
    s, _ = steps([0.0, 1.0, 0.2], 0.0)
    s[at.SERIES : at.SERIES + at.WIDTH] = 5.0
    s[at.LEVEL : at.LEVEL + at.WIDTH], s[at.SIDE : at.SIDE + at.WIDTH] = 0.5, 1.0
    s[at.CROSSES : at.CROSSES + at.WIDTH] = 1.0
    find_crossings(s)
    assert not s[at.CROSSES : at.CROSSES + at.WIDTH].any()


@pytest.mark.parametrize(("what", "order"), [(at.OF_SPEED, 1), (at.OF_SLOPE, 2)])
def test_extrema_are_those_of_the_polynomial(what, order):
    """Of w, and of w', whose value then comes from the equation of motion."""
    first = [0.3, 1.0, -0.9, -0.05, 0.02, 0.01] if order == 1 else [0.3, 0.5, 0.9, -0.6, 0.02, 0.01]
    s, polynomials = steps(first, 0.02)
    s[at.SOUGHT + ASKING] = what
    find_tops(LAWS["stribeck_delta"], s)  # whose series is not compared with the equation of motion
    for i in ASKING:
        assert s[at.SOUGHT + i] == what and s[at.LOOK + i] == 0.0
        roots = polynomials[i].deriv(order).roots()
        t = next(r.real for r in roots if abs(r.imag) < 1e-9 and 0.0 < r.real < 1.0)
        assert s[at.TOP + i] == pytest.approx(polynomials[i](t), rel=1e-12)
        assert s[at.TOP_TIME + i] == pytest.approx(t, rel=1e-12)
