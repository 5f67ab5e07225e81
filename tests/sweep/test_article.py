"""What the article says of its figures, checked by numbers. Mass 1 kg, load 1 N unless said otherwise."""

import math
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


def claims():
    """Lines of data/article.txt, but comments; figure 19 is of an extension."""
    for line in (ROOT / "tests/data/article.txt").read_text(encoding="utf-8").splitlines():
        figure, _, claim = line.partition(" ")
        if figure != "#":
            yield pytest.param(figure, claim.strip(), id=line, marks=all_installed if figure == "fig19" else ())


@pytest.mark.parametrize(("figure", "claim"), [*claims()])
def test_a_figure_shows_what_the_article_says(figure, claim):
    by_theory = {
        "near_harmonic": float(theory.stick_slip_limit(**CURVE, damping=0, normal_load=1)),
        "small_cycle": float(theory.unstable_amplitude(0.5, 0.1, 0.3, 0.1, 0.0, 1.0)),
    }
    assert eval(claim, vars(math) | by_theory, dict(found(figure)))


def test_stick_slip_ends_between_the_transition_point_and_the_near_harmonic_limit_by_stiffness():
    ends = borders.end_of_stick_slip(made("borders").data)
    assert (np.diff([found("borders")["v_min"], *ends, found("borders")["limit"]]) > 0).all()
    edge = found("fig2")["edge_from_sticking"]
    assert edge - 0.005 <= found("basins")["both_to"] <= edge


def test_figures_6_and_9_frequency_rises_amplitude_and_tendency_fall_with_stiffness():
    for figure, name, rises in (
        ("fig6", "frequency", True), ("fig6", "displacement_amplitude", False),
        ("fig9", "mu_reversal", True), ("fig9", "tendency", False),
    ):  # fmt: skip
        assert ((made(figure).data[name].diff("stiffness") > 0) == rises).all()
    ds = made("fig9").data
    assert ((ds["regime"] == 1) == (ds["stiffness"] <= found("fig9")["transition_stiffness"])).all()


def test_figure_7_the_lines_go_from_the_minimum_to_mu_stop():
    ds = made("fig7").data
    np.testing.assert_allclose(ds["deceleration"].sel(slip_speed=0), ds["mu_stop"], rtol=1e-12)
    above = ds["slip_speed"].values >= found("fig7")["v_reversal"]
    assert (ds["deceleration"].values[:, above] == ds["curve"].values[above]).all()


@pytest.mark.parametrize("speed", BORDERS)
def test_equation_3_the_true_border_is_where_scipy_found_it(speed):
    ours = [found("eq3_box")[f"border_v{speed:g}_k{stiffness:g}"] for stiffness in STIFFNESS]
    assert ours == pytest.approx(BORDERS[speed], abs=2e-4)


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
