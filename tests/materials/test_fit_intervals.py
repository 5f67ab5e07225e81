"""What points do not tell is not told: intervals against MINOS, branches nobody saw, points apart, other laws."""

import math

import numpy as np
import pytest
from iminuit import Minuit

from helpers.measured import law
from stickslip.theory.curve import SHAPES
from stickslip_materials.fit import draw_curves, fit_curve

NAMES = ("a1", "a2", "a3", "a4", "mu_start")


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("speeds", [np.geomspace(0.002, 1, 16), np.linspace(0.05, 1, 20)], ids=["log", "linear"])
def test_intervals_are_those_of_minos(speeds, seed):
    """MINOS of all four coefficients at once (James and Roos 1975), not of a scale; mu_start is in the place of a3."""
    sigma, truth = 0.004, (0.2, 0.15, 0.15, 0.08)
    mu = law(speeds, *truth) + np.random.default_rng(seed).normal(0, sigma, speeds.size)
    fit = fit_curve(speeds, mu, sigma)
    for start, names in ((False, NAMES[:4]), (True, ("mu_start",))):

        def cost(values, start=start):
            a1, a2, a3, a4 = values
            return float(np.sum(((law(speeds, a1, a2, a3 - a1 if start else a3, a4) - mu) / sigma) ** 2))

        a3 = fit.mu_start if start else fit.a3
        search = Minuit(cost, (fit.a1, fit.a2, a3, fit.a4), name=NAMES[:4])
        search.limits["a1"] = search.limits["a2"] = (0, None)
        search.limits["a4"] = (0.1 * speeds[0], 50 * speeds[-1])
        search.migrad().minos(cl=0.95)
        for name in names:
            errors = search.merrors["a3" if start else name]
            value = search.values["a3" if start else name]
            low, high = fit.interval[name]
            if errors.lower_valid and low > 0:
                assert low == pytest.approx(value + errors.lower, abs=0.02 * (high - low))
            if errors.upper_valid and math.isfinite(high) and not errors.at_upper_limit:
                assert high == pytest.approx(value + errors.upper, abs=0.02 * (high - low))


def test_quantiles_of_drawn_curves_are_the_intervals():
    speeds = np.geomspace(0.002, 1, 16)
    fit = fit_curve(speeds, law(speeds, 0.2, 0.15, 0.15, 0.08) + np.random.default_rng(1).normal(0, 0.004, 16), 0.004)
    drawn = draw_curves(fit, 20_000).coefficients
    for name in ("a1", "a3", "a4"):
        low, high = fit.interval[name]
        assert np.quantile(drawn[name], (0.025, 0.975)) == pytest.approx((low, high), abs=0.04 * (high - low))


@pytest.mark.parametrize("curve", [(0.095, 0.16, 0.004, 0.02), (0.1, 0.0, 0.0, 1.0), (0.1, 0.2, 0.0, 1.0)])
def test_flat_and_rising_points_do_not_show_more_friction_than_was_measured(curve):
    """Of the first, a grease with 3 % noise, one in twenty had a mu_start of up to 106."""
    for seed in range(10):
        random = np.random.default_rng(seed)
        w = np.geomspace(0.001, 1, 30) if curve[2] else np.linspace(0.02, 0.5, int(random.integers(5, 30)))
        mu = law(w, *curve) * (1 + random.normal(0, 0.03, w.size))
        fit = fit_curve(w, mu)
        assert not fit.determined or fit.mu_start < 1.1 * mu.max()
        assert not curve[2] or fit.mu_start < 0.15 and (fit.a3 <= 0 or fit.interval["a3"][0] > 0), fit


def test_a_fall_that_only_the_slowest_of_linear_speeds_sees_does_not_determine_its_scale():
    """Points 20 mm/s apart, a4 = 6 mm/s: "they determine all four coefficients", a4 24.8 to 74.8 mm/s."""
    w = np.linspace(0.01, 0.4, 20)
    for seed in range(10):
        fit = fit_curve(w, law(w, 0.1, 0.05, 0.25, 0.006) + np.random.default_rng(seed).normal(0, 0.002, w.size))
        assert not fit.good and not fit.interval["a4"][0] > 0.006
        assert not fit.determined or fit.interval["mu_start"][0] <= 0.35 <= fit.interval["mu_start"][1]


def test_one_point_apart_is_left_out_and_named():
    w = np.geomspace(0.001, 1, 14)
    mu = law(w, 0.1, 0.05, 0.05, 0.05)
    for seed in range(14):
        y = mu + np.random.default_rng(seed).normal(0, 0.002, w.size)
        y[seed] += 0.1
        fit = fit_curve(w, y)
        assert not fit.good
        if 1 < seed < 13:  # the ends may be a branch of their own
            assert fit.outliers == (seed,) and f"{y[seed]:.3g} at" in fit.quality
            np.testing.assert_allclose(fit.predict(w), mu, atol=0.01)


@pytest.mark.parametrize("name", ["stribeck_delta", "rational"])
def test_points_of_another_law_are_not_called_good_and_the_law_is_named(name):
    w = np.geomspace(0.001, 1, 30)
    mu = 0.1 + 0.05 * w + 0.05 * SHAPES[name](w / 0.05) + np.random.default_rng(3).normal(0, 0.0006, w.size)
    fit = fit_curve(w, mu)
    assert not fit.good and name in fit.quality
    best = fit_curve(w, mu, law="best")
    assert best.law == name and best.good and best.a4 == pytest.approx(0.05, rel=0.15)
    with pytest.raises(ValueError, match="law: got 'linear', expected stribeck"):
        fit_curve(w, mu, law="linear")


def test_a_logarithmic_fall_is_said_to_have_another_shape():
    w = np.geomspace(0.001, 1, 14)
    bad = [fit_curve(w, 0.12 - 0.01 * np.log(w / 0.05) + 0.03 * w + np.random.default_rng(s).normal(0, 0.0012, 14))
           for s in range(10)]  # fmt: skip
    assert sum(one.good for one in bad) <= 1
