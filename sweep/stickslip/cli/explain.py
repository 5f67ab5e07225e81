"""`explain`: from what was measured back to what causes it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params
from stickslip.cli.exits import JSON, QUIET, fail, remark_incomplete, reports_errors
from stickslip.cli.outputs import Outputs
from stickslip.cli.run import FRESH, run_request

if TYPE_CHECKING:
    from stickslip.files.locations import Location


@click.command(
    epilog="""\b
Examples:
  stickslip explain configs/explain.yaml
  stickslip explain felt.yaml --set particles=2000 -o felt.nc --plot felt.png"""
)
@params.CONFIG
@params.OUTPUT
@params.plot_option()
@click.option("--report", type=params.Target("page"), help="Page to write (.html, .pdf): plots and meanings.")
@FRESH
@params.DASK
@params.THREADS
@QUIET
@JSON
@reports_errors
def explain(
    config: Path, output: Location | None, plot: Path | None, report: Path | None, fresh: bool, dask: str | None
) -> dict[str, Any]:
    """Find springs, dampers and friction that explain observations.

    CONFIG holds observations, `observed` (regimes, results with their scatter), what was known before, `prior`, and
    maybe the axes over which regimes are predicted, `predict`. The result are draws of the quantities that are not
    known, the evidence of each law, and what the observations fix and what not; `stickslip run` computes the same.
    Where nothing explains the observations, the command says which of them contradicts.
    """
    from stickslip.runs.session import Request
    from stickslip.vocabulary.studies import EXPLAIN

    loaded = params.configuration(config)
    if loaded.study is None or loaded.study.key != EXPLAIN:
        fail(f"{config}: no observation, expected observed: [...] and prior: {{...}}")
    output = output or params.configured_target(loaded.output.file, "result")
    target = plot or params.configured_target(loaded.output.plot, "plot")
    page = report or params.configured_target(loaded.output.report, "page")
    request = Request(loaded, output, fresh=fresh, dask=dask)
    keep = ["explain", str(config), "-o", f"{config.stem}.nc"]
    answer = run_request(request, keep, Outputs(target, page=page))
    if "contradiction" in answer:
        remark_incomplete(f"{_place(config, answer['observation'])}: nothing explains this: {answer['contradiction']}")
    return answer


def _place(config: Path, number: int) -> str:
    """The place of an observation, with its line if the file has one."""
    from stickslip.config.yaml import read_yaml
    from stickslip.errors import ConfigError

    try:
        places = read_yaml(config).values
    except ConfigError:  # a configuration of the package, called by its name alone
        return str(config)
    place = places.get(("observed", number)) or places.get(("explain", "observed", number))
    return place.text(str(config)) if place else str(config)
