"""Maps with more cells than a page has pixels."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from helpers.maps import axis, make_map, plane
from helpers.plotted import notes_of, speeds, stiffnesses
from stickslip.dataset.display import MapAxis
from stickslip.errors import PlotError
from stickslip.plots.maps import plot_map
from stickslip.plots.palette import FLAG_COLOURS, paint
from stickslip.vocabulary.flags import REGIMES


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
