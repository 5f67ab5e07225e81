"""`fit`: measured points."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import screen
from stickslip.cli.common import JSON, Target, fail, points_file, reports_wrong_input, tell_json
from stickslip.vocabulary.laws import LAWS

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from stickslip.fit import MaterialFit, Wanted

_COLUMNS = (
    click.option("--unit", metavar="UNIT", help="Of the speeds or times, such as mm/s, where a header names none."),
    click.option("--speed-column", metavar="NAME", help="Heading of the column of speeds, if it is none of the usual."),
    click.option("--friction-column", metavar="NAME", multiple=True,
                 help="Heading of a column of friction coefficients; several give a fit each."),
    click.option("--same", metavar="PATTERN", multiple=True,
                 help='Names of repeats of one material ("grease A*"), which are fitted as one; repeatable.'),
)  # fmt: skip
POINTS = click.argument("files", type=click.Path(path_type=Path), nargs=-1, required=True)


def columns(command: Callable[..., None]) -> Callable[..., None]:
    """The options that say what the columns of a table are."""
    for option in reversed(_COLUMNS):
        command = option(command)
    return command


def wanted_of(
    unit: str | None, speed_column: str | None, friction_column: tuple[str, ...], time_column: str | None = None,
    load: str | None = None,
) -> Wanted:  # fmt: skip
    """What these options say."""
    from stickslip.fit import Wanted

    return Wanted(unit or "", speed_column or "", time_column or "", friction_column, load)


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
@POINTS
@click.option(
    "--at", default="300", metavar="TIME", show_default=True, help="Hold time at which lubricants are ranked."
)
@columns
@click.option("--time-column", metavar="NAME", help="Heading of the column of waiting times.")
@click.option("--load", help='Normal load that divides friction forces, where a file names none ("10 N").')
@click.option(
    "--law",
    type=click.Choice((*LAWS, "best")),
    default="stribeck",
    show_default=True,
    help="Of the curve; best: that of the lowest AICc. stribeck_delta is Gaussian here.",
)
@click.option("--plot", type=Target("plot"), help="Plot of points, curves and their 95 % bands.")
@JSON
@reports_wrong_input
def fit(
    files: tuple[Path, ...], at: str, unit: str | None, speed_column: str | None, friction_column: tuple[str, ...],
    same: tuple[str, ...], time_column: str | None, load: str | None, law: str, plot: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Fit friction curves, or ageing, to measured points.

    Points of (speed, mu) give a1 to a4 of the Stribeck curve, as YAML to paste; points of (time, mu) the growth of
    static friction with the waiting time (hold time), and several of these are ranked. Files are CSV as instruments and
    Excel write it: commas, semicolons or tabs, decimal points or commas. The header of each names columns and units; a
    table with several columns of friction, one a material, gives a fit of each.
    """
    from stickslip.config.select import seconds
    from stickslip.config.unit_warnings import friction_question_of_fit
    from stickslip.errors import UnitWarning
    from stickslip.fit import report
    from stickslip.fit.columns import newtons

    if load is not None:
        newtons(load)
    if same and law != "stribeck":
        fail(f"--same goes with the law stribeck, got --law {law}")
    wanted = wanted_of(unit, speed_column, friction_column, time_column, load)
    fits = fitted([points_file(file) for file in files], wanted, not as_json, same, law)
    for one in fits:
        if one.curve and (asked := friction_question_of_fit(one.curve.mu_start, one.points.get("mu"))):
            warnings.warn(f"{one.name}: {asked}", UnitWarning, stacklevel=1)
    ageing = {one.name: one.ageing for one in fits if one.ageing}
    if plot is not None:
        from stickslip import plots

        plots.save(plots.plot_fits(fits), plot)
    if as_json:
        return tell_json(_answer(fits, ageing, seconds(at), plot))
    tell_columns(fits)
    for one in fits:
        screen.echo(f"{one.name}\n{report.describe(one)}\n")
    if len(ageing) > 1:
        screen.echo(report.describe_ranking(ageing, seconds(at)))
    if len(ageing) < len(fits):
        screen.echo(f"to paste into a configuration\n{report.as_yaml(fits)}")
    if plot is not None:
        screen.echo(f"plot     {plot}")


def fitted(
    files: Sequence[Path], wanted: Wanted, ask: bool = True, same: Sequence[str] = (), law: str = "stribeck"
) -> list[MaterialFit]:
    """The fits of files; where a header names no unit and somebody sits at the terminal, the unit is asked for."""
    from dataclasses import replace

    from stickslip.fit import fit_materials
    from stickslip.vocabulary import units

    fits = fit_materials(files, wanted, same=same, law=law)
    bare = [one for one in fits if one.points.assumed]
    if not (ask and bare and _somebody_sits_there()):
        return fits
    (column, *_), points = bare[0].points.assumed, bare[0].points[bare[0].points.assumed[0].name]
    names = ", ".join(dict.fromkeys(str(one.path) for one in bare))
    screen.echo(
        f"{names}: the header gives no unit of {column.name}; it goes from {points.min():g} to {points.max():g}."
    )
    usual = units.example(column.units).split(" ", 1)[1]
    unit = click.prompt(f"Unit of {column.name}, such as {usual}", default=units.spelled(column.units))
    return fit_materials(files, replace(wanted, unit=unit.strip()), same=same, law=law)


def _somebody_sits_there() -> bool:
    import sys

    return sys.stdin.isatty() and sys.stdout.isatty()


def tell_columns(fits: Sequence[MaterialFit]) -> None:
    """Say what the columns of each file were taken for, where they are not plainly called so; of files alike once."""
    from stickslip.fit import report

    every = [each for one in fits for each in one.repeats or (one,)]
    alike: dict[str, list[str]] = {}
    for path in dict.fromkeys(one.path for one in every):
        of_file = [one for one in every if one.path == path]
        if not all(map(report.is_plain, of_file)):
            alike.setdefault(report.describe_columns(of_file), []).append(str(path))
    for columns_are, paths in alike.items():
        screen.echo(f"{', '.join(paths)}: {columns_are}\n")


def _answer(fits: Sequence[MaterialFit], ageing: dict[str, Any], at: float, plot: Path | None) -> dict[str, Any]:
    """The fits for programs."""
    from stickslip.fit import rank, report

    told: dict[str, Any] = {"fits": [report.as_plain(one) for one in fits]}
    if len(ageing) > 1:
        order = rank(ageing, at)
        told["ranking"] = {
            "at": order.at,
            "by_level": [place.name for place in order.by_level],
            "by_slope": [place.name for place in order.by_slope],
        }
    if len(ageing) < len(fits):
        told["yaml"] = report.as_yaml(fits)
    return told | ({"plot": str(plot)} if plot else {})
