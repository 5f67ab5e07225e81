"""Configurations of rigs: every mistake is explained where it stands."""

from functools import partial
from pathlib import Path

import pytest

from helpers.commands import call
from helpers.data import cases
from helpers.rig_cases import rig
from stickslip.config.grid import build_grid
from stickslip.config.reader import command_for, load_config, parse_config
from stickslip.errors import ConfigError
from stickslip_rig.api import load_rig
from stickslip_rig.sections import MOST_TESTS, sections_of

SYSTEM = "system: {mass: 100 g, stiffness: 5 N/mm, damping: 2 N s/m, normal_load: 10 N, belt_speed: 10 mm/s}\n"
FRICTION = "friction: {a1: 0.28, a2: 0, a3: 0.12, a4: 20 mm/s}\n"
DRIVE = "drive:\n  stroke: 20 mm\n"  # lines 3 and 4
TEXT = SYSTEM + FRICTION + DRIVE
MAP = SYSTEM.replace("stiffness: 5 N/mm, ", "") + FRICTION
STIFFNESS = "axes: {stiffness: [1 N/mm, 2 N/mm]}\n"
parse_rig = partial(parse_config, apart="drive")
CONFIGS = Path(__file__).parents[2] / "configs" / "rig"


def refused(text, read=parse_rig):
    """What is said of a text, by its lines."""
    with pytest.raises(ConfigError) as caught:
        read(text, "my.yaml")
    return str(caught.value).splitlines()


@cases("rig.yaml")
def test_what_is_wrong_is_said_once_with_its_line_and_its_key(more, expected):
    lines = refused(TEXT + more)
    assert lines[0].startswith(expected)
    assert [line for line in lines[1:] if not line.startswith("  hint: ")] == []


@pytest.mark.parametrize("speed", ["0", "-10 mm/s"])
def test_the_speed_of_the_drive_is_above_zero(speed):
    (line, _) = refused(TEXT.replace("10 mm/s}\nf", f"{speed}}}\nf"))
    assert "system.belt_speed" in line and "expected a speed above 0 m/s, that of the drive" in line
    (line, _) = refused(TEXT.replace(", belt_speed: 10 mm/s", "") + f"axes: {{belt_speed: [{speed}, 1 m/s]}}\n")
    assert line.startswith("my.yaml:5:21: axes.belt_speed[0]: got ")


def test_a_rig_is_no_map_and_a_map_no_rig(tmp_path):
    (line, hint) = refused(MAP + STIFFNESS)
    assert "drive: missing" in line and "stickslip run" in hint
    (tmp_path / "rig.yaml").write_text(MAP + DRIVE + STIFFNESS)
    with pytest.raises(ConfigError) as caught:
        load_config(tmp_path / "rig.yaml")
    message = "rig.yaml:3:1: drive: expected no drive in a map\n  hint: stickslip rig computes what has one"
    assert message in str(caught.value)
    assert command_for(tmp_path / "rig.yaml") == "rig" and load_rig(tmp_path / "rig.yaml")
    (tmp_path / "map.yaml").write_text(MAP + STIFFNESS)
    assert command_for(tmp_path / "map.yaml") == "run"
    assert load_config(tmp_path / "map.yaml").study is None and load_config(tmp_path / "map.yaml").beside == {}


@pytest.mark.parametrize("axis", ["stroke: [1 mm, 2 mm]", "g: {zip: {stroke: [1 mm, 2 mm]}}"])
def test_a_map_has_no_drive_to_vary(axis):
    (line, _) = refused(MAP.replace("mass", "stiffness: 1, mass") + f"axes: {{{axis}}}\n", parse_config)
    assert line.endswith("stroke belongs to drive, which a map has not")


def test_too_many_tests_are_refused_at_once():
    text = TEXT.replace("normal_load: 10 N, ", "").replace("damping: 2 N s/m, ", "")
    text += "axes:\n  normal_load: {start: 1, stop: 2, num: 1000}\n  damping: {start: 1, stop: 2, num: 1001}\n"
    (line, _) = refused(text)
    assert line == f"my.yaml:6:3: axes: got 1,001,000 tests, expected at most {MOST_TESTS:,}"


def test_quantities_of_the_drive_vary_as_all_others_do():
    text = SYSTEM.replace(", belt_speed: 10 mm/s", "") + FRICTION
    text += """drive: {strokes: 2}
axes:
  dwell: [0, 1 s]
  speed: {labels: [slow, fast], zip: {belt_speed: [5 mm/s, 10 mm/s], stroke: [2 mm, 20 mm]}}
  waiting_time: {start: 1 s, stop: 100 s, num: 3, spacing: log}
"""
    made = parse_rig(text)
    grid = build_grid(made)
    assert grid.dims == ("dwell", "speed", "waiting_time") and grid.shape == (2, 2, 3)
    cells = grid[:]
    assert cells["dwell"].tolist() == [0.0] * 6 + [1.0] * 6
    assert cells["stroke"].tolist() == [0.002] * 3 + [0.02] * 3 + [0.002] * 3 + [0.02] * 3
    assert cells["waiting_time"][:3] == pytest.approx([1, 10, 100])
    assert cells["ramp"].tolist() == [0.02] * 12


def test_everything_of_a_rig_reads_back_equal_when_resolved():
    made = rig(
        title="Felt: µ", features={"bandwidth": 100.0, "subtract_offset": True}, risk={"base": 2.0},
        axes={"g": {"labels": ["a", "b"], "zip": {"mu_stop": ["none", 0.1], "stiffness": [1.0, 2.0]}}},
        system={"stiffness": None}, drive={"profile": "sine", "ramp": None},
        sensor={"bandwidth": 800.0, "force_noise": 0.1, "seed": 7}, solver={"max_steps": 1e5},
    )  # fmt: skip
    assert parse_rig(made.to_yaml()) == made
    _, _, features, risk = sections_of(made)
    assert features.bandwidth == 100.0 and risk.base == 2.0 and features.subtract_offset


@pytest.mark.parametrize(
    ("waiting_time", "noise", "bandwidth"),
    [(1e30, 0, 300), (1, 1e308, 300), (1, 0, 1e-300), (1e12, 0, 300), (1, 0, 1e-9)],
)
def test_more_noise_than_there_is_force_or_a_bandwidth_of_nothing_is_refused(tmp_path, waiting_time, noise, bandwidth):
    text = f"{TEXT}  waiting_time: {waiting_time}\nsensor: {{force_noise: {noise}, bandwidth: {bandwidth}}}\n"
    (tmp_path / "rig.yaml").write_text(text)
    done = call("rig", "run", tmp_path / "rig.yaml")
    assert done.exit_code == 2 and "expected" in done.stderr, (done.output, done.exception)
