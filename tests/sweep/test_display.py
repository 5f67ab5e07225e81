"""Units in which results are shown: those of the configuration, while everything is SI."""

from itertools import combinations

import numpy as np
import pytest
import xarray as xr

import stickslip
from helpers.data import cases
from helpers.maps import plane
from helpers.plotted import notes_of
from stickslip.config.reader import make_config, parse_config
from stickslip.dataset.display import MapAxis, unit_of, with_units
from stickslip.errors import PlotError
from stickslip.plots.maps import plot_map
from stickslip.plots.palette import FLAG_COLOURS, HATCHES
from stickslip.vocabulary.quantities import QUANTITIES, VARIABLES

ENGINEER = """
system: {mass: 100 g, normal_load: 0.01 kN}
friction: {a1: 0.3, a2: 0.5 s/m, a3: 0.1, a4: 20 mm/s}
axes:
  stiffness: {start: 1 N/mm, stop: 10 N/mm, num: 4}
  belt_speed: [5 mm/s, 20 mm/s, 300 mm/s]
"""


@pytest.fixture(scope="module")
def result():
    return stickslip.run(parse_config(ENGINEER))


def test_results_remember_the_units_of_the_configuration_and_stay_si(result):
    shown = {name: c.attrs.get("display_units") for name, c in result.coords.items()}
    assert {name: unit for name, unit in shown.items() if unit} == {
        "mass": "g", "normal_load": "kN", "a2": "s/m", "a4": "mm/s", "stiffness": "N/mm", "belt_speed": "mm/s",
    }  # fmt: skip
    assert result["belt_speed"].values.tolist() == [0.005, 0.02, 0.3] and result["belt_speed"].units == "m s-1"
    assert float(result["normal_load"]) == 10.0


def test_what_was_written_is_shown_again_to_the_last_digit(result):
    unit = unit_of(result["belt_speed"])
    assert (unit.of(result["belt_speed"].values).tolist(), unit.name) == ([5.0, 20.0, 300.0], "mm/s")
    assert [MapAxis(result, "belt_speed").text(i) for i in range(3)] == ["5 mm/s", "20 mm/s", "300 mm/s"]


def test_units_survive_the_file(result, tmp_path):
    path = tmp_path / "map.nc"
    result.to_netcdf(path)
    with xr.open_dataset(path) as back:
        figure = plot_map(back)
    assert (
        figure.axes[0].get_xlabel() == "belt speed (mm/s)" and figure.axes[0].get_ylabel() == "spring stiffness (N/mm)"
    )
    np.testing.assert_allclose(figure.axes[0].get_ylim(), (-0.5, 11.5))
    note = " ".join(" ".join(notes_of(figure)).split())
    assert "held fixed: mass = 100 g, damping = 0 N s/m, normal load = 0.01 kN, a1 = 0.3, a2 = 0.5 s/m" in note
    assert "a3 = 0.1, a4 = 20 mm/s" in note


def test_units_of_ranges_of_groups_and_of_what_is_searched_are_found():
    data = {
        "system": {"mass": 1, "stiffness": "2 N/mm", "normal_load": 10, "belt_speed": 0.01},
        "friction": {"a1": 0.3, "a2": 0},
        "axes": {"grease": {"zip": {"a3": [0.1, 0.2], "a4": ["5 mm/s", "0.01 m/s"]}}},
        "border": {"along": "belt_speed", "between": ["1 mm/s", "90 mm/s"]},
    }
    config = make_config({**data, "axes": data["axes"]})
    assert config.written_in == {"stiffness": "N/mm", "a4": "mm/s", "belt_speed": "mm/s"}
    lines = stickslip.run(config)
    assert {lines[name].attrs["display_units"] for name in ("border", "border_width", "a4")} == {"mm/s"}
    assert "display_units" not in lines["a3"].attrs


@cases("sweep.yaml")
def test_outputs_follow_inputs_of_their_kind(result, name, values, expected):
    array = result[name].isel(stiffness=0, belt_speed=slice(None, len(values)))
    assert unit_of(array, np.array(values)).name == expected


def test_every_variable_and_quantity_has_a_unit_to_be_shown_in():
    for declared in (*VARIABLES.values(), *QUANTITIES.values()):
        unit = unit_of(xr.DataArray([2.0], dims="x", attrs={"units": declared.units}))
        assert unit.of(3.0) == pytest.approx(3.0 / unit.size) and unit.to_si(unit.of(3.0)) == pytest.approx(3.0)


def test_units_can_be_chosen_and_wrong_ones_are_refused():
    ds = with_units(plane(), {"period": "ms", "belt_speed": "km/h"})
    assert plot_map(ds, "period").axes[-1].get_ylabel() == "period of the limit cycle (ms)"
    assert MapAxis(ds, "belt_speed").centres[0] == pytest.approx(0.02 * 3.6)
    assert "display_units" not in plane()["period"].attrs
    for wanted, message in (
        ({"belt_speed": "N"}, r"cannot show belt_speed in 'N', expected a unit like m/s"),
        ({"regime": "mm"}, "pure number"), ({"speed": "mm/s"}, "no 'speed' to show in mm/s; there are"),
        ({"spring_force_max": "furlong"}, "expected a unit like N"),
    ):  # fmt: skip
        with pytest.raises(PlotError, match=message):
            with_units(plane(), wanted)


def test_exact_borders_lie_over_the_map_whatever_units_both_were_written_in():
    text = ENGINEER.replace("[5 mm/s, 20 mm/s, 300 mm/s]", "{start: 5 mm/s, stop: 300 mm/s, num: 60}")
    cells = stickslip.run(parse_config(text))
    lines = stickslip.border(parse_config(text.replace(" mm/s", "e-3")), "belt_speed", (0.005, 0.3))
    figure = plot_map(cells, lines=lines)
    (drawn,) = [line for line in figure.axes[0].lines if line.get_color() == "white"]
    np.testing.assert_allclose(drawn.get_xdata(), 1e3 * lines["border"].values[:, 0])
    np.testing.assert_allclose(drawn.get_ydata(), [1, 4, 7, 10])


def test_regimes_are_told_apart_without_colours():
    """In grey, any two regimes differ in their brightness or in their hatching."""

    def grey(colour):
        red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
        return 0.299 * red + 0.587 * green + 0.114 * blue

    for one, other in combinations(FLAG_COLOURS["regime"].values(), 2):
        assert HATCHES.get(one) != HATCHES.get(other) or abs(grey(one) - grey(other)) > 80, (one, other)


def test_units_survive_a_store_that_is_collected_by_itself(tmp_path):
    config = tmp_path / "c.yaml"
    config.write_text(ENGINEER)
    for shard in ("1/2", "2/2"):
        stickslip.run_shard(config, shard, tmp_path / "store")
    whole = stickslip.collect(tmp_path / "store", tmp_path / "map.nc")
    assert whole["belt_speed"].attrs["display_units"] == "mm/s" and whole["mass"].attrs["display_units"] == "g"
