"""The risk model: its properties, its anchors, and its calibration."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip_rig.api import Risk, calibrate
from stickslip_rig.risk import BANDS, INPUTS, band_of, number_of

SIZES = st.floats(0, 1e9)
RISKS = st.builds(
    Risk,
    base=st.floats(-20, 20),
    **{f"weight_{name}": st.floats(0, 10) for name in INPUTS},
    **{f"scale_{name}": st.floats(1e-6, 1e6) for name in INPUTS},
)


def risk_of(*values):
    """A model of its first parameters, in the order of the vocabulary."""
    return Risk(**dict(zip(Risk.model_fields, values, strict=False)))


def inputs(sticks, largest, integral):
    return dict(zip(INPUTS, (sticks, largest, integral), strict=True))


# --- the model --------------------------------------------------------------------------------------------------------


@given(RISKS, st.tuples(SIZES, SIZES, SIZES), st.sampled_from(INPUTS), st.floats(1, 1e3), st.floats(0, 1e6))
def test_the_number_rises_with_every_feature_and_stays_within_one_to_ten(risk, values, name, factor, more):
    below = inputs(*values)
    above = below | {name: below[name] * factor + more}
    low, high = int(risk.number(below)), int(risk.number(above))
    assert 1 <= low <= high <= 10
    assert risk.level(below) <= risk.level(above) + 1e-9
    assert band_of(low) in BANDS


def test_the_bands_are_those_of_the_article():
    assert [band_of(n) for n in range(1, 11)] == ["green"] * 3 + ["yellow"] * 2 + ["red"] * 5
    assert band_of(0) == "unknown"


def test_levels_are_rounded_halves_up_and_held_at_the_ends():
    assert number_of([-3, 0.4, 1.49, 1.5, 5.5, 9.5, 12]).tolist() == [1, 1, 1, 2, 6, 10, 10]
    assert np.isnan(number_of(np.nan))


@pytest.mark.parametrize("name, value", [("weight_sticks", -0.1), ("scale_sticks", 0.0), ("base", np.nan)])
def test_impossible_parameters_are_refused(name, value):
    with pytest.raises(ValueError, match=name):
        Risk(**{name: value})


def test_drops_half_as_large_and_twice_as_frequent_are_a_smaller_risk():
    """Twice the sticks, half the acceleration, the same integral: equal weights would not tell the difference."""
    risk = Risk()
    assert risk.level(inputs(400, 5, 20)) < risk.level(inputs(200, 10, 20)) < risk.level(inputs(100, 20, 20))


# --- calibration ------------------------------------------------------------------------------------------------------


TRUE = Risk(base=0.5, weight_sticks=0.8, weight_acceleration_max=1.7, weight_acceleration_integral=0.6)


def pairs(count, seed, risk=TRUE):
    """Features over several decades, independent of each other."""
    random = np.random.default_rng(seed)
    logs = random.uniform([0, -1, -1.5], [2.7, 2.2, 2], (count, 3)).T
    found = inputs(*(10.0**logs))
    return found, risk


def test_exact_levels_give_back_the_parameters_but_for_what_the_prior_pulls():
    found, risk = pairs(60, 1, risk_of(-2.0, 1.6, 3.4, 1.2))
    level = risk.level(found)
    inside = (level > 1) & (level < 10)
    assert 24 < inside.sum() < 60
    fit = calibrate(found, np.clip(level, 1, 10))
    for name in fit.interval:
        assert getattr(fit.risk, name) == pytest.approx(getattr(risk, name), abs=0.15), name
    assert np.abs(fit.level - fit.rpn)[inside].max() < 0.15


def test_leaving_out_in_closed_form_is_fitting_without():
    """Ridge regression with the same noise, of normal equations; no weight at zero, no number at an end."""
    found, risk = pairs(12, 2, risk_of(1.0, 1.0, 1.0, 1.0))
    number = np.clip(risk.number(found) + np.random.default_rng(2).normal(0.0, 0.4, 12), 1.5, 9.5)
    fit = calibrate(found, number)
    scales = np.array(Risk().scales)[:, None]
    terms = np.vstack([np.ones(12), np.log10(1.0 + np.array([found[name] for name in INPUTS]) / scales)]).T
    default = np.array([getattr(Risk(), name) for name in fit.interval])
    for i in range(12):
        rest = terms[np.arange(12) != i]
        normal = rest.T @ rest / fit.noise**2 + np.eye(4)
        without = np.linalg.solve(normal, rest.T @ np.delete(number, i) / fit.noise**2 + default)
        assert fit.left_out[i] == pytest.approx(terms[i] @ without, abs=1e-6)


def six_pairs(seed=0):
    """Six records whose features grow together, with numbers that grow as well."""
    random = np.random.default_rng(seed)
    sticks = np.array([10, 18, 30, 41, 55, 68.0])
    return inputs(sticks, *(sticks * size * np.exp(0.03 * random.normal(size=6)) for size in (1.1, 0.35)))


@pytest.mark.parametrize("seed", range(3))
def test_six_pairs_of_correlated_features_do_not_calibrate_wildly(seed):
    fit = calibrate(six_pairs(seed), [2, 3, 4, 5, 6, 7])
    for name in fit.interval:
        low, high = fit.interval[name]
        assert high - low < 6 and abs(getattr(fit.risk, name)) < 4, name
    assert {f"weight_{name}" for name in INPUTS} <= set(fit.unidentified)
    assert fit.is_better and fit.error > 1.2 * np.sqrt(np.mean((fit.level - fit.rpn) ** 2))
    for largest in (0, 3, 30):
        for integral in (0, 2, 20):
            assert fit.risk.number(inputs(236, largest, integral)) > 1


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(5, 12))
def test_whatever_the_pairs_more_of_a_feature_never_lowers_the_number(seed, count):
    random = np.random.default_rng(seed)
    values = 10.0 ** random.uniform(-1, 3, (3, count))
    fit = calibrate(inputs(*values), random.integers(1, 11, values.shape[1]))
    assert np.isfinite(list(fit.interval.values())).all() and np.isfinite(fit.left_out).all()
    grid = 10.0 ** np.linspace(-3, 5, 50)
    for name in INPUTS:
        number = fit.risk.number(dict.fromkeys(INPUTS, 7.0) | {name: grid})
        assert (np.diff(number.astype(int)) >= 0).all()


def test_numbers_without_relation_to_the_features_are_said_to_be_no_calibration():
    """The left-out pairs tell; the fitted ones look better than the default."""
    found, _ = pairs(8, 3)
    rpn = np.random.default_rng(5).permutation(Risk().number(found)).astype(float)
    fit = calibrate(found, rpn)
    assert not fit.is_better and "do not use" in fit.text()
    assert np.mean((fit.level - fit.rpn) ** 2) < fit.default_error**2 < fit.error**2


def test_the_leave_one_out_error_is_that_of_records_not_seen():
    errors = []
    for seed in range(12):
        found, risk = pairs(8, seed)
        fit = calibrate(found, risk.number(found))
        others, _ = pairs(300, 1000 + seed)
        level, number = fit.risk.level(others), risk.number(others).astype(float)
        inside = (number > 1) & (number < 10)
        errors.append([fit.error, np.sqrt(np.mean((level - number)[inside] ** 2))])
    ours, true = np.mean(errors, axis=0)
    assert ours == pytest.approx(true, rel=0.35)


def test_rounded_numbers_give_them_back_within_their_intervals():
    hits = np.zeros(4)
    trials = 25
    for seed in range(trials):
        found, risk = pairs(25, seed)
        fit = calibrate(found, risk.number(found))
        ends = [fit.interval[name] for name in fit.interval]
        hits += [low <= getattr(risk, n) <= high for n, (low, high) in zip(fit.interval, ends, strict=True)]
        assert (np.abs(number_of(fit.level) - fit.rpn) <= 1).all()
    assert (hits / trials > 0.85).all(), hits / trials


def test_a_feature_that_never_varies_is_said_to_be_undetermined():
    found, risk = pairs(30, 5)
    found["sticks"] = np.zeros(30)
    fit = calibrate(found, risk.number(found))
    assert fit.unidentified == ("weight_sticks",) and fit.risk.weight_sticks == pytest.approx(1)
    assert "not determined by the pairs" in fit.text()


@pytest.mark.parametrize(
    "count, rpn, expected",
    [(4, 5.0, "4 pairs for 4 parameters, expected at least 5"), (9, 11.0, "pair 1: got the RPN 11, expected 1 to 10")],
)
def test_pairs_that_cannot_be_used_are_refused(count, rpn, expected):
    with pytest.raises(ValueError, match=expected):
        calibrate(pairs(count, 6)[0], np.full(count, rpn))
