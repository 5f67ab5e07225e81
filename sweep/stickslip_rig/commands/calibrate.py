"""`rig calibrate`: the risk model fitted to records."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from stickslip.cli import screen
from stickslip.cli.exits import JSON, reports_errors
from stickslip_rig.commands.features import CONDITIONS, CONFIG_OPTION, record_settings


@click.command(
    epilog="""\b
Examples:
  stickslip rig calibrate pairs.csv > risk.yaml
  stickslip rig calibrate rated.csv -c rig.yaml --bandwidth "2 kHz"
Columns of FILE (.csv or .xlsx), either
  sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn
as `stickslip rig features -o` writes them, with a column rpn added, or
  file, rpn"""
)
@click.argument("file", type=click.Path(path_type=Path))
@CONFIG_OPTION
@CONDITIONS
@JSON
@reports_errors
def calibrate(
    file: Path, config: Path | None, load: str | None, speed: str | None, bandwidth: str | None
) -> dict[str, Any]:
    """Fit the risk model to measured pairs of features, or records, and RPN.

    At least five pairs of different features are needed. Records of which a feature is not
    determined are left out.

    Prints the parameters ready to paste into a configuration; how well the model predicts pairs it has not seen, and
    the quality of the fit, go to standard error.
    """
    from stickslip_rig.pairs import calibrate_file

    fit = calibrate_file(file, record_settings(config, load, speed, bandwidth))
    for pair in fit.omitted:
        screen.notice(f"left out  {pair}")
    screen.notice(fit.prediction())
    screen.echo(fit.text())
    width = max(6, *map(len, fit.names))
    screen.notice(f"\n{'pair':>{width}}{'RPN':>7}{'fitted':>8}{'level':>8}{'residual':>10}{'left out':>10}")
    rows = zip(fit.names, fit.rpn, fit.number, fit.level, fit.residuals, fit.left_out, strict=True)
    for name, rpn, number, level, residual, left_out in rows:
        screen.notice(f"{name:>{width}}{rpn:7.3g}{number:8.0f}{level:8.2f}{residual:10.2f}{left_out:10.2f}")
    screen.notice(fit.quality())
    columns = ("names", "rpn", "level", "left_out", "default")
    return {"risk": fit.risk.resolved(), "interval": fit.interval, "unidentified": fit.unidentified,
            "leave_one_out_error": fit.error, "default_error": fit.default_error,
            "is_better_than_default": fit.is_better, "noise": fit.noise,
            "omitted": fit.omitted, "pairs": {name: getattr(fit, name) for name in columns}}  # fmt: skip
