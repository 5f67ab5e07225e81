"""Effective draws per second of `explain`, beside emcee's ensemble sampler on the same likelihood.

    python benchmarks/explain.py [RUNS]      # two minutes; emcee if it is installed

The observations and the prior of configs/explain.yaml with one law, in independent normal deviates. Each sampler is run
independently RUNS times from the prior on, on one thread, with about as many likelihoods. How many independent draws
a run is worth is what its means say, whatever the sampler tells of itself: the variance of the posterior over the mean
square of what the means of runs are off those of a chain of emcee that is many times as long, of the worst quantity.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from importlib.util import find_spec
from time import process_time

import numpy as np

from stickslip.config.examples import config_path
from stickslip.config.options import options_of
from stickslip.config.reader import load_config
from stickslip.engine import stop_flag
from stickslip.studies.explain.section import Explain
from stickslip.studies.explain.smc import tempered
from stickslip.studies.explain.study import ExplainStudy

LAW, SIZE, WALKERS, RUNS, LONGER = "stribeck", 500, 500, 24, 25
BURN_IN = 0.5  # of a chain


class Target:
    """The log-likelihood of points in deviates, and how many were asked for."""

    def __init__(self) -> None:
        config = load_config(config_path("explain")).model_copy(update={"axes": ()})
        section = config.study
        assert isinstance(section, Explain)
        section = section.model_copy(update={"laws": (LAW,)})
        study = ExplainStudy(config, section, replace(options_of(config), threads=1))
        self.prior, self.experiment = study.prior, study._law(LAW)
        self.dimensions, self.points, self._stop = len(self.prior.names), 0, stop_flag()

    def log_likelihood(self, points):
        self.points += len(points)
        return self.experiment.terms(self.prior.values(points), self._stop).log_likelihood.sum(1)

    def log_posterior(self, points):
        return self.log_likelihood(points) - 0.5 * (points**2).sum(1)


def ours(target, rng, budget):
    """Draws of a population."""
    return tempered(target.log_likelihood, target.dimensions, SIZE, rng).points


def emcee_draws(target, rng, budget):
    """Draws of an ensemble from the prior on, without its burn-in; stretch moves, as unless asked otherwise."""
    import emcee

    sampler = emcee.EnsembleSampler(WALKERS, target.dimensions, target.log_posterior, vectorize=True)
    start = rng.standard_normal((WALKERS, target.dimensions))
    sampler.random_state = np.random.RandomState(rng.integers(2**31)).get_state()
    steps = max(int(budget / WALKERS), 10)
    sampler.run_mcmc(start, steps, skip_initial_state_check=True)
    return sampler.get_chain(discard=int(BURN_IN * steps), flat=True)


def measure(runs: int) -> list[dict]:
    """A row of each sampler."""
    target, rows, budget = Target(), [], 0.0
    target.log_likelihood(np.zeros((8, target.dimensions)))  # compiles
    samplers = {"tempered Monte Carlo (ours)": ours} | ({"emcee": emcee_draws} if find_spec("emcee") else {})
    drawn = {}
    for name, sampler in samplers.items():
        target.points, began = 0, process_time()
        drawn[name] = [sampler(target, np.random.default_rng([7, run]), budget) for run in range(runs)]
        seconds, budget = (process_time() - began) / runs, budget or target.points / runs
        rows.append({"sampler": name, "likelihoods": target.points / runs, "seconds": seconds})
    whole = np.concatenate([one for runs_of_one in drawn.values() for one in runs_of_one])
    true = whole.mean(0) if len(drawn) == 1 else emcee_draws(target, np.random.default_rng(8), LONGER * budget).mean(0)
    for row in rows:
        means = np.array([one.mean(0) for one in drawn[row["sampler"]]])
        row["worth"] = float((whole.var(0) / np.mean((means - true) ** 2, axis=0)).min())
        row["bias"] = float((np.abs(means.mean(0) - true) / whole.std(0)).max())
    return rows


def main(runs: int) -> None:
    """Print them."""
    for row in measure(runs):
        print(f"{row['sampler']:28} {row['likelihoods']:9,.0f} likelihoods, {row['seconds']:5.2f} s a run, worth "
              f"{row['worth']:5.0f} independent draws: {row['worth'] / row['seconds']:5.0f} a second; off by "
              f"{row['bias']:.3f} of the scatter on average")  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else RUNS)
