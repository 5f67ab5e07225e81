"""Explanations of cells whose truth is known: Coulomb friction in closed form, groups, laws, calibration."""

import numpy as np
import pytest
from scipy import stats

import stickslip
from helpers.data import rows
from stickslip.config.grid import build_grid
from stickslip.config.reader import make_config
from stickslip.engine import Options, stop_flag
from stickslip.theory.contacts import coulomb_cycle
from stickslip.vocabulary.quantities import REGIMES
from stickslip_explain.likelihood import Experiment
from stickslip_explain.section import Observation
from stickslip_explain.study import tempered

QUICK = {"particles": 200, "repetitions": 4, "progress": False}
AT = {"normal_load": 10.0, "belt_speed": 0.02}
COULOMB = {"mass": 0.1, "a1": 0.3, "a2": 0.0, "a3": 0.0, "a4": 0.1, "mu_static": 0.4}  # constant but for break-away


def lognormal(median, factor):
    return {"lognormal": {"median": median, "factor": factor}}


def coulomb(**quantities):
    """The cycle of these quantities, in closed form."""
    known = COULOMB | AT | {"stiffness": 5e3} | quantities
    names = ("mass", "stiffness", "normal_load", "belt_speed", "mu_static")
    return coulomb_cycle(*(known[name] for name in names), known["a1"])


def quadrature(observed, mislabelled, prior, nodes=400):
    """Log-evidence, and mean deviates, by the rectangle rule over normal deviates. prior : medians and factors."""
    z = np.linspace(-6, 6, nodes)
    deviates = np.array(np.meshgrid(*[z] * len(prior), indexing="ij"))
    drawn = {name: median * factor**u for (name, (median, factor)), u in zip(prior.items(), deviates, strict=True)}
    cycle = coulomb(**drawn)
    log_likelihood = np.log(1 - mislabelled)
    for name, (value, scatter) in observed.items():
        log_likelihood = log_likelihood + stats.norm.logpdf(np.log(getattr(cycle, name) / value), scale=scatter / value)
    density = np.exp(log_likelihood) * np.prod(stats.norm.pdf(deviates), axis=0) * (z[1] - z[0]) ** len(prior)
    return np.log(density.sum()), [(density * u).sum() / density.sum() for u in deviates]


@pytest.mark.parametrize("unknown", [("stiffness",), ("stiffness", "mu_static")])
def test_evidence_and_mean_of_the_coulomb_cycle_are_those_of_quadrature(unknown):
    prior = {"stiffness": (4e3, 1.3), "mu_static": (0.42, 1.03)}
    prior = {name: prior[name] for name in unknown}
    observed = {"period": (float(coulomb().period), 0.004), "slip_speed_max": (float(coulomb().slip_speed_max), 0.006)}
    evidence, means = quadrature(observed, 0.01, prior)
    seen = AT | {"regime": "stick_slip"} | {name: {"value": v, "scatter": s} for name, (v, s) in observed.items()}
    known = {name: value for name, value in COULOMB.items() if name not in prior}
    found = stickslip.explain([seen], known | {n: lognormal(*one) for n, one in prior.items()}, **QUICK, seed=3)
    error = float(found["log_evidence_error"][0])
    assert error < 0.15
    assert float(found["log_evidence"][0]) == pytest.approx(evidence, abs=4 * error + 0.01)
    assert found.attrs["explained_undecided"] == 0.0
    for (name, (median, factor)), mean in zip(prior.items(), means, strict=True):
        deviates = np.log(found[f"posterior_{name}"].values / median) / np.log(factor)
        assert deviates.mean() == pytest.approx(mean, abs=5 * deviates.std() / np.sqrt(200))


def test_repeated_runs_scatter_as_the_error_of_the_evidence_says():
    seen = AT | {"regime": "stick_slip", "period": {"value": float(coulomb().period), "scatter": 0.004}}
    prior = COULOMB | {"stiffness": lognormal(4e3, 1.3)}
    found = [stickslip.explain([seen], prior, particles=60, repetitions=6, progress=False, seed=s) for s in range(12)]
    evidence, error = (np.array([float(one[n][0]) for one in found]) for n in ("log_evidence", "log_evidence_error"))
    assert 0.5 < evidence.std(ddof=1) / np.sqrt(np.mean(error**2)) < 1.8  # chi^2 of 11 degrees, with 99 %


def test_of_a_coulomb_cycle_only_the_drop_of_friction_and_the_stiffness_are_known():
    """Period and slip speed depend on mu_static - a1 and on the spring (`theory/contacts.py`); the level is free."""
    cycle = coulomb()
    seen = AT | {"regime": "stick_slip", "period": f"{float(cycle.period)} s +- 1 %",
                 "slip_speed_max": f"{float(cycle.slip_speed_max)} m/s +- 1 %"}  # fmt: skip
    prior = COULOMB | {
        "stiffness": lognormal("5 N/mm", 2), "a1": {"uniform": [0.05, 0.6]}, "mu_static": {"uniform": [0.1, 0.8]},
    }  # fmt: skip
    found = stickslip.explain([seen], prior, **QUICK)
    drop = found["posterior_mu_static"] - found["posterior_a1"]
    assert float(drop.mean()) == pytest.approx(0.1, abs=4 * float(drop.std()))
    assert float(drop.std()) < 0.01 < 0.05 < float(found["posterior_a1"].std())
    left = found["variance_ratio"]
    assert float(left.sel(quantity="stiffness")) < 0.1 < 0.2 < float(left.sel(quantity="a1"))


def test_without_forces_only_groups_are_known():
    """Mass, spring and load all so many times larger is the same motion: along that direction nothing is learned."""
    cell = {"mass": 0.1, "stiffness": 5e3, "a1": 0.2, "a2": 0.3, "a3": 0.2, "a4": 0.02} | AT
    truth = stickslip.evaluate(cell)
    seen = [{"belt_speed": 0.02, "regime": "stick_slip", "period": f"{float(truth['period'][0])} s +- 2 %",
             "slip_speed_max": f"{float(truth['slip_speed_max'][0])} m/s +- 2 %"}]  # fmt: skip
    prior = {name: cell[name] for name in ("a1", "a2", "a3", "a4")}
    scattered = {"mass": 0.1, "stiffness": 5e3, "normal_load": 10.0}
    found = stickslip.explain(seen, prior | {n: lognormal(m, 1.5) for n, m in scattered.items()}, **QUICK)
    deviates = np.array([np.log(found[f"posterior_{n}"].values / m) / np.log(1.5) for n, m in scattered.items()])
    along = deviates.sum(0) / np.sqrt(3.0)
    assert stats.kstest(along[::4], "norm").pvalue > 1e-3
    assert float(found["direction_ratio"][0]) < 0.05
    assert float(found["direction_ratio"][-1]) == pytest.approx(1.0, abs=0.3)
    weights = found["direction_weight"][-1].values
    np.testing.assert_allclose(weights, 1.0, atol=0.35)  # m, k and N together


@pytest.mark.slow
def test_the_law_that_data_come_from_is_found_and_predictions_differ_where_laws_do():
    cell = {"mass": 0.1, "stiffness": 5e3, "normal_load": 10.0, "a1": 0.2, "a2": 0.0, "a3": 0.2, "a4": 0.02}
    speeds = [0.005, 0.01, 0.02, 0.04]
    truth = stickslip.evaluate(cell | {"belt_speed": speeds}, law="rational")
    seen = [{"belt_speed": speed, "regime": REGIMES[int(truth["regime"][i])],
             "spring_force_max": f"{float(truth['spring_force_max'][i])} +- 0.01 N",
             "spring_force_min": f"{float(truth['spring_force_min'][i])} +- 0.01 N"}
            for i, speed in enumerate(speeds)]  # fmt: skip
    prior = cell | {"a3": {"uniform": [0.1, 0.4]}, "a4": lognormal(0.02, 2)}
    axes = {"belt_speed": {"start": 0.02, "stop": 2.0, "num": 7, "spacing": "log"}}
    found = stickslip.explain(seen, prior, laws=["stribeck", "rational"], predict=axes, draws=16, **QUICK)
    assert float(found["law_probability"].sel(law="rational")) > 0.99
    assert (found["posterior_law"] == 1).mean() > 0.99
    np.testing.assert_allclose(found["probability"].sum("state"), 1.0)
    assert float(found["disagreement"].max()) == 0.0  # only one law is left that may be right
    inside = found["posterior_a4"].quantile([0.005, 0.995]).values
    assert inside[0] < 0.02 < inside[1]


# --- calibration ------------------------------------------------------------------------------------------------------

PRIORS = rows("explain.yaml")["test_explained"]["PRIORS"]
CELL = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": 0.1, "damping": 0.0, "a1": 1.0, "a2": 0.1,
        "a3": 0.3, "a4": 0.1}  # fmt: skip


def ranks(name, count, seed=1, particles=100, chosen=19):
    """Ranks of true quantities among draws, by data sets that the likelihood itself made; (count, quantities)."""
    prior, design, mislabelled = PRIORS[name]
    known = {name: value for name, value in CELL.items() if name not in prior}
    friction = {name: known.pop(name) for name in [*known] if name[0] == "a"}
    correlation = {name: prior[name] for name in prior if name == "correlation"}
    quantities = {name: value for name, value in prior.items() if name not in correlation}
    config = make_config({"explain": {"observed": [{"regime": "damped"}]}, "system": known, "friction": friction,
                          "uncertain": {"quantities": quantities} | correlation})  # fmt: skip
    known |= friction
    uncertain, options = config.uncertain, Options(variables=("regime",))
    base, rng = build_grid(config), np.random.default_rng(seed)
    found = np.empty((count, len(uncertain.names)), int)
    for i in range(count):
        truth = rng.standard_normal((1, len(uncertain.names)))
        seen = [
            _seen(known | {n: v[0] for n, v in uncertain.values(truth).items()}, one, mislabelled, rng)
            for one in design
        ]
        experiment = Experiment(seen, base, "stribeck", {}, mislabelled, options)
        draws = tempered(lambda u, e=experiment: e.terms(uncertain.values(u), stop_flag()).log_likelihood.sum(1),
                         len(uncertain.names), particles, np.random.default_rng([seed, i]))  # fmt: skip
        found[i] = (draws.points[rng.choice(particles, chosen, replace=False)] < truth).sum(0)
    return found


def _seen(cell, what, mislabelled, rng):
    """An observation of a cell: its regime, which may be noted wrongly, and results that scatter."""
    conditions = {name: value for name, value in what.items() if name in CELL}
    truth, seen = stickslip.evaluate(cell | conditions), dict(conditions)
    for name, scatter in what.items():
        if name == "regime":
            regime = REGIMES[int(truth["regime"][0])]
            others = [one for one in ("stick_slip", "damped", "creep", "sustained", "stuck") if one != regime]
            seen["regime"] = regime if rng.random() > mislabelled else str(rng.choice(others))
        elif name not in conditions:
            value = float(truth[name][0]) * np.exp(scatter * rng.standard_normal())
            seen[name] = {"value": value, "scatter": scatter * value}
    return Observation.model_validate(seen)


@pytest.mark.parametrize("name", PRIORS)
def test_some_ranks_of_the_truth_are_not_at_one_end(name):
    for column in ranks(name, 30).T:
        assert stats.kstest((column + 0.5) / 20, "uniform").pvalue > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("name", PRIORS)
def test_ranks_of_the_truth_are_uniform(name):
    """Simulation-based calibration (Talts et al. 2018), 1,000 data sets; and intervals hold what they say."""
    found = ranks(name, 1000, seed=2)
    for column in found.T:
        assert stats.chisquare(np.bincount(column, minlength=20)).pvalue > 0.01
        for most in (0.5, 0.9):
            inside = np.abs(column - 9.5) < 10 * most
            assert inside.mean() == pytest.approx(most, abs=4 * np.sqrt(most * (1 - most) / 1000))


def test_friction_points_and_a_squeak_are_explained_together():
    """A point of the curve alone is a linear model of a1: with few percent its posterior is normal, in closed form."""
    curve = {"a2": 0.4, "a3": 0.15, "a4": 0.02}
    prior = {"mass": 0.1, "stiffness": 5e3, "normal_load": 10, "a1": {"normal": {"mean": 0.25, "std": 0.02}}} | curve
    speeds, level = np.array([0.03, 0.1]), 0.27
    rest = curve["a2"] * speeds + curve["a3"] * np.exp(-speeds / curve["a4"])
    points = [{"belt_speed": v, "friction_coefficient": {"value": level + r, "scatter": 0.01}}
              for v, r in zip(speeds, rest, strict=True)]  # fmt: skip
    found = stickslip.explain(points, prior, **QUICK)
    precision = 1 / 0.02**2 + 2 / 0.01**2
    mean, std = (0.25 / 0.02**2 + 2 * level / 0.01**2) / precision, precision**-0.5
    draws = found["posterior_a1"].values
    assert draws.mean() == pytest.approx(mean, abs=0.2 * std)  # of logarithms, and 4 errors of 800 draws
    assert draws.std() == pytest.approx(std, rel=0.12)
    squeak = {"belt_speed": 0.02, "regime": "stick_slip", "spring_force_max": "4.42 +- 0.02 N"}
    both = stickslip.explain([*points, squeak], prior, **QUICK)
    assert float(both["posterior_a1"].std()) < 0.6 * std
