"""Sweeps up and down: friction on the way down is mu_stop where it is, one curve where it is not, and no invention."""

import math

import numpy as np
import pytest

import stickslip
from helpers.data import rows
from helpers.measured import SI, SYSTEM
from stickslip.theory import reversal_speed, stribeck
from stickslip_materials.compare.table import material_page
from stickslip_materials.fit import fit_curve, fit_materials
from stickslip_materials.fit.turns import course

CURVE = (0.10, 0.06, 0.05, 0.03)
UP = np.geomspace(0.01, 1.0, 14)


def sweep(stop, seed=1, noise=0.01, curve=CURVE, loops=1):
    """Speeds up and down, and friction: Eq. (2a) below the minimum on the way down; stop None: the curve."""
    least = float(np.fmin(reversal_speed(*curve[1:]), UP[-1]))
    mu_up, down = stribeck(UP, *curve), UP[::-1]
    line = stribeck(down, *curve)
    if stop is not None:
        line = np.where(down < least, stop + (stribeck(least, *curve) - stop) * down / least, line)
    speed, mu = np.tile(np.r_[UP, down], loops), np.tile(np.r_[mu_up, line], loops)
    return speed, mu * (1 + noise * np.random.default_rng(seed).standard_normal(speed.size))


@pytest.mark.parametrize("loops", [1, 2])
def test_friction_on_the_way_down_is_mu_stop_and_does_not_bend_the_curve(loops):
    fit = fit_curve(*sweep(0.09, loops=loops))
    low, high = fit.interval["mu_stop"]
    assert low < 0.09 < high and high - low < 0.02 and fit.interval["mu_start"][0] < 0.15 < fit.interval["mu_start"][1]
    assert fit.coefficients()["mu_stop"] == fit.mu_stop and fit.good and fit.points == 28 * loops
    drawn = fit.draw(500).coefficients["mu_stop"]
    assert np.quantile(drawn, (0.025, 0.975)) == pytest.approx((low, high), abs=0.3 * (high - low))


def test_exact_sweeps_give_back_mu_stop():
    assert fit_curve(*sweep(0.09, noise=0.0)).mu_stop == pytest.approx(0.09, rel=1e-4)


@pytest.mark.parametrize("curve", [CURVE, (0.1, 0.08, 0.0, 0.03)], ids=["falling", "rising"])
def test_branches_that_agree_are_one_curve(curve):
    for seed in range(4):
        speed, mu = sweep(None, seed, 0.02, curve)
        fit = fit_curve(speed, mu)
        assert math.isnan(fit.mu_stop) and "mu_stop" not in fit.interval and "while the speed falls" not in fit.quality
        assert fit.a1 == pytest.approx(fit_curve(np.sort(speed), mu[np.argsort(speed)]).a1, rel=1e-6)


def test_a_way_down_that_differs_at_all_speeds_is_no_mu_stop():
    speed, mu = sweep(None, noise=0.01)
    mu[14:] *= 0.85
    fit = fit_curve(speed, mu)
    assert math.isnan(fit.mu_stop) and not fit.good and "while the speed falls" in fit.quality


def test_friction_that_runs_in_over_loops_is_no_mu_stop():
    speed, mu = sweep(None, noise=0.01, loops=3)
    fit = fit_curve(speed, mu * np.linspace(1.2, 1.0, mu.size))
    assert math.isnan(fit.mu_stop) and not fit.good and "drifts with the order" in fit.quality


def test_the_order_of_points_tells_where_a_sweep_turns():
    up, down = np.full(14, 1.0), np.full(14, -1.0)
    speed, _ = sweep(None)
    assert course(np.delete(speed, 14)).tolist() == [*up, *down[1:]]
    assert course(speed[::-1][:14]) is None and course(np.sort(speed)) is None  # falls only, sorted
    assert course(np.random.default_rng(3).permutation(speed)) is None
    assert course(np.tile(UP, 3)) is None  # repeats of one branch
    assert course(np.repeat([1, 2, 5, 10, 5, 2, 1.0], 3)).tolist() == [1.0] * 12 + [-1.0] * 9  # steady steps
    paused = np.r_[UP, np.full(6, UP[-1]), UP[-2::-1]]
    assert course(paused).tolist() == [1.0] * 20 + [-1.0] * 13
    two = np.r_[UP, UP[-2::-1], UP, UP[-2::-1]]
    assert course(two).tolist() == [*up, *down[1:], *up, *down[1:]]


TABLES = rows("materials.yaml")["test_turns"]["TABLES"]


@pytest.mark.parametrize("kind", TABLES)
def test_tables_say_where_a_sweep_turns(kind, tmp_path):
    speed, mu = sweep(0.09)
    order = range(28) if kind in ("order", "ramp") else np.random.default_rng(1).permutation(28)
    lines = [f"{1000 * speed[i]:.6g},{mu[i]:.6g}" for i in order]
    words = {"direction": ("up", "down"), "hin/her": ("hin", "her"), "ramp": ("1", "2")}
    if kind in words:
        lines = [f"{words[kind][int(i > 13)]},{line}" for i, line in zip(order, lines, strict=True)]
    elif kind == "wide":
        lines = [f"{1000 * speed[i]:.6g},{mu[i]:.6g},{mu[27 - i]:.6g}" for i in range(14)]
    text = TABLES[kind].format(rows="\n".join(lines))
    path = tmp_path / "grease.csv"
    path.write_text(text.replace(",", ";") if kind == "hin/her" else text)
    (material,) = fit_materials([path])
    assert material.name == "grease"
    assert material.curve.mu_stop == pytest.approx(fit_curve(*sweep(0.09)).mu_stop, rel=1e-3)


def test_shuffled_points_without_a_direction_are_one_curve():
    speed, mu = sweep(0.09)
    order = np.random.default_rng(1).permutation(28)
    assert math.isnan(fit_curve(speed[order], mu[order]).mu_stop)


def test_loops_of_two_greases_in_one_file_are_a_sweep_each(tmp_path):
    path = tmp_path / "two.csv"
    rows = [(name, *row) for name, stop in (("A", 0.09), ("B", None)) for row in zip(*sweep(stop), strict=True)]
    path.write_text("\n".join(["grease,speed [mm/s],mu", *(f"{n},{1000 * w:.6g},{y:.6g}" for n, w, y in rows)]))
    first, second = fit_materials([path])
    assert first.curve.mu_stop == pytest.approx(0.09, abs=0.01) and math.isnan(second.curve.mu_stop)


def test_compare_ends_vibration_where_the_curve_with_its_line_does():
    """And its interval where those of the curves drawn do; a material without a line has no mu_stop."""
    fit = fit_curve(*sweep(0.09))
    ds = stickslip.compare({"turned": fit, "plain": sweep(None)}, **SYSTEM, draws=60, progress=False)
    one, between = ds.sel(material="turned"), (ds.attrs["searched_from"], ds.attrs["searched_to"])
    borders = stickslip.border(SI | fit.coefficients(), "belt_speed", between)["border"].values
    assert float(one["quiet_above"]) == pytest.approx(np.nanmax(borders), rel=3e-9)
    drawn = fit.draw(60, falling=True).coefficients
    drawn = stickslip.border(SI | drawn, "belt_speed", between, 1e-4)["border"]
    ends = np.sort(np.nanmax(drawn, axis=1))[[2, -3]]  # 1 - 2/60 of them lie between
    np.testing.assert_allclose([one["quiet_above_low"], one["quiet_above_high"]], ends, rtol=2e-3)
    assert float(one["mu_stop"]) == fit.mu_stop and np.isnan(ds["mu_stop"].sel(material="plain"))
    again = stickslip.run(stickslip.config.reader.parse_config(str(ds.attrs["configuration"])))
    np.testing.assert_allclose(np.nanmax(again["border"], axis=1), ds["quiet_above"], rtol=3e-9)
    assert "mu_stop" in material_page(ds)
