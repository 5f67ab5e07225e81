"""What README and docs show works when it is copied, in a folder that is no checkout."""

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

import stickslip
from helpers.configs import write_config
from stickslip import rig
from stickslip.cli import main
from stickslip.config.yaml import parse_yaml
from stickslip.rig.records.record import write_record

ROOT = Path(__file__).resolve().parents[2]
PAGES = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))}
ELSEWHERE = "dask.md"  # its blocks need a cluster, or configure one
IN_ORDER = ("notebook.md",)  # their blocks build on each other
RIG = """\
system: {mass: 100 g, stiffness: 5 N/mm, damping: 2 N s/m, normal_load: 10 N, belt_speed: 10 mm/s}
friction: {mu_start: 0.4, mu_reversal: 0.3, v_reversal: 100 mm/s, a4: 20 mm/s}
drive: {stroke: 6 mm}
"""


def blocks(language):
    """The fenced blocks of a language, by page and number."""
    found = {}
    for name, text in PAGES.items():
        for number, match in enumerate(re.finditer(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)):
            found[f"{name} {number}"] = match[1]
    return found


def commands():
    """The lines of pages and of helps that call stickslip."""
    shown = [*PAGES.values(), *(command.epilog or "" for command in main.commands.values())]
    joined = "\n".join(shown).replace("\\\n", " ")
    return sorted(set(re.findall(r"^ {2,4}(stickslip .*)$", joined, re.MULTILINE)))


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


YAML = {name: text for name, text in blocks("yaml").items() if not name.startswith(ELSEWHERE)}
PYTHON = {name: text for name, text in blocks("python").items() if not name.startswith((ELSEWHERE, *IN_ORDER))}


def test_pages_have_blocks_to_try():
    assert {name.split()[0] for name in YAML} >= {"README.md", "rig.md", "borders.md", "uncertainty.md"}
    assert {name.split()[0] for name in PYTHON} >= {
        "README.md",
        "advise.md",
        "attractors.md",
        "borders.md",
        "rig.md",
        "runs.md",
        "uncertainty.md",
    }


@pytest.mark.parametrize("name", YAML)
def test_every_configuration_of_the_docs_is_computed(here, name):
    (here / "my.yaml").write_text(YAML[name], encoding="utf-8")
    keys = parse_yaml(YAML[name]).data
    if "system" not in keys:  # it says how measured records are read
        rig.load_settings(here / "my.yaml")
        return
    done = CliRunner().invoke(main, ["rig" if "drive" in keys else "run", "my.yaml"])
    assert done.exit_code == 0, done.output
    for file in keys["output"].values():
        assert (here / file).stat().st_size > 0


@pytest.mark.parametrize("name", PYTHON)
def test_every_python_block_of_the_docs_runs(here, name):
    """It must not raise; more is not claimed."""
    write_config(here, num=100, name="my.yaml")
    (here / "my_rig.yaml").write_text(RIG)
    (test,) = rig.RigTests(rig.load_rig("my_rig.yaml")).tests([0])
    write_record(test.record, "felt.csv")
    inputs = {"sticks": [7, 30, 68, 100, 300], "acceleration_max": [1.0, 9.0, 74.0, 90.0, 200.0],
              "acceleration_integral": [0.5, 6.0, 24.0, 40.0, 90.0]}  # fmt: skip
    exec(compile(PYTHON[name], name, "exec"), {"stickslip": stickslip, "inputs": inputs, "rpn": [2, 4, 7, 8, 9]})


@pytest.mark.parametrize("page", IN_ORDER)
def test_blocks_that_build_on_each_other_run_one_after_the_other(here, page, capsys):
    names = {}
    for name, text in blocks("python").items():
        if name.startswith(page):
            exec(compile(text, name, "exec"), names)
    shown = re.findall(r"^```\n\n```text\n(.*?)^```", PAGES[page], re.MULTILINE | re.DOTALL)
    printed = capsys.readouterr().out
    assert shown and all(text in printed for text in shown)


@pytest.mark.parametrize("line", commands())
def test_every_command_line_of_docs_and_helps_is_one(here, line):
    """Click raises where an option does not exist or an argument is missing."""
    name, *arguments = shlex.split(line.partition(" > ")[0], comments=True)[1:]
    assert main.commands[name].make_context(name, arguments).command is main.commands[name]
