"""The command as a stranger meets it: groups, old spellings, files named by mistake, completion, the screen."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from helpers.commands import call, commands_of, completed
from helpers.configs import write_config
from stickslip import extensions
from stickslip.cli import SECTIONS, configs

ROOT = Path(__file__).parents[2]


# --- groups -----------------------------------------------------------------------------------------------------------


def test_help_lists_every_command_once_those_of_extensions_under_its_name():
    lines = [line.strip() for line in call("--help").stdout.splitlines()]
    (first, begin), *others = SECTIONS.items()
    shown = [line.split()[0] for line in lines[lines.index(f"{first}:") + 1 :][: len(begin)]]
    for heading, names in (*others, *extensions.commands()):
        (line,) = (line for line in lines if re.fullmatch(rf"{heading}  +{', '.join(names)}", line))
        shown += names
    assert shown == [name for name in commands_of() if " " not in name] and len({*shown}) == len(shown)


# --- what is named by mistake -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["run", "plan", "validate", "simulate"])
def test_without_a_file_the_ones_here_are_named(here, command):
    write_config(here)
    done = call(command)
    assert done.exit_code == 2 and "Configurations in this folder: small.yaml" in done.stderr


@pytest.mark.parametrize("command", ["plot", "inspect"])
def test_without_a_result_the_ones_here_are_named(here, command):
    assert "No result" in call(command).stderr
    (here / "map.nc").write_bytes(b"")
    assert "Results in this folder: map.nc" in call(command).stderr


KINDS = {  # by name: the first bytes, what it is called, and the hint
    "map.nc": (b"\x89HDF\r\n\x1a\n", "a netCDF file", "stickslip plot"),
    "points.xlsx": (b"PK\x03\x04", "an Excel workbook", "save the sheet as CSV"),
    "points.csv": (b"speed,mu\n1,2\n", "a table", "stickslip fit points.csv"),
    "map.png": (b"\x89PNG\r\n", "a plot", ""),
}


@pytest.mark.parametrize("name", KINDS)
def test_another_file_than_a_configuration_is_recognised(here, name):
    begins, what, hint = KINDS[name]
    (here / name).write_bytes(begins)
    for command in ("run", "validate", "plan"):
        done = call(command, name)
        assert done.exit_code == 2
        assert f"{name}: this is {what}, expected a configuration in YAML" in done.stderr and hint in done.stderr


def test_another_file_than_a_result_is_recognised(here):
    write_config(here)
    (here / "points.xlsx").write_bytes(b"PK\x03\x04")
    (here / "folder").mkdir()
    (here / "folder" / "map.nc").write_bytes(b"")
    (here / "map.nc.parts").mkdir()
    for name, what in (
        ("small.yaml", "a configuration, expected a result (.nc or .zarr)\nhint: `stickslip run small.yaml`"),
        ("points.xlsx", "an Excel workbook"),
        ("folder", "a folder, expected a result (.nc or .zarr)\nhint: folder holds map.nc"),
        (
            "map.nc.parts",
            "the working store of a run, expected a result (.nc or .zarr)\nhint: `stickslip status map.nc",
        ),
    ):
        for command in ("plot", "inspect"):
            done = call(command, name)
            assert done.exit_code == 2 and f"{name}: this is {what}" in done.stderr


def test_a_name_like_that_of_a_configuration_that_ships_is_proposed(here):
    assert "`stickslip init --list` names those that come" in call("run", "quikstart").stderr
    assert "did you mean quickstart?" in call("init", "--from", "quikstart").stderr


# --- validate ---------------------------------------------------------------------------------------------------------


def test_validate_answers_programs(here):
    write_config(here)
    (here / "bad.yaml").write_text("system: {mass: 1,5 kg}\n")
    (here / "odd.yaml").write_text((here / "small.yaml").read_text().replace("a4: 0.1", "a4: 20"))
    done = call("validate", "small.yaml", "bad.yaml", "odd.yaml", "--json")
    good, bad, odd = json.loads(done.stdout)["files"]
    assert done.exit_code == 2 and done.stderr == ""
    assert good["valid"] and good["configuration"]["system"]["mass"] == 1.0 and good["warnings"] == []
    a4 = next(row for row in good["understood"] if row["name"] == "a4")
    assert a4["value"] == "0.1 m/s  (100 mm/s)"
    assert not bad["valid"] and bad["problems"][0]["line"] == 1
    assert "did you mean 20 mm/s?" in odd["warnings"][0]


# --- help -------------------------------------------------------------------------------------------------------------


def test_help_lists_pages_and_shows_each():
    listed = call("help").stdout
    for name in configs.pages():
        assert re.search(rf"^  {name}  +\S", listed, re.MULTILINE)
        shown = call("help", name)
        assert shown.exit_code == 0 and len(shown.stdout) > 100


@pytest.mark.parametrize(("word", "said"), [
    ("run", "Usage: "), ("rig", "# The test rig"), ("docs/rig.md", "# The test rig"),
    ("overview", "# stickslip"),
])  # fmt: skip
def test_help_takes_pages_and_commands(word, said):
    done = call("help", *word.split())
    assert done.exit_code == 0 and said in done.stdout


def test_messages_name_topics_that_there_are_and_others_get_the_nearest():
    """Whatever the package says about `stickslip help TOPIC`."""
    named = set()
    for path in (ROOT / "sweep").rglob("*.py"):
        named |= set(re.findall(r"`stickslip help ([a-z_]+)`", path.read_text(encoding="utf-8")))
    assert named and all(call("help", topic).exit_code == 0 for topic in named), named
    done = call("help", "glosary")
    assert done.exit_code == 2 and "did you mean glossary?" in done.stderr


# --- completion and the screen ----------------------------------------------------------------------------------------


def test_commands_and_options_are_completed():
    assert completed([], "ru") == ["run"]
    assert "--plot" in completed(["run"], "--p")


def test_without_colour_nothing_is_bold():
    """A terminal is imitated, since pipes never get escapes."""
    pytest.importorskip("pty", reason="no pseudo-terminals on Windows")
    from stickslip.cli import screen

    code = (
        "from stickslip.cli import screen; from rich.table import Table\n"
        "console = screen.terminal(); console.print('[bold]x[/]', Table('a', header_style='bold'))"
    )
    assert "\x1b[" in on_terminal(code, {}) and "\x1b[" not in on_terminal(code, {"NO_COLOR": "1"})
    assert screen.terminal().width >= 1000


def on_terminal(code, variables, columns=80):
    """What a program prints to a terminal of that width."""
    import pty

    reading, writing = pty.openpty()
    environment = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR")} | variables
    environment |= {"PYTHONPATH": str(ROOT / "sweep"), "TERM": "xterm", "COLUMNS": str(columns)}
    subprocess.run([sys.executable, "-c", code], stdout=writing, env=environment, check=True)
    os.close(writing)
    said = b""
    try:
        while part := os.read(reading, 65536):
            said += part
    except OSError:  # the other end is closed
        pass
    os.close(reading)
    return said.decode()
