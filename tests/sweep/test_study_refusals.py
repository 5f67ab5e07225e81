"""What is asked of studies and cannot be, in calls and in sections: named with what is allowed, before computing."""

import re

import numpy as np
import pytest

import stickslip
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


@pytest.mark.parametrize(("call", "change", "message"), [
    ("attractors", {"box": {"displacement": (2, 0), "velocity": (0, 1)}}, "displacement: got [2, 0], "),
    ("attractors", {"box": {"displacement": (0, np.inf), "velocity": (0, 1)}}, "got [0, inf], expected a finite"),
    ("attractors", {"box": {"displacement": (0, 1)}}, "velocity: missing, expected velocities of the box"),
    ("attractors", {"box": {"displacement": (0, 1), "velocty": (0, 1)}}, "velocty: unknown key, "),
    ("attractors", {"box": None}, "box: missing"),
    ("attractors", {"box": 3}, "box: got 3"),
    ("attractors", {"samples": 48}, "samples: got 48"),
    ("attractors", {"samples": 64.5}, "samples: got 64.5"),
    ("attractors", {"seed": -1}, "seed: got -1"),
    ("border", {"along": "belt_sped"}, "along: got 'belt_sped'"),
    ("border", {"between": (np.nan, 1.0)}, "between: got [nan, 1.0], expected a finite number in m/s"),
    ("border", {"along": "mu_stop", "between": (0.5, 2.0)}, "mu_stop[0]: got 2, expected at most mu_start"),
    ("border", {"along": "damping", "between": None}, "between: missing; cells need a range of damping"),
    ("border", {"scan": 1}, "scan: got 1, expected a whole number from 2 to"),
    ("border", {"cells_or_config": {"mass": 1.0}}, "stiffness is missing"),
    ("contours", {"axes": None}, "axes: missing; cells need the names of the two parameters"),
    ("contours", {"axes": ("belt_speed", "belt_speed")}, "expected a list of the names of two different parameters"),
    ("contours", {"between": {"mass": (1, 2)}}, "between: got a range for 'mass', expected stiffness or belt_speed"),
    ("contours", {"between": {"belt_speed": (1, 2)}}, "between: missing; cells need a range of stiffness"),
    ("contours", {"points": 1}, "points: got 1, expected a whole number from 2 to"),
    ("margins", {"parameters": ()}, "parameters: got [], expected a list of different parameters"),
    ("margins", {"costs": {"mass": 1.0}}, f"costs: got {{'mass': 1.0}} {NOT_AMONG}: belt_speed or damping"),
    ("margins", {"within": {"mass": 2.0}}, f"within: got {{'mass': 2.0}} {NOT_AMONG}"),
    ("margins", {"beyond": 1.0}, "beyond: got 1.0, expected a number from 0 to 0.5"),
    ("ramp", {"along": "velocity", "between": (0, 1)}, "along: velocity is a starting state"),
    ("ramp", {"along": "belt_sped"}, "did you mean belt_speed"),
    ("ramp", {"between": (1, 0)}, "swap the ends"),
    ("ramp", {"between": None}, "between: missing"),
    ("ramp", {"points": 1}, "points: got 1, expected a whole number from 2"),
    ("ramp", {"along": "mu_stop", "between": (0.5, 2.0)}, "mu_start"),
])  # fmt: skip
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


@pytest.mark.parametrize(("section", "message"), [
    ("attractors: {displacement: [0, 1]}", "attractors.velocity: missing, expected velocities of the box"),
    ("attractors: {displacement: [1, 0], velocity: [0, 1]}", "the lower end first and the upper above it"),
    ("attractors: {displacement: [0, 1 m/s], velocity: [0, 1]}", "got [0, 1 m/s] (speed), expected a length"),
    (f"{OF_BOX}, sample: 64}}", "did you mean samples?"),
    ("attractors: {displacement: [0, 1], velocity: [0, sticking]}", "expected a"),
    ("contours: {axes: [belt_speed]}", "contours.axes: got"),
    ("contours: {axes: [belt_speed, mas]}", "did you mean mass?"),
    ("contours: {between: {damping: [0, 1]}}", "contours.between: got a range for 'damping', expected"),
    ("contours: {axes: [damping, belt_speed]}", "damping is no axis of the configuration, so it needs a range"),
    ("contours: {axes: [mu_stop, belt_speed], between: {mu_stop: [0, 2]}}", "mu_stop: got [0, 2], expected at most"),
    ("margins: {parameters: [belt_sped]}", "did you mean belt_speed?"),
    ("margins: {parameters: [belt_speed, belt_speed]}", "expected a list without repetitions"),
    (f"{OF_TWO}, within: {{damping: 0.5}}}}", "margins.within: got a mapping, expected a number above 1"),
    (f"{OF_TWO}, within: {{mass: 5}}}}", "expected a parameter that may change: belt_speed or damping"),
    (f"{OF_TWO}, within: {{belt_speed: [2, 1]}}}}", "expected the lower end first"),
    (f"{OF_TWO}, costs: {{damping: 0}}}}", "expected a number above 0"),
    (f"{OF_TWO}, into: [quiet]}}", "expected a regime: stick_slip"),
    (f"{OF_TWO}, joint: maybe}}", "margins.joint: got 'maybe', expected true or false"),
])  # fmt: skip
def test_a_section_that_cannot_be_is_refused_with_its_place(section, message):
    with pytest.raises(ConfigError) as caught:
        parse_config(f"{HEAD}{section}\n", "my.yaml")
    assert message in str(caught.value) and "my.yaml:6" in str(caught.value)
