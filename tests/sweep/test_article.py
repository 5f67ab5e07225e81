"""What the article says of its figures, checked by numbers. Mass 1 kg, load 1 N unless said otherwise."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread, imsave

import stickslip
from article import FIGURES, Written, borders, gallery, make
from article.recipe import cell, config_name, configuration, stick_slip_border
from helpers.installed import all_installed
from stickslip import theory
from stickslip.config.resolve import config_names

ROOT = Path(__file__).resolve().parents[2]
SMALL = 100_000  # bytes; plots are kept in the repository
CURVE = {"a2": 0.1, "a3": 0.3, "a4": 0.1}

# Tendency over drop where stick-slip begins, derived by SciPy: the first slip by DOP853 at rtol 1e-11, branch after
# branch, bisected for the mu_stop at which it just re-sticks. By belt speed, over stiffness.
STIFFNESS = (0.01, 0.1, 1, 10, 100, 10000)
BORDERS = {
    0.02: (0.6437, 0.0984, -0.3013, -0.0537, -0.0102, 0.0007),
    0.05: (0.6703, 0.1584, -0.2329, -0.0577, -0.0081, 0.0090),
    0.1: (0.7102, 0.2367, -0.0055, -0.0229, 0.0212, 0.0394),
    0.2: (0.7870, 0.3720, 0.2108, 0.1949, 0.1992, 0.2022),
    0.3: (0.8678, 0.5047, 0.3866, 0.3799, 0.3845, 0.3876),
}


@cache
def made(name):
    return FIGURES[name].function()


def found(name):
    return made(name).findings


def test_figure_2_the_transition_point_is_the_minimum_of_the_curve():
    assert found("fig2")["v_min"] == pytest.approx(0.1 * np.log(30), rel=1e-12)
    assert found("fig2")["mu_min"] == pytest.approx(1.044011974, abs=1e-9)
    curve = made("fig2").data["curve"]
    below = curve["slip_speed"].values < found("fig2")["v_min"]
    assert (np.diff(curve.values[below]) < 0).all() and (np.diff(curve.values[~below]) > 0).all()


def test_figure_2_stick_slip_ends_at_the_transition_point_only_if_it_starts_from_sliding():
    assert found("fig2")["edge_from_sliding"] == pytest.approx(found("fig2")["v_min"], rel=1e-3)
    near_harmonic = float(theory.stick_slip_limit(**CURVE, damping=0, normal_load=1))
    assert found("fig2")["edge_from_sticking"] == pytest.approx(near_harmonic, rel=0.01)
    assert found("fig2")["edge_from_sticking_over_v_min"] > 2


def test_beyond_figure_2_stick_slip_ends_between_the_transition_point_and_the_near_harmonic_limit():
    findings = found("borders")
    ends = borders.end_of_stick_slip(made("borders").data)
    assert findings["v_min"] == pytest.approx(0.1 * np.log(30), rel=1e-12)
    assert (np.diff(ends) > 0).all() and (findings["v_min"] < ends).all() and (ends < findings["limit"]).all()
    assert findings["end_stiff"] == pytest.approx(findings["limit"], rel=3e-5)  # 0.33 % kappa^2, kappa = 0.095
    assert findings["width"] <= 1e-9


def test_beyond_figure_2_both_are_possible_from_the_loss_of_stability_to_the_end_of_stick_slip():
    findings, step = found("basins"), 0.005
    assert findings["stable_from"] <= findings["both_from"] <= findings["stable_from"] + step
    ends = found("fig2")["edge_from_sticking"]
    assert ends - step <= findings["both_to"] <= ends
    near_harmonic = float(theory.unstable_amplitude(0.5, 0.1, 0.3, 0.1, 0.0, 1.0))
    assert findings["unstable_amplitude"] == pytest.approx(near_harmonic, rel=0.03)


def test_figure_3_sticks_at_the_belt_speed_and_slips_in_turn():
    assert found("fig3")["regime"] == "stick_slip"
    assert found("fig3")["period"] == pytest.approx(9.9445782, rel=1e-6)  # science.md 1.7
    assert found("fig3")["stick_fraction"] == pytest.approx(5.6224087 / 9.9445782, rel=1e-6)
    assert found("fig3")["relative_speed_in_stick"] == 0


def test_figure_4_the_slip_speed_overshoots_the_belt_and_can_reach_the_rising_branch():
    numbers = found("fig4")
    assert numbers["belt_speed_1"] < numbers["belt_speed_2"] < numbers["v_min"]
    assert numbers["regime_1"] == numbers["regime_2"] == "stick_slip"
    assert numbers["overshoot_1"] > numbers["overshoot_2"] > 2
    assert numbers["slip_speed_max_1"] < numbers["v_min"] < numbers["slip_speed_max_2"]


@pytest.mark.parametrize(
    ("curve", "regime"),
    [
        ("declining", "stick_slip"),
        ("flat", "sustained"),
        ("flat_with_a_damper", "damped"),
        ("rising", "damped"),
        ("steeply_rising", "creep"),
    ],
)
def test_figure_5_only_the_declining_curve_provokes_stick_slip(curve, regime):
    assert found("fig5")[f"regime_{curve}"] == regime


def test_figure_6_no_stiffness_is_free_of_stick_slip_on_the_plain_curve():
    assert found("fig6")["decades"] == pytest.approx(5)
    assert found("fig6")["share_stick_slip"] == 1


def test_figure_6_frequency_rises_and_amplitude_falls_with_stiffness():
    ds = made("fig6").data
    assert (ds["frequency"].diff("stiffness") > 0).all()
    assert (ds["displacement_amplitude"].diff("stiffness") < 0).all()
    assert found("fig6")["friction_swing_k1000"] > 2 * found("fig6")["friction_swing_k1"]  # but the force does not fall


def test_figure_7_the_lines_go_from_the_minimum_to_mu_stop():
    ds = made("fig7").data
    np.testing.assert_allclose(ds["deceleration"].sel(slip_speed=0), ds["mu_stop"], rtol=1e-12)
    above = ds["slip_speed"].values >= found("fig7")["v_reversal"]
    assert (ds["deceleration"].values[:, above] == ds["curve"].values[above]).all()
    assert found("fig7")["tendency_1"] > 0 > found("fig7")["tendency_3"]
    assert found("fig7")["tendency_2"] == pytest.approx(0, abs=1e-4)


def test_figure_8_stick_slip_damped_vibration_and_quickly_stationary():
    numbers = found("fig8")
    assert [numbers[f"regime_{i}"] for i in (1, 2, 3)] == ["stick_slip", "damped", "damped"]
    assert numbers["equilibrium_crossings_2"] > 2 * numbers["equilibrium_crossings_3"]
    assert numbers["settling_time_3"] < numbers["settling_time_2"] / 2
    assert max(numbers[f"line_error_{i}"] for i in (1, 2, 3)) < 1e-12
    assert numbers["mu_stop_2"] < numbers["border_mu_stop"] < numbers["mu_stop_1"]


def test_equation_3_is_right_in_nearly_all_cells_of_the_map_and_best_at_a_middling_speed():
    numbers = found("eq3")
    assert numbers["undecided"] == 0
    assert numbers["share_predicted"] == pytest.approx(0.967, abs=0.005)
    by_speed = [numbers[f"share_predicted_v{speed}"] for speed in ("0_02", "0_05", "0_1", "0_2")]
    assert by_speed == pytest.approx([0.949, 0.971, 0.993, 0.956], abs=0.005)
    assert numbers["share_of_false_alarms_past_min"] > 0.99


def test_equation_3_fails_where_slip_goes_through_the_rising_branch():
    numbers = found("eq3_box")
    assert numbers["undecided"] == 0
    assert numbers["share_predicted"] == pytest.approx(0.888, abs=0.005)
    assert numbers["share_predicted_below_min"] > 0.98
    assert numbers["share_predicted_past_min"] < 0.85
    assert numbers["share_of_false_alarms_past_min"] > 0.98
    assert numbers["share_missed"] < 0.02 < 0.15 < numbers["share_false_alarm"]


@pytest.mark.parametrize("speed", BORDERS)
def test_equation_3_the_true_border_is_where_scipy_found_it(speed):
    ours = [found("eq3_box")[f"border_v{speed:g}_k{stiffness:g}"] for stiffness in STIFFNESS]
    assert ours == pytest.approx(BORDERS[speed], abs=2e-4)


def test_equation_3_the_true_border_is_far_off_on_soft_springs_and_fast_belts():
    assert found("eq3_box")["border_lowest"] == pytest.approx(-0.301, abs=0.002)
    assert found("eq3_box")["border_highest"] == pytest.approx(0.868, abs=0.003)


def test_equation_3_is_exact_where_the_line_mirrors_the_curve():
    curved, straight = (found("eq3_box")[f"mirror_error_a4_{a4}"] for a4 in (1, 10))
    assert abs(straight) < 1e-3
    assert curved / straight == pytest.approx(10, rel=0.2)  # goes with the curvature, 1/a4


def test_figure_9_a_stiff_spring_ends_stick_slip_on_the_modified_curve():
    numbers = found("fig9")
    assert [numbers[f"regime_k{k}"] for k in (10, 30, 100)] == ["stick_slip", "stick_slip", "damped"]
    assert numbers["transition_stiffness"] == pytest.approx(55.92, abs=0.05)
    assert numbers["stiffness_of_zero_tendency"] == pytest.approx(47.90, abs=0.05)
    assert numbers["plain_share_stick_slip"] == 1


def test_figure_9_because_friction_at_reversal_rises_with_stiffness():
    ds = made("fig9").data
    assert (ds["mu_reversal"].diff("stiffness") > 0).all()
    assert (ds["tendency"].diff("stiffness") < 0).all()
    ends = ds["regime"].where(ds["stiffness"] <= found("fig9")["transition_stiffness"], drop=True)
    assert (ends == 1).all() and (ds["regime"] == 1).sum() == ends.size


def test_figure_10_the_area_grows_like_static_friction():
    assert found("fig10")["area_ratio_1000s"] == pytest.approx((0.15 + 0.02 * np.log10(1001)) / 0.15, rel=1e-9)


def test_figure_11_static_friction_is_linear_in_the_logarithm_of_waiting():
    numbers = found("fig11")
    assert numbers["off_law_max"] < 1e-12  # break-away is exact
    assert numbers["slope_per_decade"] == pytest.approx(numbers["ageing_rate"], rel=0.02)
    assert numbers["off_line_max"] < 0.05 * numbers["ageing_rate"]


@all_installed
def test_figure_19_greases_a_and_b_age_alike_and_grease_c_is_best():
    numbers = found("fig19")
    for grease in "ABC":
        assert numbers[f"slope_{grease}_low"] < numbers[f"ageing_rate_{grease}"] < numbers[f"slope_{grease}_high"]
    assert numbers["slope_C_high"] < min(numbers["slope_A_low"], numbers["slope_B_low"])
    assert max(numbers["slope_A_low"], numbers["slope_B_low"]) < min(numbers["slope_A_high"], numbers["slope_B_high"])
    assert numbers["best_by_level"] == numbers["best_by_slope"] == "grease C"


# --- figures, files, page ---------------------------------------------------------------------------------------------


def test_every_figure_has_its_configurations_and_every_configuration_its_figure():
    named = {config_name(config) for figure in FIGURES.values() for config in figure.configs} - {"rig/stiffness"}
    assert named == {name for name in config_names() if name.startswith("article/")}


def test_a_figure_becomes_a_plot_and_a_file_that_says_what_was_found(tmp_path):
    seen = []
    (written,) = make(["fig3"], tmp_path / "new", progress=seen.append)
    assert seen == ["fig3"]
    assert written.plot == tmp_path / "new" / "fig3.png" and written.plot.read_bytes()[1:4] == b"PNG"
    with stickslip.open(written.data) as ds:
        assert "period: 9.944578" in ds.attrs["findings"]
        assert "belt_speed: 0.1" in ds.attrs["configuration"]
        assert ds.attrs["title"].startswith("Figure 3")


def test_an_unknown_figure_is_refused_before_anything_is_made(tmp_path):
    with pytest.raises(ValueError, match="fig1; there are fig2, borders"):
        make(["fig3", "fig1"], tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_a_border_outside_the_ends_is_refused():
    p = cell(configuration("fig9"))
    del p["stiffness"]
    with pytest.raises(ValueError, match="stiffness from 100 to 200: expected one end of stick-slip"):
        stick_slip_border(p, "stiffness", (100.0, 200.0))


def apart(page):
    """The words of a page and its numbers."""
    number = re.compile(r"[+-]?\d[\d,]*(?:\.\d+)?(?:e[+-]\d+)?")
    return number.split(page), [float(found.replace(",", "")) for found in number.findall(page)]


@all_installed
def test_the_gallery_is_what_the_computation_says():
    written = [Written(name, Path(f"{name}.png"), Path(f"{name}.nc"), found(name)) for name in FIGURES]
    page = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    (words, numbers), (words_now, numbers_now) = apart(page), apart(gallery.text(written, "images/article"))
    assert words == words_now, "write it again: make gallery"
    assert numbers == pytest.approx(numbers_now, rel=0.01, abs=1e-4)  # a cell on a border may fall on either side


def test_a_slim_plot_is_smaller_and_of_indistinguishable_shades(tmp_path):
    random = np.random.default_rng(1)
    plot = tmp_path / "map.png"
    imsave(plot, np.clip(np.linspace(0, 1, 64)[:, None, None] + random.normal(0, 0.1, (64, 64, 3)), 0, 1))
    before, size = imread(plot)[..., :3], plot.stat().st_size
    gallery.slim(plot)
    after = imread(plot)[..., :3]
    assert plot.stat().st_size < 0.7 * size
    assert np.abs(after - before).max() <= 0.5 / 15 + 1 / 255


def test_the_plots_of_the_gallery_are_there_and_small():
    sizes = {name: (ROOT / "docs" / "images" / "article" / f"{name}.png").stat().st_size for name in FIGURES}
    assert max(sizes.values()) < SMALL, sizes
