"""`uncertain: {fit: points.csv}`: coefficients that scatter as measured points leave them."""

import numpy as np
import pytest

from stickslip.config.reader import load_config
from stickslip.errors import ConfigError, FitWarning
from stickslip_materials.fit import fit_curve


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
