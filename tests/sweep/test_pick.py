import math

import pytest

from helpers.configs import cell_at
from helpers.data import cases
from stickslip.config.grid import seconds
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError
from stickslip.vocabulary.models import STRIBECK
from stickslip.vocabulary.quantities import PARAMETERS_OF

MAP = parse_config("""
system: {mass: 1 kg, normal_load: 2}
friction: {a4: 0.1, mu_stop: none}
axes:
  stiffness: {start: 1, stop: 100, num: 3, spacing: log}
  belt_speed: [0.1, 0.2]
  pad:
    zip: {a1: [1.0, 0.9], a2: [0.1, 0.2], a3: [0.3, 0.1]}
    labels: [felt, rubber]
""")
CHOICE = ("stiffness=5 N/mm", "belt_speed=0.15", "pad=rubber")


def test_a_cell_has_every_parameter_with_the_chosen_values():
    cell = cell_at(MAP, CHOICE)
    assert list(cell) == list(PARAMETERS_OF[STRIBECK])
    assert (cell["stiffness"], cell["belt_speed"], cell["normal_load"]) == (5000.0, 0.15, 2.0)
    assert (cell["a1"], cell["a2"], cell["a3"]) == (0.9, 0.2, 0.1)
    assert math.isnan(cell["velocity"])


def test_a_group_can_be_picked_by_position():
    assert cell_at(MAP, ("stiffness=1", "belt_speed=0.1", "pad=0"))["a1"] == 1.0


def test_fixed_quantities_and_the_starting_state_can_be_changed_too():
    cell = cell_at(MAP, (*CHOICE, "mass=250 g", "velocity=0.3", "mu_stop=0.8"))
    assert (cell["mass"], cell["velocity"], cell["mu_stop"]) == (0.25, 0.3, 0.8)
    assert math.isnan(cell_at(MAP, (*CHOICE, "velocity=sticking"))["velocity"])


@cases("sweep.yaml")
def test_a_wrong_choice_is_explained(settings, message):
    with pytest.raises(ConfigError) as caught:
        cell_at(MAP, settings)
    assert message in str(caught.value)


@pytest.mark.parametrize(("text", "value"), [("20", 20.0), ("2 min", 120.0), ("5 ms", 0.005)])
def test_a_duration_is_seconds_or_has_a_unit(text, value):
    assert seconds(text) == pytest.approx(value)


@pytest.mark.parametrize("text", ["-1", "0", "1 m", "long", "inf", "nan"])
def test_a_duration_that_is_none_is_refused(text):
    with pytest.raises(ConfigError, match=f"--duration: got '{text}', expected a"):
        seconds(text)
