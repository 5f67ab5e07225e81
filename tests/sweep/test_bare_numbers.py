"""A number without a unit takes that of the next one, or is refused, wherever several values of a quantity stand."""

import math

import numpy as np
import pint
import pytest

import stickslip
from helpers.commands import call
from helpers.data import cases
from stickslip.config.reader import make_config, parse_config
from stickslip.errors import ConfigError, PlotError
from stickslip.plots.marks import Look
from stickslip.vocabulary.units import each_with_unit

CURVE = {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
CELL = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, **CURVE}
TEXT = "system: {mass: 1, normal_load: 1, stiffness: 1}\nfriction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}\n"
AT = TEXT.replace("mass: 1", "mass: 1, belt_speed: 0.5")
quantity = pint.UnitRegistry().Quantity


@cases("sweep.yaml")
def test_the_values_of_an_axis(axis, expected):
    np.testing.assert_array_equal(parse_config(f"{TEXT}axes: {{belt_speed: {axis}}}\n", "a").axes[0].points(), expected)


def test_each_quantity_of_a_group_has_its_own_unit():
    text = TEXT.replace(", stiffness: 1", "") + "axes: {p: {zip: {stiffness: [5, 6 N/mm], belt_speed: [0.1, 0.2]}}}\n"
    stiffness, speed = (member.points().tolist() for member in parse_config(text, "a").axes[0].members)
    assert (stiffness, speed) == ([5000, 6000], [0.1, 0.2])


@cases("sweep.yaml")
def test_the_numbers_of_a_distribution(scatter, numbers, ends):
    text = f"{TEXT}uncertain: {{quantities: {{belt_speed: {{{scatter}}}}}}}\n"
    read = parse_config(text, "a").uncertain.quantities["belt_speed"]
    assert (read.numbers, read.ends) == (numbers, ends)


@cases("sweep.yaml")
def test_the_ranges_of_studies(section, field, expected):
    np.testing.assert_equal(getattr(parse_config(f"{AT}{section}\n", "a").study, field), expected)


@cases("sweep.yaml")
def test_a_number_after_one_with_a_unit_is_refused(after):
    with pytest.raises(ConfigError, match=r"expected a unit with (2|60|1|15|600|2.0|1000) as well, since others have"):
        parse_config(f"{AT if 'axes' not in after and 'belt_speed: {' not in after else TEXT}{after}\n", "a")


@pytest.mark.parametrize("speeds", [
    [5, "100 mm/s"], (5.0, "100 mm/s"), np.array([5, "100 mm/s"], object), ["5 mm/s", "0.1 m/s"],
])  # fmt: skip
def test_python_calls(speeds):
    np.testing.assert_array_equal(stickslip.evaluate({**CELL, "belt_speed": speeds})["belt_speed"], [0.005, 0.1])
    given = {"system": {"mass": 1, "stiffness": 1, "normal_load": 1}, "friction": CURVE, "axes": {"belt_speed": speeds}}
    np.testing.assert_array_equal(make_config(given).axes[0].points(), [0.005, 0.1])


def test_boxes_and_ranges_of_python_calls():
    box = {"displacement": (-1, quantity(1000, "mm")), "velocity": (-1000, "1000 mm/s")}
    found = stickslip.attractors(CELL | {"belt_speed": 0.5}, box=box)
    assert found.attrs["box_velocity"].tolist() == [-1, 1] and found.attrs["box_displacement"].tolist() == [-0.001, 1]
    ramp = stickslip.ramp(CELL, along="belt_speed", between=(5, "900 mm/s"), points=3)
    np.testing.assert_allclose(ramp["belt_speed"][[0, -1]], [0.005, 0.9], rtol=1e-12)


def test_options_of_commands(tmp_path):
    config = tmp_path / "a.yaml"
    config.write_text(AT)
    for i, ends in enumerate((["5", "900 mm/s"], ["5 mm/s", "0.9 m/s"])):
        output = str(tmp_path / f"{i}.nc")
        words = ["border", str(config), "--along", "belt_speed", "--between", *ends, "-o", output]
        assert call(*words).exit_code == 0
        assert parse_config(stickslip.open(output).attrs["configuration"]).study.between == (0.005, 0.9)
    config.write_text(TEXT)
    done = call("validate", config, "--set", "axes.belt_speed=[5, 60 mm/s]")
    assert "0.005, 0.06 m/s" in done.output and "warning" not in done.output.lower(), done.output
    result = stickslip.evaluate(CELL | {"belt_speed": 0.5}).rename(cell="belt_speed_of")
    for limits in ("period=5..60 ms", "period=5 ms..60 ms"):
        assert Look.of(result, limits=[limits]).limits["period"] == (0.005, 0.06)
    with pytest.raises(PlotError, match="upper end has no unit"):
        Look.of(result, limits=["period=5 ms..60"])


def test_what_is_no_number_or_no_unit_is_left_as_it_is():
    for given in (
        [1, "none"],
        [1, "2 foo"],
        [True, "2 mm"],
        [math.nan, "2 mm"],
        ["2 mm", 0],
        [1, 2],
        "2 mm",
        [1, "3 %"],
    ):
        assert each_with_unit(given, "m") == given or given[0] != given[0]
