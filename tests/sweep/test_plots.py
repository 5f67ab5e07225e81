import os
import subprocess
import sys
from itertools import combinations
from operator import attrgetter

import numpy as np
import pytest
from matplotlib.colors import LogNorm, to_rgb

import stickslip
from helpers.data import cases
from helpers.maps import axis, cell_dataset, make_map, plane
from helpers.plotted import (
    LUBRICANTS,
    legend_of,
    lubricants,
    panels_of,
    refuses_what_it_cannot_draw,
    speeds,
    stiffnesses,
)
from stickslip import plots
from stickslip.dataset.build import trace_dataset
from stickslip.dataset.display import MapAxis
from stickslip.dataset.selection import selected
from stickslip.errors import PlotError
from stickslip.plots import layout
from stickslip.plots.lines import plot_trace
from stickslip.plots.maps import plot_map
from stickslip.plots.palette import FLAG_COLOURS, UNDEFINED_COLOUR
from stickslip.vocabulary.quantities import REGIMES

# --- colours and legend -----------------------------------------------------------------------------------------------


def test_cells_are_painted_in_the_colour_of_the_legend():
    ds = plane()
    figure = plot_map(ds)
    mesh = figure.axes[0].collections[0]
    painted = mesh.to_rgba(ds["regime"].values)
    for code in np.unique(ds["regime"]):
        expected = to_rgb(FLAG_COLOURS["regime"][REGIMES[code]])
        assert (painted[ds["regime"].values == code][:, :3] == expected).all()


def test_the_legend_holds_only_what_is_in_the_map():
    ds = plane()
    ds["regime"][:] = REGIMES.index("stick_slip")
    ds["regime"][0, 0] = REGIMES.index("unresolved")
    assert set(legend_of(plot_map(ds, borders=False))) == {"stick-slip", "unresolved"}


def test_a_number_gets_a_colour_bar_with_its_unit_and_undefined_cells_are_grey():
    figure = plot_map(plane(), "period")
    assert figure.axes[-1].get_ylabel() == "period of the limit cycle (s)"
    assert legend_of(figure)["undefined"].get_facecolor()[:3] == to_rgb(UNDEFINED_COLOUR)
    assert figure.axes[0].get_facecolor()[:3] == to_rgb(UNDEFINED_COLOUR)
    assert np.ma.count_masked(figure.axes[0].collections[0].get_array()) == int(plane()["period"].isnull().sum())


def test_colours_are_logarithmic_when_a_positive_number_spans_decades():
    assert isinstance(plot_map(plane(), "breakaway_time").axes[0].collections[0].norm, LogNorm)
    assert not isinstance(plot_map(plane(), "damping_ratio").axes[0].collections[0].norm, LogNorm)


def test_a_variable_without_a_single_value_is_refused_with_the_reason():
    ds = plane()
    ds["period"][:] = np.nan
    ds["regime"][:] = REGIMES.index("damped")
    with pytest.raises(PlotError, match=r"no cell has a value of period.*\(regimes: damped\)"):
        plot_map(ds, "period")
    with pytest.raises(PlotError, match="no cell has a value"):
        plot_map(ds, "period", select={"stiffness": 10})


# --- axes -------------------------------------------------------------------------------------------------------------


def test_cells_end_half_way_to_their_neighbours_on_the_scale_of_the_axis():
    ds = make_map(axis("stiffness", [1.0, 10.0, 100.0], "log"), axis("belt_speed", [0.1, 0.2, 0.4], "values"))
    np.testing.assert_allclose(MapAxis(ds, "stiffness").edges, np.array([0.1, 1.0, 10.0, 100.0]) * np.sqrt(10))
    np.testing.assert_allclose(MapAxis(ds, "belt_speed").edges, [0.05, 0.15, 0.3, 0.5])


def test_named_points_stand_side_by_side_under_their_labels():
    ax = plot_map(make_map(speeds(), *lubricants(LUBRICANTS))).axes[0]
    assert [text.get_text() for text in ax.get_xticklabels()] == LUBRICANTS
    assert ax.get_xlabel() == "lubricant"


def test_points_without_names_are_described_by_what_varies():
    ax = plot_map(make_map(*lubricants(), speeds())).axes[0]
    assert ax.get_yticklabels()[0].get_text() == "a3 = 0.1, a4 = 0.1 m/s"


# --- any number of dimensions -----------------------------------------------------------------------------------------


def test_titles_of_friction_panels_and_of_their_axes_do_not_overlap():
    first, second = (axis(name, [0.1, 0.2, 0.3], "values") for name in ("mu_stop", "ageing_rate"))
    inner = axis("ageing_time", [0.5, 1.0], "values"), axis("delta", [1.0, 2.0], "values")
    figure = plot_map(make_map(first, second, *inner))
    figure.draw_without_rendering()
    panels = panels_of(figure)
    assert panels[0].get_title() == "mu_stop = 0.1\nageing rate = 0.1"
    for words in ("title", "xaxis.label", "yaxis.label"):
        shown = [attrgetter(words)(ax) for ax in panels]
        boxes = [text.get_window_extent() for text in shown if text.get_text()]
        assert len(boxes) >= 3
        assert not any(one.overlaps(other) for one, other in combinations(boxes, 2)), words


def test_a_group_of_many_quantities_is_told_in_lines_that_fit_its_panel():
    three = (axis(name, [0.1, 0.2], "values", "pair") for name in ("mu_static", "ageing_rate", "ageing_time"))
    (first, _) = panels_of(plot_map(make_map(*three, stiffnesses(), speeds())))
    assert " ".join(first.get_title().split()) == "mu_static = 0.1, ageing rate = 0.1, ageing time = 0.1 s"
    assert max(map(len, first.get_title().splitlines())) <= 36


def test_cases_of_a_quantity_are_named_after_it():
    ds = make_map(axis("mu_stop", [np.nan, 1.2], "values", "mu_stop_case", ["none", "1.2"]), stiffnesses(), speeds())
    assert [ax.get_title() for ax in panels_of(plot_map(ds))] == ["mu_stop = none", "mu_stop = 1.2"]


def test_panels_show_their_own_part_of_the_map():
    ds = make_map(axis("normal_load", [1.0, 2.5, 9.0], "values"), stiffnesses(), speeds())
    for i, ax in enumerate(panels_of(plot_map(ds, "spring_force_max"))):
        np.testing.assert_array_equal(ax.collections[0].get_array().reshape(5, 6), ds["spring_force_max"][i])


def test_two_leading_dimensions_span_a_table():
    ds = make_map(axis("mass", [1.0, 2.0]), axis("normal_load", [1.0, 2.0, 3.0]), stiffnesses(), speeds())
    panels = panels_of(plot_map(ds))
    assert panels[4].get_title() == "mass = 2 kg\nnormal load = 2 N"


def test_too_many_panels_are_refused_with_the_remedy():
    ds = make_map(
        axis("mass", np.linspace(1, 2, 5)), axis("normal_load", [1.0, 2.0, 3.0, 4.0]), stiffnesses(), speeds()
    )
    with pytest.raises(PlotError, match=r"20 panels over mass \(5\), normal_load \(4\).*\n.*select"):
        plot_map(ds)
    assert len(panels_of(plot_map(ds, select={"mass": 1.3}))) == 4


@pytest.mark.parametrize("place", [{"lubricant": "grease"}, {"belt_speed": 0.21}, {"belt_speed": "0.21"}])
def test_a_dimension_can_be_fixed_by_label_or_by_the_nearest_value(place):
    ds = make_map(*lubricants(LUBRICANTS), stiffnesses(), speeds())
    assert len(panels_of(plot_map(ds, select=place))) == 1


@cases("sweep.yaml")
def test_impossible_selections_say_what_is_possible(place, message):
    with pytest.raises(PlotError, match=message):
        plot_map(make_map(*lubricants(LUBRICANTS), stiffnesses(), speeds()), select=place)


@pytest.mark.parametrize(
    ("asked", "drawn"), [(0.1, 0.1), (20, 10), (40, 100), (1000.0001, 1000), ("1 N/mm", 1000), ("0.2 N/mm", 100)]
)
def test_a_value_within_the_axis_takes_the_cell_that_holds_it(asked, drawn):
    """On the scale of the axis: 40 lies above the border between the cells of 10 and 100 of a logarithmic one."""
    for rising in (True, False):
        ds = make_map(axis("stiffness", np.geomspace(0.1, 1000, 5)[:: 1 if rising else -1], "log"), speeds())
        part, _ = selected(ds, {"stiffness": asked})
        assert float(part["stiffness"]) == pytest.approx(drawn)


@pytest.mark.parametrize("asked", [0.09, 0.03, 1001.0, "1.1 N/mm", 3300.0, 0.0, -1.0])
def test_a_value_beyond_the_axis_is_refused_with_its_range(asked):
    with pytest.raises(PlotError, match=r"cannot select stiffness=.*the axis runs from 0.1 N/m to 1000 N/m"):
        plot_map(plane(), select={"stiffness": asked})


def test_the_title_names_the_point_that_is_drawn():
    ds = make_map(*lubricants(LUBRICANTS), stiffnesses(), speeds())
    figure = plot_map(ds, select={"stiffness": 12.0, "lubricant": "grease"})
    assert figure.axes[0].get_title() == "A made-up map\nstiffness = 10 N/m, lubricant: grease"
    assert plot_map(plane(), select={"stiffness": 0.1}).axes[0].get_title().endswith("stiffness = 0.1 N/m")


def test_a_case_of_a_quantity_is_selected_by_its_name():
    ds = make_map(axis("mu_stop", [np.nan, 1.2], "values", "mu_stop_case", ["none", "1.2"]), stiffnesses(), speeds())
    for asked, case in (("none", "none"), (1.2, "1.2")):
        assert str(selected(ds, {"mu_stop": asked})[0]["mu_stop_case"].values) == case


def test_a_map_of_one_dimension_is_a_strip_above_points():
    ds = make_map(speeds(20))
    strip, points = plot_map(ds, "period").axes
    assert strip.get_ylabel() == "regime" and points.get_ylabel().split() == "period of the limit cycle (s)".split()
    assert points.get_xlabel() == "belt speed (m/s)"
    assert " ".join(plot_map(ds).axes[1].get_ylabel().split()) == "linear damping ratio of steady sliding on the curve"


def test_cells_of_a_list_are_numbered():
    ds = cell_dataset({name: 1.0 for name in ("mass", "a1", "a2", "a3", "a4")}, {"regime": [1, 2, 2]}, {})
    (strip,) = plot_map(ds).axes
    assert [text.get_text() for text in strip.get_xticklabels()] == ["0", "1", "2"]


def test_a_single_cell_is_no_map():
    with pytest.raises(PlotError, match="simulate"):
        plot_map(make_map())


def test_unknown_variables_are_refused_with_those_that_exist():
    with pytest.raises(PlotError, match="no variable 'colour'; there are regime"):
        plot_map(plane(), "colour")


# --- trajectories -----------------------------------------------------------------------------------------------------


def made_up_trace(belt=0.5):
    time = np.linspace(0.0, 4.0, 9)
    mode = np.array([0, 0, 0, 1, 1, 0, 0, 1, 1])
    velocity = np.where(mode == 0, belt, -0.3)
    samples = {
        "displacement": np.cumsum(velocity),
        "velocity": velocity,
        "relative_speed": belt - velocity,
        "mode": mode,
    }
    return trace_dataset(time, samples, {"mass": 1.0}, {"title": "made up"})


def test_stick_phases_are_shaded_from_re_stick_to_break_away():
    spans = [(p.get_x(), p.get_x() + p.get_width()) for p in plot_trace(made_up_trace()).axes[0].patches]
    assert spans == [(0.0, 1.5), (2.5, 3.5)]


def test_the_phase_portrait_shows_the_belt_speed_if_it_is_constant():
    assert len(plot_trace(made_up_trace()).axes[2].lines) == 3
    assert len(plot_trace(made_up_trace(np.linspace(0.1, 0.5, 9))).axes[2].lines) == 2


def test_a_map_is_no_trajectory():
    with pytest.raises(PlotError, match="not a trajectory"):
        plot_trace(plane())


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_plots_are_written_in_the_format_of_their_name(suffix, tmp_path):
    path = tmp_path / f"map{suffix}"
    layout.save(plot_map(plane()), path, dpi=60)
    assert path.read_bytes()[:4] in (b"\x89PNG", b"<?xm", b"%PDF")


@pytest.mark.parametrize("name", ["map.sketch", "absent/map.png"])
def test_plots_that_cannot_be_written_are_named(name, tmp_path):
    with pytest.raises(PlotError, match=name):
        layout.save(plot_map(plane()), tmp_path / name)


@pytest.mark.slow
def test_plotting_needs_no_pyplot():
    code = "import sys, stickslip.plots; sys.exit('matplotlib.pyplot' in sys.modules)"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    assert subprocess.run([sys.executable, "-c", code], env=environment).returncode == 0


# --- what is given ----------------------------------------------------------------------------------------------------


CELLS_OF_A_LIST = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1,
                   "belt_speed": [0.5, 0.3, 0.4]}  # fmt: skip


def test_attractors_of_a_list_of_cells_are_points():
    box = {"displacement": (-1.0, 1.0), "velocity": (-1.0, 1.0)}
    found = stickslip.attractors(CELLS_OF_A_LIST, box=box)
    upper, lower = plots.plot_attractors(found).axes
    np.testing.assert_array_equal(upper.lines[1].get_ydata(), found["settling_share"])
    assert all(line.get_linestyle() == "None" and line.get_marker() == "o" for line in (*upper.lines, *lower.lines))


@pytest.mark.parametrize("draw", [
    plots.plot_map, plots.plot_result, plots.plot_attractors, plots.plot_branches, plots.plot_ramp, plots.plot_of_ramp,
    plots.plot_trace, plots.plot_probability,
])  # fmt: skip
def test_every_plot_of_a_dataset_says_what_to_give_instead(draw):
    refuses_what_it_cannot_draw(draw, draws_cells=draw in (plots.plot_map, plots.plot_result))
