"""Effective draws per second of `explain`, beside emcee's ensemble sampler on the same likelihood and sbi's networks.

    python benchmarks/explain.py [RUNS]      # two minutes, and with sbi ten; emcee and sbi if they are installed

The observations and the prior of configs/explain.yaml with one law, in independent normal deviates. Each sampler is run
independently RUNS times from the prior on, on one thread, with about as many likelihoods. How many independent draws
a run is worth is what its means say, whatever the sampler tells of itself: the variance of the posterior over the mean
square of what the means of runs are off those of a chain of emcee that is many times as long, of the worst quantity.
Beside it, how far the worst of the quantiles of 5, 50 and 95 % of all runs are off those of that chain.

sbi (neural posterior estimation, as unless asked otherwise) learns the posterior from simulated observations, with the
scatter that the likelihood has; few runs, since it trains for minutes. Simulations without a period it leaves out.
"""

from __future__ import annotations

import sys
from contextlib import chdir
from dataclasses import replace
from importlib.util import find_spec
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from stickslip.config.grid import options_of
from stickslip.config.reader import load_config
from stickslip.config.resolve import config_path
from stickslip.engine import stop_flag
from stickslip.vocabulary.quantities import DECIDED, REGIMES
from stickslip_explain.section import Explain
from stickslip_explain.study import ExplainStudy, tempered

LAW, SIZE, WALKERS, RUNS, LONGER = "stribeck", 500, 500, 24, 25
BURN_IN = 0.5  # of a chain
SIMULATIONS, DRAWS, TRAINED = 10_000, 5_000, 3  # that a network learns from, that are drawn of it; networks at most


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

    def simulated(self, points, rng):
        """Observations of points, (n, numbers), and those that were made: whether the regime was noted that was seen,
        and logarithms of results; NaN where there are none."""
        self.points += len(points)
        columns, made, codes = [], [], np.array([REGIMES.index(name) for name in DECIDED])
        for i, (results, _) in self.experiment._results(self.prior.values(points), self._stop, None).items():
            seen, regime = self.experiment.observed[i], results["regime"]
            others = (np.searchsorted(codes, regime) + rng.integers(1, codes.size, regime.size)) % codes.size
            wrong = rng.random(regime.size) < self.experiment.mislabelled
            noted = np.where(wrong, codes[others], regime)
            columns.append(np.isin(noted, [REGIMES.index(name) for name in seen.regime]))
            made.append(1.0)
            for name, one in seen.metrics.items():
                values = np.where(results[name] > 0, results[name], np.nan)
                columns.append(np.log(values) + one.log_std * rng.standard_normal(regime.size))
                made.append(one.log_mean)
        return np.stack(columns, 1).astype(np.float32), np.array(made, np.float32)


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


def network_draws(target, rng, budget):
    """Draws of a network that was trained on simulations of the prior."""
    import torch
    from sbi.inference import NPE

    torch.set_num_threads(1)
    torch.manual_seed(rng.integers(2**31))
    points = rng.standard_normal((SIMULATIONS, target.dimensions))
    simulated, made = target.simulated(points, rng)
    prior = torch.distributions.MultivariateNormal(torch.zeros(target.dimensions), torch.eye(target.dimensions))
    with TemporaryDirectory() as folder, chdir(folder):  # it writes logs where it stands
        inference = NPE(prior=prior, show_progress_bars=False)
        inference.append_simulations(torch.as_tensor(points.astype(np.float32)), torch.as_tensor(simulated)).train()
    drawn = inference.build_posterior().sample((DRAWS,), x=torch.as_tensor(made), show_progress_bars=False)
    return drawn.numpy().astype(np.float64)


def measure(runs: int) -> list[dict]:
    """A row of each sampler."""
    target, rows, budget = Target(), [], 0.0
    target.log_likelihood(np.zeros((8, target.dimensions)))  # compiles
    samplers = {"tempered Monte Carlo (ours)": ours} | ({"emcee": emcee_draws} if find_spec("emcee") else {})
    samplers |= {"sbi, neural posterior": network_draws} if find_spec("sbi") else {}
    drawn = {}
    for name, sampler in samplers.items():
        count = min(runs, TRAINED) if sampler is network_draws else runs
        target.points, began = 0, process_time()
        drawn[name] = [sampler(target, np.random.default_rng([7, run]), budget) for run in range(count)]
        seconds, budget = (process_time() - began) / count, budget or target.points / count
        rows.append({"sampler": name, "cells": target.points / count, "seconds": seconds})
    true = emcee_draws(target, np.random.default_rng(8), LONGER * budget) if "emcee" in drawn else \
        np.concatenate(next(iter(drawn.values())))  # fmt: skip
    for row in rows:
        means = np.array([one.mean(0) for one in drawn[row["sampler"]]])
        row["worth"] = float((true.var(0) / np.mean((means - true.mean(0)) ** 2, axis=0)).min())
        all_of, of_true = (np.quantile(draws, (0.05, 0.5, 0.95), axis=0) for draws in
                           (np.concatenate(drawn[row["sampler"]]), true))  # fmt: skip
        row["off"] = float((np.abs(all_of - of_true) / true.std(0)).max())
    return rows


def main(runs: int) -> None:
    """Print them."""
    for row in measure(runs):
        print(f"{row['sampler']:28} {row['cells']:9,.0f} points, {row['seconds']:6.2f} s a run, worth "
              f"{row['worth']:5.0f} independent draws: {row['worth'] / row['seconds']:6.2f} a second; quantiles off by "
              f"{row['off']:.2f} of the scatter")  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else RUNS)
