"""Numbers without a unit that are implausible in SI: asked about, and nothing else is."""

import warnings

import pytest

from helpers.commands import call
from helpers.configs import cell_at
from helpers.data import cases
from helpers.installed import shipped
from stickslip.config.reader import load_config, parse_config
from stickslip.config.resolve import config_path
from stickslip.errors import UnitWarning

QUIET = """\
system: {mass: 1 kg, normal_load: 10, damping: 0}
friction: {a1: 0.2, a2: 0, a3: 0.1, a4: 20}
axes:
  stiffness: {start: 1, stop: 100, num: 4, spacing: log}
  belt_speed: {start: 1, stop: 500, num: 5}
"""


def said(folder, text, load=load_config):
    """What is said of a configuration."""
    path = folder / "map.yaml"
    path.write_text(text)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        load(path)
    return [str(warning.message).replace(str(path), "map.yaml") for warning in caught]


def of_one(quantity):
    """A study without dimensions in which one quantity is another one."""
    name = quantity.split(":")[0]
    friction = {"a1": "1", "a2": "0.1", "a3": "0.3", "a4": "0.1"}
    system = {"mass": "1", "stiffness": "1", "normal_load": "1", "belt_speed": "0.1"}
    start = {"displacement": "0", "velocity": "sticking"}
    sections = {"system": system, "friction": friction, "start": start}
    for section in sections.values():
        section |= {name: quantity.split(": ")[1]} if name in section else {}
    return "\n".join(f"{key}: {{{', '.join(map(': '.join, s.items()))}}}" for key, s in sections.items())


def test_speeds_meant_in_millimetres_are_asked_about_with_their_places(tmp_path):
    (asked,) = said(tmp_path, QUIET)
    assert asked.splitlines()[:2] == [
        "map.yaml:2:37: friction.a4: got 20 m/s; did you mean 20 mm/s?",
        "map.yaml:5:3: axes.belt_speed: got 1 to 500 m/s; did you mean 1 to 500 mm/s?",
    ]
    assert "write the unit" in asked


@pytest.mark.parametrize(("quantity", "meant"), [
    ("mass: 250", "250 g"), ("a4: 2", "2 mm/s"), ("belt_speed: -50", "50 mm/s"), ("velocity: 50", "50 mm/s"),
    ("displacement: 20", "20 mm"),
])  # fmt: skip
def test_what_no_contact_does_is_asked_about(tmp_path, quantity, meant):
    (asked,) = said(tmp_path, of_one(quantity))
    assert f"did you mean {meant}?" in asked


@pytest.mark.parametrize("quantity", [
    "mass: 250 kg", "a4: 20 m/s", "belt_speed: 500 m/s", "belt_speed: 10", "displacement: 20 m", "velocity: 500 m/s",
    "mass: 10", "a4: 0.5", "belt_speed: 2", "belt_speed: -0.6", "displacement: -1.04", "velocity: 1.5",
])  # fmt: skip
def test_a_value_with_a_unit_or_of_order_one_is_not_questioned(tmp_path, quantity):
    assert said(tmp_path, of_one(quantity)) == []


PAD = """\
system: {mass: 100 g, stiffness: 5 N/mm, normal_load: 10 N}
friction: {a1: 0.3, a2: 0, a3: 0.1, a4: 20 mm/s}
axes: {belt_speed: {start: 1 mm/s, stop: 200 mm/s, num: 3}}
"""


@cases("sweep.yaml")
def test_what_is_absurd_in_si_is_named_with_the_likely_unit(tmp_path, old, new, question):
    assert said(tmp_path, PAD) == []
    (asked,) = said(tmp_path, PAD.replace(old, new, 1))
    assert question in asked


def test_a_fault_of_the_earth_is_not_questioned(tmp_path):
    """Its deflections are metres and its frequencies a hundredth of a hertz."""
    fault = PAD.replace("100 g", "1e12 kg").replace("5 N/mm", "1e9 N/m").replace("10 N", "1e10 N")
    assert said(tmp_path, fault) == []


@pytest.mark.parametrize("scale", [0.5, 5.0])
@pytest.mark.parametrize("name", ["mass", "normal_load", "stiffness", "a4", "belt_speed", "a2"])
def test_a_dimensionless_study_may_scale_any_of_its_numbers(tmp_path, name, scale):
    values = {"mass": 1.0, "normal_load": 1.0, "stiffness": 1.0, "a4": 0.1, "belt_speed": 0.1, "a2": 0.1}
    assert said(tmp_path, of_one(f"{name}: {values[name] * scale}") if name != "a2" else of_one("a1: 1")) == []


@pytest.mark.parametrize("axis", ["a4: [10, 20]", "a4: {values: [10, 20]}", "g: {zip: {a4: [10, 20, 20]}}"])
def test_axes_of_every_form_are_looked_at(tmp_path, axis):
    (asked,) = said(tmp_path, QUIET.replace(", a4: 20", "").replace("  belt_speed", f"  {axis}\n  belt_speed"))
    assert "a4: got 10 to 20 m/s; did you mean 10 to 20 mm/s?" in asked


@pytest.mark.parametrize("name", shipped())
def test_no_configuration_that_ships_is_questioned(name):
    with warnings.catch_warnings(record=True) as questions:
        warnings.simplefilter("always")
        load_config(config_path(name), apart=None)
    assert questions == []


def test_the_configuration_in_a_result_is_not_questioned(tmp_path):
    (tmp_path / "map.yaml").write_text(QUIET)
    with pytest.warns(UnitWarning):
        config = load_config(tmp_path / "map.yaml")
    with warnings.catch_warnings(record=True) as questions:
        warnings.simplefilter("always")
        parse_config(config.to_yaml())
    assert questions == []


@pytest.mark.filterwarnings(f"default::{UnitWarning.__module__}.{UnitWarning.__name__}")
@pytest.mark.parametrize("command", ["run", "plan", "validate"])
def test_commands_ask_on_standard_error_before_they_compute(here, command):
    (here / "map.yaml").write_text(QUIET)
    done = call(command, "map.yaml")
    assert done.exit_code == 0
    assert done.stderr.startswith("warning: map.yaml:2:37: friction.a4: got 20 m/s")
    assert "did you mean" not in done.stdout


# --- cells that are picked --------------------------------------------------------------------------------------------

PART = parse_config("""
system: {mass: 250 g, normal_load: 30 N, damping: 1 N s/m}
friction: {mu_start: 0.4, mu_reversal: 0.3, v_reversal: 100 mm/s, a4: 20 mm/s}
axes:
  stiffness: {start: 1 N/mm, stop: 50 N/mm, num: 4, spacing: log}
  belt_speed: {start: 1 mm/s, stop: 300 mm/s, num: 4}
""")


def asked_of(*settings):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        cell_at(PART, settings)
    return "\n".join(str(warning.message) for warning in caught)


@cases("sweep.yaml")
def test_numbers_that_pick_a_cell_are_asked_about(setting, question):
    others = [given for given in ("belt_speed=25 mm/s", "stiffness=12 N/mm") if given.split("=")[0] not in setting]
    assert question in asked_of(setting, *others)


@cases("sweep.yaml")
def test_cells_that_are_plausible_are_not_asked_about(settings):
    assert asked_of(*settings) == ""
