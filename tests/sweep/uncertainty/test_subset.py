"""Subset simulation against probabilities that are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import integrate, stats

from stickslip.studies.uncertain import subset_simulation

REPEATED = 16


def repeated(limit_state, dimensions, samples=2000, seed=1):
    """Mean, its standard error, and the evaluations of one simulation."""
    found = [
        subset_simulation(limit_state, dimensions, samples, np.random.default_rng([seed, i])) for i in range(REPEATED)
    ]
    p = np.array([one.probability for one in found])
    return p.mean(), p.std(ddof=1) / np.sqrt(REPEATED), max(one.evaluations for one in found)


@pytest.mark.parametrize("dimensions", [1, 2, 10])
@pytest.mark.parametrize("beta", [1.0, 3.0, 4.75, 6.0])
def test_the_probability_beyond_a_plane_is_that_of_the_normal_distribution(beta, dimensions):
    direction = np.ones(dimensions) / np.sqrt(dimensions)
    mean, error, evaluations = repeated(lambda u: beta - u @ direction, dimensions)
    exact = stats.norm.sf(beta)
    assert abs(mean - exact) < 4 * error
    assert error < 0.2 * exact
    assert evaluations <= 2000 * 10


def test_the_probability_beyond_a_parabola_is_that_of_the_integral():
    beta, bend = 4.0, 0.3
    mean, error, _ = repeated(lambda u: beta - u[:, 0] + bend * u[:, 1] ** 2, 2)
    exact = integrate.quad(lambda z: stats.norm.pdf(z) * stats.norm.sf(beta + bend * z**2), -10, 10, epsabs=1e-15)[0]
    assert abs(mean - exact) < 4 * error
    assert error < 0.2 * exact


def test_two_regions_are_both_found():
    mean, error, _ = repeated(lambda u: 4.0 - np.abs(u[:, 0]), 2)
    assert abs(mean - 2 * stats.norm.sf(4.0)) < 4 * error


def test_what_cannot_be_evaluated_is_not_counted_and_said():
    found = subset_simulation(
        lambda u: np.where(u[:, 1] > 1.0, np.nan, 2.0 - u[:, 0]), 2, 10_000, np.random.default_rng(1)
    )
    assert found.probability == pytest.approx(stats.norm.sf(2.0) * stats.norm.cdf(1.0), rel=0.1)
    assert 0.05 < found.unknown < stats.norm.sf(1.0)  # chains that stay away from it meet it less


def test_where_nothing_leads_to_the_event_there_is_no_number():
    found = subset_simulation(lambda u: np.ones(len(u)), 2, 100, np.random.default_rng(1))
    assert np.isnan(found.probability) and found.evaluations < 2000
    half = subset_simulation(lambda u: np.where(u[:, 0] < -1.5, -1.0, np.inf), 2, 10_000, np.random.default_rng(1))
    assert half.probability == pytest.approx(stats.norm.cdf(-1.5), rel=0.1)  # met before there was a level


def test_an_event_that_cannot_happen_has_probability_zero():
    found = subset_simulation(lambda u: 1.0 + np.exp(-u[:, 0]), 2, 100, np.random.default_rng(1))
    assert found.probability == 0.0 and found.levels == 16
