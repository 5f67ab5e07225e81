"""`validate`, `init` and `schema`: configurations, without computing anything."""

import json
import shlex
import sys
import warnings
from pathlib import Path
from typing import Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import DONE, JSON, WRONG_INPUT, fail, fields, is_for_programs, print_json, reports_errors
from stickslip.cli.outputs import plot_limits
from stickslip.errors import ConfigError, Problem, dotted


@click.command()
@click.argument("configs", type=params.PathOrUrl("configuration"), nargs=-1, required=True)
@params.SET
@JSON
@reports_errors
def validate(configs: tuple[Path, ...]) -> None:
    """Check configurations without computing anything.

    Every mistake of every file is listed, with its line and column. For valid ones it shows what was understood: every
    quantity in SI and in customary units, what they come to (natural frequency, static deflection), every axis with
    its points. Values that are legal and implausible are asked about.
    """
    answers = [_validated(path) for path in map(params.config_file, configs)]
    print_json({"files": answers})
    sys.exit(DONE if all(answer["valid"] for answer in answers) else WRONG_INPUT)


def _validated(path: Path) -> dict[str, Any]:
    """Check one configuration and print what was understood; for programs, too."""
    from stickslip.config.describe import describe
    from stickslip.config.reader import load_config
    from stickslip.runs.work import study_of

    answer: dict[str, Any] = {"file": str(path), "valid": True, "problems": []}
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            config = load_config(path, params.settings(), apart=None)
    except ConfigError as error:
        if not is_for_programs():
            screen.notice(str(error))
        return answer | {"valid": False, "problems": [_problem(problem) for problem in error.problems]}
    rows, computes = list(describe(config)), study_of(config).described()
    texts = [str(warning.message) for warning in caught]
    if config.has_cells and config.output.plot is not None and (part := plot_limits(config)):
        texts.append(f"output.plot: {part}")
    for text in texts if not is_for_programs() else ():
        screen.notice(f"warning: {text}")
    screen.echo(f"{path}: valid, {computes}")
    screen.print_rows([(row.name, row.value, row.meaning) for row in rows], indent="  ")
    return answer | {
        "warnings": texts,
        "computes": computes,
        "understood": [row._asdict() for row in rows],
        "configuration": config.resolved(),
    }


def _problem(problem: Problem) -> dict[str, Any]:
    line, column, option = problem.place or (None, None, "")
    # what an option gave has no line
    where = {"line": line or None, "column": column or None, "option": option or None, "key": dotted(problem.path)}
    return where | fields(problem, "message", "hint")


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
    from stickslip.config.examples import config_names, config_path, starter
    from stickslip.config.reader import command_for
    from stickslip.config.yaml import read_yaml

    if listing:
        for each in config_names():
            path = config_path(each)
            screen.echo(f"stickslip {command_for(path)} {each:20} {read_yaml(path).data['title']}")
        return
    text, command = starter(), "run"
    try:
        if name is not None:
            source = config_path(name)
            text, command = source.read_text(encoding="utf-8"), command_for(source)
    except FileNotFoundError as error:
        fail(f"--from: {error}")
    try:
        with file.open("x", encoding="utf-8") as target:
            target.write(text)
    except FileExistsError:
        fail(f"{file}: exists already; name another file, or remove it first")
    except OSError as error:
        fail(f"{file}: {error.strerror}")
    screen.echo(f"wrote {file}; next: {shlex.join(['stickslip', command, str(file)])}")


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
