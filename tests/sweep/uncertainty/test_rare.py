"""Subset simulation against probabilities that are known: planes, borders in closed form, plain Monte Carlo."""

import numpy as np
import pytest
from scipy import stats

import stickslip
from stickslip import plots
from stickslip.config.reader import parse_config
from stickslip.errors import PlotError
from stickslip.studies.uncertain import limit_of, subset_simulation

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


PAD = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
TEXT = """\
system: {{mass: 1 kg, normal_load: 1 N{more}}}
friction: {{a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}}
axes: {{{axes}}}
uncertain:
  quantities: {{{quantities}}}
  subset: {{samples: {samples}, repetitions: 8}}
"""
SPEED = "belt_speed: {normal: {mean: 0.95 m/s, std: 0.03 m/s}}"


def rare(quantities=SPEED, samples=1000, more=", stiffness: 1", axes=""):
    config = parse_config(TEXT.format(quantities=quantities, samples=samples, more=more, axes=axes))
    return stickslip.run(config)


def test_one_uncertain_speed_gives_the_normal_distribution_at_the_border():
    found = rare()
    border = float(stickslip.border(PAD, "belt_speed", (0.6, 1.0))["border"][0, 0])
    exact = stats.norm.cdf((border - 0.95) / 0.03)  # 2e-7
    p, error = (float(found[name].sel(state="stick_slip")) for name in ("probability", "probability_error"))
    assert 1e-7 < exact < 1e-6
    assert abs(p - exact) < 4 * error and error < 0.4 * exact
    assert int(found["evaluations"]) < 8 * 1000 * 9
    assert float(found["undecided"]) == 0.0


def test_two_inputs_give_the_border_integrated():
    found = rare(f"{SPEED}, damping: {{uniform: [0, 0.005]}}")
    nodes, weights = np.polynomial.legendre.leggauss(8)
    speeds = stickslip.border(PAD | {"damping": 0.0025 * (1 + nodes)}, "belt_speed", (0.5, 1.0))["border"].values[:, 0]
    exact = weights @ stats.norm.cdf((speeds - 0.95) / 0.03) / 2
    p, error = (float(found[name].sel(state="stick_slip")) for name in ("probability", "probability_error"))
    assert abs(p - exact) < 4 * error and error < 0.4 * exact


def test_a_motion_without_a_margin_is_far_from_stick_slip_and_an_unknown_one_is_unknown():
    regime = np.array([1, 1, 2, 2, 5, 6, 7], np.int8)
    margin = np.array([-0.1, np.nan, 0.2, np.nan, np.nan, 0.1, -0.1])
    found = limit_of(regime, margin)
    assert found[:5].tolist() == [-0.1, -np.finfo(float).tiny, 0.2, np.inf, np.inf]
    assert np.isnan(found[5:]).all()


def test_it_is_drawn_over_an_axis_on_a_logarithmic_scale():
    ds = rare(axes="stiffness: [0.9, 1]", more="", samples=200)
    (ax,) = plots.plot_probability(ds).axes
    assert ax.get_yscale() == "log" and ds.attrs["uncertain_method"].startswith("subset simulation: 8 repetitions")
    with pytest.raises(PlotError, match="is a number"):
        plots.plot_probability(rare(samples=200))
