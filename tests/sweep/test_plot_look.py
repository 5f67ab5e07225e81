"""What may be wished of a map: scales, limits, points, hatching, colours of signs; pixels of many cells."""

import numpy as np
import pytest
from matplotlib.colors import LogNorm, to_rgb
from matplotlib.contour import QuadContourSet

from helpers.data import cases
from helpers.maps import axis, make_map, plane
from helpers.nightly import few
from helpers.plotted import LUBRICANTS, legend_of, lubricants, notes_of, panels_of, speeds, stiffnesses
from stickslip.dataset.display import MapAxis, with_units
from stickslip.errors import PlotError
from stickslip.plots.layout import resize
from stickslip.plots.maps import plot_map
from stickslip.plots.marks import Look
from stickslip.plots.palette import FLAG_COLOURS, HATCHES, paint
from stickslip.vocabulary.quantities import REGIMES

# --- limits and scales ------------------------------------------------------------------------------------------------


def test_limits_of_an_axis_are_in_its_units_and_other_cells_are_not_drawn():
    ds = with_units(plane(rows=6, columns=30), {"belt_speed": "mm/s"})
    ax = plot_map(ds, look=Look.of(ds, limits=["belt_speed=100..300 mm/s, stiffness=1..100 N/m"])).axes[0]
    assert ax.get_xlim() == pytest.approx((100, 300)) and ax.get_ylim() == pytest.approx((1, 100))
    assert ax.collections[0].get_array().shape[1] < 15


def test_limits_of_a_variable_are_those_of_its_colours_and_show_what_lies_beyond():
    ds = plane()
    figure = plot_map(ds, "spring_force_max", look=Look.of(ds, limits=["spring_force_max=1.4..1.5 N"]))
    norm = figure.axes[0].collections[0].norm
    assert (norm.vmin, norm.vmax) == pytest.approx((1.4, 1.5))
    assert figure.axes[-1].get_ylim() == pytest.approx((1.4, 1.5))


def test_logarithmic_scales_of_axes_and_colours():
    ds = plane(columns=8)
    figure = plot_map(ds, "spring_force_max", look=Look.of(ds, log=["belt_speed", "spring_force_max"]))
    assert figure.axes[0].get_xscale() == "log"
    assert isinstance(figure.axes[0].collections[0].norm, LogNorm)


@cases("sweep.yaml")
def test_wishes_that_cannot_be_met_say_what_can(wishes, message):
    ds = plane()
    with pytest.raises(PlotError, match=message):
        plot_map(ds, "damping_ratio", look=Look.of(ds, **wishes))


def test_names_have_no_scale():
    ds = make_map(*lubricants(LUBRICANTS), stiffnesses(), speeds())
    for wishes in ({"log": ["lubricant"]}, {"limits": ["lubricant=0..1"]}):
        with pytest.raises(PlotError, match="labels, no numbers"):
            Look.of(ds, **wishes)
    with pytest.raises(PlotError, match="regime has names, no numbers"):
        plot_map(ds, look=Look.of(ds, limits=["regime=0..1"]))


# --- operating points -------------------------------------------------------------------------------------------------


def test_marks_beyond_the_limits_are_not_drawn():
    ds = plane(columns=30)
    look = Look.of(
        ds, limits=["belt_speed=0.1..0.3"], marks=["stiffness=5, belt_speed=0.2", "stiffness=5, belt_speed=0.5"]
    )
    figure = plot_map(ds, look=look)
    rings = [line.get_xydata().tolist() for line in panels_of(figure)[0].lines]
    assert rings == [[[0.2, 5.0]]] and not any(label.startswith("B") for label in legend_of(figure))


def test_marks_lie_where_they_are_and_are_explained():
    ds = with_units(plane(), {"belt_speed": "mm/s"})
    figure = plot_map(
        ds, look=Look.of(ds, marks=["stiffness=5 N/m, belt_speed=20 mm/s", "pump: belt_speed=0.5, stiffness=9"])
    )
    drawn = [line.get_xydata()[0].tolist() for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert drawn == [[20.0, 5.0], [500.0, 9.0]]
    assert {"A: 5 N/m, 20 mm/s", "pump: 500 mm/s, 9 N/m"} <= set(legend_of(figure))
    assert {text.get_text() for text in figure.axes[0].texts} == {"A", "pump"}


def test_a_mark_is_drawn_in_the_panel_it_names_or_in_all():
    ds = make_map(axis("normal_load", [1.0, 2.5], "values"), *lubricants(LUBRICANTS), stiffnesses(), speeds())
    here = "stiffness=10, belt_speed=0.1"
    marks = [f"a: {here}", f"b: lubricant=grease, {here}", f"c: lubricant=dry, normal_load=2.5 N, {here}"]
    panels = panels_of(plot_map(ds, look=Look.of(ds, marks=marks)))
    drawn = {" ".join(ax.get_title().split()): sorted(text.get_text() for text in ax.texts) for ax in panels}
    assert drawn["normal load = 1 N lubricant: grease"] == ["a", "b"]
    assert drawn["normal load = 2.5 N lubricant: dry"] == ["a", "c"]
    assert drawn["normal load = 1 N lubricant: bonded coating"] == ["a"]


def test_a_mark_on_a_map_of_one_dimension_is_a_line():
    ds = make_map(speeds(20))
    strip, points = plot_map(ds, look=Look.of(ds, marks=["belt_speed=0.25"])).axes
    for ax in (strip, points):
        assert [0.25, 0.25] in [list(line.get_xdata()) for line in ax.lines]


def test_what_is_fixed_has_no_mark():
    ds = plane()
    with pytest.raises(PlotError, match="stiffness is fixed in this picture"):
        plot_map(ds, select={"stiffness": 10}, look=Look.of(ds, marks=["stiffness=10, belt_speed=0.1"]))


# --- hatching, signs --------------------------------------------------------------------------------------------------


def test_regimes_are_hatched_up_to_the_edges_of_their_cells():
    ds = plane(rows=4, columns=4)
    ds["regime"][:] = REGIMES.index("stick_slip")
    ds["regime"][2:, 1:] = REGIMES.index("stuck")
    figure = plot_map(ds, borders=False)
    areas = {one.hatches[0]: one for one in figure.axes[0].collections if isinstance(one, QuadContourSet)}
    area = areas[HATCHES[FLAG_COLOURS["regime"]["stuck"]]]
    ax, corners = figure.axes[0], np.concatenate([path.vertices for path in area.get_paths()])
    assert corners[:, 0].max() == ax.get_xlim()[1] and corners[:, 1].max() == ax.get_ylim()[1]
    assert corners[:, 0].min() == ax.collections[0].get_coordinates()[0, 1, 0]
    assert {legend_of(figure)[name].get_hatch() for name in ("stuck", "stick-slip")} == {*areas}
    assert any("held fixed" in note for note in notes_of(figure))


@pytest.mark.parametrize(("name", "factor"), [("damping_ratio", 1.0), ("damping_ratio", 1e5), ("margin_mass", 1.0)])
def test_a_sign_that_says_something_has_colours_that_part_at_zero(name, factor):
    ds = plane(rows=20, columns=20).rename(damping_ratio=name)
    ds[name][:] = np.linspace(-1, 1, 400).reshape(20, 20) ** 5
    ds[name][0, 0] *= factor
    figure = plot_map(ds, name)
    mesh = figure.axes[0].collections[0]
    red, _, blue, _ = mesh.cmap(mesh.norm(np.array([-0.5, 0.5]))).T
    assert red[0] > blue[0] and blue[1] > red[1]
    middle = mesh.cmap(mesh.norm(0.0))[:3]
    assert np.ptp(middle) < 0.05 and min(middle) > 0.9
    ticks = figure.axes[-1].get_yticks()
    assert factor == 1.0 or {-100.0, 0.0} <= set(ticks)


# --- titles and legends ----------------------------------------------------------------------------------------------


# --- nothing is cut off -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(16, 9), (9, 7), (8, 16)])
@pytest.mark.parametrize("variable", few(["damping_ratio", "regime", "period"], 1))
def test_nothing_is_cut_off_in_a_figure_of_any_size(variable, size):
    ds = with_units(plane(rows=6, columns=8), {"belt_speed": "mm/s"})
    wishes = Look.of(ds, marks=["operating point: stiffness=50 N/m, belt_speed=100 mm/s"])
    assert_whole(plot_map(ds, variable, look=wishes, title="What the bracket on its rail does"), size)


def test_nothing_is_cut_off_in_small_multiples_and_in_a_notebook():
    ds = make_map(*lubricants(LUBRICANTS), stiffnesses(), speeds())
    assert_whole(plot_map(ds), None)
    shown = plot_map(ds.isel(lubricant=slice(2)))
    assert shown._repr_png_()[:4] == b"\x89PNG"
    assert_whole(shown, None)


def assert_whole(figure, centimetres):
    """The box around all that is drawn lies within the figure."""
    if centimetres:
        resize(figure, *(side / 2.54 for side in centimetres))
    figure.draw_without_rendering()
    box, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    assert min(box.x0, box.y0) >= -0.02 and box.x1 <= width + 0.02 and box.y1 <= height + 0.02, box


def test_a_label_of_a_mark_stands_on_the_side_where_there_is_room():
    ds = plane(rows=6, columns=8)
    slow, fast = (float(ds["belt_speed"][i]) for i in (0, -1))
    marks = [f"slow: stiffness=5 N/m, belt_speed={slow}", f"fast: stiffness=5 N/m, belt_speed={fast}"]
    figure = plot_map(ds, look=Look.of(ds, marks=marks))
    sides = {text.get_text(): text.get_ha() for text in panels_of(figure)[0].texts}
    assert sides == {"slow": "left", "fast": "right"}


def test_logarithmic_axes_have_plain_numbers():
    ax = plot_map(plane()).axes[0]
    assert {"1", "10", "100"} <= {label.get_text() for label in ax.get_yticklabels()}
    few = plot_map(plane(), look=Look.of(plane(), limits=["stiffness=1..60 N/m"])).axes[0]
    assert {"1", "2", "5", "10", "20", "50"} <= {label.get_text() for label in few.get_yticklabels()}


def test_limits_keep_colours_logarithmic():
    assert isinstance(paint("period", np.geomspace(1e-3, 10.0, 50), limits=(0.1, 2.0)).norm, LogNorm)


def test_cells_without_a_value_are_hatched():
    ds = plane()
    ds["period"] = ds["damping_ratio"].where(ds["belt_speed"] > ds["belt_speed"].values[1]).rename("period")
    assert plot_map(ds, "period").axes[0].patch.get_hatch()


def large(rows=1100, columns=1500):
    """Pixels of 3 x 3 cells, the last ones shorter."""
    return make_map(stiffnesses(rows), axis("belt_speed", np.linspace(0.02, 0.6, columns)), damping=0.2)


def test_a_large_map_is_drawn_in_pixels_of_many_cells_which_the_plot_says():
    figure = plot_map(large())
    assert figure.axes[0].collections[0].get_array().shape == (367, 500)
    assert "each pixel shows 3 x 3 cells: their most frequent value" in notes_of(figure)
    assert "each pixel shows 3 x 3 cells: the mean of those that have a value" in notes_of(plot_map(large(), "period"))
    assert not any("pixel" in note for note in notes_of(plot_map(plane())))


def test_a_pixel_of_several_regimes_is_pale_and_a_lost_one_is_in_the_legend():
    ds = large()
    ds["regime"][:] = REGIMES.index("damped")
    ds["regime"][4, 7] = REGIMES.index("failed")
    figure = plot_map(ds, borders=False)
    names = [text.get_text() for text in figure.legends[0].texts]
    assert [" ".join(name.split()) for name in names] == [
        "damped", "failed (only in mixed)", "mixed (pale: the most frequent)"
    ]  # fmt: skip
    mesh = figure.axes[0].collections[0]
    colours = mesh.to_rgba(mesh.get_array())[..., :3]
    pure = to_rgb(FLAG_COLOURS["regime"]["damped"])
    assert (colours[1, 2] > pure).all()
    assert (np.delete(colours.reshape(-1, 3), 500 + 2, axis=0) == pure).all()


def test_no_pale_colour_is_taken_for_a_pure_one():
    palette = paint("regime", np.arange(2 * len(REGIMES))).colours.colors
    pure, pale = np.split(np.array([to_rgb(colour) for colour in palette]), 2)
    nearest = np.abs(pale[:, None] - pure[None]).max(axis=2).min(axis=1)
    assert nearest.min() > 0.07


def test_pixels_and_borders_lie_where_their_cells_lie():
    ds = large()
    figure, x = plot_map(ds), MapAxis(ds, "belt_speed")
    drawn = figure.axes[0].collections[0].get_coordinates()
    np.testing.assert_allclose(drawn[0, :, 0], np.append(x.edges[:-1:3], x.edges[-1]))
    assert figure.axes[0].get_xlim() == (x.edges[0], x.edges[-1])
    (zero,) = (c for c in figure.axes[0].collections[1:] if c.levels[0] == 0.0)
    points = np.concatenate([path.vertices for path in zero.get_paths() if len(path.vertices)])
    found = ds["damping_ratio"].interp(belt_speed=("p", points[:, 0]), stiffness=("p", points[:, 1]))
    scale = float(np.abs(ds["damping_ratio"]).max())
    assert np.abs(found).max() < 1e-3 * scale


def test_irregular_and_falling_axes_are_drawn_in_pixels_too():
    speeds = np.cumsum(np.random.default_rng(1).random(1500) ** 3 + 1e-3)
    ds = make_map(axis("stiffness", np.geomspace(1, 1000, 1100)[::-1], "log"), axis("belt_speed", speeds, "values"))
    rising = ds.sortby("stiffness")
    mesh = plot_map(ds).axes[0].collections[0]
    np.testing.assert_array_equal(mesh.get_array(), plot_map(rising).axes[0].collections[0].get_array())
    across, down = (MapAxis(rising, dim).pixel_edges(3) for dim in ("belt_speed", "stiffness"))
    np.testing.assert_array_equal(mesh.get_coordinates()[0, :, 0], across)
    np.testing.assert_array_equal(mesh.get_coordinates()[:, 0, 1], down)


def test_a_long_map_of_one_dimension_is_a_strip_of_pixels():
    figure = plot_map(make_map(speeds(4001)), "period")
    assert figure.axes[0].collections[0].get_array().size == 667
    assert "each pixel shows 6 cells: the mean of those that have a value" in notes_of(figure)


def test_codes_of_a_newer_version_are_refused():
    ds = plane()
    ds["regime"][0, 0] = 42
    with pytest.raises(PlotError, match=r"regime has codes that this version does not know: \[42\]"):
        plot_map(ds)
