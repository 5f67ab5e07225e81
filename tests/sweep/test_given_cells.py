"""Cells from Python: arrays with dimensions, texts with units, and what comes back."""

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr

import stickslip
from stickslip import plots
from stickslip.vocabulary.cells import as_cells

PAIR = {"mass": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
SPEEDS = xr.DataArray([10.0, 100.0, 700.0], {"v": ["slow", "fast", "faster"]}, "v", attrs={"units": "mm/s"})
SPRINGS = xr.DataArray([1.0, 10.0], dims="spring", name="k")


def test_arrays_of_different_dimensions_are_broadcast_by_name_and_their_coordinates_stay():
    ds = stickslip.evaluate(PAIR | {"stiffness": SPRINGS, "belt_speed": SPEEDS, "damping": SPRINGS / 100})
    assert dict(ds.sizes) == {"spring": 2, "v": 3} and ds["period"].dims == ("spring", "v")
    assert ds["belt_speed"].dims == ("v",) and ds["belt_speed"].attrs["units"] == "m s-1"
    np.testing.assert_array_equal(ds["belt_speed"], [0.01, 0.1, 0.7])
    assert ds["damping"].dims == ("spring",) and ds["mass"].dims == () and ds["mass"] == 1.0
    assert ds["velocity"].dims == () and np.isnan(ds["velocity"]), "defaults are told, too"
    for k, spring in enumerate((1.0, 10.0)):
        one = PAIR | {"stiffness": spring, "damping": spring / 100, "belt_speed": ds["belt_speed"].values}
        plain = stickslip.evaluate(one)
        for name in plain.data_vars:
            np.testing.assert_array_equal(ds[name][k], plain[name], err_msg=name)
    assert ds["regime"].sel(v="fast", spring=0).dtype == np.int8


def test_a_dimension_that_is_called_as_its_parameter_is_its_index_in_si():
    speeds = xr.DataArray([10.0, 700.0], dims="belt_speed", attrs={"units": "mm/s"})
    speeds = speeds.assign_coords(belt_speed=speeds)
    ds = stickslip.evaluate(PAIR | {"belt_speed": speeds, "stiffness": SPRINGS.rename(spring="stiffness")})
    np.testing.assert_array_equal(ds.indexes["belt_speed"], [0.01, 0.7])
    np.testing.assert_array_equal(ds["stiffness"], [1.0, 10.0])
    assert plots.plot_map(ds).axes, "a result over named dimensions is a map"


def test_the_cells_of_a_map_are_evaluated_on_its_dimensions():
    axes = {"stiffness": [1.0, 10.0], "belt_speed": np.linspace(0.01, 0.7, 3), "mu_stop": ["none", 1.2]}
    friction = {name: value for name, value in PAIR.items() if name.startswith("a")}
    ds = stickslip.sweep(system={"mass": 1, "normal_load": 1}, friction=friction, axes=axes)
    again = stickslip.evaluate(ds, rtol=1e-6)
    assert again["regime"].dims == ds["regime"].dims
    xr.testing.assert_equal(again["period"], ds["period"])
    assert set(ds.coords) <= set(again.coords)
    some = stickslip.evaluate(ds.sel(belt_speed=0.01, mu_stop_case="1.2"))
    np.testing.assert_array_equal(some["period"], ds["period"].sel(belt_speed=0.01, mu_stop_case="1.2"))


def test_texts_with_units_are_read_everywhere_cells_are():
    texts = PAIR | {"mass": "1000 g", "stiffness": ["1 N/m", "10 N/m"], "belt_speed": "100 mm/s", "mu_stop": "none"}
    plain = PAIR | {"stiffness": [1.0, 10.0], "belt_speed": 0.1}
    xr.testing.assert_equal(stickslip.evaluate(texts), stickslip.evaluate(plain))
    one = texts | {"stiffness": "10 N/m"}
    motion = stickslip.simulate(duration="500 ms", samples=11, **one)
    xr.testing.assert_equal(motion, stickslip.simulate(duration=0.5, samples=11, **plain | {"stiffness": 10.0}))
    found = stickslip.border(one, "belt_speed", ("10 mm/s", "5 m/s"))
    xr.testing.assert_equal(found, stickslip.border(plain | {"stiffness": 10.0}, "belt_speed", (0.01, 5.0)))
    margins = stickslip.margins(one, ["belt_speed"], joint=False)
    assert margins["border_belt_speed"].sel(side="above").item() == pytest.approx(found["border"].item(), rel=1e-8)


def test_units_of_arrays_are_converted_and_never_dropped():
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    plain = stickslip.evaluate(PAIR | {"stiffness": [1000.0, 5000.0], "belt_speed": 0.1})
    quantities = {
        "stiffness": [1.0, 5.0] * unit.newton / unit.millimeter,
        "belt_speed": 10 * unit.centimeter / unit.second,
    }
    xr.testing.assert_equal(stickslip.evaluate(PAIR | quantities), plain)
    with pytest.raises(ValueError, match=r"^belt_speed: got the units 'kg' \(mass\), expected a speed"):
        stickslip.evaluate(PAIR | quantities | {"belt_speed": 1 * unit.kilogram})
    speed = xr.DataArray(100.0, attrs={"units": "mm/s"})
    motion = stickslip.simulate(duration=1.0, samples=11, belt_speed=speed, **PAIR, stiffness=1000.0)
    assert motion["belt_speed"] == 0.1
    listed = as_cells(xr.Dataset({"belt_speed": SPEEDS}).assign(PAIR | {"stiffness": 1.0}))
    np.testing.assert_array_equal(listed["belt_speed"], [0.01, 0.1, 0.7])
    assert (
        stickslip.evaluate(PAIR | {"stiffness": 1.0, "belt_speed": SPEEDS})["belt_speed"].attrs["display_units"]
        == "mm/s"
    )


def test_designers_calls_keep_dimensions_too():
    cells = PAIR | {"stiffness": SPRINGS, "belt_speed": SPEEDS}
    found = stickslip.border(cells, "belt_speed", (0.01, 5.0))
    assert found["border"].dims == ("spring", "crossing"), "what is said of the parameter itself is left out"
    margins = stickslip.margins(cells, ["damping"], joint=False)
    assert margins["margin_damping"].dims == ("spring", "v") and "v" in margins.coords
    box = {"displacement": (0.0, 1.5), "velocity": (-0.5, 0.5)}
    assert stickslip.attractors(cells, box, samples=64)["settling_share"].dims == ("spring", "v")
    lines = stickslip.contours(PAIR | {"damping": SPRINGS / 100}, ("stiffness", "belt_speed"),
                               {"stiffness": ("1 N/m", "10 N/m"), "belt_speed": (0.1, 1.0)}, points=8)  # fmt: skip
    assert "spring" in lines.sizes or "spring" in lines.variables


OTHER = xr.DataArray([1.0, 2.0], {"v": ["slow", "other"]}, "v")
WRONG = {
    "an array without dimensions": (
        {"stiffness": [1.0, 2.0]},
        TypeError,
        "^stiffness: got an array without dimensions",
    ),
    "another index": ({"stiffness": OTHER}, ValueError, "^stiffness and belt_speed do not fit together: .*v"),
    "another unit": ({"belt_speed": SPEEDS.assign_attrs(units="kg")}, ValueError, r"got the units 'kg' \(mass\)"),
    "no unit": ({"belt_speed": SPEEDS.assign_attrs(units="mm/sek")}, ValueError, "no unit is called 'sek'"),
    "a bad value": ({"stiffness": -SPRINGS}, ValueError, r"^stiffness\[0, 0\]: got -1, expected a stiffness above 0"),
    "a result": ({"belt_speed": SPEEDS.rename(v="period")}, ValueError, "dimension called period"),
    "a parameter": ({"belt_speed": SPEEDS.rename(v="mass")}, ValueError, "dimension called mass"),
}


@pytest.mark.parametrize(("change", "kind", "message"), WRONG.values(), ids=WRONG)
def test_what_does_not_fit_is_refused_by_name(change, kind, message):
    with pytest.raises(kind, match=message):
        stickslip.evaluate(PAIR | {"stiffness": 1.0, "belt_speed": SPEEDS} | change)


def test_arrays_given_are_not_changed_and_not_kept():
    belt = np.linspace(0.1, 1.0, 5000)
    before = belt.copy()
    ds = stickslip.evaluate(PAIR | {"stiffness": 10.0, "belt_speed": belt}, max_steps=10)
    ds["belt_speed"][:] = 0.0
    ds["mass"][:1] = 7.0
    np.testing.assert_array_equal(belt, before)
    assert ds["mass"][1] == 1.0 and ds["normal_load"][0] == 1.0


# --- what other libraries hold ----------------------------------------------------------------------------------------

BASE = PAIR | {"stiffness": 1.0}
MASKED = np.ma.array([0.1, 0.2], mask=[False, True])
NULLABLE = pd.Series([0.1, None], dtype="Float64")
QUANTITY = pint.UnitRegistry().Quantity
SPEED_LISTS = {  # two belt speeds, 10 and 20 mm/s
    "nothing masked": np.ma.array([0.01, 0.02], mask=False),
    "Pint": QUANTITY(np.array([10.0, 20.0]), "mm/s"),
    "Pint in xarray": xr.DataArray(QUANTITY(np.array([10.0, 20.0]), "mm/s"), dims="cell"),
    "texts of pandas": pd.Series(["10 mm/s", "20 mm/s"]),
    "texts of a dtype": pd.Series(["10 mm/s", "20 mm/s"], dtype="string"),
    "an index": pd.Index(["10 mm/s", "0.02 m/s"]),
    "categories": pd.Series(["10 mm/s", "20 mm/s"], dtype="category"),
    "texts of xarray": xr.DataArray(["10 mm/s", "20 mm/s"], dims="cell"),
    "objects with units": xr.DataArray(np.array([10, 20], object), dims="cell", attrs={"units": "mm/s"}),
}
NO_NUMBERS = {
    "masked": MASKED,
    "masked whole numbers": np.ma.array([1, 2], mask=[True, False]),
    "one masked value": np.ma.masked,
    "a list of masked arrays": [MASKED, MASKED],
    "a list with a masked value": [0.1, np.ma.masked],
    "a masked quantity of Pint": QUANTITY(np.ma.array([1.0, 2.0], mask=[False, True]), "m/s"),
    "a masked table of xarray": xr.DataArray(NULLABLE.array, dims="x"),
    "NA": NULLABLE,
    "NA of whole numbers": pd.Series([1, None], dtype="Int64"),
    "NA of texts": pd.Series(["1 m/s", None], dtype="string"),
    "NA among objects": pd.Series([0.1, pd.NA], dtype=object),
    "None": [0.1, None],
    "quantities in a list": [QUANTITY(1.0, "m/s"), QUANTITY(2.0, "m/s")],
    "one quantity in a list": [QUANTITY(1.0, "m/s")],
    "lists of different lengths": [[1.0, 2.0], [3.0]],
    "dates": pd.to_datetime(["2020-01-01"]),
    "times": pd.to_timedelta([1], unit="s"),
    "logical values": np.array([True]),
    "complex": np.array([1 + 0j]),
}


@pytest.mark.parametrize("speeds", SPEED_LISTS.values(), ids=SPEED_LISTS)
def test_arrays_of_other_libraries_are_read_with_their_units(speeds):
    np.testing.assert_array_equal(stickslip.evaluate(BASE | {"belt_speed": speeds})["belt_speed"], [0.01, 0.02])


@pytest.mark.parametrize("name", ["belt_speed", "mu_stop"])
@pytest.mark.parametrize("values", NO_NUMBERS.values(), ids=NO_NUMBERS)
def test_what_is_masked_missing_or_no_number_is_refused_and_not_computed(name, values):
    """Also where NaN stands for absent: what is hidden is not known to be absent."""
    with pytest.raises((TypeError, ValueError), match=f"^{name}"):
        stickslip.evaluate(BASE | {"belt_speed": 0.1} | {name: values})


def test_units_of_pint_inside_xarray_are_those_of_an_axis():
    speeds = xr.DataArray(QUANTITY(np.array([10.0, 25.0]), "mm/s"), dims="belt_speed", name="belt_speed")
    system = {"mass": 1.0, "normal_load": 1.0, "stiffness": 1.0}
    friction = {name: PAIR[name] for name in ("a1", "a2", "a3", "a4")}
    ds = stickslip.sweep(system=system, friction=friction, axes={"belt_speed": speeds}, progress=False)
    np.testing.assert_array_equal(ds["belt_speed"], [0.01, 0.025])


def test_a_table_of_pandas_is_cells_along_its_index():
    table = pd.DataFrame({name: [value, value] for name, value in BASE.items()} | {"belt_speed": [0.1, 0.2]})
    assert stickslip.evaluate(table)["regime"].dims == ("index",)
    ds = stickslip.evaluate(table.set_index(pd.Index(["felt", "rubber"], name="pad")))
    assert float(ds["belt_speed"].sel(pad="rubber")) == 0.2
    with pytest.raises(TypeError, match="'dampng' is not a parameter"):
        stickslip.evaluate(table.assign(dampng=1.0))
