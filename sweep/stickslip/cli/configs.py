"""`validate`, `init` and `schema`: configurations, without computing anything."""

from __future__ import annotations

import json
import shlex
import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import screen, shown
from stickslip.cli.common import (
    DONE,
    JSON,
    SET,
    WRONG_INPUT,
    ConfigPath,
    config_file,
    configuration,
    fail,
    settings,
    tell_json,
)

if TYPE_CHECKING:
    from stickslip.config.describe import Row
    from stickslip.errors import Problem


@click.command()
@click.argument("configs", type=ConfigPath(), nargs=-1, required=True)
@SET
@JSON
def validate(configs: tuple[Path, ...], as_json: bool) -> None:
    """Check configurations without computing anything.

    Every mistake of every file is listed, with its line and column. For valid ones it shows what was understood: every
    quantity in SI and in customary units, what they come to (natural frequency, static deflection), every axis with
    its points. Values that are legal and implausible are asked about.
    """
    from stickslip.config.describe import describe
    from stickslip.errors import ConfigError
    from stickslip.rig.config import is_rig, load_rig
    from stickslip.runs.work import study_of

    answers = []
    for path in map(config_file, configs):
        answer: dict[str, Any] = {"file": str(path), "valid": True, "problems": []}
        answers.append(answer)
        try:
            with warnings.catch_warnings(record=True) as asked:
                warnings.simplefilter("always")
                config = load_rig(path, settings()).config if is_rig(path) else configuration(path)
        except ConfigError as error:
            answer |= {"valid": False, "problems": [_problem(problem) for problem in error.problems]}
            if not as_json:
                screen.echo(str(error), err=True)
            continue
        rows = list(describe(config))
        answer["warnings"] = [str(warning.message) for warning in asked]
        if not is_rig(path) and config.output.plot is not None and (part := shown.will_be_drawn(config)):
            answer["warnings"].append(f"output.plot: {part}")
        answer["computes"] = study_of(config).described()
        answer["understood"] = [row._asdict() for row in rows]
        answer["configuration"] = config.resolved()
        if not as_json:
            for text in answer["warnings"]:
                screen.echo(f"warning: {text}", err=True)
            screen.echo(f"{path}: valid, {answer['computes']}")
            _show(rows)
    if as_json:
        tell_json({"files": answers})
    sys.exit(DONE if all(answer["valid"] for answer in answers) else WRONG_INPUT)


def _problem(problem: Problem) -> dict[str, Any]:
    """A problem for programs."""
    from stickslip.errors import dotted

    line, column, option = problem.place or (None, None, "")
    return {
        "line": line or None,  # what an option gave has none
        "column": column or None,
        "option": option or None,
        "key": dotted(problem.path),
        "message": problem.message,
        "hint": problem.hint,
    }


def _show(rows: list[Row]) -> None:
    """What was understood, in three columns."""
    name, value = (max(map(len, column)) for column in list(zip(*rows, strict=True))[:2])
    for row in rows:
        screen.echo(f"  {row.name:{name}}  {row.value:{value}}  {row.meaning}".rstrip())


@click.command(
    epilog="""\b
Examples:
  stickslip init my.yaml
  stickslip init --list
  stickslip init my_rig.yaml --from rig/materials"""
)
@click.argument("file", type=click.Path(path_type=Path), default="stickslip.yaml")
@click.option("--from", "name", metavar="NAME", help="Copy a configuration that comes with stickslip.")
@click.option("--list", "listing", is_flag=True, help="List the available ones, and write nothing.")
def init(file: Path, name: str | None, listing: bool) -> None:
    """Write a commented configuration to start from.

    FILE is stickslip.yaml unless given; a file that exists is never overwritten.
    """
    if listing:
        return _list()
    text, command = _beginning(name)
    try:
        with file.open("x", encoding="utf-8") as target:
            target.write(text)
    except FileExistsError:
        fail(f"{file}: exists already; name another file, or remove it first")
    except OSError as error:
        fail(f"{file}: {error.strerror}")
    screen.echo(f"wrote {file}; next: {shlex.join(['stickslip', command, str(file)])}")


def _beginning(name: str | None) -> tuple[str, str]:
    """The text to start from, and the command that computes it."""
    from stickslip.config.examples import config_path
    from stickslip.config.template import TEMPLATE
    from stickslip.rig.config import is_rig

    if name is None:
        return TEMPLATE, "run"
    try:
        source = config_path(name)
    except FileNotFoundError as error:
        fail(f"--from: {error}")
    return source.read_text(encoding="utf-8"), "rig" if is_rig(source) else "run"


def _list() -> None:
    """The configurations that come with the package, by the command that computes them."""
    from stickslip.config.examples import config_names, config_path
    from stickslip.config.yaml import read_yaml

    for name in config_names():
        data = read_yaml(config_path(name)).data
        screen.echo(f"stickslip {'rig' if 'drive' in data else 'run'} {name:20} {data['title']}")


@click.command()
def schema() -> None:
    """Print the JSON Schema of configurations.

    It lets editors check and complete the YAML.

    \b
    In VS Code with the YAML extension:
      stickslip schema > stickslip.schema.json
    and as first line of a configuration
      # yaml-language-server: $schema=stickslip.schema.json
    """
    from stickslip.config.schema import json_schema

    screen.echo(json.dumps(json_schema(), indent=2))
