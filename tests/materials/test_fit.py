"""Fits of made-up points, whose curve is known, and of points that do not determine it; CSV files good and bad."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.optimize import curve_fit

from helpers.data import cases
from helpers.measured import law
from stickslip.errors import ConfigError, Place
from stickslip_materials.fit import (
    AGEING_COLUMNS,
    CURVE_COLUMNS,
    fit_ageing,
    fit_ageing_file,
    fit_curve,
    fit_file,
    rank,
    read_points,
)

ARTICLE = (1.0, 0.1, 0.3, 0.1)
NAMES = ("a1", "a2", "a3", "a4")


def growth(t, mu0, beta, t0):
    return mu0 + beta * np.log10(1 + t / t0)


def covered(truth, intervals):
    return [low <= value <= high for value, (low, high) in zip(truth, intervals, strict=True)]


def binomial_bounds(trials):
    """Counts that a share of 95 % gives in all but one of a hundred series."""
    margin = 2.6 * math.sqrt(trials * 0.95 * 0.05)
    return 0.95 * trials - margin, 0.95 * trials + margin


# --- curves -----------------------------------------------------------------------------------------------------------


@settings(max_examples=40)
@given(
    st.floats(0.05, 1), st.floats(0.01, 0.5), st.floats(0.1, 2), st.floats(-4, 1), st.floats(0, 1), st.integers(8, 30)
)
def test_exact_points_give_back_their_curve_in_any_units(a1, rise, drop, log_speed, place, count):
    """From any size of speed, without a hint where to look; a decline within what is measured."""
    speed = 10**log_speed * np.linspace(0, 1, count)
    a4 = speed[-1] * (0.08 + 0.3 * place)
    truth = (a1, rise * a1 / speed[-1], drop * a1, a4)
    fit = fit_curve(speed, law(speed, *truth))
    assert [fit.a1, fit.a2, fit.a3, fit.a4] == pytest.approx(truth, rel=1e-5)
    assert fit.good and not fit.unidentified and fit.r_squared == pytest.approx(1)
    np.testing.assert_allclose(fit.predict(speed), law(speed, *truth), rtol=1e-8)


def test_estimates_and_errors_are_those_of_scipys_curve_fit():
    random = np.random.default_rng(8)
    speed = np.geomspace(0.005, 2, 25)
    deviation = random.uniform(0.002, 0.02, speed.size)
    mu = law(speed, *ARTICLE) + random.normal(0, deviation)
    for sigma, known in ((None, False), (deviation, True)):
        best, covariance = curve_fit(law, speed, mu, ARTICLE, sigma, known, xtol=1e-12, ftol=1e-12)
        fit = fit_curve(speed, mu, sigma)
        assert list(fit.coefficients().values()) == pytest.approx(best, rel=1e-5)
        np.testing.assert_allclose(fit.covariance, covariance, rtol=1e-3, atol=1e-3 * np.abs(covariance).min())
        assert [fit.standard_error[n] for n in NAMES] == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-3)
        start = covariance[0, 0] + covariance[2, 2] + 2 * covariance[0, 2]
        assert fit.standard_error["mu_start"] == pytest.approx(math.sqrt(start), rel=1e-3)
    assert fit.residual_rms == pytest.approx(np.sqrt(np.mean((mu - law(speed, *best)) ** 2)), rel=1e-6)


@pytest.mark.slow
def test_the_band_is_that_of_repeated_measurements_and_holds_the_curve():
    random = np.random.default_rng(11)
    speed, at = np.linspace(0, 1, 40), np.array([0.0, 0.05, 0.3, 1.0])
    fits = [fit_curve(speed, law(speed, *ARTICLE) + random.normal(0, 0.005, speed.size), 0.005) for _ in range(80)]
    spread = np.std([fit.predict(at) for fit in fits], axis=0)
    low, high = fits[0].band(at)
    np.testing.assert_allclose((high - low) / (2 * 1.96), spread, rtol=0.25)
    inside = [(fit.band(at)[0] <= law(at, *ARTICLE)) & (law(at, *ARTICLE) <= fit.band(at)[1]) for fit in fits]
    assert (np.mean(inside, axis=0) > 0.88).all()
    falling = fit_curve(np.array(FALLS["bending"][0]) / 1000, FALLS["bending"][1])
    assert np.isinf(falling.band(at)[1]).all()  # a2, which was taken as 0, is not known
    assert np.isinf(fit_curve(np.linspace(0, 1, 4), law(np.linspace(0, 1, 4), *ARTICLE)).band(at)[1]).all()


def noisy(truth, speed, scatter=0.003, seed=1):
    return law(speed, *truth) + np.random.default_rng(seed).normal(0, scatter, speed.size)


@pytest.mark.parametrize(
    ("speed", "mu", "unidentified", "said"),
    [
        (np.linspace(0, 1, 20), lambda w: 0.3 + 0.1 * w, {"a3", "a4"}, "o declining branch"),
        (np.linspace(0, 1, 20), lambda w: noisy((0.3, 0.1, 0, 1), w), {"a3", "a4"}, "o declining branch"),
        (np.linspace(0, 1, 20), lambda w: np.full_like(w, 0.4), {"a3", "a4"}, "o declining branch"),
        (np.linspace(0.5, 1, 20), lambda w: noisy((0.3, 0.1, 0.2, 0.02), w), {"a3", "a4"}, "o declining branch"),
        (np.linspace(0.3, 1, 20), lambda w: noisy(ARTICLE, w, 1e-4), set(), "extrapolated from 0.3 m/s"),
        (np.linspace(0, 0.05, 20), lambda w: noisy(ARTICLE, w), {"a1"}, "do not determine a1"),
        (np.linspace(0, 1, 4), lambda w: law(w, *ARTICLE), set(NAMES), "do not test the fit"),
        (np.linspace(0, 1, 40), lambda w: 0.3 + 0.3 * np.exp(-((w / 0.3) ** 4)), set(), "another shape"),
        (np.linspace(0, 1, 150), lambda w: noisy(ARTICLE, w, 0.1), None, "explains only"),
    ],
    ids=["rising", "rising, noisy", "flat", "above the decline", "just above it", "below its end", "four points",
         "another law", "scatter"],
)  # fmt: skip
def test_a_bad_fit_is_said_plainly(speed, mu, unidentified, said):
    fit = fit_curve(speed, mu(speed))
    assert not fit.good
    assert said in fit.quality
    assert unidentified is None or unidentified <= set(fit.unidentified)


def test_residuals_beyond_the_stated_deviation_are_said_plainly():
    speed = np.linspace(0, 1, 30)
    mu = noisy(ARTICLE, speed, 0.01)
    assert fit_curve(speed, mu, 0.01).good
    assert "times sigma" in fit_curve(speed, mu, 0.003).quality


@pytest.mark.parametrize(
    ("fit", "points", "message"),
    [
        (fit_curve, ([0, 1, 2], [1, 1, 1]), "got 3 distinct speeds, expected at least 4"),
        (fit_curve, ([0, 0, 1, 1, 1], [1, 1, 1, 1, 1]), "got 2 distinct speeds"),
        (fit_curve, ([0, 1, 2, 3], [1, 1, 1]), "mu: got the shape"),
        (fit_curve, ([0, 1, -2, 3], [1, 1, 1, 1]), r"speed\[2\]: got -2"),
        (fit_curve, ([0, 1, 2, 3], [1, math.nan, 1, 1]), r"mu\[1\]: got nan"),
        (fit_curve, ([0, 1, 2, 3], [0, 0, 0, 0]), "nothing but 0"),
        (fit_curve, ([0, 1, 2, 3], [1, 1, 1, 1], [1, 0, 1, 1]), r"sigma\[1\]: got 0"),
        (fit_ageing, ([10, 60], [0.1, 0.2], None), "got 2 distinct waiting times, expected at least 3"),
        (fit_ageing, ([10, 60, 300], [0.1, 0.2, 0.3], 0.0), "t0: got 0.0, expected a time > 0"),
        (fit_ageing, ([10, -60, 300], [0.1, 0.2, 0.3], 1.0), r"time\[1\]: got -60"),
        (fit_ageing, ([10, 60, 300], [0.1, 0.2], 1.0), "mu: got the shape"),
    ],
)
def test_impossible_points_are_refused(fit, points, message):
    with pytest.raises(ValueError, match=message):
        fit(*points)


# --- curves that fall all the way, that rise, that end at a bound -----------------------------------------------------

# speed in mm/s, mu
FALLS = {
    "bending": ([0.5, 1, 2, 5, 10], [0.14, 0.132, 0.124, 0.115, 0.11]),
    "straight": ([0.5, 2, 5, 7, 10], [0.14, 0.1355, 0.125, 0.12, 0.11]),
    "steeper and steeper": ([0.5, 2, 5, 7, 10], [0.14, 0.138, 0.13, 0.122, 0.11]),
    "with an outlier": ([0.5, 1, 2, 4, 7, 10], [0.14, 0.132, 0.124, 0.126, 0.115, 0.11]),
    "four": ([0.5, 2, 5, 10], [0.14, 0.132, 0.12, 0.11]),
}


@pytest.mark.parametrize(("speed", "mu"), FALLS.values(), ids=FALLS)
def test_a_few_points_that_fall_all_the_way_give_a_curve_that_falls(speed, mu):
    """Never a3 = 0, which would mean no stick-slip at all; what was not determined is said."""
    w = np.array(speed) / 1000
    fit = fit_curve(w, mu)
    assert "falls from 0.0005 m/s to 0.01 m/s" in fit.quality
    assert fit.assumed == ("a2",) and fit.a2 == 0 and "a2" in fit.unidentified and not fit.good
    curve = fit.predict(np.linspace(w[0], w[-1], 50))
    assert (np.diff(curve) < 0).all()
    np.testing.assert_allclose(fit.predict(w), mu, atol=0.006)
    low, high = fit.interval["mu_start"]
    spare = len(speed) - 4
    known = spare > 1 and "another shape" not in fit.quality
    assert (low, high) == (0, math.inf) or (known and 0.11 < low < 0.14 < high)
    assert fit.has_intervals == known
    if mu is FALLS["straight"][1]:  # coefficients that trade off against each other
        assert {"a1", "a3", "a4"} <= set(fit.unidentified) and "do not determine a1 and a3 and a4" in fit.quality


@pytest.mark.parametrize("mu", [[0.14, 0.12, 0.121, 0.119, 0.122], [0.14, 0.11, 0.112, 0.111]])
def test_a_few_points_in_no_order_are_too_few_to_tell(mu):
    """A first point above the others may well be a decline: nobody is told to leave it out."""
    quality = fit_curve(np.array([0.5, 1, 2, 5, 10])[: len(mu)] / 1000, mu).quality
    assert "measure more" in quality and "a3 was" not in quality


@pytest.mark.slow
def test_confidence_intervals_of_a_curve_that_strengthens_hold_what_they_promise():
    random = np.random.default_rng(12)
    truth = (0.4, 0.05, -0.15, 0.1)
    speed, trials, hits, good = np.linspace(0, 1, 40), 80, np.zeros(5), 0
    for _ in range(trials):
        fit = fit_curve(speed, law(speed, *truth) + random.normal(0, 0.005, speed.size))
        assert fit.a3 < 0
        good += fit.good
        hits += covered((*truth, 0.25), [fit.interval[name] for name in (*NAMES, "mu_start")])
    assert good >= 0.95 * trials
    low, high = binomial_bounds(trials)
    assert (hits > low).all() and (hits < high).all(), hits / trials


def test_a_curve_that_rises_and_then_falls_is_found():
    speed = np.linspace(0, 1, 40)
    truth = (0.4, -0.1, -0.15, 0.1)
    fit = fit_curve(speed, law(speed, *truth))
    assert list(fit.coefficients().values()) == pytest.approx(truth, rel=1e-5)


def test_static_friction_of_a_fit_is_not_negative():
    speed = np.linspace(0.02, 1, 30)
    fit = fit_curve(speed, np.maximum(law(speed, 0.4, 0.0, -0.5, 0.1), 0))
    assert fit.mu_start == 0.0 and fit.interval["mu_start"][0] == 0.0
    assert "mu_start" in fit.at_bound and "At its bound" in fit.quality and not fit.good


def test_a_coefficient_at_its_bound_is_not_praised():
    speed = np.linspace(0, 1, 30)
    fit = fit_curve(speed, law(speed, 0.5, -0.01, 0.3, 0.1) + np.random.default_rng(2).normal(0, 0.003, 30))
    assert fit.a2 == 0.0 and fit.at_bound == ("a2",) and fit.interval["a2"][0] == 0.0
    assert "determine a1, a3 and a4" in fit.quality
    fit = fit_curve(speed, law(speed, 0.0, 0.1, 0.3, 0.1) - 0.01 * np.exp(-((speed - 0.3) ** 2) / 0.02))
    assert "a1" in fit.at_bound and "At its bound" in fit.quality and not fit.good


# --- ageing -----------------------------------------------------------------------------------------------------------

WAITS = np.repeat([10.0, 60.0, 300.0, 1000.0], 3)  # the article's


def test_ageing_with_known_t0_is_a_straight_line_over_the_logarithm():
    random = np.random.default_rng(3)
    mu = growth(WAITS, 0.2, 0.03, 2.0) + random.normal(0, 0.002, WAITS.size)
    fit = fit_ageing(WAITS, mu, t0=2.0)
    (slope, level), covariance = np.polyfit(np.log10(1 + WAITS / 2.0), mu, 1, cov=True)
    assert [fit.mu0, fit.beta] == pytest.approx([level, slope], rel=1e-9)
    assert fit.standard_error["beta"] == pytest.approx(math.sqrt(covariance[0, 0]), rel=1e-9)
    assert fit.standard_error["mu0"] == pytest.approx(math.sqrt(covariance[1, 1]), rel=1e-9)
    assert not fit.t0_assumed and fit.interval["t0"] == (2.0, 2.0)


@pytest.mark.parametrize(
    ("waits", "truth", "given", "scatter"),
    [(WAITS, (0.2, 0.03, 1.0), 1.0, 0.002), (np.geomspace(0.5, 2000, 30), (0.2, 0.03, 20.0), None, 0.001)],
    ids=["t0 known", "t0 found"],
)
def test_confidence_intervals_of_ageing_hold_what_they_promise(waits, truth, given, scatter):
    random = np.random.default_rng(4)
    trials, hits = 200, np.zeros(3)
    for _ in range(trials):
        fit = fit_ageing(waits, growth(waits, *truth) + random.normal(0, scatter, waits.size), given)
        assert fit.good and not fit.t0_assumed
        hits += covered(truth, [fit.interval[name] for name in ("mu0", "beta", "t0")])
    low, high = binomial_bounds(trials)
    checked = hits[: 2 if given else 3]
    assert (checked > low).all() and (checked < high).all(), hits / trials


def test_interval_of_t0_is_that_of_scipys_curve_fit_where_the_scatter_is_small():
    waits = np.geomspace(0.5, 2000, 12)
    mu = growth(waits, 0.2, 0.03, 20.0) + np.random.default_rng(12).normal(0, 1e-5, waits.size)
    best, covariance = curve_fit(
        lambda t, mu0, beta, log_t0: growth(t, mu0, beta, np.exp(log_t0)), waits, mu, (0.2, 0.03, 3)
    )
    fit = fit_ageing(waits, mu)
    reach = stats.t(waits.size - 3).ppf(0.975) * math.sqrt(covariance[2, 2])
    assert np.log(fit.interval["t0"]) == pytest.approx([best[2] - reach, best[2] + reach], abs=0.02 * reach)
    assert math.log(fit.t0) == pytest.approx(best[2], abs=1e-3 * reach)
    errors = np.sqrt(np.diag(covariance)) * [1, 1, fit.t0]
    assert list(fit.standard_error.values()) == pytest.approx(errors, rel=1e-3)


def test_waits_long_against_t0_do_not_determine_it_but_the_slope_and_the_level():
    random = np.random.default_rng(5)
    truth, bounded, trials = (0.2, 0.03, 0.3), 0, 100
    for _ in range(trials):
        fit = fit_ageing(WAITS, growth(WAITS, *truth) + random.normal(0, 0.002, WAITS.size))
        bounded += not fit.t0_assumed
        if fit.t0_assumed:
            assert fit.t0 >= min(1.0, fit.interval["t0"][1]) * (1 - 1e-9)
            assert fit.interval["t0"][0] == 0 and math.isnan(fit.standard_error["t0"])
            assert "do not determine t0" in fit.quality and fit.good
            assert fit.beta == pytest.approx(0.03, abs=0.005)
            assert float(fit.predict(100.0)) == pytest.approx(growth(100.0, *truth), abs=0.003)
    assert bounded <= 12  # one in twenty is told a t0 by chance


def test_growth_in_proportion_to_time_has_no_slope_per_decade():
    fit = fit_ageing(
        np.linspace(1, 100, 20), 0.2 + 1e-4 * np.linspace(1, 100, 20) + noisy((0, 0, 0, 1), np.zeros(20), 1e-5)
    )
    assert not fit.good and "in proportion to time" in fit.quality
    assert fit.interval["t0"][1] == math.inf


@pytest.mark.parametrize(("slope", "scatter", "said"), [
    (0.0, 0.003, "show no ageing"),
    (-0.05, 0.003, "no ageing"),
    (0.02, 0.02, "explains only"),
])  # fmt: skip
def test_points_without_ageing_are_said_plainly(slope, scatter, said):
    waits = np.tile(WAITS, 4 if scatter > 0.01 else 1)
    mu = growth(waits, 0.5, slope, 1.0) + np.random.default_rng(6).normal(0, scatter, waits.size)
    fit = fit_ageing(waits, mu, t0=1.0)
    assert not fit.good and said in fit.quality


def test_lubricants_are_ranked_as_in_the_article():
    """Fig. 19: greases A and B of equal slope, grease C the lowest in level and in slope."""
    random = np.random.default_rng(9)
    truths = {"A": (0.12, 0.020, 1.0), "B": (0.09, 0.020, 1.0), "C": (0.07, 0.008, 1.0)}
    fits = {
        n: fit_ageing(WAITS, growth(WAITS, *p) + random.normal(0, 5e-4, WAITS.size), 1.0) for n, p in truths.items()
    }
    ranking = rank(fits, at=60.0)
    assert [r.name for r in ranking.by_level] == ["C", "B", "A"]
    assert ranking.by_slope[0].name == "C"
    for r in ranking.by_level:
        assert r.value == pytest.approx(growth(60.0, *truths[r.name]), abs=1e-3)
        assert r.interval[0] < growth(60.0, *truths[r.name]) < r.interval[1]
    with pytest.raises(ValueError, match="expected at least one"):
        rank({}, at=60.0)
    with pytest.raises(ValueError, match="expected a waiting time >= 0"):
        rank(fits, at=-1.0)


def test_the_interval_of_a_level_holds_what_it_promises():
    random = np.random.default_rng(10)
    truth, trials, hits = (0.2, 0.03, 1.0), 400, 0
    for _ in range(trials):
        fit = fit_ageing(WAITS, growth(WAITS, *truth) + random.normal(0, 0.002, WAITS.size), 1.0)
        (only,) = rank({"only": fit}, at=100.0).by_level
        hits += only.interval[0] <= growth(100.0, *truth) <= only.interval[1]
    low, high = binomial_bounds(trials)
    assert low < hits < high


# --- files ------------------------------------------------------------------------------------------------------------


def write(folder, text, encoding="utf-8"):
    path = folder / "points.csv"
    path.write_bytes(text.encode(encoding))
    return path


def test_points_are_read_in_si_whatever_the_order_and_the_units(tmp_path):
    text = '# felt, 10 N\n\nmu [-], "Speed [mm/s]"\n0.61, 0.7\n# a remark\n .5e0 ,+1\n'
    points = read_points(write(tmp_path, text, "utf-8-sig"), CURVE_COLUMNS)
    assert points["speed"].tolist() == [0.0007, 0.001] and points["mu"].tolist() == [0.61, 0.5]
    assert set(points) == {"speed", "mu"}
    points = read_points(write(tmp_path, "time (min),mu\r\n1,0.2\r\n"), AGEING_COLUMNS)
    assert points["time"].tolist() == [60.0]
    points = read_points(write(tmp_path, "speed,mu,sigma\n2,0.2,0.01\n"), CURVE_COLUMNS)
    assert [float(column[0]) for column in points.values()] == [2.0, 0.2, 0.01]


def test_a_unit_that_the_header_lacks_is_assumed_aloud_or_taken_from_the_caller(tmp_path):
    rows = "".join(f"{w},{mu}\n" for w, mu in zip(*FALLS["bending"], strict=True))
    bare = write(tmp_path, f"speed,mu\n{rows}")
    fit = fit_file(bare)
    assert fit.quality.startswith("The header gives no unit of speed, so the numbers were read in m/s (0.5 to 10 m/s)")
    assert "write 'speed [mm/s]'" in fit.quality and not fit.good
    told = fit_file(bare, unit="mm/s")
    assert told.a4 == pytest.approx(fit.a4 / 1000) and "header" not in told.quality
    assert fit_file(write(tmp_path, f"speed [m/s],mu\n{rows}"), unit="mm/s").a4 == fit.a4  # the header counts
    with pytest.raises(ConfigError, match=r"expected the unit of a speed(.|\n)*mm is a unit of length"):
        fit_file(write(tmp_path, f"speed,mu\n{rows}"), unit="mm")
    waits = "time,mu\n10,0.1\n60,0.12\n300,0.14\n1000,0.15\n"
    assert "no unit of time, so the numbers were read in s" in fit_ageing_file(write(tmp_path, waits)).quality
    assert "header" not in fit_ageing_file(write(tmp_path, waits), unit="min").quality


@cases("materials.yaml")
def test_what_is_wrong_in_a_file_is_said_with_its_place(tmp_path, text, place, said):
    path = write(tmp_path, text)
    with pytest.raises(ConfigError) as caught:
        read_points(path, CURVE_COLUMNS)
    (problem, *_) = caught.value.problems
    assert said in str(caught.value)
    assert problem.place == (place and Place(*place))
    assert str(caught.value).startswith(str(path) + (f":{place[0]}:{place[1]}: " if place else ": "))


def test_all_wrong_lines_are_told_at_once_up_to_a_screenful(tmp_path):
    with pytest.raises(ConfigError) as caught:
        read_points(write(tmp_path, "speed,mu\n" + "1;2,0,5\n" * 1000), CURVE_COLUMNS)
    assert len(caught.value.problems) == 20
