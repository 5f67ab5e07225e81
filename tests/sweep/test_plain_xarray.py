"""What xarray alone makes of our files, and what plots make of what xarray does to our datasets."""

import numpy as np
import pytest
import xarray as xr

import stickslip
from stickslip import plots
from stickslip.dataset import coarse
from stickslip.files.writing import write

FRICTION = {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
LABELS = ["A", "µ-oil, grade 2"]


def greases():
    group = xr.Dataset({"damping": ("grease", [0.01, 0.2])}, {"grease": LABELS})
    axes = {"grease": group, "mu_stop": ["none", 1.2], "belt_speed": np.linspace(0.01, 1.0, 5)}
    return stickslip.sweep(system={"mass": 1, "stiffness": 1, "normal_load": 1}, friction=FRICTION, axes=axes)


@pytest.mark.parametrize("name", ["map.nc", "map.zarr"])
def test_labels_select_in_plain_xarray(name, tmp_path):
    ds = greases()
    write(ds, tmp_path / name)
    with xr.open_dataset(tmp_path / name) as plain:  # with zarr, a warning about its metadata would be an error here
        one = plain.sel(grease=LABELS[1], mu_stop_case="1.2")
        np.testing.assert_array_equal(one["regime"], ds["regime"][1, 1])
        assert one["damping"] == 0.2
    with stickslip.open(tmp_path / name) as own:
        xr.testing.assert_identical(own.compute(), ds)
        assert own["grease"].dtype.kind == "U"


def test_zarr_opens_without_a_warning_and_is_the_same_with_and_without_consolidated_metadata(tmp_path):
    ds = greases()
    write(ds, tmp_path / "map.zarr")
    whole, loose = (xr.open_zarr(tmp_path / "map.zarr", consolidated=way) for way in (True, False))
    xr.testing.assert_identical(whole, loose)
    with xr.open_zarr(tmp_path / "map.zarr") as plain:
        assert list(plain) == list(ds) and set(plain.coords) == set(ds.coords)
    with stickslip.open(tmp_path / "map.zarr") as own:  # Zarr lists a folder at random
        assert list(own) == list(ds)


# --- plots of what `where` left -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def plane():
    axes = {"stiffness": np.geomspace(1, 100, 6), "belt_speed": np.linspace(0.01, 1.0, 10)}
    return stickslip.sweep(system={"mass": 1, "normal_load": 1}, friction=FRICTION, axes=axes)


@pytest.mark.parametrize(
    "condition", [lambda ds: ds.belt_speed > 0.5, lambda ds: ds.period > 0, lambda ds: ds.period < 0]
)
def test_what_where_left_out_is_left_blank(plane, condition):
    part = plane.where(condition(plane))
    assert part["regime"].dtype.kind == "f", "as xarray has it"
    codes = coarse.flags(part["regime"], (1, 1))
    np.testing.assert_array_equal(np.ma.getmaskarray(codes.values), part["regime"].isnull())
    shown = part["regime"].values[part["regime"].notnull()]
    np.testing.assert_array_equal(codes.values.compressed(), shown)
    assert set(codes.present) == set(shown)
    for ds in (part, part.isel(stiffness=0)):
        plots.plot_map(ds).canvas.draw()


def test_of_a_pixel_the_most_frequent_flag_that_is_left_is_shown():
    array = xr.DataArray([[1.0, 2.0, np.nan, np.nan], [np.nan, 2.0, np.nan, np.nan]], dims=("y", "x"))
    found = coarse.flags(array, (2, 2))
    np.testing.assert_array_equal(found.values.mask, [[False, True]])
    assert found.values[0, 0] == 2 and found.mixed[0, 0] and not found.mixed[0, 1] and found.present == (1, 2)
