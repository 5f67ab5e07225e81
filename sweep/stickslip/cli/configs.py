"""`validate`, `init` and `help`: configurations without computing anything, and the pages of the documentation."""

from __future__ import annotations

import json
import shlex
import sys
import warnings
from pathlib import Path
from typing import Any

import click

from stickslip.cli import params, screen
from stickslip.cli.screen import DONE, JSON, WRONG_INPUT, fail, fields, is_for_programs, print_json, reports_errors
from stickslip.errors import ConfigError, Problem, dotted
from stickslip.vocabulary.quantities import or_meant


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
    for text in texts if not is_for_programs() else ():
        screen.notice(f"warning: {text}")
    screen.echo(f"{path}: valid, {computes}")
    screen.print_rows(rows, indent="  ")
    return answer | {
        "warnings": texts,
        "computes": computes,
        "understood": [dict(zip(("name", "value", "meaning"), row, strict=True)) for row in rows],
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
  stickslip init --schema > stickslip.schema.json
  stickslip init my_rig.yaml --from rig/materials"""
)
@click.argument("file", type=click.Path(path_type=Path), default="stickslip.yaml")
@click.option("--from", "name", metavar="NAME", help="Copy a configuration that comes with stickslip.")
@click.option("--list", "listing", is_flag=True, help="List the available ones, and write nothing.")
@click.option("--schema", is_flag=True, help="Print the JSON Schema of configurations, and write nothing.")
def init(file: Path, name: str | None, listing: bool, schema: bool) -> None:
    """Write a commented configuration to start from.

    FILE is stickslip.yaml unless given; a file that exists is never overwritten. With the schema editors check and
    complete the YAML: in VS Code with the YAML extension by a first line
    `# yaml-language-server: $schema=stickslip.schema.json`.
    """
    from stickslip.config.reader import command_for, is_for_what_is_installed
    from stickslip.config.resolve import config_names, config_path, starter
    from stickslip.config.yaml import read_yaml

    if schema:
        from stickslip.config.describe import json_schema

        return screen.echo(json.dumps(json_schema(), indent=2))
    if listing:
        for each, path in ((name, config_path(name)) for name in config_names()):
            if is_for_what_is_installed(path):
                screen.echo(f"stickslip {command_for(path)} {each:20} {read_yaml(path).data['title']}")
        return None
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
    return screen.echo(f"wrote {file}; next: {shlex.join(['stickslip', command, str(file)])}")


_PACKAGE = Path(__file__).resolve().parents[1]
_INSTALLED = _PACKAGE / "pages_of_docs"
_CHECKOUT = _PACKAGE.parents[1]
_WIDEST = 100  # characters of a line of prose


@click.command("help")
@click.argument("topic", required=False)
@click.pass_context
def help_command(context: click.Context, topic: str | None) -> None:
    """Read a page of the documentation here in the terminal.

    Without TOPIC it lists the pages. What a command does is said by `stickslip COMMAND --help`.
    """
    known = pages()
    if topic is None:
        width = max(map(len, known), default=0)
        screen.echo("Pages, shown by `stickslip help NAME`:\n")
        for name, page in known.items():
            screen.echo(f"  {name:{width}}  {title(page)}")
        return screen.echo(f"\nThe files are in {_folders()[0]}")
    name = Path(topic).name.removesuffix(".md")
    if name in known:
        return click.echo_via_pager(known[name].read_text(encoding="utf-8").rstrip())
    parent = context.parent
    command = parent.command.get_command(parent, topic) if parent and isinstance(parent.command, click.Group) else None
    if command is None:
        fail(f"{topic!r} is no topic{or_meant(topic, known)}\nhint: `stickslip help` lists the topics")
    screen.echo(command.get_help(click.Context(command, info_name=topic, parent=parent)))


def _folders() -> tuple[Path, Path]:
    """The folder of the pages, and that of README."""
    return (_INSTALLED, _INSTALLED) if _INSTALLED.is_dir() else (_CHECKOUT / "docs", _CHECKOUT)


def pages() -> dict[str, Path]:
    """All pages by name, README among them as `overview`; sorted. The front of the site is none."""
    folder, root = _folders()
    files = {path.stem: path for path in folder.glob("*.md") if path.stem.lower() not in ("index", "readme")}
    files["overview"] = root / "README.md"
    return {name: path for name, path in sorted(files.items()) if path.is_file()}


def title(page: Path) -> str:
    """The first heading of a page."""
    lines = page.read_text(encoding="utf-8").splitlines()
    return next((line[2:].strip() for line in lines if line.startswith("# ")), page.stem)
