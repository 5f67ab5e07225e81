"""The sampler by itself, against posteriors and evidences that are known in closed form."""

import numpy as np
import pytest
from scipy import stats

from stickslip_explain.study import tempered

DESIGN = np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 1.0]])
NOISE = np.diag([0.1, 0.2]) ** 2


def of_gaussian(observed):
    """The log-likelihood of y = DESIGN u + noise."""
    noise = stats.multivariate_normal(np.zeros(2), NOISE)
    return lambda points: noise.logpdf(observed - points @ DESIGN.T)


def populations(log_likelihood, dimensions, size=400, count=24):
    return [tempered(log_likelihood, dimensions, size, np.random.default_rng([7, i])) for i in range(count)]


def test_the_linear_gaussian_posterior_and_its_evidence_are_those_of_the_closed_form():
    observed = np.array([1.0, -0.5])
    found = populations(of_gaussian(observed), 3)
    covariance = np.linalg.inv(np.eye(3) + DESIGN.T @ np.linalg.inv(NOISE) @ DESIGN)
    mean = covariance @ DESIGN.T @ np.linalg.inv(NOISE) @ observed
    each = np.array([one.points.mean(0) for one in found])
    error = each.std(0, ddof=1) / np.sqrt(len(found))
    assert (np.abs(each.mean(0) - mean) < 4 * error).all()
    assert (error < 0.05 * np.sqrt(np.diag(covariance))).all()
    spread = np.mean([np.cov(one.points.T) for one in found], axis=0)
    np.testing.assert_allclose(np.diag(spread), np.diag(covariance), rtol=0.05)
    evidence = np.array([one.log_evidence for one in found])
    true = stats.multivariate_normal(np.zeros(2), DESIGN @ DESIGN.T + NOISE).logpdf(observed)
    assert abs(evidence.mean() - true) < 4 * evidence.std(ddof=1) / np.sqrt(len(found)) + 0.01


def test_two_modes_that_no_move_connects_keep_their_shares():
    """Of the prior three quarters lie above the place that parts them: both modes are as likely, per point."""
    border = stats.norm.isf(0.75)
    width = 0.01

    def log_likelihood(points):
        x = points[:, 0]
        near = np.minimum(np.abs(x - border - 0.8), np.abs(x - border + 0.8))
        return -0.5 * (near / width) ** 2

    shares = [float((one.points[:, 0] > border).mean()) for one in populations(log_likelihood, 1)]
    low, high = stats.norm.pdf(border - 0.8), stats.norm.pdf(border + 0.8)
    assert np.mean(shares) == pytest.approx(high / (high + low), abs=4 * np.std(shares) / np.sqrt(len(shares)))


def test_impossible_points_explain_nothing():
    """A quarter of the prior is possible, and all of it alike: the evidence is its share."""
    found = populations(lambda u: np.where(u[:, 0] > stats.norm.isf(0.25), 0.0, -np.inf), 2)
    assert all((one.points[:, 0] > stats.norm.isf(0.25)).all() for one in found)
    assert np.mean(np.exp([one.log_evidence for one in found])) == pytest.approx(0.25, abs=0.02)
    none = tempered(lambda u: np.full(len(u), -np.inf), 2, 50, np.random.default_rng(1))
    assert none.log_evidence == -np.inf


def test_a_seed_gives_the_same_draws():
    one, other = (tempered(of_gaussian(np.zeros(2)), 3, 100, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one.points, other.points)


@pytest.mark.slow
def test_ranks_of_the_truth_are_uniform_in_the_linear_gaussian_case():
    """Simulation-based calibration (Talts et al. 2018), 1,000 data sets."""
    rng, ranks = np.random.default_rng(11), []
    for i in range(1000):
        truth = rng.standard_normal(3)
        observed = DESIGN @ truth + rng.multivariate_normal(np.zeros(2), NOISE)
        found = tempered(of_gaussian(observed), 3, 190, np.random.default_rng([12, i]))
        ranks.append((found.points[rng.permutation(190)[:19]] < truth).sum(0))
    for column in np.transpose(ranks):
        assert stats.chisquare(np.bincount(column, minlength=20)).pvalue > 0.01
