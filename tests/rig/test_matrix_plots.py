"""Heat maps of test matrices."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.contour import QuadContourSet

from stickslip.errors import PlotError
from stickslip.plots.layout import save
from stickslip_rig.api import RPN_NAME
from stickslip_rig.plots import LIGHTS, plot_matrix
from stickslip_rig.risk import BANDS, band_of
from stickslip_rig.tables import test_names as names_of_tests

COORDINATES = {
    "material": ("material", ["dry", "felt", "fluid $A$"], {"long_name": "material"}),
    "waiting_time": ("waiting_time", [10.0, 300.0], {"units": "s", "long_name": "hold time before the first stroke"}),
    "belt_speed": ("belt_speed", [0.001, 0.005, 0.01],
                   {"units": "m s-1", "long_name": "belt speed", "display_units": "mm/s"}),
    "normal_load": ("normal_load", [10.0, 80.0], {"units": "N", "long_name": "normal load"}),
}  # fmt: skip


def matrix(*dims, lengths=None):
    """A matrix over some of `COORDINATES` whose numbers are 0 to 10 in turn."""
    coords = {dim: COORDINATES[dim] for dim in dims if not lengths}
    shape = lengths or tuple(len(COORDINATES[dim][1]) for dim in dims)
    rpn = (np.arange(np.prod(shape, dtype=int)) % 11).reshape(shape).astype(np.int8)
    band = np.vectorize(lambda n: ("unknown", *BANDS).index(band_of(int(n))), otypes=[np.int8])(rpn)
    variables = {"model_rpn": (dims, rpn), "model_rpn_band": (dims, band)}
    return xr.Dataset(variables, coords, {"title": "A $title$"})


def numbers_of(figure, shape):
    """What is written in the cells, by their place."""
    found = np.full(shape, "", dtype="U8")
    for text in figure.axes[0].texts:
        x, y = text.get_position()
        found[int(y), int(x)] = text.get_text()
    return found


@pytest.mark.parametrize(
    "dims, shape",
    [
        ((), (1, 1)),
        (("belt_speed",), (3, 1)),
        (("material", "belt_speed"), (3, 3)),
        (("material", "waiting_time", "belt_speed"), (6, 3)),
        (("material", "waiting_time", "belt_speed", "normal_load"), (6, 6)),
    ],
)
def test_a_matrix_of_any_number_of_dimensions_has_a_cell_for_each_test_in_the_order_of_the_dataset(dims, shape):
    ds = matrix(*dims)
    figure = plot_matrix(ds)
    rpn, mesh = ds["model_rpn"].values.reshape(shape), figure.axes[0].collections[0]
    painted = mesh.to_rgba(mesh.get_array())
    expected = np.array([[to_rgb(LIGHTS[band_of(int(n))]) for n in row] for row in rpn])
    assert painted.shape[:2] == shape and np.allclose(painted[..., :3], expected)
    assert (numbers_of(figure, shape) == np.where(rpn == 0, "?", rpn.astype(str))).all()


def test_the_plot_says_whose_number_it_is_and_what_the_bands_mean():
    figure = plot_matrix(matrix("material", "belt_speed"))
    (legend,) = figure.legends
    assert RPN_NAME in legend.get_title().get_text() and figure.get_suptitle() == "A $title$"
    assert [text.get_text().split(":")[0] for text in legend.texts] == ["?", "1–3", "4–5", "6–10"]
    colours = [patch.get_facecolor()[:3] for patch in legend.get_patches()]
    assert colours == [to_rgb(LIGHTS[name]) for name in ("unknown", "green", "yellow", "red")]


def test_red_is_hatched_where_it_is_since_it_is_as_dark_as_green():
    figure = plot_matrix(matrix("material", "belt_speed"))
    (area,) = (one for one in figure.axes[0].collections if isinstance(one, QuadContourSet))
    (path,) = area.get_paths()
    inside = [path.contains_point((j + 0.4, i + 0.6)) for i in range(3) for j in range(3)]
    assert inside == [band_of(n) == "red" for n in range(9)]
    assert [bool(entry.get_hatch()) for entry in figure.legends[0].get_patches()] == [False, False, False, True]


def test_cells_have_the_names_of_their_points_in_the_units_of_the_configuration():
    ax = plot_matrix(matrix("material", "waiting_time", "belt_speed", "normal_load")).axes[0]
    assert (ax.get_ylabel(), ax.get_xlabel()) == (
        "material, hold time before the first stroke",
        "belt speed, normal load",
    )
    assert [tick.get_text() for tick in ax.get_yticklabels()][-2:] == ["fluid $A$, 10 s", "fluid $A$, 300 s"]
    assert [tick.get_text() for tick in ax.get_xticklabels()][:2] == ["1 mm/s, 10 N", "1 mm/s, 80 N"]
    ds = matrix("material", "belt_speed").assign_coords(load=("case", [1.0, 2.0]), mass=("case", [1.0, 2.0]))
    assert names_of_tests(ds, ["material", "belt_speed", "case"])[17] == "fluid $A$, 10 mm/s, load = 2, mass = 2"
    assert names_of_tests(ds, []) == ["A $title$"]


def test_numbers_are_left_out_of_cells_that_are_too_small_which_is_said():
    crowded = plot_matrix(matrix("a", "b", lengths=(60, 60)))
    assert not crowded.axes[0].texts and "too small for numbers" in crowded.legends[0].get_title().get_text()


def test_a_matrix_can_be_saved_and_none_is_refused(tmp_path):
    save(plot_matrix(matrix("material", "belt_speed")), tmp_path / "matrix.svg")
    assert (tmp_path / "matrix.svg").read_text().startswith("<?xml")
    for ds in (matrix("material").drop_vars("model_rpn"), matrix("material").isel(material=slice(0))):
        with pytest.raises(PlotError, match="nothing to draw"):
            plot_matrix(ds)
