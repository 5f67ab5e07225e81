"""Areas inside cycles and their extent, against closed forms."""

import numpy as np
import pytest

from stickslip.studies.exact import area_in_box, largest, velocities_at_rest_point

SAMPLES = 513


def ellipse(width, height):
    """A clockwise ellipse in the plane (x, v), v being the derivative of x: x, v and accelerations."""
    rate = height / width
    phase = np.linspace(0.0, 2.0 * np.pi, SAMPLES)[np.newaxis] + 0.3  # no sample at an extreme
    return width * np.sin(phase), height * np.cos(phase), -height * rate * np.sin(phase)


def area(width, height, *ends):
    period = np.array([2.0 * np.pi * width / height])
    return area_in_box(*ellipse(width, height), period, *(np.array([float(end)]) for end in ends))[0]


@pytest.mark.parametrize(
    ("ends", "exact"),
    [
        ((-9, 9, -9, 9), np.pi),
        ((-9, 9, 0, 9), np.pi / 2),
        ((0, 9, 0, 9), np.pi / 4),
        ((0.5, 9, -9, 9), np.pi / 3 - np.sqrt(3) / 4),  # the segment beyond half the radius
        ((-9, 9, -9, -0.5), np.pi / 3 - np.sqrt(3) / 4),
        ((-0.5, 0.5, -0.5, 0.5), 1.0),  # a box inside
        ((0.8, 9, 0.7, 9), 0.0),  # a corner beyond the circle
        ((2, 3, -1, 1), 0.0),
        ((-2, 2, 1.5, 3), 0.0),
    ],
)
def test_area_of_a_circle_cut_by_a_box(ends, exact):
    assert area(1.0, 1.0, *ends) == pytest.approx(exact, abs=1e-6)


def test_the_four_quadrants_about_any_point_hold_the_whole_ellipse():
    draw = np.random.default_rng(2)
    for x, v in draw.uniform(-1, 1, (20, 2)):
        quadrants = [(-9, x, -9, v), (x, 9, -9, v), (-9, x, v, 9), (x, 9, v, 9)]
        total = sum(area(1.3, 0.7, *ends) for ends in quadrants)
        assert total == pytest.approx(np.pi * 1.3 * 0.7, rel=1e-6)


def test_extremes_and_passings_lie_between_samples():
    x, v, a = ellipse(1.3, 0.7)
    extremes = [largest(x), largest(-x), largest(v), largest(-v), *velocities_at_rest_point(x, v, a)]
    assert np.concatenate(extremes) == pytest.approx([1.3, 1.3, 0.7, 0.7, 0.7, -0.7], rel=1e-8)
