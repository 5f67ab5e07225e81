"""`rig calibrate` and `rig identify`: the risk model, and the simulated rig, fitted to records."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import JSON, fail, incomplete, print_json, refuses_bad_input, reports_errors
from stickslip.vocabulary import units
from stickslip_rig.commands.features import CONDITIONS, CONFIG_OPTION, record_settings

if TYPE_CHECKING:
    from stickslip_rig.identification import Identification


@click.command(
    epilog="""\b
Examples:
  stickslip rig calibrate pairs.csv > risk.yaml
  stickslip rig calibrate rated.csv -c rig.yaml --bandwidth "2 kHz"
  stickslip rig calibrate pairs.csv --scales
Columns of FILE (.csv or .xlsx), either
  sticks, acceleration_max [m/s2], acceleration_integral [m/s], rpn
as `stickslip rig features -o` writes them, with a column rpn added, or
  file, rpn"""
)
@click.argument("file", type=click.Path(path_type=Path))
@CONFIG_OPTION
@CONDITIONS
@click.option("--scales", is_flag=True, help="Fit the scales as well; needs pairs over several decades.")
@JSON
@reports_errors
def calibrate(
    file: Path, config: Path | None, load: str | None, speed: str | None, bandwidth: str | None, scales: bool
) -> dict[str, Any]:
    """Fit the risk model to measured pairs of features, or records, and RPN.

    At least five pairs of different features are needed, eight with --scales. Records of which a feature is not
    determined are left out.

    Prints the parameters ready to paste into a configuration; how well the model predicts pairs it has not seen, and
    the quality of the fit, go to standard error.
    """
    from stickslip_rig.pairs import calibrate_file

    fit = calibrate_file(file, record_settings(config, load, speed, bandwidth), scales)
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


@click.command(
    epilog="""\b
Examples:
  stickslip rig identify felt.csv -c my_rig.yaml --parameter mu_static --parameter damping
  stickslip rig identify felt.csv -c rig.yaml --parameter damping --start damping=2 --load 10N"""
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-c", "--config", type=click.Path(path_type=Path), required=True, help="YAML of the simulated rig.",
              callback=lambda _context, _option, path: params.config_file(path))  # fmt: skip
@params.SET
@click.option("--parameter", "names", multiple=True, required=True, metavar="NAME", help="To identify; repeatable.")
@click.option("--start", multiple=True, metavar="NAME=VALUE", help="Where to begin.  [default: the value of CONFIG]")
@click.option("--test", "number", type=click.IntRange(0), default=0, metavar="N", help="Of CONFIG.  [default: 0]")
@CONDITIONS
@JSON
@reports_errors
def identify(
    file: Path, config: Path, names: tuple[str, ...], start: tuple[str, ...], number: int, load: str | None,
    speed: str | None, bandwidth: str | None,
) -> dict[str, Any]:  # fmt: skip
    """Identify parameters of a simulated rig from a measured record.

    FILE is a record as for `stickslip rig features`; CONFIG describes the rig and the test it was measured in. The
    parameters are those with which the simulated record has the features of the measured one, by least squares.
    """
    from stickslip.config.overrides import Setting
    from stickslip_rig import api as rig
    from stickslip_rig.identification import other_test
    from stickslip_rig.sections import sections_of
    from stickslip_rig.simulation import values_of

    how, judged = record_settings(None, load, speed, None), []
    if bandwidth is not None:
        judged = [Setting(f"--bandwidth {bandwidth}", "features.bandwidth", bandwidth)]
    loaded = rig.load_rig(config, (*params.settings(), *judged))
    record = rig.read_record(file, how.record, how.conditions)
    with refuses_bad_input(file):
        try:
            simulate = rig.simulator(loaded, names, number)
        except IndexError as error:  # no such test
            fail(f"{file}: {error}")
        begin = values_of(loaded, names, number) | _starts(start, names)
        if missing := [name for name, value in begin.items() if isnan(value)]:
            fail(f"{config}: gives no {missing[0]} to begin with: --start {missing[0]}=VALUE")
        if text := other_test(record, simulate(begin).coords, names):
            fail(f"{file}: {text} in {config}: give both the same test")
        with screen.progress_bar("simulated records at most") as move:
            identified = rig.identify(simulate, record, begin, settings=sections_of(loaded).features, progress=move)
    _show(identified)
    for remark in filter(None, str(rig.features(record, sections_of(loaded).features)["remarks"].item()).splitlines()):
        screen.echo(f"{file}: {remark}")
    if not identified.converged:
        print_json(asdict(identified))
        incomplete("the search did not converge: start elsewhere (--start), or identify fewer parameters")
    return asdict(identified)


def _starts(texts: tuple[str, ...], names: tuple[str, ...]) -> dict[str, float]:
    """Values of `--start`, in SI. Raises ConfigError."""
    from stickslip.config.select import in_si
    from stickslip.vocabulary.quantities import QUANTITIES

    starts = params.pairs(texts)
    for name, text in starts.items():
        if name not in names:
            fail(f"--start {name}={text}: name it with --parameter as well")
    return {name: in_si(QUANTITIES[name], text, "--start", name) for name, text in starts.items()}


def _show(result: Identification) -> None:
    """Print the parameters with their intervals, and the features beside each other."""
    from stickslip.vocabulary.quantities import QUANTITIES
    from stickslip_rig.quantities import FEATURES

    table = screen.new_table("parameter", numbers=("estimate", "95 %: from", "to", ""))
    for name, value in result.estimates.items():
        low, high = result.interval[name]
        ends = (f"{low:.5g}", f"{high:.5g}") if isfinite(high) and high < 1e6 * value else ("not determined", "")
        table.add_row(name, f"{value:.5g}", *ends, units.spelled(QUANTITIES[name].units))
    screen.print_table(table)
    for section in dict.fromkeys(QUANTITIES[name].section for name in result.estimates):
        values = {n: v for n, v in result.estimates.items() if QUANTITIES[n].section == section}
        written = (f"{n}: {v:.5g} {units.spelled(QUANTITIES[n].units)}".rstrip() for n, v in values.items())
        screen.echo(f"{section}: {{{', '.join(written)}}}  # ready to paste")
    table = screen.new_table("feature", numbers=("measured", "simulated", "difference", ""))
    for name, value in result.measured.items():
        got, unit = result.simulated[name], units.spelled(FEATURES[name].units)
        share = f"{(got - value) / abs(value):+.1%}" if value else f"{got - value:+.3g}"
        table.add_row(name, f"{value:.5g}", f"{got:.5g}", share, unit)
    screen.print_table(table)
    end = "converged" if result.converged else "not converged"
    screen.echo(f"{end} after {result.evaluations} steps")
