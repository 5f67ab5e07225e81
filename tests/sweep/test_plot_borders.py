"""Borders over maps: those of linear theory, and exact ones."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.contour import QuadContourSet
from scipy.optimize import brentq

from helpers.maps import axis, make_map, plane
from helpers.plotted import legend_of, panels_of, speeds, stiffnesses
from stickslip import theory
from stickslip.dataset.build import axis_variable
from stickslip.dataset.display import joined_crossings
from stickslip.errors import PlotError
from stickslip.plots.maps import plot_map
from stickslip.vocabulary.quantities import QUANTITIES

# --- linear theory ----------------------------------------------------------------------------------------------------


def linear_borders_of(figure):
    """Points (x, y) of the borders of linear theory, by level."""
    contours = [one for one in figure.axes[0].collections if isinstance(one, QuadContourSet) and not one.filled]
    return {one.levels[0]: np.concatenate([path.vertices for path in one.get_paths()]).T for one in contours}


def test_linear_borders_lie_where_the_damping_ratio_is_zero_and_one():
    ds = make_map(axis("stiffness", np.geomspace(0.01, 10, 60), "log"), speeds(80), damping=0.2)
    figure = plot_map(ds)
    assert {"damping ratio 0 (linear)", "damping ratio 1 (linear)"} <= set(legend_of(figure))
    lines = linear_borders_of(figure)
    assert set(lines) == {0.0, 1.0}
    for level, (speed, stiffness) in lines.items():
        slope = theory.stribeck_slope(speed, *(float(ds[name]) for name in ("a2", "a3", "a4")))
        np.testing.assert_allclose(theory.damping_ratio(slope, 1.0, stiffness, 0.2, 1.0), level, atol=0.01)


@pytest.mark.parametrize("law", ["stribeck", "rational", "stribeck_delta"])
def test_a_refined_map_has_the_borders_of_the_closed_form(law):
    """Most of its cells have no damping ratio; sliding loses stability where the curve has its minimum."""
    ds = make_map(stiffnesses(), speeds(40), delta=1.0, damping=0.0).drop_vars("damping_ratio")
    ds = ds.assign_attrs(refine_box=8, configuration=f"friction: {{law: {law}}}\n")
    ((speed, _),) = linear_borders_of(plot_map(ds)).values()
    a2, a3, a4 = (float(ds[name]) for name in ("a2", "a3", "a4"))
    z = brentq(lambda z: a2 + a3 / a4 * theory.curve.weakening(law, z, 1.0)[1], 0.1, 10.0)
    np.testing.assert_allclose(speed, z * a4, rtol=1e-3)
    assert not linear_borders_of(plot_map(ds.drop_vars("mass"))), "of which theory knows too little"


def test_borders_outside_the_map_are_neither_drawn_nor_promised():
    ds = make_map(stiffnesses(), axis("belt_speed", np.linspace(0.02, 0.1, 5)))
    figure = plot_map(ds)
    assert set(legend_of(figure)) == {"stick-slip"}
    assert not [one for one in figure.axes[0].collections if len(getattr(one, "levels", ())) == 1]


# --- exact ------------------------------------------------------------------------------------------------------------


def border_lines_of(figure, panel=0):
    """Coordinates of the white lines in a panel."""
    return [line.get_xydata() for line in panels_of(figure)[panel].lines if line.get_color() == "white"]


def borders_along(along, across, values, **regimes):
    """A dataset of borders with a line per point of `across`."""
    values = np.array(values)
    below = np.where(np.isnan(values), 0, regimes.get("below", 1))
    above = np.where(np.isnan(values), 0, regimes.get("above", 2))
    columns = {"border": values, "regime_below": below, "regime_above": above}
    ds = xr.Dataset({name: ((across.dim, "crossing"), column) for name, column in columns.items()})
    ds["border"].attrs["units"] = QUANTITIES[along].units
    ds = ds.assign_coords({across.dim: axis_variable(across)})
    return ds.assign_attrs(result="border", border_parameter=along)


def test_borders_along_either_axis_are_drawn_over_a_map():
    ds = plane()
    x, y = str(ds["regime"].dims[1]), str(ds["regime"].dims[0])
    for along, across in ((x, y), (y, x)):
        places = ds[across].values
        middle = float(ds[along].values.mean())
        figure = plot_map(ds, lines=borders_along(along, axis(across, places), [[middle]] * len(places)))
        (line,) = border_lines_of(figure)
        np.testing.assert_array_equal(line[:, 0 if across == x else 1], places)
        assert (line[:, 1 if across == x else 0] == middle).all() and "border, exact" in legend_of(figure)


def test_borders_of_other_cells_are_refused():
    ds = plane()
    x, y = str(ds["regime"].dims[1]), str(ds["regime"].dims[0])
    lines = borders_along(x, axis(y, ds[y].values), [[1.0]] * ds.sizes[y]).assign_coords(mass=1234.5)
    if "mass" not in ds.coords:
        ds = ds.assign_coords(mass=1.0)
    with pytest.raises(PlotError, match=r"those of other cells: mass is 1234\.5 there"):
        plot_map(ds, lines=lines)


def test_a_crossing_goes_on_where_regimes_agree_and_leaves_a_gap_where_they_do_not():
    nan = np.nan
    border = np.array([[0.1, 0.5], [0.2, 0.6], [0.6, nan], [0.2, 0.7]])
    below = np.array([[1, 2], [1, 2], [2, 0], [1, 2]])
    above = np.array([[2, 3], [2, 3], [3, 0], [2, 3]])
    found = joined_crossings(np.arange(4.0), border, below, above)
    told = sorted((kind, values.tolist(), places.tolist()) for places, values, kind in found)
    assert told == [
        ((1, 2), [0.1, 0.2], [0.0, 1.0]), ((1, 2), [0.2], [3.0]), ((2, 3), [0.5, 0.6, 0.6, 0.7], [0.0, 1.0, 2.0, 3.0])
    ]  # fmt: skip


def test_of_several_crossings_of_a_kind_the_nearest_go_on():
    nan = np.nan
    border = np.array([[0.1, 0.2, 0.9], [0.8, nan, nan], [0.1, 0.75, 0.85]])
    below, above = np.array([[1, 2, 1], [1, 0, 0], [1, 2, 1]]), np.array([[2, 1, 2], [2, 0, 0], [2, 1, 2]])
    found = joined_crossings(np.arange(3.0), border, below, above)
    assert sorted(values.tolist() for _, values, _ in found) == [[0.1], [0.1], [0.2], [0.75], [0.9, 0.8, 0.85]]
