"""The section uncertain: what it may say, and what is refused with file, line and key."""

import re

import numpy as np
import pytest
from scipy import stats

from helpers.configs import message
from helpers.data import cases
from stickslip.config.describe import describe
from stickslip.config.reader import make_config, parse_config
from stickslip.errors import ConfigError

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


@cases("sweep.yaml")
def test_what_is_wrong_is_said_with_its_place(bad, said):
    assert said in message(bad if bad.startswith("system") else HEAD + bad)


def test_a_border_is_not_asked_for_beside_probabilities():
    assert "expected one of them" in message(text() + "border: {along: stiffness, between: [1, 2]}\n")


# --- quantities drawn from values, row by row -------------------------------------------------------------------------

CAR = {"mass": 2.0, "stiffness": 2e4, "normal_load": 30.0}


def test_rows_stay_together_and_each_is_as_probable():
    rng = np.random.default_rng(2)
    a1 = rng.uniform(0.1, 0.4, 100)
    values = {"a1": a1.tolist(), "a3": (0.5 - a1).tolist()}
    given = {name: {"drawn": one} for name, one in values.items()} | {"damping": {"uniform": [0, 1]}}
    config = make_config({
        "system": {**CAR, "belt_speed": 0.02}, "friction": {"a2": 0, "a4": 0.02}, "uncertain": {"quantities": given},
    })  # fmt: skip
    normals = rng.standard_normal((20_000, 3))
    drawn = config.uncertain.values(normals)
    np.testing.assert_allclose(drawn["a1"] + drawn["a3"], 0.5, rtol=1e-12)
    shares = np.array([(drawn["a1"] == one).mean() for one in a1])
    assert abs(shares - 0.01).max() < 5 * np.sqrt(0.01 / 20_000)
    assert abs(np.corrcoef(drawn["a1"], drawn["damping"])[0, 1]) < 0.03
    assert not config.uncertain.indices


@cases("sweep.yaml")
def test_drawn_values_that_are_none_are_refused(quantities, more, expected):
    friction = more.pop("friction", {"a2": 0, "a4": 0.1})
    given = {name: {"drawn": values} for name, values in quantities.items()}
    config = {"system": {**CAR, "belt_speed": 0.1}, "friction": friction, "uncertain": {"quantities": given, **more}}
    with pytest.raises(ConfigError, match=re.escape(expected)):
        make_config(config)


def test_distributions_are_told_in_words_with_units():
    assert read("belt_speed: {gamma: {a: 3, loc: 5, scale: 2 mm/s}}").uncertain.quantities["belt_speed"].text(
        "m/s"
    ) == ("gamma, a 3, loc 0.005 m/s, scale 0.002 m/s")
    with_end = read("belt_speed: {normal: {mean: 0.8 m/s, std: 50 mm/s}, truncated: {low: 0}}")
    assert ("belt_speed", "uncertain", "normal, mean 0.8 m/s, std 0.05 m/s, truncated at low 0 m/s") in describe(
        with_end
    )
