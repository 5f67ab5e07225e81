import math
import pickle

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.checks import MOST_CELLS
from stickslip.config import ConfigError, load_config, make_config, parse_config
from stickslip.models import Range, Values
from stickslip.quantities import MEASURED, QUANTITIES
from stickslip.resources import config_names, config_path
from stickslip.rig.config import is_rig, load_rig, parse_rig
from stickslip.sections import Friction, Start, System
from stickslip.variables import LAWS, PARAMETERS

GOOD = """\
title: A map
system:
  mass: 1 kg
  stiffness: 10
  normal_load: 5 N
  belt_speed: 10 mm/s
friction:
  a1: 1
  a2: 0.1
  a3: 0.3
  a4: 0.1
"""
MEASURED_FORM = (
    GOOD[: GOOD.index("friction")]
    + """\
friction:
  mu_start: 0.4
  mu_reversal: 0.3
  v_reversal: 0.2
  a4: 0.05
"""
)


def with_line(number: int, *lines: str, text: str = GOOD) -> str:
    """`text` with one line replaced by others."""
    all_lines = text.splitlines()
    all_lines[number - 1 : number] = lines
    return "\n".join(all_lines) + "\n"


def message(text: str) -> str:
    """What is wrong with a configuration, in full."""
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "map.yaml")
    return str(caught.value)


# --- what is read -----------------------------------------------------------------------------------------------------


def test_curves_that_strengthen_from_rest_or_weaken_at_speed_are_read():
    text = with_line(9, "  a2: -0.05") + "axes: {a3: {start: -0.4, stop: 0.4, num: 9}}\n"
    config = parse_config(text.replace("  a3: 0.3\n", ""))
    assert config.friction.a2 == -0.05 and config.axes[0].start == -0.4


def test_quantities_become_si():
    config = parse_config(GOOD)
    assert (config.system.mass, config.system.belt_speed) == (1.0, 0.01)


def test_defaults_are_filled_in():
    config = parse_config(GOOD)
    assert config.system.damping == 0.0
    assert (config.friction.mu_stop, config.friction.mu_static) == ("none", "mu_start")
    assert (config.start.displacement, config.start.velocity) == (0.0, "sticking")
    assert (config.solver.rtol, config.solver.horizon, config.solver.early_stop) == (1e-6, None, True)
    assert (config.execution.threads, config.execution.block) == ("auto", 4096)
    assert config.axes == ()


def test_a_power_of_ten_without_a_point_is_a_number():
    """YAML 1.1 reads 1e-3 as a word."""
    assert parse_config(with_line(3, "  mass: 1e-3")).system.mass == 0.001


def test_axes_keep_the_order_of_the_file():
    axes = "axes:\n  damping: [0, 1]\n  displacement: {values: [1 mm, 2 mm]}\n"
    config = parse_config(GOOD + axes)
    assert config.axes == (Values(name="damping", values=(0.0, 1.0)), Values(name="displacement", values=(1e-3, 2e-3)))
    swapped = parse_config(GOOD + "axes:\n  displacement: [1 mm, 2 mm]\n  damping: [0, 1]\n")
    assert swapped != config


def test_a_varied_quantity_is_not_fixed():
    config = parse_config(with_line(6, "axes: {belt_speed: {start: 1 mm/s, stop: 1, num: 3, spacing: log}}"))
    assert config.system.belt_speed is None
    assert config.axes == (Range(name="belt_speed", spacing="log", start=0.001, stop=1.0, num=3),)


def test_words_stand_for_absent_quantities():
    config = parse_config(GOOD + "  mu_stop: none\nstart: {velocity: sticking}\naxes: {mu_static: [mu_start, 1.5]}\n")
    assert (config.friction.mu_stop, config.start.velocity) == ("none", "sticking")
    assert config.axes[0].values == ("mu_start", 1.5)


def test_a_group_varies_quantities_together():
    group = "axes:\n  oil: {zip: {damping: [0, 1 N s/m], velocity: [sticking, 2]}, labels: [thin, thick]}\n"
    (oil,) = parse_config(GOOD + group).axes
    assert oil.labels == ("thin", "thick")
    assert [(m.name, m.values) for m in oil.members] == [("damping", (0.0, 1.0)), ("velocity", ("sticking", 2.0))]


def test_sections_without_content_are_allowed():
    assert parse_config(GOOD + "start:\naxes:\nsolver:\n") == parse_config(GOOD)


def test_the_sections_own_all_quantities():
    for section, model in {"system": System, "friction": Friction, "start": Start}.items():
        assert set(model.model_fields) - {"law", "fit"} == {n for n, q in QUANTITIES.items() if q.section == section}


def test_configurations_cannot_be_changed():
    with pytest.raises(ValueError, match="frozen"):
        parse_config(GOOD).system.mass = 2.0


@pytest.mark.parametrize("name", config_names())
def test_configurations_that_ship_are_good(name):
    load, parse = (load_rig, parse_rig) if is_rig(config_path(name)) else (load_config, parse_config)
    config = load(config_path(name))
    assert parse(config.to_yaml()) == config
    assert getattr(config, "config", config).output.file == f"{name.rpartition('/')[2]}.nc"


# --- every bad input, with its message --------------------------------------------------------------------------------

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
        "  hint: remove the quotes: 1e-3 is read in kg",
    ),
    "a comma for a point": (
        GOOD + 'start: {displacement: "1,5 mm"}\n',
        "map.yaml:12:23: start.displacement: got '1,5 mm', expected a length such as '10 mm' or a number in m\n"
        "  hint: write a decimal point, not a comma: '1.5 mm'",
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
        "map.yaml:4:3: system.stifness: unknown key, expected mass, stiffness, damping, normal_load or belt_speed\n"
        "  hint: did you mean stiffness?",
    ),
    "a misspelt section": (
        with_line(1, "sistem: {}", text=GOOD),
        "map.yaml:1:1: sistem: unknown key, "
        "expected title, system, friction, start, axes, solver, execution or output\n  hint: did you mean system?",
    ),
    "a key of another section": (
        GOOD + "solver: {mu_stop: 1}\n",
        "map.yaml:12:10: solver.mu_stop: unknown key, expected rtol, horizon, max_steps or early_stop\n"
        "  hint: mu_stop belongs to friction, or to axes",
    ),
    "a misspelt axis": (
        with_line(6, "axes: {belt_sped: [1, 2]}"),
        "map.yaml:6:8: axes.belt_sped: unknown quantity, expected mass, stiffness, damping, normal_load, belt_speed, "
        "a1, a2, a3, a4, delta, mu_stop, mu_static, ageing_rate, ageing_time, displacement, velocity, contact_time, "
        "mu_start, mu_reversal or v_reversal\n"
        "  hint: did you mean belt_speed?",
    ),
    "a law nobody knows": (
        with_line(7, "friction:", "  law: coulomb"),
        "map.yaml:8:8: friction.law: got 'coulomb', expected stribeck, stribeck_delta, rational or cubic",
    ),
    "an exponent the law has not": (
        with_line(7, "friction:", "  law: rational", "  delta: 2"),
        "map.yaml:9:3: friction.delta: got an exponent with the law rational, expected none\n"
        "  hint: the law stribeck_delta has one",
    ),
    "a measured curve of another law": (
        GOOD.partition("friction")[0]
        + "friction: {law: cubic, mu_start: 1, mu_reversal: 0.8, v_reversal: 0.1, a4: 0.1}\n",
        "map.yaml:7:24: friction.mu_start: got mu_start with the law cubic, "
        "expected a1, a2, a3 and a4: this form is for the law stribeck\n"
        "map.yaml:7:37: friction.mu_reversal: got mu_reversal with the law cubic, "
        "expected a1, a2, a3 and a4: this form is for the law stribeck\n"
        "map.yaml:7:55: friction.v_reversal: got v_reversal with the law cubic, "
        "expected a1, a2, a3 and a4: this form is for the law stribeck",
    ),
    "a missing quantity": (
        with_line(4),
        "map.yaml:2:1: system.stiffness: missing, "
        "expected the spring stiffness: a stiffness such as '5 N/mm' or a number in N/m\n"
        "  hint: or vary it: axes: {stiffness: ...}",
    ),
    "a missing curve": (
        "".join(GOOD.splitlines(keepends=True)[:6]),
        "map.yaml:1:1: friction: the friction curve is missing, "
        "expected a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4",
    ),
    "half a curve": (
        with_line(9),
        "map.yaml:7:1: friction.a2: missing, expected the slope a2 of the rising branch of the Stribeck curve: "
        "a slope over speed such as '0.1 s/m' or a number in s/m\n  hint: or vary it: axes: {a2: ...}",
    ),
    "two forms of the curve": (
        GOOD + "axes: {mu_start: [1, 2]}\n",
        "map.yaml:8:3: friction.a1: got a1 besides mu_start on line 12, expected one form of the curve\n"
        "  hint: the forms are a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4\n"
        "map.yaml:9:3: friction.a2: got a2 besides mu_start on line 12, expected one form of the curve\n"
        "  hint: the forms are a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4\n"
        "map.yaml:10:3: friction.a3: got a3 besides mu_start on line 12, expected one form of the curve\n"
        "  hint: the forms are a1, a2, a3, a4, or mu_start, mu_reversal, v_reversal, a4",
    ),
    "fixed and varied": (
        GOOD + "axes: {mass: [1, 2]}\n",
        "map.yaml:12:8: axes.mass: given twice, as system.mass on line 3 already, expected once\n"
        "  hint: keep the one you mean",
    ),
    "varied twice": (
        with_line(3, text=GOOD) + "axes:\n  mass: [1, 2]\n  both: {zip: {mass: [1, 2]}}\n",
        "map.yaml:13:16: axes.both.zip.mass: given twice, as axes.mass on line 12 already, expected once\n"
        "  hint: keep the one you mean",
    ),
    "reversed bounds": (
        with_line(6, "axes: {belt_speed: {start: 0.8, stop: 10 mm/s, num: 5}}"),
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
        "map.yaml:6:8: axes.belt_speed.stop: missing, expected a list of values, or start, stop and num",
    ),
    "a number for an axis": (
        with_line(6, "axes: {belt_speed: 3}"),
        "map.yaml:6:20: axes.belt_speed: got 3, expected a list of values, or start, stop and num",
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
        with_line(6, "axes: {belt_speed: {values: [1, 2, 1000 mm/s]}}"),
        "map.yaml:6:36: axes.belt_speed.values[2]: got '1000 mm/s', expected a value that is not in the list yet\n"
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
        "  hint: sticking can stand in a list: values: [...]",
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
    "labels that are equal": (
        with_line(6, "axes: {oil: {zip: {belt_speed: [1, 2]}, labels: [a, a]}}"),
        "map.yaml:6:53: axes.oil.labels[1]: got 'a', expected a name that is not in the list yet",
    ),
    "labels that are numbers": (
        with_line(6, "axes: {oil: {zip: {belt_speed: [1, 2]}, labels: [a, 5]}}"),
        "map.yaml:6:53: axes.oil.labels[1]: got 5, expected a name\n  hint: put it in quotes",
    ),
    "too many cells": (
        with_line(3, text=with_line(6, "axes:", "  mass: {start: 1, stop: 2, num: 1000000}",
                                    "  belt_speed: {start: 1, stop: 2, num: 100000}")),
        "map.yaml:6:3: axes: got 1e+11 cells (1000000 x 100000), expected at most 1e+10\n"
        "  hint: use fewer points, or fewer axes",
    ),
    "mu_stop above mu_start": (
        GOOD + "  mu_stop: 1.4\n",
        "map.yaml:12:12: friction.mu_stop: got 1.4, expected at most mu_start = a1 + a3 = 1.3\n"
        "  hint: a contact cannot need more friction coming to rest than to break away",
    ),
    "mu_stop above mu_start in a corner of the grid": (
        with_line(8, text=GOOD) + "axes: {mu_stop: [none, 0.7, 1.2], a1: {start: 0.8, stop: 1, num: 1000000}}\n",
        "map.yaml:11:29: axes.mu_stop[2]: got 1.2, expected at most mu_start = a1 + a3 = 1.1\n"
        "  hint: a contact cannot need more friction coming to rest than to break away",
    ),
    "static friction below zero": (
        with_line(10, "  a3: -1.5") + "  mu_stop: 0.2\n",
        "map.yaml:10:7: friction.a3: got -1.5, expected at least -a1 = -1\n"
        "  hint: the curve starts at mu_start = a1 + a3, which is the static friction",
    ),
    "static friction below zero in a corner of the grid": (
        with_line(8, text=with_line(10)) + "axes: {a1: [0.2, 0.7], a3: {start: -0.5, stop: 0.1, num: 9}}\n",
        "map.yaml:10:36: axes.a3.start: got -0.5, expected at least -a1 = -0.2\n"
        "  hint: the curve starts at mu_start = a1 + a3, which is the static friction",
    ),
    "mu_static below mu_start": (
        MEASURED_FORM + "  mu_static: 0.39\n",
        "map.yaml:12:14: friction.mu_static: got 0.39, expected at least mu_start = 0.4\n"
        "  hint: the static friction is that of break-away or more; leave mu_static out for mu_start",
    ),
    "a minimum above the start": (
        with_line(9, "  mu_reversal: 0.5", text=MEASURED_FORM),
        "map.yaml:9:16: friction.mu_reversal: got 0.5, expected less than mu_start = 0.4\n"
        "  hint: a curve without a minimum is given by a1, a2, a3 and a4, with a3: 0",
    ),
    "a minimum at rest": (
        with_line(10, "  v_reversal: 0 m/s", text=MEASURED_FORM),
        "map.yaml:10:15: friction.v_reversal: got '0 m/s', expected a speed above 0 m/s",
    ),
    "a curve that would have to start below zero": (
        with_line(10, "  v_reversal: 0.02", text=MEASURED_FORM),
        "map.yaml:10:15: friction.v_reversal: got 0.02, expected more: "
        "with mu_start = 0.4, mu_reversal = 0.3, a4 = 0.05 it makes a1 = -1.22, which is below 0\n"
        "  hint: raise v_reversal or lower a4",
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
    "to the end of no horizon": (
        GOOD + "solver: {early_stop: false}\n",
        "map.yaml:12:22: solver.early_stop: got false, expected true, because no horizon is given\n"
        "  hint: add a horizon such as '100 s' to solver",
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
        "map.yaml:12:22: execution.threads: got 0, expected auto or a whole number from 1 to 4096",
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
    "a picture of unknown kind": (
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
def test_bad_input_is_explained(name):
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


def test_a_problem_of_one_section_does_not_hide_those_of_another_check():
    text = with_line(9, "  a2: oops", text=GOOD) + "  mu_stop: 2\n"
    assert "friction.a2: got 'oops'" in message(text) and "friction.mu_stop: got 2" in message(text)


def test_the_worst_point_of_a_group_is_found_jointly():
    """mu_stop 1.2 stands beside a1 = 1: only point by point is there nothing wrong."""
    group = "axes: {oil: {zip: {mu_stop: [0.7, 1.2, none], a1: [0.5, 1, 0.1]}}}\n"
    assert parse_config(with_line(8, text=GOOD) + group).axes[0].size == 3
    swapped = group.replace("[0.5, 1, 0.1]", "[1, 0.5, 0.1]")
    assert "axes.oil.zip.mu_stop[1]: got 1.2, expected at most mu_start = a1 + a3 = 0.8" in message(
        with_line(8, text=GOOD) + swapped
    )


def test_rounding_is_no_reason_to_refuse():
    """0.1 + 0.2 is above 0.3."""
    text = with_line(8, "  a1: 0.1", text=with_line(10, "  a3: 0.2", text=GOOD))
    assert parse_config(text + "  mu_static: 0.3\n").friction.mu_static == 0.3
    assert parse_config(text + "  mu_stop: 0.3\n").friction.mu_stop == 0.3


def test_checks_do_not_walk_over_cells():
    """1e10 cells are the most allowed; walking over them would take minutes."""
    axes = "".join(f"  {name}: {{start: 1, stop: 2, num: 100000}}\n" for name in ("a1", "mu_stop"))
    text = with_line(8, text=GOOD) + "axes:\n" + axes
    with pytest.raises(ConfigError, match="got 2, expected at most mu_start = a1 . a3 = 1.3"):
        parse_config(text)
    assert 100_000**2 == MOST_CELLS


# --- errors, plain data -----------------------------------------------------------------------------------------------


def test_errors_survive_pickling():
    """They travel from worker processes."""
    with pytest.raises(ConfigError) as caught:
        parse_config("title: 1\n", "map.yaml")
    copy = pickle.loads(pickle.dumps(caught.value))
    assert str(copy) == str(caught.value) and copy.problems == caught.value.problems


def test_plain_data_is_explained_without_lines():
    with pytest.raises(ConfigError, match=r"^<data>: system\.mass: got '1 m' \(length\), expected a mass"):
        make_config(parse_config(GOOD).resolved() | {"system": {"mass": "1 m", "stiffness": 1, "normal_load": 1,
                                                                "belt_speed": 1}})  # fmt: skip


def test_plain_data_may_list_values_without_a_key():
    data = parse_config(GOOD).resolved()
    data["axes"] = {"displacement": [1, 2, "1000 mm"]}
    del data["start"]["displacement"]
    with pytest.raises(
        ConfigError, match=r"^<data>: axes\.displacement\[2\]: got '1000 mm', expected a value that is not"
    ):
        make_config(data)


# --- round trip -------------------------------------------------------------------------------------------------------

above_zero = st.floats(1e-6, 1e6)
anything = st.floats(-1e6, 1e6)


def value_of(name):
    declared = QUANTITIES[name]
    if name in ("mu_stop", "mu_static"):
        return st.just({"mu_stop": "none", "mu_static": "mu_start"}[name])
    if name == "delta":
        return st.floats(1.0, 10.0)
    if name == "a3":
        return above_zero  # below zero it must fit to a1
    return anything if declared.minimum == -math.inf else above_zero


@st.composite
def data(draw):
    """A configuration as plain data: some quantities fixed, some along axes, in any order."""
    measured = draw(st.booleans())
    law = "stribeck" if measured else draw(st.sampled_from(LAWS))
    names = [n for n in PARAMETERS if not (measured and n in ("a1", "a2", "a3"))] + (list(MEASURED) if measured else [])
    if law != "stribeck_delta":
        names.remove("delta")
    varied = draw(st.lists(st.sampled_from(names), max_size=3, unique=True))
    if measured:  # values that make a curve
        varied = [n for n in varied if n != "a4" and n not in MEASURED]
    good = {"mu_start": 0.5, "mu_reversal": 0.4, "v_reversal": 0.7, "a4": 0.1} if measured else {}
    found = {"title": draw(st.text(min_size=1).filter(lambda t: t.strip() == t and t.isprintable())), "axes": {}}
    found["friction"] = {"law": law}
    for name in names:
        if name not in varied:
            value = good.get(name) or draw(value_of(name))
            found.setdefault(QUANTITIES[name].section, {})[name] = value
    for name in varied:
        found["axes"][name] = draw(axis(name))
    if draw(st.booleans()):
        found["solver"] = {"horizon": draw(above_zero), "early_stop": draw(st.booleans()), "rtol": 1e-12}
    return found


def axis(name):
    values = st.lists(value_of(name), min_size=1, max_size=4, unique=True).map(lambda v: sorted(v, key=str_last))
    ends = value_of("delta") if name == "delta" else above_zero
    start_stop = st.tuples(ends, ends).filter(lambda pair: pair[0] < pair[1] * (1 - 1e-9))
    ranges = st.builds(
        lambda ends, num, spacing: {"start": ends[0], "stop": ends[1], "num": num, "spacing": spacing},
        start_stop, st.integers(2, 100), st.sampled_from(["linear", "log"]),
    )  # fmt: skip
    return (
        values if name in ("mu_stop", "mu_static") else st.one_of(values, values.map(lambda v: {"values": v}), ranges)
    )


def str_last(value):
    return (isinstance(value, str), value)


@given(data())
@settings(max_examples=150, deadline=None)
def test_the_resolved_configuration_reads_back_as_an_equal_one(plain):
    config = make_config(plain)
    text = config.to_yaml()
    again = parse_config(text)
    assert again == config
    assert make_config(config.resolved()) == config
    assert again.to_yaml() == text
    assert [axis.name for axis in again.axes] == list(plain["axes"])


@given(st.text(max_size=200))
def test_any_text_is_a_configuration_or_explained(text):
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "map.yaml")
    assert caught.value.problems
    assert all(line.startswith(("map.yaml", "  hint: ")) for line in str(caught.value).splitlines())
