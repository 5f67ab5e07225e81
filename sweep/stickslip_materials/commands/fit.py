"""`fit` and `points`: friction curves and ageing from measured points, and points from records."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import save_plot
from stickslip.cli.screen import JSON, Answer, fail, refuses_bad_input, reports_errors
from stickslip.errors import UnitWarning
from stickslip.vocabulary.models import CURVE_LAWS

MEMORY_LAWS = ("rate_state_ageing", "rate_state_slip", "lugre")  # those of `fit/memory.py`

_AT = "300"  # s

if TYPE_CHECKING:
    from stickslip_materials.fit import MaterialFit, Wanted


def COLUMNS(command: params.Command) -> params.Command:  # noqa: N802, a decorator
    """The options that say what the columns of a table are; `column_choice` and `fit_files` ask for them."""
    option = screen.remembered_option
    return params.decorated(
        command,
        option("--unit", metavar="UNIT", help="Of the speeds or times, such as mm/s, where a header names none."),
        option("--speed-column", metavar="NAME", help="Heading of the column of speeds, if it is none of the usual."),
        option("--friction-column", metavar="NAME", multiple=True,
               help="Heading of a column of friction coefficients; several give a fit each."),
        option("--same", metavar="PATTERN", multiple=True,
               help='Names of repeats of one material ("grease A*"), which are fitted as one; repeatable.'),
    )  # fmt: skip


def column_choice(load: str | None) -> Wanted:
    """The columns that the options choose. load : by which friction forces are divided."""
    from stickslip_materials.fit import Wanted

    unit, speed, time = (screen.remembered(name) or "" for name in ("unit", "speed_column", "time_column"))
    return Wanted(unit, speed, time, screen.remembered("friction_column"), load)


@click.command(
    epilog="""\b
Examples:
  stickslip fit configs/measured/dry.csv --plot dry.png    # columns: speed [mm/s], mu
  stickslip fit configs/measured/table.csv       # with several columns of friction: a fit of each
  stickslip fit configs/measured/dry.csv --law best        # of all laws that one fits best (AICc)
  stickslip fit bare.csv --unit mm/s                       # yours; columns: speed, mu
  stickslip fit odd.csv --speed-column "Motor 1" --friction-column "Signal B"
  stickslip fit greaseA.csv greaseB.csv --at "5 min"       # columns: time [s], mu
  stickslip fit steps.csv --law rate_state_ageing          # columns: time [s], speed, mu
  stickslip fit loops.csv --law lugre --load "10 N"        # columns: displacement [um], mu"""
)
@params.RECORDS
@click.option("--at", metavar="TIME", help="Hold time at which lubricants are ranked.  [default: 300]")
@COLUMNS
@screen.remembered_option("--time-column", metavar="NAME", help="Heading of the column of waiting times.")
@click.option("--load", help='Normal load that divides friction forces, where a file names none ("10 N").')
@click.option(
    "--law",
    type=click.Choice((*CURVE_LAWS, "best", *MEMORY_LAWS)),
    default="stribeck",
    show_default=True,
    help="Of the curve; best: that of the lowest AICc. stribeck_delta is Gaussian here. rate_state_...: of a record of "
    "velocity steps and holds; lugre: contact stiffness, of small motions back and forth.",
)
@click.option("--stiffness", metavar="STIFFNESS", help='Of the drive ("20 N/um"); fitted where it is not given.')
@params.plot_option("Plot of points, curves and their 95 % bands.")
@JSON
@reports_errors
def fit(
    files: tuple[Path, ...], at: str | None, load: str | None, law: str, stiffness: str | None, plot: Path | None
) -> Answer:
    """Fit friction curves, ageing, or contacts with memory.

    Points of (speed, mu) give the Stribeck curve, as YAML to paste; points of (time, mu) the growth of
    static friction with the waiting time (hold time), and several of these are ranked. Records of velocity steps, and
    of pre-sliding loops, give contacts with memory (--law). Files are CSV as instruments and
    Excel write it: commas, semicolons or tabs, decimal points or commas. The header of each names columns and units; a
    table with several columns of friction, one a material, gives a fit of each.
    """
    from stickslip.config.grid import seconds
    from stickslip_materials.doubts import question_of_fit
    from stickslip_materials.fit import rank, report
    from stickslip_materials.fit.columns import newtons

    weight = None if load is None else newtons(load)
    if at is not None and law in MEMORY_LAWS:
        fail(f"--at ranks lubricants by their hold times, got --law {law}")
    if law in MEMORY_LAWS:
        return _fit_memory(files, law, weight, stiffness, plot)
    if stiffness is not None:
        fail(f"--stiffness goes with a law of rate-and-state friction, got --law {law}")
    if screen.remembered("same") and law != "stribeck":
        fail(f"--same goes with the law stribeck, got --law {law}")
    fits = fit_files(files, column_choice(load), law)
    for each in fits:
        if each.curve and (question := question_of_fit(each.curve.mu_start, each.points)):
            warnings.warn(f"{each.name}: {question}", UnitWarning, stacklevel=1)
    show_columns(fits)
    for each in fits:
        screen.echo(f"{each.name}\n{report.describe(each)}\n")
    answer: dict[str, Any] = {"fits": [report.as_plain(each) for each in fits]}
    ageing = {each.name: each.ageing for each in fits if each.ageing}
    if len(ageing) > 1:
        order = rank(ageing, seconds(at or _AT))
        screen.echo(report.describe_ranking(order))
        names = {by: [place.name for place in getattr(order, by)] for by in ("by_level", "by_slope")}
        answer["ranking"] = {"at": order.at, **names}
    elif at is not None:
        warnings.warn("--at is not used: it ranks two tables of hold times or more", UnitWarning, stacklevel=1)
    if load is not None and not any("(--load)" in note for each in fits for note in each.points.notes):
        text = "--load is not used: no column is a friction force, or the file tells the load"
        warnings.warn(text, UnitWarning, stacklevel=1)
    if len(ageing) < len(fits):
        answer["yaml"] = report.as_yaml(fits)
        screen.echo(f"to paste into a configuration\n{answer['yaml']}")
    save_plot(lambda plots: plots.plot_fits(fits), plot)
    return lambda: answer | ({"plot": str(plot)} if plot else {})


def _fit_memory(
    files: Sequence[Path], law: str, load: float | None, stiffness: str | None, plot: Path | None
) -> Answer:
    """Contacts with memory, of each record."""
    from stickslip_materials.fit import fit_memory_file, report

    spring = None
    if stiffness is not None:
        spring = params.si_quantity("--stiffness", stiffness, "N m-1", "a value above 0")
    fits = {}
    for file in files:
        with refuses_bad_input(file):
            fits[file.name] = fit_memory_file(params.points_file(file), law, load=load, stiffness=spring)
        screen.echo(f"{report.describe_memory(file.name, fits[file.name])}\n")
    save_plot(lambda plots: plots.plot_memory_fits(fits), plot)
    shown = ("law", "values", "interval", "residual_rms", "good", "quality")
    plain = [{"name": name} | {key: getattr(each, key) for key in shown} for name, each in fits.items()]
    return lambda: {"fits": plain} | ({"plot": str(plot)} if plot else {})


def fit_files(files: Sequence[Path], choice: Wanted, law: str = "stribeck", ageing: bool = True) -> list[MaterialFit]:
    """The fits of files, or of those that come with the package."""
    from stickslip_materials.fit import fit_materials

    paths = [params.points_file(file) for file in files]
    return fit_materials(paths, choice, same=screen.remembered("same"), law=law, ageing=ageing)


def show_columns(fits: Sequence[MaterialFit]) -> None:
    """Say what the columns of each file were taken for; of files alike once."""
    from stickslip_materials.fit import report

    of_file: dict[str, list[MaterialFit]] = {}
    for part in (part for each in fits for part in each.parts):
        of_file.setdefault(str(part.path), []).append(part)
    alike: dict[str, list[str]] = {}
    for path, parts in of_file.items():
        alike.setdefault(report.describe_columns(parts), []).append(path)
    for text, paths in alike.items():
        screen.echo(f"{', '.join(paths)}: {text}\n")


@click.command(
    epilog="""\b
Examples:
  stickslip points disc.csv -o points.csv     # columns: time, speed, force, load
  stickslip points disc.csv -o points.csv --radius "20 mm" --load "10 N"
  stickslip points cof.csv -o points.csv --plan plan.csv    # begin, end, speed, load
  stickslip fit points.csv"""
)
@click.argument("record", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=params.Target("points"), required=True, help="Table of points to write: .csv.")
@click.option("--plan", type=click.Path(path_type=Path), help="Table of steps: begin, end, speed, load.")
@click.option("--radius", metavar="LENGTH", help='Of the track ("20 mm"), where speeds are those of rotation.')
@click.option("--load", metavar="FORCE", help='Normal load ("10 N"), where no column tells it.')
@click.option("--speed-column", default="", metavar="NAME", help="Heading of the speeds, if it is none of the usual.")
@click.option("--friction-column", default="", metavar="NAME", help="Heading of friction, or of its force.")
@click.option("--settle", metavar="TIME", help="Left out at the beginning of each step.  [default: what runs in]")
@reports_errors
def points(
    record: Path, output: Path, plan: Path | None, radius: str | None, load: str | None, settle: str | None,
    speed_column: str, friction_column: str,
) -> None:  # fmt: skip
    """Points of friction from a record at steps of speed and load.

    RECORD is a CSV file of a pin-on-disc or block-on-ring test: time, speed, and friction or its force. Each step gives
    a point: the mean friction behind running-in, with the standard deviation that samples which follow each other
    leave. `stickslip fit` and `stickslip compare` read what is written.
    """
    from stickslip_materials.fit import read_steps, write_points
    from stickslip_materials.fit.report import describe_steps

    length, force, time = (
        None if text is None else params.si_quantity(option, text, unit, "a value above 0", or_zero=unit == "s")
        for option, text, unit in (("--radius", radius, "m"), ("--load", load, "N"), ("--settle", settle, "s"))
    )
    steps = read_steps(record, plan, radius=length, load=force, settle=time,
                       speed_column=speed_column, friction_column=friction_column)  # fmt: skip
    write_points(steps, output)
    screen.echo(describe_steps(steps))
    screen.echo(f"points   {output}")
