"""`validate`, `init` and `schema`: configurations, without computing anything."""

from __future__ import annotations

import json
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli.common import DONE, SET, WRONG_INPUT, config_file, configuration, fail, settings

if TYPE_CHECKING:
    from stickslip.config.model import Config


@click.command()
@click.argument("configs", type=click.Path(path_type=Path), nargs=-1, required=True)
@SET
def validate(configs: tuple[Path, ...]) -> None:
    """Check configurations without computing anything.

    Every mistake of every file is listed, with its line and column. For valid ones it shows what was understood: every
    quantity in SI, every axis with its points.
    """
    from stickslip.errors import ConfigError
    from stickslip.rig.simulate.config import is_rig, load_rig
    from stickslip.runs.work import study_of

    wrong = False
    for path in map(config_file, configs):
        try:
            config = load_rig(path, settings()).config if is_rig(path) else configuration(path)
            click.echo(f"{path}: valid, {study_of(config).described()}")
            _show(config)
        except ConfigError as error:
            click.echo(str(error), err=True)
            wrong = True
    sys.exit(WRONG_INPUT if wrong else DONE)


def _show(config: Config) -> None:
    """What was understood, in three columns."""
    from stickslip.config.understood import understood

    rows = list(understood(config))
    name, value = (max(map(len, column)) for column in list(zip(*rows, strict=True))[:2])
    for row in rows:
        click.echo(f"  {row.name:{name}}  {row.value:{value}}  {row.meaning}".rstrip())


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
    click.echo(f"wrote {file}; next: {shlex.join(['stickslip', command, str(file)])}")


def _beginning(name: str | None) -> tuple[str, str]:
    """The text to start from, and the command that computes it."""
    from stickslip.config.examples import config_path
    from stickslip.config.starter import STARTER
    from stickslip.rig.simulate.config import is_rig

    if name is None:
        return STARTER, "run"
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
        click.echo(f"stickslip {'rig' if 'drive' in data else 'run'} {name:20} {data['title']}")


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

    click.echo(json.dumps(json_schema(), indent=2))
