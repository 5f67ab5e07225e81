"""Single values, keys and sections: what is read, and what is said of what cannot be."""

import math
import pickle
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.configs import GOOD, MEASURED_FORM, message, with_line
from helpers.data import rows
from helpers.installed import shipped
from stickslip.config import sections
from stickslip.config.reader import load_config, parse_config
from stickslip.config.resolve import config_path
from stickslip.errors import ConfigError


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


REFUSED = rows("refused.yaml")


@pytest.mark.parametrize("row", REFUSED, ids=[row["wrong"] for row in REFUSED])
def test_what_cannot_be_is_refused_with_its_place_and_what_is_allowed(row, monkeypatch):
    monkeypatch.setattr(sections, "own_names", tuple)  # laws that other tests have registered
    text = MEASURED_FORM if "of" in row else GOOD
    for number, others in sorted(row["lines"].items(), reverse=True):
        text = with_line(number, *([others] if isinstance(others, str) else others), text=text)
    assert re.fullmatch(".*".join(map(re.escape, row["said"].split("…"))), message(text))


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
