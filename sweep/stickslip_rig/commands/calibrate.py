"""`rig calibrate`: the risk model fitted to records."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from stickslip.cli import screen
from stickslip.cli.screen import JSON, reports_errors
from stickslip_rig.commands.features import CONFIG_OPTION


@click.command(
    epilog="""\b
Examples:
  stickslip rig calibrate pairs.csv > risk.yaml
Columns of FILE (.csv or .xlsx)
  sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn
as `stickslip rig features -o` writes them, with a column rpn added"""
)
@click.argument("file", type=click.Path(path_type=Path))
@CONFIG_OPTION
@JSON
@reports_errors
def calibrate(file: Path, config: Path | None) -> dict[str, Any]:
    """Fit the risk model to measured pairs of features and RPN.

    At least five pairs of different features are needed. Records of which a feature is not
    determined are left out.

    Prints the parameters ready to paste into a configuration; the pairs and what the fit makes of them go to standard
    error.
    """
    from stickslip.config.studies import Table
    from stickslip_rig.pairs import calibrate_file
    from stickslip_rig.settings import load_settings

    fit = calibrate_file(file, load_settings(config).risk)
    screen.echo(fit.text())
    columns = {"RPN": fit.rpn, "fitted": fit.level, "left out": fit.left_out, "default": fit.default}
    rows = [(name, *(f"{value:.2f}" for value in row)) for name, *row in zip(fit.names, *columns.values(), strict=True)]
    screen.notice(Table("", ("pair",), tuple(columns), rows).text())
    screen.notice(fit.prediction())
    for pair in fit.omitted:
        screen.notice(f"left out  {pair}")
    pairs = ("names", "rpn", "level", "left_out", "default")
    return {"risk": fit.risk.resolved(), "interval": fit.interval, "unidentified": fit.unidentified,
            "leave_one_out_error": fit.error, "default_error": fit.default_error,
            "is_better_than_default": fit.is_better, "noise": fit.noise,
            "omitted": fit.omitted, "pairs": {name: getattr(fit, name) for name in pairs}}  # fmt: skip
