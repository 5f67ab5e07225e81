"""`validate`, `init`: configurations without computing anything; `simulate`, `advise`: one cell; and `help`."""

from __future__ import annotations

import json
import shlex
import sys
import warnings
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import save_plot, save_result, show_result
from stickslip.cli.screen import (
    DONE,
    JSON,
    WRONG_INPUT,
    fail,
    fields,
    is_for_programs,
    print_json,
    refuses_bad_input,
    reports_errors,
)
from stickslip.errors import ConfigError, Problem, dotted
from stickslip.vocabulary.display_units import quantity
from stickslip.vocabulary.quantities import (
    REGIME_MESSAGES,
    REGIMES,
    STATUS_MESSAGES,
    STATUSES,
    UNDECIDED,
    VARIABLES,
    flag_label,
    or_meant,
)

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location

_LABELS = {  # by variable, in the order of the rows
    "frequency": "frequency", "period": "period", "stick_fraction": "sticking", "displacement_amplitude": "amplitude",
    "velocity_amplitude": "velocity amplitude", "spring_force_max": "peak spring force",
    "spring_force_min": "least spring force", "acceleration_max": "peak acceleration",
    "slip_speed_max": "peak slip speed", "breakaway_time": "first break-away", "settling_time": "settling time",
    "settled_displacement": "settles at", "damping_ratio": "damping ratio",
    "critical_stiffness": "critical stiffness",
}  # fmt: skip
_OF_CYCLES = ("displacement_amplitude", "velocity_amplitude")  # 0 elsewhere, which says nothing
_FORCES = ("spring_force_max", "spring_force_min")
_ROUNDING = 1e-9  # of the largest force; less is none


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


# --- one cell, in words and over time ---------------------------------------------------------------------------------


@click.command(
    epilog="""\b
Examples:
  stickslip simulate configs/quickstart.yaml --at stiffness="5 N/mm" --at belt_speed="20 mm/s"
  stickslip simulate configs/quickstart.yaml \\
      --at stiffness="5 N/m" --at belt_speed="10 cm/s" -t "1 min" -o trace.nc
  stickslip simulate configs/lubricants.yaml \\
      --at lubricant=grease --at belt_speed=0.1 --plot trace.png"""
)
@params.CONFIG
@params.AT
@click.option(
    "-t", "--duration", metavar="TIME",
    help='How long: seconds, or with a unit ("2 min").  [default: eight cycles, or until it has settled]',
)  # fmt: skip
@params.OUTPUT
@params.plot_option()
@JSON
@reports_errors
def simulate(
    config: Location, at: tuple[str, ...], duration: str | None, output: Location | None,
    plot: Path | None,
) -> dict[str, Any]:  # fmt: skip
    """Compute one cell of a configuration, over time.

    CONFIG is a YAML file, or a result (.nc, .zarr), which holds its configuration. The axes need a value each (--at);
    everything else is as in the file. Says the regime, the frequency, the forces and more; -o writes the motion over
    time, --plot draws it.
    """
    from stickslip.api import cells
    from stickslip.config.grid import cell_of, config_at, seconds
    from stickslip.dataset.display import with_units
    from stickslip.vocabulary.quantities import QUANTITIES

    loaded = config_at(params.recipe_in(config), at)
    given = None if duration is None else seconds(duration)
    law, solver, cell = loaded.friction.law, loaded.solver, cell_of(loaded)
    result = cells.evaluate(cell, solver.rtol, solver.horizon, law=law, max_steps=solver.max_steps)
    span = cells.time_span(result, given)
    screen.print_rows(_rows(result))
    answer = _answer(result)
    if output is None and plot is None:
        screen.echo("over time: -o trace.nc, --plot trace.png")
        return answer
    ds = cells.simulate(
        cell, duration=span.duration, samples=span.samples, law=law, rtol=solver.rtol,
        max_steps=solver.max_steps,
    )  # fmt: skip
    ds = with_units(ds, {name: unit for name, unit in loaded.written_in.items() if name in ds.coords})
    over = ", ".join(filter(None, [quantity(span.duration, "s"), span.why]))
    save_result(ds, output, "trajectory", over)
    labels = [text for text in at if text.partition("=")[0].strip() not in QUANTITIES]
    shown = ds.assign_attrs(title=", ".join(filter(None, (loaded.title, *labels))))
    save_plot(lambda plots: plots.plot_trace(shown), plot, over if output is None else "")
    return answer | {"duration": span.duration, "output": output, "plot": plot}


def _values(result: xr.Dataset, *names: str) -> dict[str, float]:
    return {name: float(result[name].values[0]) for name in names}


def _rows(result: xr.Dataset) -> list[tuple[str, str]]:
    """Labels and values of a cell as texts; only what is finite."""
    regime, status = REGIMES[int(result["regime"].values[0])], STATUSES[int(result["status"].values[0])]
    rows = [("regime", f"{flag_label(regime)}: {REGIME_MESSAGES[regime]}"), ("", STATUS_MESSAGES[status])]
    values = _values(result, *(name for name in _LABELS if name in result))
    largest = max(abs(values[name]) for name in _FORCES)
    values |= {name: 0.0 for name in _FORCES if abs(values[name]) < _ROUNDING * largest}
    if regime not in ("stick_slip", "sustained"):
        values |= dict.fromkeys(_OF_CYCLES, nan)
    texts = {name: quantity(value, VARIABLES[name].units) for name, value in values.items() if isfinite(value)}
    if regime == "stick_slip" and "stick_fraction" in texts:
        texts["stick_fraction"] = f"{values['stick_fraction']:.1%} of the period"
    else:
        texts.pop("stick_fraction", "")
    return rows + [(_LABELS[name], text) for name, text in texts.items()]


def _answer(result: xr.Dataset) -> dict[str, Any]:
    """Every variable of the cell, in SI, flags by their names."""
    values = {name: result[name].values[0].item() for name in VARIABLES if name in result}
    return values | {"regime": REGIMES[values["regime"]], "status": STATUSES[values["status"]]}


@click.command(
    epilog="""\b
Examples:
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter belt_speed --parameter stiffness \\
      --set margins.costs.stiffness=2 --set margins.within=20
  stickslip advise configs/quickstart.yaml --at stiffness=50 --at belt_speed=0.5 \\
      --parameter mu_start --parameter v_reversal      # friction as the lever"""
)
@params.CONFIG
@params.AT
@click.option("--parameter", "parameters", multiple=True, metavar="NAME", help="What may change; may be repeated.")
@click.option("--speed-range", metavar="RANGE", help='Belt speeds to be quiet throughout, as in "5..60 mm/s".')
@click.option("--into", multiple=True, metavar="REGIME", help="Regime wanted; may be repeated.")
@params.OUTPUT
@reports_errors
def advise(
    config: Location, at: tuple[str, ...], parameters: tuple[str, ...], speed_range: str | None,
    into: tuple[str, ...], output: Location | None,
) -> None:  # fmt: skip
    """Say which changes take a cell over a border.

    CONFIG is a YAML file, or a result, which holds its configuration; the axes need a value each (--at). From a
    vibrating regime (stick_slip, sustained) borders to quiet ones (damped, creep, stuck) are looked for unless --into
    names others, from a quiet one those to vibrating ones. Every proposal is simulated 1 % past its border, and one
    that does not hold there is no cure. Costs of changes (1), and how far to look (10 times), are those of a section
    `margins` or of --set. In Python: `margins(...).stickslip.report()`.
    """
    from stickslip.api.studies import margins
    from stickslip.config.grid import config_at
    from stickslip.config.studies import section_of_call
    from stickslip.studies.changes import OPPOSITE
    from stickslip.studies.margins import Margins
    from stickslip.vocabulary.units import ends_of

    with refuses_bad_input(""):
        ends = None if speed_range is None else ends_of("--speed-range", speed_range)
        speeds = section_of_call(Margins, speed_range=ends).speeds
    if speeds and any(setting.partition("=")[0].strip() == "belt_speed" for setting in at):
        fail("--speed-range: got one and --at belt_speed, expected one of them")
    recipe = params.recipe_in(config)
    loaded = config_at(recipe, at if ends is None else (*at, f"belt_speed={ends[0]}"))
    own = getattr(recipe, "study", None)
    own = own if isinstance(own, Margins) else section_of_call(Margins)
    with refuses_bad_input(config), screen.progress_bar(doing=" searched") as move:
        ds = margins(
            loaded, parameters or None, own.costs, own.within, into=into or (OPPOSITE,), speed_range=ends,
            progress=move,
        )  # fmt: skip
    if (home := int(ds["regime"])) in UNDECIDED:
        fail(f"{config}: this cell is {flag_label(REGIMES[home])}: nothing can be said of it\nhint: raise max_steps")
    show_result(ds)
    save_result(ds, output)
