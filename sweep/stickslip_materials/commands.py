"""`fit`, `compare` and `points`: friction curves and ageing from measured points, ranks, and points from records."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import save_page, save_plot, save_result, save_table, show_result
from stickslip.cli.screen import JSON, Answer, refuses_bad_input, reports_errors
from stickslip.errors import UnitWarning
from stickslip.vocabulary.models import CURVE_LAWS

if TYPE_CHECKING:
    from stickslip_materials.fit import MaterialFit

_AT = "300"  # s
_SEVERAL = partial(click.option, multiple=True)


def _columns(command: params.Command) -> params.Command:
    """The options that say what the columns of a table are; `_choice` and `_fits` ask for them."""
    option = screen.remembered_option
    return params.decorated(
        command,
        option("--unit", metavar="UNIT", help="Of the speeds or times, such as mm/s, where a header names none."),
        option("--speed-column", metavar="NAME", help="Heading of the column of speeds, if it is none of the usual."),
        option("--friction-column", metavar="NAME", multiple=True,
               help="Heading of a column of friction coefficients; several give a fit each."),
    )  # fmt: skip


def _fits(files: Sequence[Path], load: str | None, **how: Any) -> list[MaterialFit]:
    """The fits of files, or of those that come with the package, and what their columns were taken for on screen; of
    files alike once. load : by which friction forces are divided. how : as for `fit_materials`."""
    from stickslip_materials.fit import Wanted, fit_materials
    from stickslip_materials.fit.files import describe_columns

    unit, speed, time = (screen.remembered(name) or "" for name in ("unit", "speed_column", "time_column"))
    wanted = Wanted(unit, speed, time, screen.remembered("friction_column"), load)
    fits = fit_materials([params.points_file(file) for file in files], wanted, **how)
    of_file: dict[str, list[MaterialFit]] = {}
    for each in fits:
        of_file.setdefault(str(each.path), []).append(each)
    alike: dict[str, list[str]] = {}
    for path, parts in of_file.items():
        alike.setdefault(describe_columns(parts), []).append(path)
    for text, paths in alike.items():
        screen.echo(f"{', '.join(paths)}: {text}\n")
    return fits


@click.command(
    epilog="""\b
Examples:
  stickslip fit configs/measured/dry.csv --plot dry.png    # columns: speed [mm/s], mu
  stickslip fit configs/measured/table.csv       # with several columns of friction: a fit of each
  stickslip fit configs/measured/dry.csv --law best        # of all laws that one fits best (AICc)
  stickslip fit bare.csv --unit mm/s                       # yours; columns: speed, mu
  stickslip fit odd.csv --speed-column "Motor 1" --friction-column "Signal B"
  stickslip fit greaseA.csv greaseB.csv --at "5 min"       # columns: time [s], mu"""
)
@params.RECORDS
@click.option("--at", metavar="TIME", help="Hold time at which lubricants are ranked.  [default: 300]")
@_columns
@screen.remembered_option("--time-column", metavar="NAME", help="Heading of the column of waiting times.")
@click.option("--load", help='Normal load that divides friction forces, where a file names none ("10 N").')
@click.option(
    "--law",
    type=click.Choice((*CURVE_LAWS, "best")),
    default="stribeck",
    show_default=True,
    help="Of the curve; best: that of the lowest AICc. stribeck_delta is Gaussian here.",
)
@params.plot_option("Plot of points, curves and their 95 % bands.")
@JSON
@reports_errors
def fit(files: tuple[Path, ...], at: str | None, load: str | None, law: str, plot: Path | None) -> Answer:
    """Fit friction curves, or ageing.

    Points of (speed, mu) give the Stribeck curve, as YAML to paste; points of (time, mu) the growth of
    static friction with the waiting time (hold time), and several of these are ranked. Files are CSV as instruments and
    Excel write it: commas, semicolons or tabs, decimal points or commas. The header of each names columns and units; a
    table with several columns of friction, one a material, gives a fit of each.
    """
    from stickslip_materials.fit.columns import newtons

    if load is not None:
        newtons(load)  # refused before a file is read
    answer = _fit_points(_fits(files, load, law=law), at, load, plot)
    return lambda: answer | ({"plot": str(plot)} if plot else {})


def _fit_points(fits: list[MaterialFit], at: str | None, load: str | None, plot: Path | None) -> dict[str, Any]:
    """Curves and ageing, of each material."""
    from stickslip.config.grid import seconds
    from stickslip_materials.fit import files, rank

    for each in fits:
        if each.curve and (question := files.question_of(each)):
            warnings.warn(f"{each.name}: {question}", UnitWarning, stacklevel=1)
        screen.echo(f"{each.name}\n{files.describe(each)}\n")
    answer: dict[str, Any] = {"fits": [files.as_plain(each) for each in fits]}
    ageing = {each.name: each.ageing for each in fits if each.ageing}
    if len(ageing) > 1:
        order = rank(ageing, seconds(at or _AT))
        screen.echo(files.describe_ranking(order))
        names = {by: [place.name for place in getattr(order, by)] for by in ("by_level", "by_slope")}
        answer["ranking"] = {"at": order.at, **names}
    elif at is not None:
        warnings.warn("--at is not used: it ranks two tables of hold times or more", UnitWarning, stacklevel=1)
    if load is not None and not any("(--load)" in note for each in fits for note in each.points.notes):
        text = "--load is not used: no column is a friction force, or the file tells the load"
        warnings.warn(text, UnitWarning, stacklevel=1)
    if len(ageing) < len(fits):
        answer["yaml"] = files.as_yaml(fits)
        screen.echo(f"to paste into a configuration\n{answer['yaml']}")
    save_plot(lambda plots: plots.plot_fits(fits), plot)
    return answer


@click.command(
    epilog="""\b
Examples:
  stickslip compare configs/measured/dry.csv configs/measured/grease_a.csv \\
      --mass "100 g" --stiffness "5 N/mm" --load "10 N" --damping "1 N s/m" --speed "30 mm/s"
  stickslip compare configs/measured/table.csv --mass "100 g" --stiffness "5 N/mm" \\
      --load "10 N" --plot materials.png -o ranks.xlsx""",
)
@params.RECORDS
@click.option("--mass", required=True, help='Of the oscillator: kg, or with a unit ("100 g").')
@click.option("--stiffness", required=True, help='Of its spring: N/m, or with a unit ("5 N/mm").')
@click.option("--load", "normal_load", required=True, help='Normal load: N, or with a unit ("2 kN").')
@click.option("--damping", help='Of its damper: N s/m, "1 N s/m" or, of critical damping, "3 %".  [default: 0]')
@_SEVERAL("--speed", metavar="SPEED", help="Belt speed at which regime and margin are told; several, a column each; or "
          'a range ("5..60 mm/s"), in which it is to be quiet throughout.')  # fmt: skip
@_columns
@click.option("--level", type=float, default=0.95, show_default=True, help="Of confidence of the intervals.")
@click.option("--draws", type=int, default=1000, show_default=True, help="Curves drawn a material; 0: no intervals.")
@click.option("--seed", type=int, default=1, show_default=True, help="Of the draws.")
@_SEVERAL("-o", "--output", "outputs", type=params.Target("table", "result"),
          help="File to write: .csv or .xlsx (the table), .nc or .zarr (all of it); repeatable.")  # fmt: skip
@params.plot_option()
@click.option("--title", help="Of plot and page.")
@click.option("--report", type=params.Target("page"), help="Page to write (.html): ranks, plot, fits.")
@JSON
@reports_errors
def compare(
    files: tuple[Path, ...], speed: tuple[str, ...], outputs: tuple[Path, ...], plot: Path | None, title: str | None,
    report: Path | None, **options: Any,
) -> Answer:  # fmt: skip
    """Rank materials by the belt speed above which each is quiet.

    Fits a friction curve to the points of each FILE (of each column of friction in a table of several), and finds where
    the vibration that begins in stick ends for good, to nine digits, with the interval that the scatter of the points
    leaves. FILES are CSV as instruments and Excel write it; see `stickslip fit`.
    """
    from stickslip.dataset.display import with_units
    from stickslip.files.targets import KINDS
    from stickslip_materials.compare.compare import compare as compared

    fits = _fits(files, options["normal_load"], ageing=False)
    with refuses_bad_input(""), screen.progress_bar("curves", " compared") as move:
        ds = compared(fits, belt_speed=(speed[0] if len(speed) == 1 else speed) or None, progress=move, **options)
    units = (text.rpartition("..")[2].lstrip("+-.0123456789eE ").strip() for text in speed)
    if unit := next(filter(None, units), None):  # that in which the belt speeds were given
        speeds = [str(name) for name, values in ds.variables.items() if values.attrs.get("units") == "m s-1"]
        ds = with_units(ds, dict.fromkeys(speeds, unit))
    ds = ds if title is None else ds.assign_attrs(title=title)
    show_result(ds)
    for output in outputs:
        (save_table if output.suffix.lower() in KINDS["table"].suffixes else save_result)(ds, output)
    save_plot(lambda plots: plots.plot_result(ds), plot)
    if report is not None:
        save_page(ds, report)

    def for_programs() -> dict[str, Any]:
        from stickslip_materials.compare.result import Comparison
        from stickslip_materials.fit.files import columns_of

        files = {output.suffix[1:].lower(): output for output in outputs} | {"plot": plot, "report": report}
        written = {kind: str(file) for kind, file in files.items() if file is not None}
        read = {fit.name: {"file": str(fit.path), **columns_of(fit)} for fit in fits}
        return {**Comparison.answer(ds), "written": written, "read": read}

    return for_programs


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
    **columns: str,
) -> None:  # fmt: skip
    """Points of friction from a record at steps of speed and load.

    RECORD is a CSV file of a pin-on-disc or block-on-ring test: time, speed, and friction or its force. Each step gives
    a point: the mean friction behind running-in, with the standard deviation that samples which follow each other
    leave. `stickslip fit` and `stickslip compare` read what is written.
    """
    from stickslip_materials.fit import read_steps, write_points
    from stickslip_materials.fit.files import describe_steps

    length, force, time = (
        None if text is None else params.si_quantity(option, text, unit, "a value above 0", or_zero=unit == "s")
        for option, text, unit in (("--radius", radius, "m"), ("--load", load, "N"), ("--settle", settle, "s"))
    )
    steps = read_steps(record, plan, radius=length, load=force, settle=time, **columns)
    write_points(steps, output)
    screen.echo(describe_steps(steps))
    screen.echo(f"points   {output}")
