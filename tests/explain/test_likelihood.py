"""The likelihood against its definition: labels that may be wrong, normal logarithms, Student's t, bounds."""

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from stickslip.vocabulary.flags import REGIMES
from stickslip_explain.likelihood import observation_terms
from stickslip_explain.section import Observation

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


@pytest.mark.parametrize(
    ("text", "value", "scatter"),
    [("54 +- 2 ms", 0.054, 0.002), ("54 ms ± 4 %", 0.054, 0.00216), ("54 ms +/- 0.002 s", 0.054, 0.002),
     ("0.054 +- 0.002", 0.054, 0.002)],
)  # fmt: skip
def test_scatter_is_read_as_people_write_it(text, value, scatter):
    measured = Observation.model_validate({"period": text}).metrics["period"]
    assert (measured.value, measured.scatter) == (pytest.approx(value), pytest.approx(scatter))
    assert Observation.model_validate({"stick_fraction": "0.5 +- 0.02"}).metrics["stick_fraction"].value == 0.5
