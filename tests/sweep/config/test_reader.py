"""Single values, keys and sections: what is read, and what is said of what cannot be."""

import math
import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.configs import GOOD, message, with_line
from helpers.installed import shipped
from stickslip.config import sections
from stickslip.config.reader import load_config, parse_config
from stickslip.config.resolve import config_path
from stickslip.config.sections import System
from stickslip.errors import ConfigError
from stickslip.vocabulary.quantities import listed
from stickslip.vocabulary.results import BESIDE, STUDIES


def test_quantities_become_si():
    config = parse_config(GOOD)
    assert (config.system.mass, config.system.belt_speed) == (1.0, 0.01)


def test_a_power_of_ten_without_a_point_is_a_number():
    """YAML 1.1 reads 1e-3 as a word."""
    assert parse_config(with_line(3, "  mass: 1e-3")).system.mass == 0.001


def test_a_damping_in_percent_is_a_share_of_critical_damping_of_one_spring():
    system = "system: {mass: 2, stiffness: STIFFNESS, normal_load: 10, damping: 3 %, belt_speed: 0.1}\n"
    text = system + "friction: {a1: 0.2, a2: 0.02, a3: 0.1, a4: 0.1}\n"
    damping = parse_config(text.replace("STIFFNESS", "800")).system.damping
    assert damping == pytest.approx(0.03 * 2.0 * (2.0 * 800.0) ** 0.5)
    assert "1:67: system.damping: got '3 %'" in message(text.replace("stiffness: STIFFNESS, ", " " * 22))


def test_words_stand_for_absent_quantities():
    config = parse_config(GOOD + "  mu_stop: none\nstart: {velocity: sticking}\naxes: {mu_static: [mu_start, 1.5]}\n")
    assert math.isnan(config.friction.mu_stop) and math.isnan(config.start.velocity)
    assert math.isnan(config.axes[0].values[0]) and config.axes[0].values[1] == 1.5
    plain = config.resolved()
    assert (plain["friction"]["mu_stop"], plain["start"]["velocity"]) == ("none", "sticking")
    assert plain["axes"] == {"mu_static": {"values": ["mu_start", 1.5]}}


@pytest.mark.parametrize("name", shipped())
def test_configurations_that_ship_are_good(name):
    config = load_config(config_path(name), apart=None)
    assert parse_config(config.to_yaml()) == config
    assert config.output.file == f"{name.rpartition('/')[2]}.nc"


BAD = {
    "negative mass": (
        with_line(3, "  mass: -1 kg"),
        "map.yaml:3:9: system.mass: got '-1 kg', expected a mass above 0 kg",
    ),
    "no mass at all": (
        with_line(3, "  mass: 0"),
        "map.yaml:3:9: system.mass: got 0, expected a mass above 0 kg",
    ),
    "negative coefficient": (
        with_line(8, "  a1: -0.1"),
        "map.yaml:8:7: friction.a1: got -0.1, expected a number of at least 0",
    ),
    "NaN": (
        with_line(4, "  stiffness: .nan"),
        "map.yaml:4:14: system.stiffness: got .nan, expected a finite number in N/m",
    ),
    "infinity": (
        with_line(4, "  stiffness: 1e400"),
        "map.yaml:4:14: system.stiffness: got 1e400, expected a finite number in N/m",
    ),
    "a number in quotes": (
        with_line(3, '  mass: "1e-3"'),
        "map.yaml:3:9: system.mass: got '1e-3', expected a mass such as '250 g' or a number in kg\n"
        "  hint: remove the quotes: 1e-3",
    ),
    "a comma for a point": (
        GOOD + 'start: {displacement: "1,5 mm"}\n',
        "map.yaml:12:23: start.displacement: got '1,5 mm', expected a length such as '10 mm' or a number in m\n"
        "  hint: write a decimal point, not a comma",
    ),
    "a wrong unit": (
        with_line(6, "  belt_speed: 10 mm"),
        "map.yaml:6:15: system.belt_speed: got '10 mm' (length), "
        "expected a speed such as '10 mm/s' or a number in m/s",
    ),
    "a truth value": (
        with_line(3, "  mass: true"),
        "map.yaml:3:9: system.mass: got true, expected a mass such as '250 g' or a number in kg",
    ),
    "nothing": (
        with_line(3, "  mass:"),
        "map.yaml:3:3: system.mass: got nothing, expected a mass such as '250 g' or a number in kg",
    ),
    "a duplicate key": (
        with_line(4, "  stiffness: 10", "  stiffness: 20"),
        "map.yaml:5:3: system.stiffness: given twice, first on line 4, expected once\n  hint: remove one of the two",
    ),
    "a misspelt key": (
        with_line(4, "  stifness: 10"),
        f"map.yaml:4:3: system.stifness: unknown key, expected {listed(System.model_fields)}\n"
        "  hint: did you mean stiffness?",
    ),
    "a misspelt section": (
        with_line(1, "sistem: {}", text=GOOD),
        "map.yaml:1:1: sistem: unknown key, "
        f"expected title, system, friction, start, axes, solver, execution, output, {listed([*STUDIES, *BESIDE])}\n"
        "  hint: did you mean system?",
    ),
    "a key of another section": (
        GOOD + "solver: {mu_stop: 1}\n",
        "map.yaml:12:10: solver.mu_stop: unknown key, expected rtol, horizon, max_steps or early_stop\n"
        "  hint: mu_stop belongs to friction, or to axes",
    ),
    "a law nobody knows": (
        with_line(7, "friction:", "  law: coulomb"),
        "map.yaml:8:8: friction.law: got 'coulomb', expected stribeck, stribeck_delta, rational, cubic, "
        "rate_state_ageing or rate_state_slip\n"
        "  hint: if coulomb was registered in another process, call register_law here as well, before anything else",
    ),
    "a tolerance out of range": (
        GOOD + "solver: {rtol: 0.1}\n",
        "map.yaml:12:16: solver.rtol: got 0.1, expected a number from 1e-12 to 0.01",
    ),
    "a horizon that is no time": (
        GOOD + "solver: {horizon: 3 m}\n",
        "map.yaml:12:19: solver.horizon: got '3 m' (length), expected a time such as '2 min' or a number in s\n"
        "  hint: leave horizon out for no limit",
    ),
    "a word of YAML 1.1": (
        GOOD + "solver: {early_stop: yes}\n",
        "map.yaml:12:22: solver.early_stop: got 'yes', expected true or false",
    ),
    "no steps": (
        GOOD + "solver: {max_steps: 0}\n",
        "map.yaml:12:21: solver.max_steps: got 0, expected a whole number from 1 to 2000000000",
    ),
    "no threads": (
        GOOD + "execution: {threads: 0}\n",
        "map.yaml:12:22: execution.threads: got 0, expected a whole number from 1 to 4096, or auto",
    ),
    "no scheduler": (
        GOOD + "execution: {dask: head:8786}\n",
        "map.yaml:12:19: execution.dask: got 'head:8786', expected an address such as tcp://host:8786, "
        "a scheduler file (.json), local or none",
    ),
    "a table as output": (
        GOOD + "output: {file: map.csv}\n",
        "map.yaml:12:16: output.file: got 'map.csv', expected a file name that ends in .nc or .zarr",
    ),
    "a plot of unknown format": (
        GOOD + "output: {plot: map.jpg}\n",
        "map.yaml:12:16: output.plot: got 'map.jpg', expected a file name that ends in .png, .svg or .pdf",
    ),
    "a title that is a number": (
        with_line(1, "title: 2024"),
        "map.yaml:1:8: title: got 2024, expected a text\n  hint: put it in quotes",
    ),
    "a list for a section": (
        GOOD + "solver: [1]\n",
        "map.yaml:12:9: solver: got a list, expected a mapping with the keys rtol, horizon, max_steps or early_stop",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input_is_explained(name, monkeypatch):
    monkeypatch.setattr(sections, "own_names", tuple)  # laws that other tests have registered
    text, expected = BAD[name]
    assert message(text) == expected


def test_all_problems_are_reported_at_once_in_the_order_of_the_file():
    text = with_line(3, "  mass: -1", text=with_line(6, "  belt_speed: 10 mm", text=GOOD))
    text += "  mu_stop: 2\nsolver: {rtol: 1, max_step: 3}\naxes: {damping: {start: 2, stop: 1, num: 1}}\n"
    assert [line.split(" got ")[0] for line in message(text).splitlines() if "hint" not in line] == [
        "map.yaml:3:9: system.mass:",
        "map.yaml:6:15: system.belt_speed:",
        "map.yaml:12:12: friction.mu_stop:",
        "map.yaml:13:16: solver.rtol:",
        "map.yaml:13:19: solver.max_step: unknown key, expected rtol, horizon, max_steps or early_stop",
        "map.yaml:14:34: axes.damping.stop:",
        "map.yaml:14:42: axes.damping.num:",
    ]


@given(st.text(max_size=200))
def test_any_text_is_a_configuration_or_explained(text):
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "map.yaml")
    assert caught.value.problems
    assert all(line.startswith(("map.yaml", "  hint: ")) for line in str(caught.value).splitlines())


def test_errors_survive_pickling():
    """They travel from worker processes."""
    with pytest.raises(ConfigError) as caught:
        parse_config("title: 1\n", "map.yaml")
    copy = pickle.loads(pickle.dumps(caught.value))
    assert str(copy) == str(caught.value) and copy.problems == caught.value.problems
