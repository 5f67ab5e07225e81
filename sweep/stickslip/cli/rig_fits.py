"""`rig calibrate` and `rig identify`: the risk model, and the simulated rig, fitted to records."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stickslip.cli import screen
from stickslip.cli.common import (
    JSON,
    SET,
    config_file,
    fail,
    incomplete,
    pairs,
    prepare_kernels,
    reports_wrong_input,
    settings,
    tell_json,
)
from stickslip.cli.progress import progress_bar
from stickslip.cli.rig import CONDITIONS, CONFIG_OPTION, record_settings

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.rig.identification import Identification

_ALIKE = 0.01  # relative: conditions of the measured and the simulated test that differ by less are the same


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
@reports_wrong_input
def calibrate(
    file: Path, config: Path | None, load: str | None, speed: str | None, bandwidth: str | None, scales: bool,
    as_json: bool,
) -> None:  # fmt: skip
    """Fit the risk model to measured pairs of features, or records, and RPN.

    At least five pairs of different features are needed, eight with --scales. Records of which a feature is not
    determined are left out.

    Prints the parameters ready to paste into a configuration; how well the model predicts pairs it has not seen, and
    the quality of the fit, go to standard error.
    """
    from stickslip.rig.pairs import calibrate_file

    how = record_settings(config, {"normal_load": load, "drive_speed": speed}, bandwidth)
    found = calibrate_file(file, how, scales)
    for pair in found.omitted:
        screen.echo(f"left out  {pair}", err=True)
    screen.echo(found.prediction(), err=True)
    screen.echo(found.text())
    width = max(6, *map(len, found.names))
    screen.echo(f"\n{'pair':>{width}}{'RPN':>7}{'fitted':>8}{'level':>8}{'residual':>10}{'left out':>10}", err=True)
    rows = zip(found.names, found.rpn, found.number, found.level, found.residuals, found.left_out, strict=True)
    for name, rpn, number, level, residual, left_out in rows:
        screen.echo(f"{name:>{width}}{rpn:7.3g}{number:8.0f}{level:8.2f}{residual:10.2f}{left_out:10.2f}", err=True)
    screen.echo(found.quality(), err=True)
    if as_json:
        columns = ("names", "rpn", "level", "left_out", "default")
        tell_json({"risk": found.risk.known, "interval": found.interval, "unidentified": found.unidentified,
                   "leave_one_out_error": found.error, "default_error": found.default_error,
                   "is_better_than_default": found.is_better, "noise": found.noise,
                   "omitted": found.omitted, "pairs": {name: getattr(found, name) for name in columns}})  # fmt: skip


@click.command(
    epilog="""\b
Examples:
  stickslip rig identify felt.csv -c my_rig.yaml --parameter mu_start --parameter mu_reversal
  stickslip rig identify felt.csv -c my_rig.yaml --parameter a3 --start a3=0.2 --load "10 N" """
)
@click.argument("file", type=click.Path(path_type=Path))
@click.option("-c", "--config", type=click.Path(path_type=Path), required=True, help="YAML of the simulated rig.",
              callback=lambda _context, _option, path: config_file(path))  # fmt: skip
@SET
@click.option("--parameter", "names", multiple=True, required=True, metavar="NAME", help="To identify; repeatable.")
@click.option("--start", multiple=True, metavar="NAME=VALUE", help="Where to begin.  [default: the value of CONFIG]")
@click.option("--test", "number", type=click.IntRange(0), default=0, metavar="N", help="Of CONFIG.  [default: 0]")
@CONDITIONS
@JSON
@reports_wrong_input
def identify(
    file: Path, config: Path, names: tuple[str, ...], start: tuple[str, ...], number: int, load: str | None,
    speed: str | None, bandwidth: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Identify parameters of a simulated rig from a measured record.

    FILE is a record as for `stickslip rig features`; CONFIG describes the rig and the test it was measured in. The
    parameters are those with which the simulated record has the features of the measured one, by least squares.
    """
    from dataclasses import replace
    from math import isnan

    from stickslip import rig
    from stickslip.errors import ConfigError
    from stickslip.rig.simulation import values_of

    how = record_settings(None, {"normal_load": load, "drive_speed": speed}, bandwidth)
    made = rig.load_rig(config, settings())
    judged = made.features if bandwidth is None else replace(made.features, bandwidth=how.features.bandwidth)
    record = rig.read_record(file, how.record, how.conditions)
    prepare_kernels(made.config.friction.law, signals=True)
    try:
        simulate = rig.simulator(made, names, number)
        begin = values_of(made, names, number) | _starts(start, names)
        if lacking := [name for name, value in begin.items() if isnan(value)]:
            fail(f"{config}: gives no {lacking[0]} to begin with: --start {lacking[0]}=VALUE")
        _check_conditions(record, simulate(begin), names, file, config)
        with progress_bar(0, of="simulated records at most") as move:
            found = rig.identify(simulate, record, begin, settings=judged, progress=move)
    except ConfigError:
        raise
    except (ValueError, IndexError) as error:
        fail(f"{file}: {error}")
    except KeyboardInterrupt:
        incomplete("interrupted: nothing was identified")
    _show(found)
    for remark in filter(None, str(rig.features(record, judged)["remarks"].item()).splitlines()):
        screen.echo(f"{file}: {remark}")
    if as_json:
        tell_json(asdict(found))
    if not found.converged:
        incomplete("the search did not converge: start elsewhere (--start), or identify fewer parameters")


def _starts(texts: tuple[str, ...], names: tuple[str, ...]) -> dict[str, float]:
    """What `--start` says, in SI."""
    from stickslip.errors import QuantityError
    from stickslip.vocabulary.quantities import QUANTITIES

    found = {}
    for name, text in pairs(texts).items():
        if name not in names:
            fail(f"--start {name}={text}: name it with --parameter as well")
        try:
            found[name] = QUANTITIES[name].read(_number_or_text(text))
        except QuantityError as error:
            fail(f"--start {name}={text}: expected {error.expected}")
    return found


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _check_conditions(
    record: xr.Dataset, simulated: xr.Dataset, names: tuple[str, ...], file: Path, config: Path
) -> None:
    """End if the measured test was another than the simulated one."""
    from stickslip.vocabulary import units
    from stickslip.vocabulary.settings import CONDITIONS as ROWS

    for name, row in ROWS.items():
        identified = name in names or name == "drive_speed" and "belt_speed" in names
        if identified or name not in record.coords or name not in simulated.coords:
            continue
        measured, given = float(record[name]), float(simulated[name])
        if abs(measured - given) > _ALIKE * abs(given):
            unit = units.spelled(row.units)
            fail(f"{file}: {name} is {measured:g} {unit}, and {given:g} {unit} in {config}: give both the same test")


def _show(found: Identification) -> None:
    """The parameters with their intervals, and the features beside each other."""
    from math import isfinite

    from stickslip.rig.quantities import FEATURES
    from stickslip.vocabulary import units
    from stickslip.vocabulary.quantities import QUANTITIES

    screen.echo(f"{'parameter':16}{'estimate':>12}{'95 %: from':>14}{'to':>12}")
    for name, value in found.estimates.items():
        low, high = found.interval[name]
        ends = f"{low:14.5g}{high:12.5g}" if isfinite(high) and high < 1e6 * value else f"{'not determined':>26}"
        screen.echo(f"{name:16}{value:12.5g}{ends}  {units.spelled(QUANTITIES[name].units)}".rstrip())
    for section in dict.fromkeys(QUANTITIES[name].section for name in found.estimates):
        values = {n: v for n, v in found.estimates.items() if QUANTITIES[n].section == section}
        written = (f"{n}: {v:.5g} {units.spelled(QUANTITIES[n].units)}".rstrip() for n, v in values.items())
        screen.echo(f"{section}: {{{', '.join(written)}}}  # ready to paste")
    screen.echo(f"\n{'feature':20}{'measured':>12}{'simulated':>12}{'difference':>12}")
    for name, value in found.measured.items():
        got, unit = found.simulated[name], units.spelled(FEATURES[name].units)
        share = f"{(got - value) / abs(value):+12.1%}" if value else f"{got - value:+12.3g}"
        screen.echo(f"{name:20}{value:12.5g}{got:12.5g}{share}  {unit}".rstrip())
    end = "converged" if found.converged else "not converged"
    screen.echo(f"{end} after {found.evaluations} steps")
