"""What is seen and what can be changed, without a browser: configurations, maps, sliders."""

from math import isnan
from pathlib import Path

import numpy as np
import pytest

import stickslip
from helpers.configs import write_config
from helpers.data import cases
from helpers.nightly import few
from stickslip.config.grid import cell_of, config_at
from stickslip.config.reader import load_config, parse_config
from stickslip.engine import stop_flag
from stickslip.errors import ConfigError
from stickslip.files import writing
from stickslip.vocabulary.display_units import Unit, quantity, unit_for
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip_explore import maps
from stickslip_explore.view import (
    COARSE,
    FULL,
    View,
    cell_of_view,
    config_of,
    first_view,
    is_listed,
    open_source,
    settings,
    sides,
    sliders_of,
    with_plane,
)  # fmt: skip

SHIPPED = ("hysteresis", "lubricants", "quickstart", "uncertain")
CONFIGS = [path.stem for path in sorted(Path("configs").glob("*.yaml"))]
FEW = (9, 11)


def shipped(name):
    return open_source(f"configs/{name}.yaml")


def seen(source, view, most=COARSE):
    return maps.picture(maps.computed(config_of(source, view, most), stop_flag()), view)


def read(source, view, *most):
    return maps.picture(maps.read(source, view), view, *most)


def at_pixel(shown, i, j):
    return {shown.y.name: shown.y.at(i), shown.x.name: shown.x.at(j)}


def column(shown, name):
    return next(one for one in shown.columns if one.name == name)


def regimes(shown):
    return column(shown, "regime").values


@pytest.fixture(params=SHIPPED)
def source(request):
    return shipped(request.param)


@pytest.mark.parametrize("name", few(CONFIGS, {*CONFIGS} - {"table"}))  # a table has kernels of its own
def test_what_comes_with_the_program_is_seen_over_its_last_two_axes_or_what_people_ask_about(name):
    source = shipped(name)
    view = first_view(source)
    own = [name for name, axis in source.axes.items() if axis.size > 1][-2:]
    assert view.plane[2 - len(own) :] == tuple(own)
    shown = seen(source, view, COARSE if name in SHIPPED else (4, 5))
    assert (shown.y.name, shown.x.name) == view.plane and shown.shades.shape == regimes(shown).shape
    assert (regimes(shown) > 0).all()
    assert name not in SHIPPED or shown.shades.size >= 5 * 40 or min(shown.shades.shape) >= 15


def test_a_pixel_is_the_cell_that_a_click_computes(source):
    view = first_view(source)
    shown = seen(source, view, FEW)
    for i, j in np.random.default_rng(1).integers(0, shown.shades.shape, (12, 2)):
        cell = cell_of_view(source, view, at_pixel(shown, i, j))
        known = stickslip.evaluate(cell, law=source.options.law, rtol=source.options.rtol)
        assert int(known["regime"][0]) == regimes(shown)[i, j]
        force = column(shown, "spring_force_max")
        assert np.isclose(float(known["spring_force_max"][0]), force.values[i, j] * force.unit.size, rtol=1e-5)


@pytest.mark.filterwarnings("ignore::stickslip.errors.UnitWarning")
def test_the_settings_of_a_cell_give_that_cell_to_the_last_bit(source):
    view = first_view(source)
    slider = next(slider for slider in sliders_of(source, view.plane) if slider.name == "mass")
    changed = View(view.y, view.x, {"mass": 1.5 * slider.start}, view.points)
    for one in (view, changed):
        shown = seen(source, one, FEW)
        at = at_pixel(shown, 1, 2)
        direct = cell_of_view(source, one, at)
        by_words = cell_of(config_at(load_config(source.name), settings(source, one, at)))
        assert np.array_equal(list(direct.values()), list(by_words.values()), equal_nan=True)
    assert direct["mass"] == 1.5 * slider.start


def test_the_yaml_of_a_view_gives_the_same_map(source):
    view = first_view(source)
    view = View(view.y, view.x, {"normal_load": 1.25 * source.typical["normal_load"]}, view.points)
    config = config_of(source, view, FEW)
    again = stickslip.run(parse_config(config.to_yaml()))
    assert np.array_equal(again["regime"].values, maps.computed(config, stop_flag())["regime"].values)
    assert config.output.file is None and config.output.plot is None  # nobody's files are written over


@pytest.mark.parametrize("name", ["quickstart", "lubricants", "uncertain"])
def test_every_slider_reaches_both_ends_or_says_what_is_in_the_way(name):
    source = shipped(name)
    view = first_view(source)
    for slider in sliders_of(source, view.plane):
        assert slider.low < slider.high and (isnan(slider.start) or slider.low <= slider.start <= slider.high), slider
        assert slider.low <= slider.otherwise <= slider.high
        for end in (slider.low, slider.high):
            assert np.isclose(slider.value(slider.place(end)), end, rtol=1e-3)
            changed = View(view.y, view.x, {slider.name: end}, view.points)
            try:
                shown = seen(source, changed, (3, 4))
            except ConfigError as error:
                assert "expected" in str(error)
                assert any(name in str(error) for name in QUANTITIES)
            else:
                assert (regimes(shown) > 0).all()


def test_a_slider_begins_at_what_the_file_says():
    source = shipped("quickstart")
    sliders = {slider.name: slider for slider in sliders_of(source, ("stiffness", "belt_speed"))}
    start = {"mass": 0.1, "normal_load": 10.0, "damping": 0.0, "a4": 0.1}
    assert {name: sliders[name].start for name in start} == start
    assert isnan(sliders["mu_stop"].start) and sliders["mu_stop"].may_be_absent and not sliders["mass"].may_be_absent
    assert "stiffness" not in sliders and "delta" not in sliders  # an axis; of another law
    assert sliders["mass"].unit.name == "g" and sliders["mass"].is_log and not sliders["damping"].is_log


def test_a_slider_changes_what_physics_says_it_changes_or_names_the_key_and_the_bound():
    source = shipped("quickstart")
    view = first_view(source)
    plain = seen(source, view, FEW)
    damped = seen(source, View(view.y, view.x, {"damping": 1.8}, {}), FEW)
    stick_slip = [int((regimes(shown) == 1).sum()) for shown in (plain, damped)]
    assert 0 < stick_slip[1] < stick_slip[0]
    # xi'' + gamma xi' + xi = mu(w): with c = 0, four times load, stiffness and mass move the same cell alike
    at = {"stiffness": 50.0, "belt_speed": 0.3}
    one = stickslip.evaluate(cell_of_view(source, view, at))
    heavy = View(view.y, view.x, {"normal_load": 40.0, "mass": 0.4}, {})
    four = stickslip.evaluate(cell_of_view(source, heavy, at | {"stiffness": 200.0}))
    assert np.isclose(float(four["period"][0]), float(one["period"][0]), rtol=1e-9)
    with pytest.raises(ConfigError, match=r"mu_stop.*got 1\.4, expected at most .*1\.3"):
        config_of(source, View(view.y, view.x, {"mu_stop": 1.4}, {}))


def test_any_quantity_can_be_a_side():
    source = shipped("lubricants")
    offered = sides(source)
    assert offered[:2] == ["lubricant", "belt_speed"] and {"mass", "stiffness", "normal_load"} <= set(offered)
    view = with_plane(first_view(source), "stiffness", "belt_speed")
    assert view.points == {} and view.plane == ("stiffness", "belt_speed")
    shown = seen(source, View(*view.plane, {}, {"lubricant": 3}), FEW)
    cell = cell_of_view(source, View(*view.plane, {}, {"lubricant": 3}), at_pixel(shown, 4, 5))
    assert cell["a1"] + cell["a3"] == pytest.approx(0.15)  # grease: mu_start
    assert shown.y.kind == "log" and shown.y.values[0] == 1e3 and shown.y.values[-1] == pytest.approx(1e5)


def test_points_with_names_lie_side_by_side_under_them():
    shown = seen(shipped("hysteresis"), first_view(shipped("hysteresis")), (300, 40))
    assert shown.y.kind == "listed" and shown.y.labels == ("none", "1.3", "1.044", "0.788", "0.6")
    assert shown.y.ends == (-0.5, 4.5) and shown.x.kind == "linear"


def test_what_is_uncertain_has_its_median_and_the_page_says_so():
    source = shipped("uncertain")
    assert source.fixed["belt_speed"] == pytest.approx(0.78)
    assert len(source.notes) == 1 and "median" in source.notes[0] and "belt_speed 780 mm/s" in source.notes[0]


# --- results of files -------------------------------------------------------------------------------------------------


def test_a_result_is_shown_as_it_lies_in_the_file_without_computing(tmp_path, monkeypatch):
    ds = stickslip.run(write_config(tmp_path), tmp_path / "map.nc")
    source = open_source(tmp_path / "map.nc")
    monkeypatch.setattr(maps, "MapStudy", None)
    assert np.array_equal(regimes(read(source, first_view(source))), ds["regime"].values)
    assert {name for name, _ in maps.variables(maps.read(source, first_view(source)))} >= {"regime", "period"}


def test_a_result_of_three_dimensions_shows_the_plane_that_was_picked(tmp_path):
    text = tmp_path / "three.yaml"
    text.write_text(
        "title: t\nsystem: {mass: 1, normal_load: 1}\nfriction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}\n"
        "axes:\n  mu_stop: [none, 1.0, 0.7]\n  damping: {start: 0, stop: 0.4, num: 3}\n"
        "  stiffness: {start: 0.01, stop: 10, num: 7, spacing: log}\n  belt_speed: {start: 0.05, stop: 1, num: 8}\n"
    )
    ds = stickslip.run(text, tmp_path / "map.nc")
    source = open_source(tmp_path / "map.nc")
    view = first_view(source)
    for point in range(3):
        one = View(view.y, view.x, {}, {"mu_stop": point})
        assert np.array_equal(regimes(read(source, one)), ds["regime"].values[point, 1])
        assert np.array_equal(regimes(seen(source, one, FULL)), ds["regime"].values[point, 1])
    assert is_listed(source.axes["mu_stop"]) and not is_listed(source.axes["damping"])
    pytest.importorskip("bokeh")
    from stickslip_explore.static import left_out

    (note,) = left_out(source)
    assert note.startswith("mu_stop is held at none") and "2 points are not" in note


def test_a_result_larger_than_the_screen_is_reduced_and_says_so(tmp_path):
    stickslip.run(write_config(tmp_path, num=450), tmp_path / "map.nc")
    source = open_source(tmp_path / "map.nc")
    shown = read(source, first_view(source))
    assert shown.shades.shape == (225, 225) and "2 x 2 cells" in shown.note
    assert any("mixed" in label for label, _ in shown.legend)


def test_cells_that_were_left_out_are_blank_and_variables_stand_in_the_order_of_the_vocabulary(tmp_path):
    ds = stickslip.run(write_config(tmp_path))
    kept = ds["regime"] == 1
    writing.write(ds.where(kept)[sorted(ds.data_vars, reverse=True)], tmp_path / "loud.nc")
    source = open_source(tmp_path / "loud.nc")
    view = first_view(source)
    for most in (FULL, (4, 5)):
        shown = read(source, view, most)
        blank = np.array(shown.palette)[shown.shades] == "#ffffff"
        assert blank.any() and not blank.all() and np.array_equal(blank, np.isnan(regimes(shown)))
        assert [label for label, _ in shown.legend][0] == "stick-slip"
    assert np.array_equal(np.isnan(regimes(read(source, view))), ~kept.values)
    offered = [name for name, _ in maps.variables(maps.read(source, view))]
    assert offered[0] == "regime" and offered.index("period") < offered.index("damping_ratio")


CELL = {"mass": 1, "normal_load": 1, "stiffness": 1, "belt_speed": 0.1, "a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1}
NO_MAPS = {
    "contours.nc": lambda folder: stickslip.contours(write_config(folder), points=16, scan=8),
    "trace.nc": lambda folder: stickslip.simulate(duration=1.0, **CELL),
    "cells.nc": lambda folder: stickslip.evaluate(CELL),
    "ramp.nc": lambda folder: stickslip.ramp(CELL | {"belt_speed": 0.3}, "belt_speed", (0.1, 0.5), 5),
}


@pytest.mark.parametrize("name", ["configs/rig/materials.yaml", *NO_MAPS])
def test_what_is_no_map_is_refused_with_a_reason(name, tmp_path):
    path, reason = (
        name,
        r"(?s)a ramp.*stickslip plot .*ramp\.nc" if "ramp" in name else "(?s)rig|no map|holds no regimes",
    )
    if name in NO_MAPS:
        path = tmp_path / name
        writing.write(NO_MAPS[name](tmp_path), path)
    with pytest.raises(ConfigError, match=reason):
        open_source(path)


# --- words ------------------------------------------------------------------------------------------------------------


@cases("explore.yaml")
def test_numbers_are_told_in_the_unit_in_which_they_are_read(units, value, expected):
    assert quantity(value, units) == expected
    assert unit_for("m s-1", [2.0], "mm/s").text(2.0) == "2000 mm/s"


def test_sides_and_sliders_are_in_the_units_the_file_was_written_in():
    lubricants = shipped("lubricants")
    shown = seen(lubricants, first_view(lubricants))
    assert shown.x.unit.name == "mm/s" and shown.x.title == "belt speed (mm/s)"
    sliders = {slider.name: slider for slider in sliders_of(lubricants, first_view(lubricants).plane)}
    assert sliders["stiffness"].unit == Unit("N/mm", 1e3) and sliders["mass"].unit.name == "kg"
    assert column(shown, "slip_speed_max").unit.name == "mm/s"  # outputs follow inputs


def test_names_of_regimes_stand_in_their_own_region(source):
    shown = seen(source, first_view(source))
    names = list(column(shown, "regime").names)
    assert shown.regions
    for name, x, y in shown.regions:
        here = regimes(shown)[shown.y.nearest(y), shown.x.nearest(x)]
        assert names[int(here)].partition(" (")[0] == name
    largest = np.bincount(regimes(shown).astype(int).ravel()).argmax()
    assert any(names[largest].startswith(name) for name, _, _ in shown.regions)
