"""`--set key=value`: put into the file before it is checked, and named where it is wrong."""

import pytest

from helpers.configs import GOOD
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


@pytest.mark.parametrize(("text", "path", "value"), [
    ("system.mass=200 g", ("system", "mass"), 0.2),
    ("system.mass = 2", ("system", "mass"), 2.0),
    ("solver.rtol=1e-9", ("solver", "rtol"), 1e-9),
    ("title=A: b", None, None),
    ("solver.max_steps=5", ("solver", "max_steps"), 5),
    ("execution.threads=3", ("execution", "threads"), 3),
])  # fmt: skip
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


@pytest.mark.parametrize(("text", "said"), [
    ("system.mass=1,5 kg", "my.yaml: --set system.mass=1,5 kg: system.mass: got '1,5 kg', expected a mass"),
    ("sytem.mass=1", "my.yaml: --set sytem.mass=1: sytem: unknown key"),
    ("axes.stiffness.nm=1", "my.yaml: --set axes.stiffness.nm=1: axes.stiffness.nm: unknown key"),
    ("axes.stiffness.num.more=1", "axes.stiffness.num has no more"),
    ("axes.stiffness.num[0]=1", "axes.stiffness.num has no [0]"),
    ("axes.stiffness[0]=1", "axes.stiffness has no [0]"),
    ("axes.stiffness.num=[1", "my.yaml: --set axes.stiffness.num=[1: axes.stiffness.num: not valid YAML"),
    ("axes.mass.num=5", "my.yaml: --set axes.mass.num=5: axes.mass.start: missing"),
    ("system.stiffness=4", "given twice, as system.stiffness by --set system.stiffness=4 already"),
    ("system.stiffness=4", "hint: --set axes.stiffness= removes the other"),
    ("uncertain.quantities.mass={uniform: [1, 2]}", "hint: --set system.mass= removes the other"),
    ("solver.draws=64", "hint: draws belongs to uncertain"),
    ("axes.stiffness={start: 1, start: 2}", "--set axes.stiffness={start: 1, start: 2}: axes.stiffness: given twice"),
])  # fmt: skip
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
