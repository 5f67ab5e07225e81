"""`--set key=value`: put into the file before it is checked, and named where it is wrong."""

import pytest

from helpers.configs import GOOD
from helpers.data import cases
from stickslip.config.reader import parse_config
from stickslip.config.yaml import overridden, parse_yaml, setting
from stickslip.errors import ConfigError

AXES = GOOD.replace("  stiffness: 10\n", "") + "axes: {stiffness: {start: 1, stop: 10, num: 10}}\n"


def read(text, *texts):
    return parse_config(text, "my.yaml", [setting(one) for one in texts])


def complaint(text, *texts):
    with pytest.raises(ConfigError) as raised:
        read(text, *texts)
    return str(raised.value)


@cases("config.yaml")
def test_a_setting_is_read_as_the_file_is(text, path, value):
    if path is None:
        assert "title: got a mapping" in complaint(GOOD, text)
        return
    section, key = path
    assert getattr(getattr(read(GOOD, text), section), key) == pytest.approx(value, rel=1e-15)


def test_axes_change_by_one_of_their_keys_or_as_a_whole():
    config = read(AXES, "axes.stiffness.num=50", "axes.stiffness.start=2 N/mm", "axes.stiffness.stop=5 N/mm")
    assert (config.axes[0].start, config.axes[0].num) == (2000.0, 50)
    assert read(AXES, "axes.stiffness=[1, 2, 3]").axes[0].values == (1.0, 2.0, 3.0)
    assert read(AXES, "axes.stiffness=[1, 2, 3]", "axes.stiffness[2]=7").axes[0].values == (1.0, 2.0, 7.0)


def test_nothing_after_the_equals_sign_removes_a_key():
    config = read(AXES, "axes.stiffness=", "system.stiffness=7")
    assert config.axes == () and config.system.stiffness == 7
    assert "friction has no mu_stop" in complaint(GOOD, "friction.mu_stop=")


def test_a_configuration_keeps_what_was_set():
    config = read(AXES, "solver.rtol=1e-9", "axes.stiffness.num=4")
    again = parse_config(config.to_yaml())
    assert again == config and again.solver.rtol == 1e-9 and again.axes[0].num == 4


@cases("config.yaml")
def test_errors_name_the_setting_in_place_of_a_line(text, said):
    assert said in complaint(AXES, text)


@pytest.mark.parametrize("text", ["", "mass", "=1", "a..b=1", ".a=1", "a b=1", "a[x]=1", "a[=1"])
def test_what_is_no_setting_is_refused(text):
    with pytest.raises(ValueError, match="expected KEY=VALUE"):
        setting(text)


def test_every_place_in_what_was_set_is_that_of_the_setting():
    given = setting("axes.mass={zip: {a: [1, {b: 2}]}}")
    document = overridden(parse_yaml(AXES), [given])
    inside = [path for path in document.values if path[:2] == ("axes", "mass")]
    assert len(inside) == 6 and all(document.values[path] == given.place for path in inside)
    assert document.values["system", "mass"].option == ""
