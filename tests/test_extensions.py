"""An extension that lies outside the tree: found by its entry point, as `pip install` writes it."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from helpers.installed import DECLARED
from stickslip import extensions
from stickslip.cli import main
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError

TESTS = Path(__file__).parent

PACE = (TESTS / "data/pace.py").read_text(encoding="utf-8")
EXTENSION = '''
import click

from stickslip.extensions import Extension, StudyEntry


@click.command("greet")
def greet():
    """Say hello."""
    click.echo("hello from a toy")


EXTENSION = Extension(
    commands={"Toys": {"greet": "toy", "pace": "stickslip.cli.run"}},
    calls={"toy": "toy.study"},
    studies={"pace": StudyEntry("toy.study:PaceStudy", "Find how fast cells move.")},
)
'''
CONFIG = """\
system: {mass: 1, stiffness: 2, normal_load: 3}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes: {belt_speed: {start: 0.1, stop: 0.5, num: 3}, damping: [0, 0.5]}
pace: {factor: 2}
"""


@pytest.fixture
def installed(tmp_path):
    """A folder in which the toy is installed."""
    (tmp_path / "toy").mkdir()
    (tmp_path / "toy" / "__init__.py").write_text(EXTENSION, encoding="utf-8")
    (tmp_path / "toy" / "study.py").write_text(PACE, encoding="utf-8")
    about = tmp_path / "toy-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: toy\nVersion: 1.0\n", encoding="utf-8")
    (about / "entry_points.txt").write_text(f"[{extensions.GROUP}]\ntoy = toy:EXTENSION\n", encoding="utf-8")
    (tmp_path / "my.yaml").write_text(CONFIG, encoding="utf-8")
    return tmp_path


def test_a_toy_brings_commands_a_section_a_figure_and_a_python_name(installed):
    code = """
import stickslip
from click.testing import CliRunner
from stickslip.cli import main
from stickslip.config.describe import json_schema
def output(*words):
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, (words, done.output, done.exception)
    return done.output
assert "greet, pace" in output("--help") and output("greet") == "hello from a toy\\n"
assert "its numbers (factor)" in " ".join(output("pace", "--help").split()) and "pace" in json_schema()["properties"]
ds = stickslip.run("my.yaml")
assert ds["pace"].shape == (3, 2) and ds.attrs["result"] == "pace"
cell = stickslip.evaluate(ds.stickslip.cell(belt_speed=0.1, damping=0))
assert float(ds["pace"][0, 0]) == 2 * float(cell["slip_speed_max"][0])
texts = ds.stickslip.plot().findobj(lambda artist: hasattr(artist, "get_text"))
assert "a figure of its own" in [text.get_text() for text in texts]
from stickslip.toy import PaceStudy
assert stickslip.toy.PaceStudy is PaceStudy
"""
    paths = os.environ | {"PYTHONPATH": os.pathsep.join([str(installed), *sys.path])}
    done = subprocess.run([sys.executable, "-c", code], env=paths, cwd=installed, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_an_extension_whose_package_was_taken_away_is_left_out(monkeypatch):
    class Gone:
        name, module = "gone", "stickslip_gone.extension"

        def load(self):
            raise ModuleNotFoundError("No module named 'stickslip_gone'", name="stickslip_gone")

    monkeypatch.setattr(extensions, "entry_points", lambda group: [Gone()])
    assert extensions.named.__wrapped__() == {}


def test_an_extension_that_lacks_what_it_imports_says_so(monkeypatch):
    class Broken:
        name, module = "broken", "toy.extension"

        def load(self):
            raise ModuleNotFoundError("No module named 'nothing'", name="nothing")

    monkeypatch.setattr(extensions, "entry_points", lambda group: [Broken()])
    with pytest.raises(ModuleNotFoundError, match="nothing"):
        extensions.named.__wrapped__()


# --- the tests of the engine ------------------------------------------------------------------------------------------


def extension_names(text, helpers=()):
    """What a module names of extensions: imports, attributes, and module paths and code in strings.

    helpers : modules of `helpers` that are about extensions, which it may not import either.
    """
    packages = [place.partition(".")[0] for place in DECLARED.values()]
    calls = [name if "." in name else rf"stickslip(?:\.| import ){name}" for name in extensions.brought("calls")]
    pattern = re.compile(rf"\b(?:{'|'.join([*packages, *calls, *(f'helpers.{name}' for name in helpers)])})\b")
    texts = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            texts += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            texts += [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Attribute):
            texts.append(ast.unparse(node))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            texts.append(node.value)
    return [found[0] for found in map(pattern.search, texts) if found]


@pytest.mark.parametrize("room", ["sweep", "kernels"])
def test_no_test_of_the_engine_names_an_extension(room):
    """With the folders of extensions and their tests deleted, those of the engine pass."""
    helpers = [path.stem for path in (TESTS / "helpers").glob("*.py") if extension_names(path.read_text("utf-8"))]
    named = {str(path): extension_names(path.read_text("utf-8"), helpers) for path in (TESTS / room).rglob("*.py")}
    assert len(named) > 20 and {path: names for path, names in named.items() if names} == {}


def test_without_an_extension_for_points_configurations_that_need_one_are_neither_listed_nor_read(monkeypatch):
    with_all = CliRunner().invoke(main, ["init", "--list"]).stdout
    monkeypatch.setattr(extensions, "named", dict)
    listed = CliRunner().invoke(main, ["init", "--list"]).stdout
    gone = {line.split()[2] for line in set(with_all.splitlines()) - set(listed.splitlines())}
    assert gone == {"goal", "materials", "table"} and "quickstart" in listed
    text = "system: {mass: 1, stiffness: 2, normal_load: 3}\nfriction: {fit: dry.csv}\naxes: {belt_speed: [1, 2]}\n"
    with pytest.raises(ConfigError, match=r"<text>:2:11: friction: nothing that is installed reads the points to fit"):
        parse_config(text)
