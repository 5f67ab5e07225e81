"""Configurations from Python are those of the YAML that says the same."""

import math
import warnings

import numpy as np
import pytest
import xarray as xr
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import stickslip
from helpers.fuzzing import GOOD, SCALARS, TREES
from stickslip.config.reader import load_config, parse_config
from stickslip.config.studies import is_config
from stickslip.config.yaml import parse_yaml
from stickslip.errors import ConfigError, FitWarning, UnitWarning
from stickslip.vocabulary.quantities import PARAMETERS, QUANTITIES

PAD = {
    "system": {"mass": "100 g", "normal_load": 10, "stiffness": "5 N/mm"},
    "friction": {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": "100 mm/s"},
}


def read(given):
    """A configuration, or the problems of it but for their places."""
    load = parse_config if isinstance(given, str) else load_config
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FitWarning)
        warnings.simplefilter("ignore", UnitWarning)
        try:
            return load(given)
        except ConfigError as error:
            return sorted((".".join(map(str, p.path)), _without_lines(p.message), str(p.hint)) for p in error.problems)


def _without_lines(message):
    words = {"null": "nothing", "true": "True", "false": "False", ".inf": "inf", "-.inf": "-inf", ".nan": "nan"}
    got, comma, rest = message.partition(", expected")
    found = got.removeprefix("got ")
    plain = f"got {words.get(found, found)}" if found != got else got
    for number in range(1, 60):
        plain, rest = plain.replace(f" on line {number}", ""), rest.replace(f" on line {number}", "")
    return plain + comma + rest


def spelled_as_python(value):
    """A value as YAML text that `parse_yaml` reads as it is, its numbers written as Python writes them."""
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{key}": {spelled_as_python(one)}' for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(spelled_as_python, value)) + "]"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if value != value else f"{'-' if value < 0 else ''}.inf"
    return (
        {None: "null", True: "true", False: "false"}[value]
        if value in (None, True, False) and isinstance(value, bool | None)
        else repr(value)
    )


WORDS = st.text("abcdefgh_ 0123456789.,/", max_size=8)
PLAIN = st.one_of(st.integers(-(10**6), 10**6), st.floats(), WORDS, st.none(), st.booleans(),
                  st.sampled_from(["5 N/mm", "1,5 kg", "10 mm/s", "none", "sticking", "auto"]))  # fmt: skip
VALUES = st.recursive(
    PLAIN, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS, inner, max_size=3), max_leaves=5
)


@st.composite
def changed(draw):
    """The plain data of a good configuration, with up to three values replaced, dropped or added."""
    data = parse_yaml(draw(st.sampled_from(GOOD))).data
    for _ in range(draw(st.integers(0, 3))):
        place = data
        while isinstance(place, dict) and place:
            key = draw(st.sampled_from(sorted(place)))
            if not isinstance(place[key], dict) or draw(st.booleans()):
                what = draw(st.sampled_from(["replace", "drop", "add"]))
                if what == "drop":
                    del place[key]
                else:
                    place[key if what == "replace" else draw(st.sampled_from([*QUANTITIES, "labels", "zip"]))] = draw(
                        VALUES
                    )
                break
            place = place[key]
    return data


@settings(max_examples=30, deadline=None, database=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(data=changed())
def test_a_dict_is_read_as_the_yaml_that_says_the_same(data):
    assert read(data) == read(spelled_as_python(data))


@pytest.mark.parametrize("text", GOOD)
def test_a_good_configuration_is_equal_from_python_and_its_yaml_gives_it_again(text):
    config = read(parse_yaml(text).data)
    assert config == read(text)
    assert read(config.resolved()) == config == parse_config(config.to_yaml())


def test_what_is_wrong_is_told_at_once_with_the_path_of_the_key():
    axes = {"belt_speed": [0.1, 0.2, "3 mm/s", "4 kg"], "mass": range(3), "labels": 1}
    with pytest.raises(ConfigError) as caught:
        stickslip.sweep(**PAD, axes=axes, solver={"rtoll": 1e-6}, output=None)
    lines = str(caught.value).splitlines()
    assert "axes.belt_speed[3]: got '4 kg' (mass), expected a speed such as '10 mm/s' or a number in m/s" in lines
    assert any(line.startswith("axes.mass[0]: got 0, expected a mass above 0 kg") for line in lines)
    assert any(line.startswith("axes.mass: given twice, as system.mass already") for line in lines)
    assert any(line.startswith("solver.rtoll: unknown key") for line in lines)
    assert len(caught.value.problems) == 5 and all(problem.place is None for problem in caught.value.problems)


def axes_of(axes):
    return load_config(PAD | {"axes": axes}).axes


@pytest.mark.parametrize(
    "values",
    [np.array([0.1, 0.2, 0.5]), np.float32([0.1, 0.2, 0.5]), (0.1, 0.2, 0.5), [np.float64(0.1), 0.2, 0.5],
     xr.DataArray([0.1, 0.2, 0.5], dims="x"), xr.DataArray([100.0, 200.0, 500.0], dims="x", attrs={"units": "mm/s"}),
     ["100 mm/s", "20 cm/s", "0.5 m/s"]],
    ids=["array", "float32", "tuple", "numbers of numpy", "DataArray", "its units", "texts"],
)  # fmt: skip
def test_values_of_an_axis_come_in_every_form(values):
    (axis,) = axes_of({"belt_speed": values})
    assert axis.values == pytest.approx((0.1, 0.2, 0.5), rel=1e-6)


@pytest.mark.parametrize(("spread", "spacing"), [(np.linspace, "linear"), (np.geomspace, "log")])
def test_arrays_that_numpy_spaced_are_ranges_with_their_scale(spread, spacing):
    values = spread(1.0, 12.0, 37)
    (axis,) = axes_of({"belt_speed": values})
    assert axis.spacing == spacing
    np.testing.assert_array_equal(axis.points(), values)


def test_an_array_with_an_impossible_value_is_told_by_its_place():
    with pytest.raises(ConfigError, match=r"^axes\.stiffness\[0\]: got -1\.0, expected a stiffness above 0 N/m"):
        load_config(
            {
                **PAD,
                "system": {"mass": 1, "normal_load": 1, "belt_speed": 1},
                "axes": {"stiffness": np.linspace(-1, 1, 4)},
            }
        )


def test_nan_in_an_array_is_the_word_of_its_quantity():
    mu_stop, velocity = axes_of({"mu_stop": np.array([np.nan, 1.2]), "velocity": xr.DataArray([np.nan, 0.1], dims="x"),
                                 "belt_speed": [0.1, 0.2]})[:2]  # fmt: skip
    assert math.isnan(mu_stop.values[0]) and math.isnan(velocity.values[0])
    with pytest.raises(ConfigError, match=r"axes\.belt_speed\[1\]: got nan, expected"):
        axes_of({"belt_speed": np.array([0.1, np.nan])})


def test_a_dataset_with_names_is_a_labelled_axis():
    greases = xr.Dataset(
        {"damping": ("grease", [0.1, 0.2]), "a1": ("grease", [1.0, 1.1])}, {"grease": ["A", "B"]}, {"title": "t"}
    )
    curve = {name: value for name, value in PAD["friction"].items() if name != "a1"}
    config = load_config(PAD | {"friction": curve, "axes": {"grease": greases, "belt_speed": [0.1, 0.2]}})
    group = config.axes[0]
    assert (group.name, group.labels, [m.name for m in group.members]) == ("grease", ("A", "B"), ["damping", "a1"])
    zipped = {"zip": {"damping": greases["damping"], "a1": greases["a1"].values}, "labels": ["A", "B"]}
    assert load_config(PAD | {"friction": curve, "axes": {"grease": zipped, "belt_speed": [0.1, 0.2]}}) == config


def test_a_table_of_pandas_is_a_labelled_axis():
    greases = xr.Dataset({"damping": ("grease", [0.1, 0.2]), "maker": ("grease", ["x", "y"])}, {"grease": ["A", "B"]})
    table = greases.to_dataframe()
    (named, _) = axes_of({"grease": table, "belt_speed": [0.1, 0.2]})
    assert (named.labels, [(m.name, m.values) for m in named.members]) == (("A", "B"), [("damping", (0.1, 0.2))])
    (numbered, _) = axes_of({"grease": table.reset_index(drop=True)[["damping"]], "belt_speed": [0.1, 0.2]})
    assert numbered.labels is None and numbered.members == named.members


@pytest.mark.parametrize(
    "given", [{3: 1}, {"axes": [3]}, {"axes": xr.Dataset({"mass": (("x", "y"), np.ones((2, 2)))})}]
)
def test_what_no_yaml_could_say_is_refused(given):
    with pytest.raises(ConfigError):
        load_config(PAD | given)


@settings(max_examples=60, deadline=None, database=None, suppress_health_check=list(HealthCheck), derandomize=True)
@given(
    key=st.sampled_from(["system", "friction", "axes", "solver", "border", "uncertain", "output"]),
    value=TREES,
    one=SCALARS,
)
def test_any_python_value_is_a_configuration_or_a_config_error(key, value, one):
    read(PAD | {"axes": {"belt_speed": [0.1, one]}, key: value})


def test_forgotten_units_are_asked_about_in_python_too():
    with pytest.warns(UnitWarning, match=r"friction\.a4: got 100 m/s; did you mean 100 mm/s") as asked:
        load_config(PAD | {"friction": PAD["friction"] | {"a4": 100}, "axes": {"belt_speed": [0.1, 0.2]}})
        stickslip.sweep(**PAD | {"friction": PAD["friction"] | {"a4": 100}}, axes={"belt_speed": [0.1, 0.2]})
    assert {warning.filename for warning in asked} == {__file__}  # the line of the caller, however deep it is found


# --- the calls --------------------------------------------------------------------------------------------------------


AXES = {"stiffness": ["1 N/mm", "5 N/mm"], "belt_speed": np.linspace(0.01, 1.2, 8)}
SYSTEM = {"mass": "100 g", "normal_load": "10 N"}
MAP = {"system": SYSTEM, "friction": PAD["friction"], "axes": AXES}


def test_sweep_run_and_a_file_give_the_same_map(tmp_path):
    ds = stickslip.sweep(system=SYSTEM, friction=PAD["friction"], axes=AXES, title="pad")
    xr.testing.assert_identical(ds.drop_attrs(), stickslip.run(MAP).drop_attrs())
    (tmp_path / "pad.yaml").write_text(stickslip.load_config(MAP | {"title": "pad"}).to_yaml())
    same = stickslip.run(tmp_path / "pad.yaml")
    xr.testing.assert_equal(ds, same)
    assert ds.attrs["configuration"] == same.attrs["configuration"]
    written = stickslip.sweep(
        system=SYSTEM, friction=PAD["friction"], axes=AXES, title="pad", output=tmp_path / "pad.nc"
    )
    xr.testing.assert_equal(written.compute(), ds)
    written.close()


def test_the_output_of_a_sweep_may_be_its_section(tmp_path):
    asked = {"system": SYSTEM, "friction": PAD["friction"], "axes": AXES}
    few = stickslip.sweep(**asked, output={"variables": ["period"]})
    assert set(few.data_vars) == {"regime", "period"}
    with stickslip.sweep(**asked, output={"file": tmp_path / "few.nc", "variables": ["period"]}) as written:
        assert (tmp_path / "few.nc").exists()
        xr.testing.assert_equal(written.compute(), few)
    with pytest.raises(ConfigError, match=r"output\.file: got 'map\.txt', expected a file name that ends in"):
        stickslip.sweep(**asked, output={"file": "map.txt"})


def test_every_call_that_takes_a_configuration_takes_a_dict(tmp_path):
    text = load_config(MAP)
    one = MAP | {"axes": {"belt_speed": AXES["belt_speed"]}, "system": SYSTEM | {"stiffness": "5 N/mm"}}
    xr.testing.assert_equal(stickslip.border(MAP, "belt_speed"), stickslip.border(text, "belt_speed"))
    xr.testing.assert_equal(stickslip.contours(MAP, points=16), stickslip.contours(text, points=16))
    margins = stickslip.margins(one, ["belt_speed"], joint=False)
    assert margins["margin_belt_speed"].dims == ("belt_speed",)
    box = {"displacement": ("0 mm", "10 mm"), "velocity": (-0.5, "500 mm/s")}
    assert stickslip.attractors(one, box, samples=64)["settling_share"].dims == ("belt_speed",)
    ramp = stickslip.ramp(one, "belt_speed", ("10 mm/s", "1.2 m/s"), points=4)
    assert ramp["regime"].sizes == {"direction": 2, "belt_speed": 4} and ramp["belt_speed"][0] == 0.01
    along = stickslip.run(one | {"border": {"along": "belt_speed"}})
    np.testing.assert_allclose(along["border"], stickslip.border(one, "belt_speed")["border"])
    done = stickslip.run_shard(MAP, "1/1", tmp_path / "store")
    assert done.computed == 16 and stickslip.status(MAP, store=tmp_path / "store").cells_finished == 16
    assert stickslip.collect(MAP, tmp_path / "map.nc", store=tmp_path / "store")["regime"].shape == (2, 8)


def test_a_mapping_of_parameters_is_cells_and_one_of_sections_a_configuration():
    assert is_config(MAP) and not is_config({name: 1.0 for name in PARAMETERS})
    assert is_config({"axes": {}}) and not is_config({})
