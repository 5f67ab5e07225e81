"""The section uncertain: what it may say, and what is refused with file, line and key."""

from __future__ import annotations

import contextlib
import copy
import functools
import operator

import numpy as np
import pytest
from scipy import stats

from helpers.configs import message
from stickslip.config.reader import load_config, make_config, parse_config
from stickslip.config.yaml import parse_yaml
from stickslip.errors import ConfigError, FitWarning
from stickslip_materials.fit import fit_curve

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


@pytest.mark.parametrize(
    "args",
    [
        (),
        (f"{SPEED}, damping: {{normal: {{mean: 0.01, std: 0.01}}, truncated: {{low: 0}}}}",),
        (f"{SPEED}, mu_stop: {{triangular: {{low: 1, mode: 1.1, high: 1.2}}}}", "draws: 64", "indices: false"),
        (f"{SPEED}, damping: {{uniform: [0, 1]}}",
         "correlation: {between: [damping, belt_speed], matrix: [[1, .5], [.5, 1]]}"),
        (f"{SPEED}, damping: {{gamma: {{scale: 2, loc: 0, a: 3}}, truncated: {{high: 9}}}}",),
        (f"{SPEED}, contact_time: {{lognormal: {{median: 1 min, factor: 2}}}}", "metrics: []"),
        (SPEED, "subset: {samples: 1000}"),
    ],
)  # fmt: skip
def test_a_section_as_it_was_understood_reads_back_equal(args):
    config = read(*args)
    assert parse_config(config.to_yaml()) == config


def test_indices_are_computed_where_inputs_are_independent():
    both = f"{SPEED}, damping: {{uniform: [0, 1]}}"
    assert read(both).uncertain.indices
    matrix = "correlation: {between: [damping, belt_speed], matrix: [[1, .5], [.5, 1]]}"
    assert not read(both, matrix).uncertain.indices


def test_a_distribution_may_have_its_name_and_its_numbers_from_scipy():
    gamma = read("belt_speed: {gamma: {a: 3, loc: 5, scale: 2 mm/s}}").uncertain.quantities["belt_speed"]
    assert gamma.numbers == {"a": 3.0, "loc": 0.005, "scale": 0.002}
    assert gamma.in_words("belt_speed") == "gamma, a 3, loc 0.005 m/s, scale 0.002 m/s"
    z = np.array([-4.0, -1.0, 0.0, 2.0])
    assert gamma.distribution.at(z) == pytest.approx(stats.gamma(3, 0.005, 0.002).ppf(stats.norm.cdf(z)), rel=1e-9)


BAD = {
    "a distribution that leaves the physical range": (
        text(f"{SPEED}, damping: {{normal: {{mean: 0.1, std: 0.1}}}}"),
        "map.yaml:4:69: uncertain.quantities.damping: got 15.9 % of the points elsewhere, "
        "expected a damping coefficient of at least 0 N s/m\n"
        "  hint: truncate it: damping: {normal: ..., truncated: {low: ..., high: ...}}, or one end",
    ),
    "draws that do not fit the rest": (
        text(f"{SPEED}, mu_stop: {{uniform: [1.1, 1.35]}}"),
        "map.yaml:4:78: uncertain.quantities.mu_stop: got 1.34993 in the worst draw (19 % of them are impossible), "
        "expected at most mu_start = a1 + a3 = 1.3\n"
        "  hint: friction at standstill cannot exceed that at break-away; truncate the distribution",
    ),
    "a quantity that is fixed as well": (
        text("mass: {uniform: [1, 2]}, belt_speed: {uniform: [1, 2]}"),
        "map.yaml:4:16: uncertain.quantities.mass: given twice, as system.mass on line 1 already, expected once\n"
        "  hint: keep the one you mean",
    ),
    "a quantity on an axis as well": (
        text() + "axes: {belt_speed: [1, 2]}\n",
        "map.yaml:5:8: axes.belt_speed: given twice, as uncertain.quantities.belt_speed on line 4 already, "
        "expected once\n  hint: keep the one you mean",
    ),
    "an unknown quantity": (
        text(f"{SPEED}, dampin: {{uniform: [0, 1]}}"),
        "map.yaml:4:69: uncertain.quantities.dampin: unknown quantity, expected mass, stiffness, damping, normal_load, "
        "belt_speed, a1, a2, a3, a4, delta, mu_stop, mu_static, ageing_rate, ageing_time, mu_0, v_0, a, b, D_c, "
        "direct_cutoff_speed, evolution_cutoff_speed, contact_stiffness, contact_damping, contact_damping_speed, "
        "elastic_part, displacement, velocity, contact_time, mu_start, mu_reversal or v_reversal\n"
        "  hint: did you mean damping?",
    ),
    "an unknown distribution": (
        text("belt_speed: {gauss: {mean: 1, std: 1}}"),
        "map.yaml:4:29: uncertain.quantities.belt_speed.gauss: unknown key, "
        "expected normal, lognormal, uniform, triangular, drawn or truncated",
    ),
    "a distribution whose quantiles scipy would search for": (
        text("belt_speed: {foldnorm: {c: 1, loc: 1, scale: 1}}"),
        "map.yaml:4:29: uncertain.quantities.belt_speed.foldnorm: unknown key",
    ),
    "numbers that a distribution of scipy does not take": (
        text("belt_speed: {gamma: {a: -1, loc: 1, scale: 1}}"),
        "map.yaml:4:36: uncertain.quantities.belt_speed.gamma: got gamma, a -1, loc 1 m/s, scale 1 m/s, expected",
    ),
    "a number that is missing": (
        text("belt_speed: {gamma: {a: 2, scale: 1}}"),
        "uncertain.quantities.belt_speed.gamma.loc: missing, expected a, loc and scale",
    ),
    "no scatter": (
        text("belt_speed: {normal: {mean: 1, std: 0}}"),
        "map.yaml:4:37: uncertain.quantities.belt_speed.normal: got normal, mean 1 m/s, std 0 m/s, "
        "expected numbers that make one: std and median above 0, ",
    ),
    "ends in the wrong order": (
        text("belt_speed: {uniform: {low: 2 m/s, high: 1 m/s}}"),
        "map.yaml:4:38: uncertain.quantities.belt_speed.uniform: got uniform, low 2 m/s, high 1 m/s, "
        "expected numbers that make one: ",
    ),
    "a factor below one": (
        text("belt_speed: {lognormal: {median: 1, factor: 0.5}}"),
        "map.yaml:4:40: uncertain.quantities.belt_speed.lognormal: got lognormal, median 1 m/s, factor 0.5, "
        "expected numbers that make one: ",
    ),
    "a wrong unit": (
        text("belt_speed: {normal: {mean: 1 m, std: 0.1}}"),
        "map.yaml:4:44: uncertain.quantities.belt_speed.normal.mean: got '1 m' (length), "
        "expected a speed such as '10 mm/s' or a number in m/s",
    ),
    "a matrix that is not positive definite": (
        text(f"{SPEED}, damping: {{uniform: [0, 1]}}",
             "correlation: {between: [belt_speed, damping], matrix: [[1, -1], [-1, 1]]}"),
        "map.yaml:5:57: uncertain.correlation.matrix: got a list, expected 2 rows of 2 numbers, symmetric, "
        "positive definite and with 1 along the diagonal",
    ),
    "a matrix that is not symmetric": (
        text(f"{SPEED}, damping: {{uniform: [0, 1]}}",
             "correlation: {between: [belt_speed, damping], matrix: [[1, 0.5], [0.4, 1]]}"),
        "map.yaml:5:57: uncertain.correlation.matrix: got a list, expected 2 rows of 2 numbers, symmetric, ",
    ),
    "indices of correlated inputs": (
        text(f"{SPEED}, damping: {{uniform: [0, 1]}}", "indices: true",
             "correlation: {between: [belt_speed, damping], matrix: [[1, 0.5], [0.5, 1]]}"),
        "map.yaml:5:12: uncertain.indices: got true, expected false: Sobol indices are defined for independent inputs\n"
        "  hint: leave the correlation out to see which input matters",
    ),
    "not a power of two": (
        text(SPEED, "draws: 1000"),
        "map.yaml:5:10: uncertain.draws: got 1000, expected a power of two\n"
        "  hint: Sobol points are even in powers of two; the nearest is 1024",
    ),
    "an unknown metric": (
        text(SPEED, "metrics: [perriod]"),
        "map.yaml:5:13: uncertain.metrics[0]: got 'perriod', expected a result: breakaway_time, ",
    ),
    "more draws than a run can have": (
        text(SPEED, "draws: 67108864", "scramblings: 512") ,
        "map.yaml:5:10: uncertain.draws: got 1.03e+11 cells (103079215104 draws), expected at most 1e+10\n"
        "  hint: use fewer draws or scramblings",
    ),
    "truncation that leaves nothing": (
        text("belt_speed: {normal: {mean: 1, std: 0.1}, truncated: {low: 3}}"),
        "map.yaml:4:37: uncertain.quantities.belt_speed.normal: got normal, mean 1 m/s, std 0.1 m/s, "
        "truncated to 3 ... inf m/s, expected 1e-06 of it or more within the ends",
    ),
    "no quantities": (
        HEAD.replace("mass: 1 kg", "mass: 1 kg, belt_speed: 1") + "  draws: 64\n",
        "map.yaml:3:1: uncertain.quantities: missing, expected quantities with distributions\n"
        "  hint: quantities: {belt_speed: {normal: {mean: 0.8 m/s, std: 0.05 m/s}}}",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_said_with_its_place(case):
    bad, said = BAD[case]
    assert said in message(bad)


def test_a_border_is_not_asked_for_beside_probabilities():
    assert "expected one of them" in message(text() + "border: {along: stiffness, between: [1, 2]}\n")


# --- fitted curves ----------------------------------------------------------------------------------------------------


def write_points(folder, noise=0.005, count=60, above=0.005):
    rng = np.random.default_rng(1)
    speed = np.linspace(above, 1, count)
    mu = 1 + 0.1 * speed + 0.3 * np.exp(-speed / 0.1) + rng.normal(0, noise, count)
    rows = "\n".join(f"{w!r},{m!r}" for w, m in zip(speed.tolist(), mu.tolist(), strict=True))
    (folder / "points.csv").write_text(f"speed (m/s),mu\n{rows}\n")
    path = folder / "fitted.yaml"
    path.write_text("system: {mass: 1, stiffness: 10, normal_load: 5, belt_speed: 0.5}\nuncertain: {fit: points.csv}\n")
    return path, fit_curve(speed, mu)


def test_the_coefficients_of_a_fitted_curve_scatter_as_its_points_leave_them(tmp_path):
    path, fit = write_points(tmp_path)
    config = load_config(path)
    assert config.uncertain.names == ("a1", "a2", "a3", "a4")
    assert not config.uncertain.indices
    drawn = config.uncertain.values(np.random.default_rng(2).standard_normal((400_000, 4)))
    values = np.array([drawn[name] for name in config.uncertain.names])
    scale = np.sqrt(np.diag(fit.covariance))
    assert np.cov(values) / np.outer(scale, scale) == pytest.approx(fit.covariance / np.outer(scale, scale), abs=0.01)
    assert values.mean(1) == pytest.approx([fit.a1, fit.a2, fit.a3, fit.a4], abs=4e-5)


def test_a_result_knows_the_scatter_of_its_curve_without_the_points(tmp_path):
    path, _ = write_points(tmp_path)
    config = load_config(path)
    (tmp_path / "points.csv").unlink()
    assert parse_config(config.to_yaml(), str(path)) == config


def test_a_fitted_coefficient_may_be_truncated_and_other_quantities_be_correlated_beside_it(tmp_path):
    path, fit = write_points(tmp_path)
    more = """fit: points.csv, quantities: {a2: {truncated: {low: 0}}, damping: {uniform: [0, 1]},
      displacement: {uniform: [0, 1]}}, correlation: {between: [displacement, damping], matrix: [[1, 0.3], [0.3, 1]]}"""
    path.write_text(path.read_text().replace("fit: points.csv", more))
    said = load_config(path).uncertain
    assert said.quantities["a2"].ends == {"low": 0.0}
    expected = np.eye(6)
    expected[:2, :2] = [[1, 0.3], [0.3, 1]]
    expected[2:, 2:] = fit.covariance / np.sqrt(np.outer(*[np.diag(fit.covariance)] * 2))
    order = [said.names.index(name) for name in ("damping", "displacement", "a1", "a2", "a3", "a4")]
    assert np.array(said.correlation)[np.ix_(order, order)] == pytest.approx(expected)


def test_points_that_do_not_determine_the_curve_are_refused(tmp_path):
    path, _ = write_points(tmp_path, above=0.9)
    with pytest.raises(ConfigError, match="do not determine|of the points below"), pytest.warns(FitWarning):
        load_config(path)


# --- nonsense ---------------------------------------------------------------------------------------------------------

WHOLE = f"""\
{HEAD}\
  draws: 64
  metrics: [period]
  quantiles: [0.5]
  quantities:
    belt_speed: {{gamma: {{a: 2, loc: 0, scale: 1 m/s}}}}
    displacement: {{normal: {{mean: 0, std: 0.1}}}}
    velocity: {{drawn: [1, 2]}}
    damping: {{uniform: [0, 1], truncated: {{low: 0.1, high: 0.9}}}}
    mu_stop: {{triangular: {{low: 1, mode: 1.1, high: 1.2}}}}
    contact_time: {{lognormal: {{median: 1, factor: 2}}}}
  correlation: {{between: [damping, mu_stop], matrix: [[1, 0.5], [0.5, 1]]}}
"""
NONSENSE = (None, [], {}, "x", -1, True, float("nan"), 1e308, 10**400, [[1, 2]], [1, "a"], {"a": 1}, {1: 2})


def places(data, path=()):
    yield path
    inside = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in inside:
        yield from places(value, (*path, key))


def test_nonsense_in_any_place_is_a_configuration_or_is_refused():
    whole = parse_yaml(WHOLE).data
    for path in list(places(whole["uncertain"], ("uncertain",))):
        for nonsense in NONSENSE:
            data = copy.deepcopy(whole)
            around = functools.reduce(operator.getitem, path[:-1], data)
            around[path[-1]] = nonsense
            with contextlib.suppress(ConfigError):
                config = make_config(data)
                assert parse_config(config.to_yaml()) == config
