"""Areas inside cycles, against closed forms."""

import numpy as np
import pytest

from stickslip.studies.attractors.area import Orbits, area_in_box, velocities_at_rest_point

SAMPLES = 513  # cubics through so many are good to 3e-10


def ellipses(width, height):
    """Clockwise ellipses in the plane (x, v), v being the derivative of x; their period follows."""
    width, height = np.atleast_1d(width).astype(float), np.atleast_1d(height).astype(float)
    rate = height / width
    phase = np.linspace(0.0, 2.0 * np.pi, SAMPLES) + 0.3  # no sample at an extreme
    x = width[:, np.newaxis] * np.sin(phase)
    v, a = height[:, np.newaxis] * np.cos(phase), -height[:, np.newaxis] * rate[:, np.newaxis] * np.sin(phase)
    return Orbits(x, v, a, 2.0 * np.pi / rate)


def box(left, right, low, high):
    return (np.array([float(end)]) for end in (left, right, low, high))


def test_area_of_an_ellipse_in_a_large_box():
    found = area_in_box(ellipses([1.0, 2.0], [1.0, 0.1]), *(np.full(2, end) for end in (-9.0, 9.0, -9.0, 9.0)))
    assert found == pytest.approx([np.pi, 0.2 * np.pi], rel=1e-11)


@pytest.mark.parametrize(
    ("ends", "area"),
    [
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
def test_area_of_a_circle_cut_by_a_box(ends, area):
    assert area_in_box(ellipses(1.0, 1.0), *box(*ends))[0] == pytest.approx(area, abs=1e-9)


def test_the_four_quadrants_about_any_point_hold_the_whole_ellipse():
    """Any point cuts the plane into four boxes; together they hold the whole ellipse."""
    draw = np.random.default_rng(2)
    for x, v in draw.uniform(-1, 1, (20, 2)):
        quadrants = [(-9, x, -9, v), (x, 9, -9, v), (-9, x, v, 9), (x, 9, v, 9)]
        total = sum(area_in_box(ellipses(1.3, 0.7), *box(*one))[0] for one in quadrants)
        assert total == pytest.approx(np.pi * 1.3 * 0.7, rel=1e-9)


def test_extremes_and_passings_lie_between_samples():
    orbits = ellipses(1.3, 0.7)
    assert np.concatenate(orbits.extremes(orbits.x, orbits.v)) == pytest.approx([1.3, -1.3], rel=1e-9)
    assert np.concatenate(orbits.extremes(orbits.v, orbits.a)) == pytest.approx([0.7, -0.7], rel=1e-9)
    assert np.concatenate(velocities_at_rest_point(orbits)) == pytest.approx([0.7, -0.7], rel=1e-9)
