"""What is asked of studies and cannot be, in calls and in sections: named with what is allowed, before computing."""

import re

import pytest

import stickslip
from helpers.data import cases
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError

CELL = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
BOX = {"displacement": (0.0, 2.0), "velocity": (-1.0, 1.0)}
CALLS = {
    "attractors": {"box": BOX},
    "border": {"along": "belt_speed", "between": (0.01, 5.0)},
    "contours": {"axes": ("stiffness", "belt_speed"), "between": {"stiffness": (1.0, 2.0), "belt_speed": (0.1, 1.0)}},
    "margins": {"parameters": ("belt_speed", "damping")},
    "ramp": {"along": "belt_speed", "between": (0.1, 1.0)},
}
NOT_AMONG = "('mass' in it), expected a parameter that may change"


@cases("sweep.yaml")
def test_a_call_names_what_it_cannot_do_with_what_is_allowed(call, change, message):
    asked = {"cells_or_config": CELL | {"belt_speed": 0.5}} | CALLS[call]
    with pytest.raises((TypeError, ValueError), match=re.escape(message)):
        getattr(stickslip, call)(**(asked | change))


HEAD = """\
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  stiffness: {start: 1, stop: 2, num: 3}
  belt_speed: {start: 0.1, stop: 1, num: 3}
"""
OF_BOX = "attractors: {displacement: [0, 1], velocity: [0, 1]"
OF_TWO = "margins: {parameters: [belt_speed, damping]"


@cases("sweep.yaml")
def test_a_section_that_cannot_be_is_refused_with_its_place(section, message):
    with pytest.raises(ConfigError) as caught:
        parse_config(f"{HEAD}{section}\n", "my.yaml")
    assert message in str(caught.value) and "my.yaml:6" in str(caught.value)
