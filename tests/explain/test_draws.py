"""The likelihood against its definition, and the sampler against posteriors and evidences in closed form."""

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from stickslip.vocabulary.quantities import REGIMES
from stickslip_explain.likelihood import observation_terms
from stickslip_explain.section import Observation
from stickslip_explain.study import tempered

STICK_SLIP, DAMPED, CREEP, UNRESOLVED = (REGIMES.index(n) for n in ("stick_slip", "damped", "creep", "unresolved"))


def terms(observed, regime, mislabelled=0.08, **results):
    columns = {name: np.asarray(values, float) for name, values in results.items()}
    return observation_terms(
        Observation.model_validate(observed), {"regime": np.asarray(regime), **columns}, mislabelled
    )


def test_a_regime_alone_counts_and_labels_of_all_regimes_sum_to_one():
    found = [np.exp(terms({"regime": name}, [DAMPED]).log_likelihood[0])
             for name in ("stick_slip", "damped", "creep", "sustained", "stuck")]  # fmt: skip
    assert found == pytest.approx([0.02, 0.92, 0.02, 0.02, 0.02])
    either = terms({"regime": ["damped", "creep"]}, [DAMPED, STICK_SLIP])
    np.testing.assert_allclose(np.exp(either.log_likelihood), [0.94, 0.04])
    assert either.contradicts.tolist() == [False, True]


def test_the_logarithm_of_a_result_scatters_normally_and_counts_where_a_cell_has_it():
    found = terms({"regime": "stick_slip", "period": "54 +- 2 ms"}, [STICK_SLIP, STICK_SLIP, DAMPED],
                  period=[0.054, 0.060, np.nan])  # fmt: skip
    density = stats.norm(np.log(0.054), 2 / 54)
    expected = [np.log(0.92) + density.logpdf(np.log(value)) for value in (0.054, 0.060)] + [np.log(0.02)]
    np.testing.assert_allclose(found.log_likelihood, expected, rtol=1e-12)
    assert found.contradicts.tolist() == [False, False, True]
    assert terms({"period": "54 ms +- 1 %"}, [STICK_SLIP], period=[0.06]).contradicts[0]


def test_repeats_have_the_likelihood_of_a_normal_scatter_that_nobody_knows():
    """Student's t is the normal density integrated over the standard deviation with the prior 1/sigma."""
    repeats = np.array([0.050, 0.054, 0.057])

    def marginal(period):
        deviations = np.log(repeats) - np.log(period)
        return quad(lambda u: np.prod(stats.norm.pdf(deviations, scale=np.exp(u))), -9, 6, limit=400)[0]

    periods = np.array([0.040, 0.054, 0.075])
    found = terms({"period": repeats.tolist()}, [STICK_SLIP] * 3, period=periods).log_likelihood
    expected = np.log([marginal(one) for one in periods])
    np.testing.assert_allclose(found - found[1], expected - expected[1], rtol=1e-6)


def test_cells_without_a_verdict_bound_the_likelihood_from_both_sides():
    found = terms({"regime": "damped"}, [UNRESOLVED, DAMPED])
    np.testing.assert_allclose(np.exp(found.log_likelihood), [0.92, 0.92])
    np.testing.assert_allclose(np.exp(found.log_likelihood - found.unsure), [0.02, 0.92])
    assert not found.contradicts.any()


def test_results_without_a_regime_say_that_there_are_some():
    found = terms({"period": "54 +- 2 ms"}, [STICK_SLIP, CREEP, UNRESOLVED], period=[0.054, np.nan, np.nan])
    np.testing.assert_allclose(found.log_likelihood[1:], np.log([0.02, 0.92]))
    np.testing.assert_allclose(found.unsure, [0, 0, np.log(0.92 / 0.02)])
    assert found.contradicts.tolist() == [False, True, False]


# --- the sampler ------------------------------------------------------------------------------------------------------

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
