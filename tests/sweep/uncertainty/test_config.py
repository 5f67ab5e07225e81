"""The section uncertain: what it may say, and what is refused with file, line and key."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from helpers.configs import message
from stickslip.config.reader import parse_config

HEAD = """\
system: {mass: 1 kg, stiffness: 10 N/m, normal_load: 5 N}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
uncertain:
"""
SPEED = "belt_speed: {normal: {mean: 0.8 m/s, std: 50 mm/s}}"


def text(quantities=SPEED, *more):
    return HEAD + "\n".join([f"  quantities: {{{quantities}}}", *(f"  {line}" for line in more)]) + "\n"


def read(*args):
    return parse_config(text(*args))


def test_indices_are_computed_where_inputs_are_independent():
    both = f"{SPEED}, damping: {{uniform: [0, 1]}}"
    assert read(both).uncertain.indices
    matrix = "correlation: {between: [damping, belt_speed], matrix: [[1, .5], [.5, 1]]}"
    assert not read(both, matrix).uncertain.indices


def test_a_distribution_may_have_its_name_and_its_numbers_from_scipy():
    gamma = read("belt_speed: {gamma: {a: 3, loc: 5, scale: 2 mm/s}}").uncertain.quantities["belt_speed"]
    assert gamma.numbers == {"a": 3.0, "loc": 0.005, "scale": 0.002}
    z = np.array([-4.0, -1.0, 0.0, 2.0])
    assert gamma.distribution.at(z) == pytest.approx(stats.gamma(3, 0.005, 0.002).ppf(stats.norm.cdf(z)), rel=1e-9)


BOTH = f"{SPEED}, damping: {{uniform: [0, 1]}}"
BAD = [
    (text(f"{SPEED}, damping: {{normal: {{mean: 0.1, std: 0.1}}}}"), "4:69: uncertain.quantities.damping: got 15.9 %"),
    (text(f"{SPEED}, mu_stop: {{uniform: [1.1, 1.35]}}"), "4:78: uncertain.quantities.mu_stop: got 1.34993 in the"),
    (text("mass: {uniform: [1, 2]}, belt_speed: {uniform: [1, 2]}"),
     "4:16: uncertain.quantities.mass: given twice, as system.mass on line 1"),
    (text() + "axes: {belt_speed: [1, 2]}\n",
     "5:8: axes.belt_speed: given twice, as uncertain.quantities.belt_speed on line 4"),
    (text(f"{SPEED}, dampin: {{uniform: [0, 1]}}"), "4:69: uncertain.quantities.dampin: unknown quantity, expected"),
    (text("belt_speed: {gauss: {mean: 1, std: 1}}"),
     "4:29: uncertain.quantities.belt_speed.gauss: unknown key, expected normal, lognormal"),
    # whose quantiles SciPy would search for
    (text("belt_speed: {foldnorm: {c: 1, loc: 1, scale: 1}}"), "4:29: uncertain.quantities.belt_speed.foldnorm: unkn"),
    (text("belt_speed: {gamma: {a: -1, loc: 1, scale: 1}}"), "4:36: uncertain.quantities.belt_speed.gamma: got {'"),
    (text("belt_speed: {gamma: {a: 2, scale: 1}}"), "uncertain.quantities.belt_speed.gamma.loc: missing, expected"),
    (text("belt_speed: {normal: {mean: 1, std: 0}}"), "4:37: uncertain.quantities.belt_speed.normal: got {'normal'"),
    (text("belt_speed: {uniform: {low: 2 m/s, high: 1 m/s}}"), "4:38: uncertain.quantities.belt_speed.uniform: got {"),
    (text("belt_speed: {lognormal: {median: 1, factor: 0.5}}"), "4:40: uncertain.quantities.belt_speed.lognormal: got"),
    (text("belt_speed: {normal: {mean: 1 m, std: 0.1}}"),
     "4:44: uncertain.quantities.belt_speed.normal.mean: got '1 m' (length), expected a speed"),
    (text(BOTH, "correlation: {between: [belt_speed, damping], matrix: [[1, -1], [-1, 1]]}"),
     "5:57: uncertain.correlation.matrix: got a list, expected 2 rows"),
    (text(BOTH, "correlation: {between: [belt_speed, damping], matrix: [[1, 0.5], [0.4, 1]]}"),
     "5:57: uncertain.correlation.matrix: got a list, expected 2 rows"),
    (text(BOTH, "indices: true", "correlation: {between: [belt_speed, damping], matrix: [[1, 0.5], [0.5, 1]]}"),
     "5:12: uncertain.indices: got true, expected false"),
    (text(BOTH, "covariance: {between: [belt_speed, damping], matrix: [[1, 0.5], [0.5, 1]]}"),
     "5:3: uncertain.covariance: unknown key, expected quantities, correlation"),
    (text(SPEED, "draws: 1000"), "5:10: uncertain.draws: got 1000, expected a power of two"),
    (text(SPEED, "metrics: [perriod]"), "5:13: uncertain.metrics[0]: got 'perriod', expected a result"),
    (text(SPEED, "draws: 67108864", "scramblings: 512"), "5:10: uncertain.draws: got 1.03e+11 cells"),
    (text("belt_speed: {normal: {mean: 1, std: 0.1}, truncated: {low: 3}}"),
     "4:37: uncertain.quantities.belt_speed.normal: got {'normal': {'mean': 1.0, 'std': 0.1}, 'truncated'"),
    (HEAD.replace("mass: 1 kg", "mass: 1 kg, belt_speed: 1") + "  draws: 64\n", "3:1: uncertain.quantities: missing"),
]  # fmt: skip


@pytest.mark.parametrize(("bad", "said"), BAD)
def test_what_is_wrong_is_said_with_its_place(bad, said):
    assert said in message(bad)


def test_a_border_is_not_asked_for_beside_probabilities():
    assert "expected one of them" in message(text() + "border: {along: stiffness, between: [1, 2]}\n")
