"""`explain` and `next`: from what was measured back to what causes it, and which measurement would tell most."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import Outputs, save_result, show_result
from stickslip.cli.run import run_request
from stickslip.cli.screen import JSON, fail, refuses_bad_input, remark_incomplete, reports_errors

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Example:
  stickslip explain felt.yaml --set particles=2000 -o felt.nc --plot felt.png"""
)
@params.CONFIG
@params.OUTPUT
@params.plot_option()
@click.option("--report", type=params.Target("page"), help="Page to write (.html): plots and meanings.")
@JSON
@reports_errors
def explain(config: Path, output: Location | None, plot: Path | None, report: Path | None) -> dict[str, Any]:
    """Find springs, dampers and friction that explain observations.

    CONFIG holds observations, `explain: {observed: [...]}` (regimes, results with their scatter), what was known
    before, `uncertain`, and maybe `axes` over which regimes are predicted. The result are draws of the quantities that
    are not known, the evidence of each law, and what the observations fix and what not; `stickslip run` computes the
    same. Where nothing explains the observations, the command says which of them contradicts.
    """
    from stickslip.config.yaml import read_yaml
    from stickslip.runs.session import Request

    loaded = params.configuration(config)
    if loaded.study is None or loaded.study.key != "explain":
        fail(f"{config}: no observation, expected explain: {{observed: [...]}}")
    configured = params.configured_targets(loaded)
    request = Request(loaded, output or configured[0])
    answer = run_request(request, Outputs(plot or configured[1], report or configured[2]))
    if "contradiction" in answer:
        path = ("explain", "observed", answer["observation"])
        place = read_yaml(config).values.get(path) if config.exists() else None
        where = place.text(str(config)) if place else str(config)
        remark_incomplete(f"{where}: nothing explains this: {answer['contradiction']}")
    return answer


# --- the next measurement ---------------------------------------------------------------------------------------------


@click.command(
    "next",
    epilog="""\b
Examples:
  stickslip next explain.nc --over belt_speed normal_load
  stickslip next explain.nc --over belt_speed="5..300 mm/s" --scatter period=2 --plot next.png""",
)
@click.argument("file", type=params.PathOrUrl())
@click.argument("more", nargs=-1, metavar="[NAME]")
@click.option("--over", multiple=True, metavar="NAME[=RANGE]",
              help="One or two parameters in which an observation may differ.")  # fmt: skip
@params.AT
@click.option("--scatter", multiple=True, metavar="RESULT=PERCENT",
              help="Result to be measured, with its standard deviation.  [default: those observed before]")  # fmt: skip
@click.option("--points", type=click.IntRange(2, 1000), default=16, show_default=True, help="Points of each axis.")
@params.OUTPUT
@params.plot_option()
@reports_errors
def next_command(
    file: Location, more: tuple[str, ...], over: tuple[str, ...], at: tuple[str, ...], scatter: tuple[str, ...],
    points: int, output: Location | None, plot: Path | None,
) -> None:  # fmt: skip
    """Say which measurement would tell most.

    FILE is what `stickslip explain` wrote. Over one or two parameters (`--over belt_speed normal_load`), others that
    differ between observations at one value (`--at normal_load="10 N"`), the expected information of one more
    observation is computed, and the best three places are named, with what each would narrow.
    """
    from stickslip.vocabulary.units import ends_of
    from stickslip_explain.api import next_measurement

    if not over:
        fail("missing --over, expected one or two parameters: --over belt_speed normal_load")
    with refuses_bad_input(""):
        ranges = {}
        for text in (*over, *more):
            name, equals, ends = text.partition("=")
            ranges[name.strip()] = ends_of(f"--over {name}", ends) if equals else None
    measured = {name: share / 100.0 for name, share in params.numbers("--scatter", scatter, unit="%").items()}
    with refuses_bad_input(file), screen.progress_bar("draws") as move:
        ds = next_measurement(
            str(file), ranges, at=params.pairs(at), scatter=measured or None, points=points, progress=move
        )
    show_result(ds)
    save_result(ds, output)
    Outputs(plot).save(ds)
