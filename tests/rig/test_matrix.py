"""The heat map and the page of a test matrix."""

import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.contour import QuadContourSet

from stickslip.config.reader import parse_config
from stickslip.errors import PlotError
from stickslip.plots.layout import save
from stickslip.vocabulary.quantities import STATUSES
from stickslip_rig.api import RPN_NAME, RigTests, load_rig, make_rig, run_matrix
from stickslip_rig.evaluation import test_names as names_of_tests
from stickslip_rig.plots import LIGHTS, plot_matrix
from stickslip_rig.risk import BANDS, band_of

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


def test_a_matrix_can_be_saved_and_none_is_refused(tmp_path):
    save(plot_matrix(matrix("material", "belt_speed")), tmp_path / "matrix.svg")
    assert (tmp_path / "matrix.svg").read_text().startswith("<?xml")
    for ds in (matrix("material").drop_vars("model_rpn"), matrix("material").isel(material=slice(0))):
        with pytest.raises(PlotError, match="nothing to draw"):
            plot_matrix(ds)


HOSTILE = '<script>alert("1")</script> & $x$'
RIG = {
    "title": f"Report {HOSTILE}",
    "system": {"mass": 0.1, "stiffness": 5000.0, "damping": 2.0, "normal_load": 10.0},
    "drive": {"stroke": 0.002, "strokes": 2, "ramp": 0.02, "waiting_time": 1.0},
    "sensor": {"rate": 500.0, "oversampling": 4},
    "axes": {
        "material": {"labels": [HOSTILE, "_felt"],
                     "zip": {"a1": [0.3, 0.2], "a3": [0.2, 0.02], "a4": [0.02, 0.02], "a2": [0.0, 0.1]}},
        "belt_speed": {"values": [0.005, 0.01]},
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def computed():
    rig = make_rig(RIG)
    return rig, run_matrix(rig)


def rows_of(page):
    """The texts in the cells of the tables; tests/sweep/test_pages.py reads the frame."""
    lines = re.findall(r"<tr>(.*?)</tr>", page, re.DOTALL)
    cells = (re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", line, re.DOTALL) for line in lines)
    return [[unescape(re.sub(r"<[^>]*>", "", cell)) for cell in row] for row in cells]


def test_a_page_has_every_test_and_says_what_was_not_integrated_and_where_it_comes_from(computed):
    rig, ds = computed
    page = RigTests.page(ds, None)
    head, *rows = rows_of(page)
    assert head[:3] == ["record", "RPN", "sticks"] and page.count("<img") == 1
    assert [row[:2] for row in rows] == [
        [f"{material}, {speed} m/s", str(int(ds["model_rpn"].values.flat[n]))]
        for n, (material, speed) in enumerate((m, s) for m in (HOSTILE, "_felt") for s in ("0.005", "0.01"))
    ]
    assert [row[2] for row in rows] == [f"{n:.0f}" for n in ds["sticks"].values.ravel()]
    assert "<script" not in page and RPN_NAME in unescape(page) and "not integrated" not in page
    assert all(ds.attrs[key] in unescape(page) for key in ("source", "software", "date_created"))
    assert parse_config(unescape(re.search(r"(?s)<pre[^>]*>(.*?)</pre>", page)[1])) == rig
    broken = ds.copy(deep=True)
    broken["status"][1, 0] = STATUSES.index("step_limit")
    broken["model_rpn"][1, 0] = broken["model_rpn_band"][1, 0] = 0
    broken["sticks"][1, 0] = np.nan
    page = RigTests.page(broken, None)
    assert "1 not integrated to the end (_felt, 0.005 m/s): the step budget ran out" in page
    assert rows_of(page)[3][1:3] == ["?", "–"]


def test_the_matrix_that_ships_has_the_conditions_of_table_1_of_the_article():
    grid = RigTests(load_rig(Path(__file__).resolve().parents[2] / "configs" / "rig" / "test_matrix.yaml")).grid
    points = {c.name: c.values.tolist() for c in grid.coords}
    assert points["belt_speed"] == [0.001, 0.005, 0.01] and points["normal_load"] == [10, 20, 80]
    assert points["waiting_time"] == [10, 60, 300]
    temperatures = {label.split()[-2] for c in grid.coords for label in c.labels or ()}
    assert temperatures == {"-30", "23", "80"} and grid.size == 324
