"""`validate`, `init` and `schema`: configurations, without computing anything."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import click

from stickslip import screen
from stickslip.cli.common import DONE, WRONG_INPUT, fail


@click.command()
@click.argument("configs", type=click.Path(path_type=Path), nargs=-1, required=True)
def validate(configs: tuple[Path, ...]) -> None:
    """Check configurations without computing anything.

    Every mistake of every file is listed, with its line and column.
    """
    from stickslip.config import load_config
    from stickslip.grid import build_grid
    from stickslip.problems import ConfigError
    from stickslip.rig.config import is_rig, load_rig

    wrong = False
    for path in configs:
        try:
            config = load_rig(path).config if is_rig(path) else load_config(path)
            click.echo(f"{path}: good, {screen.describe(build_grid(config))}")
        except ConfigError as error:
            click.echo(str(error), err=True)
            wrong = True
    sys.exit(WRONG_INPUT if wrong else DONE)


@click.command()
@click.argument("file", type=click.Path(path_type=Path), default="stickslip.yaml")
def init(file: Path) -> None:
    """Write a commented configuration to start from.

    FILE is stickslip.yaml unless given; a file that exists is never overwritten.
    """
    from stickslip.starter import STARTER

    try:
        with file.open("x", encoding="utf-8") as target:
            target.write(STARTER)
    except FileExistsError:
        fail(f"{file}: exists already; name another file, or remove it first")
    except OSError as error:
        fail(f"{file}: {error.strerror}")
    click.echo(f"wrote {file}; next: stickslip run {file}")


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
    from stickslip.schema import json_schema

    click.echo(json.dumps(json_schema(), indent=2))
