"""Axes: lists, ranges and groups of quantities."""

import pytest

from helpers.configs import GOOD
from stickslip.config.model import Values
from stickslip.config.reader import make_config, parse_config
from stickslip.errors import ConfigError


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
