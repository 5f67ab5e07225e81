"""Heat maps of test matrices."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb

from stickslip.errors import PlotError
from stickslip.plots.layout import save
from stickslip.plots.palette import UNDEFINED_COLOUR
from stickslip.vocabulary.display_units import Unit, quantity
from stickslip_rig.api import RPN_NAME
from stickslip_rig.labels import dimension, point_name, unit_for
from stickslip_rig.plots import LIGHTS, number_text, plot_matrix
from stickslip_rig.risk import BANDS, band_of

COORDINATES = {
    "material": ("material", ["dry", "felt", "fluid $A$"], {"long_name": "material"}),
    "waiting_time": ("waiting_time", [10.0, 300.0], {"units": "s", "long_name": "hold time before the first stroke"}),
    "belt_speed": ("belt_speed", [0.001, 0.005, 0.01], {"units": "m s-1", "long_name": "belt speed"}),
    "normal_load": ("normal_load", [10.0, 80.0], {"units": "N", "long_name": "normal load"}),
}


def matrix(*dims, lengths=None):
    """A matrix over some of `COORDINATES` whose numbers are 0 to 10 in turn."""
    coords = {dim: COORDINATES[dim] for dim in dims if not lengths}
    shape = lengths or tuple(len(COORDINATES[dim][1]) for dim in dims)
    rpn = (np.arange(np.prod(shape, dtype=int)) % 11).reshape(shape).astype(np.int8)
    band = np.vectorize(lambda n: ("unknown", *BANDS).index(band_of(int(n))), otypes=[np.int8])(rpn)
    largest = np.where(rpn == 0, np.nan, 3.5 * rpn)
    variables = {
        "model_rpn": (dims, rpn),
        "model_rpn_band": (dims, band),
        "acceleration_max": (dims, largest, {"units": "m s-2", "long_name": "largest acceleration"}),
        "status": (dims, np.full(shape, 5, np.int8), {"long_name": "how the integration ended"}),
        "peak_frequency": ((*dims, "peak"), np.ones((*shape, 3)), {"units": "s-1"}),
    }
    return xr.Dataset(variables, coords, {"title": "A $title$"})


def mesh_of(figure):
    return figure.axes[0].collections[0]


def axes_of(figure):
    """The names of the dimensions along rows and columns, and the points beside each cell, the innermost last."""
    ax = figure.axes[0]
    along = (ax.get_ylabel(), ax.get_xlabel())
    return along, [
        [tick.get_text().split() for tick in ticks] for ticks in (ax.get_yticklabels(), ax.get_xticklabels())
    ]


def numbers_of(figure, shape):
    """What is written in the cells, by their place."""
    found = np.full(shape, "", dtype="U8")
    for text in figure.axes[0].texts:
        x, y = text.get_position()
        if 0 < x < shape[1] and 0 < y < shape[0]:
            found[int(y), int(x)] = text.get_text()
    return found


@pytest.mark.parametrize(
    "dims, shape",
    [
        ((), (1, 1)),
        (("belt_speed",), (1, 3)),
        (("material",), (3, 1)),
        (("material", "belt_speed"), (3, 3)),
        (("material", "waiting_time", "belt_speed"), (6, 3)),
        (("material", "waiting_time", "belt_speed", "normal_load"), (6, 6)),
    ],
)
def test_a_matrix_of_any_number_of_dimensions_has_a_cell_for_each_test_in_the_order_of_the_dataset(dims, shape):
    ds = matrix(*dims)
    figure = plot_matrix(ds)
    rpn = ds["model_rpn"].values.reshape(shape)
    painted = mesh_of(figure).to_rgba(mesh_of(figure).get_array())
    expected = np.array([[to_rgb(LIGHTS[band_of(int(n))]) for n in row] for row in rpn])
    assert painted.shape[:2] == shape and np.allclose(painted[..., :3], expected)
    assert (numbers_of(figure, shape) == np.where(rpn == 0, "?", rpn.astype(str))).all()


def test_the_plot_says_whose_number_it_is_and_what_the_bands_mean():
    figure = plot_matrix(matrix("material", "belt_speed"))
    assert figure.axes[0].get_legend().get_title().get_text() == RPN_NAME
    assert figure.axes[0].get_title() == "A $title$" and not figure.texts
    bands = [text.get_text() for text in figure.axes[0].get_legend().texts]
    assert [words.split(":")[0] for words in bands] == ["1–3", "4–5", "6–10", "?"]
    colours = [patch.get_facecolor()[:3] for patch in figure.axes[0].get_legend().get_patches()]
    assert colours == [to_rgb(LIGHTS[name]) for name in ("green", "yellow", "red", "unknown")]


def test_red_is_hatched_where_it_is_since_it_is_as_dark_as_green():
    figure = plot_matrix(matrix("material", "belt_speed"))
    (hatched,) = [patch for patch in figure.axes[0].patches if patch.get_hatch()]
    inside = [hatched.get_path().contains_point((j + 0.4, i + 0.6)) for i in range(3) for j in range(3)]
    assert inside == [band_of(n) == "red" for n in range(9)]
    entries = figure.axes[0].get_legend().get_patches()
    assert [bool(entry.get_hatch()) for entry in entries] == [False, False, True, False]


def test_labels_and_names_stand_in_the_units_people_use():
    names, (rows, columns) = axes_of(plot_matrix(matrix("material", "waiting_time", "belt_speed", "normal_load")))
    assert names == ("material, waiting time (s)", "belt speed (mm/s), normal load (N)")
    felt, fluid = ["felt", "300"], ["fluid", "$A$", "300"]  # as it is, no mathematics
    assert rows == [["10"], ["dry", "300"], ["10"], felt, ["10"], fluid]  # an outer point once, beside its rows
    assert columns == [["10"], ["1", "80"], ["10"], ["5", "80"], ["10"], ["10", "80"]]


def test_a_number_gets_a_colour_bar_with_its_unit_and_cells_without_one_are_grey():
    ds = matrix("material", "belt_speed")
    figure = plot_matrix(ds, "acceleration_max")
    assert figure.axes[0].child_axes[0].get_xlabel() == "largest acceleration (m/s²)"
    assert numbers_of(figure, (3, 3)).ravel().tolist()[:3] == ["–", "3.5", "7"]
    painted = mesh_of(figure).to_rgba(mesh_of(figure).get_array())
    assert painted[0, 0, :3] == pytest.approx(to_rgb(UNDEFINED_COLOUR))


def test_numbers_are_black_on_light_cells_and_white_on_dark_ones():
    figure = plot_matrix(matrix("belt_speed", "normal_load"), "acceleration_max")
    inks = {text.get_text(): text.get_color() for text in figure.axes[0].texts}
    assert inks["3.5"] == "white" and inks["17.5"] == "black"


def test_how_the_integration_ended_is_drawn_as_in_maps():
    figure = plot_matrix(matrix("material"), "status")
    assert [text.get_text() for text in figure.axes[0].get_legend().texts] == ["horizon reached"]


@pytest.mark.slow
def test_numbers_fit_forty_cells_each_way_and_are_left_out_of_more_which_is_said():
    shown, crowded = (plot_matrix(matrix("a", "b", lengths=(n, n))) for n in (40, 300))
    assert (numbers_of(shown, (40, 40)) != "").all()
    figure_width = shown.get_size_inches()[0] * 72
    sizes = {text.get_fontsize() for text in shown.axes[0].texts}
    assert min(sizes) >= 6 and figure_width < 1000
    assert (numbers_of(crowded, (300, 300)) == "").all()
    assert "too small for numbers" in crowded.axes[0].get_legend().get_title().get_text()


def test_nothing_overlaps_and_nothing_is_cut_off():
    ds = matrix("material", "waiting_time", "belt_speed", "normal_load")
    ds = ds.assign_coords(material=["a rather long name of a pair", "b", "_c"], belt_speed=[0.001234, 0.02345, 0.3456])
    figure = plot_matrix(ds)
    figure.draw_without_rendering()
    page = figure.bbox
    ax = figure.axes[0]
    texts = (*ax.texts, *ax.get_yticklabels(), *ax.get_xticklabels(), ax.xaxis.label, ax.yaxis.label, ax.title)
    boxes = [text.get_window_extent() for text in texts]
    boxes.append(ax.get_legend().get_window_extent())
    assert all(page.x0 <= b.x0 and b.x1 <= page.x1 and page.y0 <= b.y0 and b.y1 <= page.y1 for b in boxes)
    crossing = [
        (a, b) for i, a in enumerate(boxes) for b in boxes[:i] if a.shrunk(0.9, 0.9).overlaps(b.shrunk(0.9, 0.9))
    ]
    assert not crossing


def test_a_matrix_can_be_saved_as_a_vector_plot(tmp_path):
    save(plot_matrix(matrix("material", "belt_speed")), tmp_path / "matrix.svg")
    assert (tmp_path / "matrix.svg").read_text().startswith("<?xml")


@pytest.mark.parametrize(
    "variable, expected",
    [("loudness", "no variable 'loudness' of a test matrix; there are acc"), ("peak_frequency", "several values")],
)
def test_what_cannot_be_drawn_is_refused(variable, expected):
    with pytest.raises(PlotError, match=expected):
        plot_matrix(matrix("material"), variable)


# --- words ------------------------------------------------------------------------------------------------------------


def test_units_are_those_people_use():
    assert unit_for("m s-1", [0.001, 0.01]) == Unit("mm/s", 1e-3)
    assert unit_for("m s-1", [20.0, np.nan]) == Unit("m/s")
    assert unit_for("m s-2", [0.1]).printed == "m/s²" and unit_for("1", [0.1]) == Unit()
    assert quantity(5000.0, "N m-1") == "5 N/mm" and quantity(0.0, "m") == "0 m"


def test_numbers_have_three_digits():
    found = [number_text(v) for v in (0.0, 0.01234, 49.97, 12345.6, np.nan, 1e-7)]
    assert found == ["0", "0.0123", "50", "12346", "–", "1e-7"]


def test_tests_are_named_by_their_points():
    ds = matrix("material", "belt_speed").assign_coords(load=("case", [1.0, 2.0]), mass=("case", [1.0, 2.0]))
    dims = [dimension(ds, dim) for dim in ("material", "belt_speed", "case")]
    assert point_name(dims, 17) == "fluid $A$, 10\N{NO-BREAK SPACE}mm/s, case 2"
    assert point_name([], 0) == ""
