"""Probabilities of regimes against closed forms and plain Monte Carlo, and what unknown draws do to them."""

import numpy as np
import pytest
from scipy import stats

import stickslip
from stickslip.config.grid import options_of
from stickslip.config.reader import parse_config
from stickslip.engine import stop_flag
from stickslip.studies.draws import STATES, Design, reduced
from stickslip.studies.uncertain import SampleStudy

PAD = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
TEXT = """\
system: {{mass: 1 kg, stiffness: 1 N/m, normal_load: 1 N}}
friction: {{a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}}
axes: {{{axes}}}
solver: {{max_steps: {steps}}}
uncertain:
  draws: {draws}
  seed: {seed}
  quantities: {{belt_speed: {{normal: {{mean: 0.78 m/s, std: 0.05 m/s}}}}{more}}}
  metrics: [period]
"""
pytestmark = pytest.mark.usefixtures("kernels")


def sample(draws=1024, seed=1, more="", axes="", steps=100_000, text=TEXT):
    config = parse_config(text.format(draws=draws, seed=seed, more=more, axes=axes, steps=steps))
    return SampleStudy(config, options_of(config))


def results(of, block=20_000):
    blocks = [of.compute(range(start, min(start + block, of.size)), stop_flag()) for start in range(0, of.size, block)]
    said = of.inputs.uncertain
    found = reduced(blocks, of.inputs.grid.size, of.design, said.metrics, said.quantiles)
    return {name: values[0] for name, values in found.items()} if of.inputs.grid.size == 1 else found


def border(**more):
    return float(stickslip.border(PAD | more, "belt_speed", (0.6, 1.0))["border"][0, 0])


def test_with_one_uncertain_speed_the_probability_is_the_normal_distribution_at_the_border():
    found = results(sample())
    exact = stats.norm.cdf((border() - 0.78) / 0.05)
    assert abs(found["probability"][0] - exact) < 3.5 * found["probability_error"][0]
    assert found["probability_error"][0] < 1e-3  # plain Monte Carlo with as many draws: 4e-3
    assert found["probability"][:2].sum() == pytest.approx(1.0)
    assert found["sobol_first"][0] == pytest.approx(1.0, abs=0.01)  # the only quantity explains everything
    assert np.isnan(found["sobol_first"][2:]).all()  # regimes that do not occur


def test_errors_of_probabilities_are_as_large_as_the_probabilities_are_wrong():
    """Regimes on the two sides of a plane, which spares the integration."""
    exact, off = stats.norm.cdf(0.3), []
    for seed in range(60):
        design = Design(2, 256, 8, seed, False)
        normals = design.normals(design.place(0, design.per_cell))
        regime = np.where(normals @ [0.8, 0.6] < 0.3, 1, 2).astype(np.int8)
        found = reduced([{"regime": regime}], 1, design, (), ())
        off.append((found["probability"][0, 0] - exact) / found["probability_error"][0, 0])
    assert 0.8 < np.std(off) < 1.7  # Student's t with 7 degrees of freedom: 1.18
    assert abs(np.mean(off)) < 0.5


def test_a_case_with_two_inputs_is_that_of_plain_monte_carlo_and_of_the_border_integrated():
    found = results(sample(more=", damping: {uniform: [0, 0.02]}"))
    rng = np.random.default_rng(3)
    cells = PAD | {"belt_speed": rng.normal(0.78, 0.05, 20_000), "damping": rng.uniform(0, 0.02, 20_000)}
    sticks = stickslip.evaluate(cells)["regime"].values == 1
    plain, error = sticks.mean(), sticks.std() / np.sqrt(sticks.size)
    assert abs(found["probability"][0] - plain) < 3.5 * np.hypot(error, found["probability_error"][0])
    nodes, weights = np.polynomial.legendre.leggauss(12)
    lines = PAD | {"damping": 0.01 * (1 + nodes)}
    speeds = stickslip.border(lines, "belt_speed", (0.5, 1.0))["border"].values[:, 0]
    given = stats.norm.cdf((speeds - 0.78) / 0.05)  # probability of stick-slip at a damping
    exact = weights @ given / 2
    assert abs(found["probability"][0] - exact) < 3.5 * found["probability_error"][0]
    first = (weights @ given**2 / 2 - exact**2) / (
        exact * (1 - exact)
    )  # of the damping: closed form, but for the border
    assert abs(found["sobol_first"][0, 1] - first) < 3.5 * found["sobol_first_error"][0, 1]


def test_numbers_do_not_depend_on_how_draws_are_cut_into_blocks():
    text = TEXT.replace(", stiffness: 1 N/m", "")
    study = sample(64, more=", damping: {uniform: [0, 0.02]}", axes="stiffness: [0.5, 1]", text=text)
    whole, pieces = results(study, study.size), results(study, 333)
    for name, values in whole.items():
        assert np.array_equal(values, pieces[name], equal_nan=True), name


def test_draws_that_are_not_decided_are_carried_as_bounds():
    exact = stats.norm.cdf((border() - 0.78) / 0.05)
    found = results(sample(draws=256, steps=16))
    assert 0.2 < found["undecided"] < 0.9
    low, high = found["probability_low"], found["probability_high"]
    assert low[0] - 0.01 < exact < high[0] + 0.01
    assert high - low == pytest.approx(np.full(len(STATES), found["undecided"]))
    assert (low <= found["probability"]).all() and (found["probability"] <= high).all()
    assert np.isnan(found["sobol_total"][0]).all()  # all draws may be of one regime
    more = ", damping: {uniform: [0, 0.02]}"
    known, found = (results(sample(draws=256, more=more, steps=steps)) for steps in (100_000, 20))
    assert 0.02 < found["undecided"] < 0.5
    assert (found["sobol_total_error"][0] > 1.2 * known["sobol_total_error"][0]).all()


def test_means_and_quantiles_of_a_metric_are_those_of_the_draws_that_have_it():
    found = results(sample(draws=512))
    rng = np.random.default_rng(4)
    ds = stickslip.evaluate(PAD | {"belt_speed": rng.normal(0.78, 0.05, 20_000)})
    period = ds["period"].values[np.isfinite(ds["period"].values)]
    spread = np.hypot(found["mean_period_error"], period.std() / np.sqrt(period.size))
    assert abs(found["mean_period"] - period.mean()) < 3.5 * spread
    assert found["quantile_period"] == pytest.approx(np.quantile(period, [0.05, 0.5, 0.95]), rel=2e-4)
    assert found["count_period"] == pytest.approx(found["probability"][0] * 8 * 2 * 512)


def test_correlated_inputs_scatter_as_their_covariance_says():
    text = TEXT.replace(
        "metrics", "correlation: {{between: [belt_speed, damping], matrix: [[1, -0.8], [-0.8, 1]]}}\n  metrics"
    )
    one = sample(draws=4096, more=", damping: {normal: {mean: 0.1, std: 0.01}}", text=text)
    place = one.design.place(0, one.size)
    cells, possible = one.inputs.cells(place.cell, one.design.normals(place))
    drawn = np.array([cells["belt_speed"], cells["damping"]])
    assert np.cov(drawn) == pytest.approx(np.array([[25e-4, -4e-4], [-4e-4, 1e-4]]), rel=5e-3)
    assert possible.all() and "sobol_first" not in results(
        sample(draws=16, more=", damping: {normal: {mean: 0.1, std: 0.01}}", text=text)
    )


def test_draws_that_no_oscillator_has_are_failed_and_carried():
    one = sample(draws=16, more=", mu_stop: {normal: {mean: 1.2, std: 0.02}}")
    normals = np.zeros((3, 2))
    normals[1, 1] = 6.0  # mu_stop = 1.32, above mu_start = 1.3
    found = one.inputs.compute(np.zeros(3, np.int64), normals, one.options, stop_flag())
    assert found["regime"].tolist()[1] == 7 and found["regime"][0] == found["regime"][2] < 6
