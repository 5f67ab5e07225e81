"""Axes: lists, ranges and groups of quantities."""

import pytest

from helpers.configs import GOOD, message, with_line
from stickslip.config.model import Values
from stickslip.config.reader import make_config, parse_config
from stickslip.errors import ConfigError
from stickslip.vocabulary.quantities import OF_EXTENSIONS, QUANTITIES, listed

CELL_QUANTITIES = [name for name in QUANTITIES if name not in OF_EXTENSIONS]


def test_axes_keep_the_order_of_the_file():
    axes = "axes:\n  damping: [0, 1]\n  displacement: {values: [1 mm, 2 mm]}\n"
    config = parse_config(GOOD + axes)
    assert config.axes == (Values(name="damping", values=(0.0, 1.0)), Values(name="displacement", values=(1e-3, 2e-3)))
    swapped = parse_config(GOOD + "axes:\n  displacement: [1 mm, 2 mm]\n  damping: [0, 1]\n")
    assert swapped != config


def test_a_group_varies_quantities_together():
    group = "axes:\n  oil: {zip: {damping: [0, 1 N s/m], velocity: [sticking, 2]}, labels: [thin, thick]}\n"
    (oil,) = parse_config(GOOD + group).axes
    assert oil.labels == ("thin", "thick")
    assert oil.resolved()["zip"] == {"damping": [0.0, 1.0], "velocity": ["sticking", 2.0]}


def test_plain_data_may_list_values_without_a_key():
    data = parse_config(GOOD).resolved()
    data["axes"] = {"displacement": [1000, 2000, "1000 mm"]}
    del data["start"]["displacement"]
    with pytest.raises(
        ConfigError, match=r"^<data>: axes\.displacement\[2\]: got '1000 mm', expected a value that is not"
    ):
        make_config(data)


BAD = {
    "a misspelt axis": (
        with_line(6, "axes: {belt_sped: [1, 2]}"),
        f"map.yaml:6:8: axes.belt_sped: unknown quantity, expected {listed(CELL_QUANTITIES)}\n"
        "  hint: did you mean belt_speed?",
    ),
    "reversed bounds": (
        with_line(6, "axes: {belt_speed: {start: 800, stop: 10 mm/s, num: 5}}"),
        "map.yaml:6:39: axes.belt_speed.stop: got '10 mm/s', expected more than start (0.8 m/s)\n"
        "  hint: swap start and stop",
    ),
    "equal bounds": (
        with_line(6, "axes: {belt_speed: {start: 1, stop: 1, num: 5}}"),
        "map.yaml:6:37: axes.belt_speed.stop: got 1, expected more than start (1 m/s)\n"
        "  hint: a quantity that does not vary belongs in its section",
    ),
    "a logarithm of nothing": (
        with_line(6, "axes: {belt_speed: {start: 0, stop: 1, num: 5, spacing: log}}"),
        "map.yaml:6:28: axes.belt_speed.start: got 0, expected a start above 0 m/s for log spacing\n"
        "  hint: or use spacing: linear",
    ),
    "an unknown spacing": (
        with_line(6, "axes: {belt_speed: {start: 1, stop: 2, num: 5, spacing: logarithmic}}"),
        "map.yaml:6:57: axes.belt_speed.spacing: got 'logarithmic', expected linear or log",
    ),
    "one point": (
        with_line(6, "axes: {belt_speed: {start: 1, stop: 2, num: 1}}"),
        "map.yaml:6:45: axes.belt_speed.num: got 1, expected a whole number from 2 to 10000000\n"
        "  hint: a quantity that does not vary belongs in its section",
    ),
    "half a point": (
        with_line(6, "axes: {belt_speed: {start: 1, stop: 2, num: 2.5}}"),
        "map.yaml:6:45: axes.belt_speed.num: got 2.5, expected a whole number from 2 to 10000000",
    ),
    "points closer than rounding": (
        with_line(6, "axes: {belt_speed: {start: 1, stop: 1.0000000000001, num: 100000}}"),
        "map.yaml:6:59: axes.belt_speed.num: got 100000, "
        "expected fewer points: neighbours would be equal after rounding",
    ),
    "no stop": (
        with_line(6, "axes: {belt_speed: {start: 1, num: 5}}"),
        "map.yaml:6:8: axes.belt_speed.stop: missing, expected start, stop and num",
    ),
    "a number for an axis": (
        with_line(6, "axes: {belt_speed: 3}"),
        "map.yaml:6:20: axes.belt_speed: got 3, expected a list of values, or start, stop and num\n"
        "  hint: belt_speed: {start: ..., stop: ..., num: 50}",
    ),
    "an empty list": (
        with_line(6, "axes: {belt_speed: []}"),
        "map.yaml:6:20: axes.belt_speed: got a list, expected a list of values",
    ),
    "a bad value in a list": (
        with_line(6, "axes: {belt_speed: [1, 2 m/s, 3 kg]}"),
        "map.yaml:6:31: axes.belt_speed[2]: got '3 kg' (mass), expected a speed such as '10 mm/s' or a number in m/s",
    ),
    "a value twice": (
        with_line(6, "axes: {belt_speed: {values: [1000, 2000, 1000 mm/s]}}"),
        "map.yaml:6:42: axes.belt_speed.values[2]: got '1000 mm/s', expected a value that is not in the list yet\n"
        "  hint: it is the same as value number 1",
    ),
    "values out of order": (
        with_line(6, "axes: {belt_speed: [1, 3, 2]}"),
        "map.yaml:6:27: axes.belt_speed[2]: got 2, expected values that rise or fall all the way\n"
        "  hint: sort them; a group (zip) keeps any order",
    ),
    "a word as a bound": (
        GOOD + "axes: {velocity: {start: sticking, stop: 1, num: 3}}\n",
        "map.yaml:12:26: axes.velocity.start: got 'sticking', expected a speed such as '10 mm/s' or a number in m/s\n"
        "  hint: sticking is allowed in a list: values: [...]",
    ),
    "a group of unequal lengths": (
        with_line(6, "axes:", "  pair: {zip: {belt_speed: [1, 2], damping: [1, 2, 3]}, labels: [a, b]}"),
        "map.yaml:7:45: axes.pair.zip.damping: got 3 values, expected 2 like belt_speed on line 7",
    ),
    "a group without members": (
        GOOD + "axes: {pair: {zip: {}}}\n",
        "map.yaml:12:20: axes.pair.zip: expected a mapping of quantities to lists of values\n"
        "  hint: zip: {mass: [1, 2], ...}",
    ),
    "a group named like a quantity": (
        with_line(6, "axes: {mass: {zip: {belt_speed: [1, 2]}}}"),
        "map.yaml:6:8: axes.mass: got the name mass, "
        "expected a name of its own for the group: a word that is no quantity and no result",
    ),
    "labels that are no list": (
        with_line(6, "axes: {oil: {zip: {belt_speed: [1, 2]}, labels: thin}}"),
        "map.yaml:6:49: axes.oil.labels: got 'thin', expected a list of names",
    ),
    "labels that are equal": (
        with_line(6, "axes: {oil: {zip: {belt_speed: [1, 2]}, labels: [a, a]}}"),
        "map.yaml:6:53: axes.oil.labels[1]: got 'a', expected a name that is not in the list yet",
    ),
    "labels that are numbers": (
        with_line(6, "axes: {oil: {zip: {belt_speed: [1, 2]}, labels: [a, 5]}}"),
        "map.yaml:6:53: axes.oil.labels[1]: got 5, expected a name\n  hint: put it in quotes",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_bad_axis_is_explained(name):
    text, expected = BAD[name]
    assert message(text) == expected
