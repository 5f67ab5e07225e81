"""`rig`: a test matrix on a simulated rig, records of measured ones, and the risk number fitted to such."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import SectionedGroup, params, screen
from stickslip.cli.outputs import Outputs, save_plot, save_result, save_table, show_result
from stickslip.cli.run import BLOCKS, run_request, shard_of
from stickslip.cli.screen import JSON, QUIET, Answer, fail, refuses_bad_input, reports_errors
from stickslip.errors import UnitWarning
from stickslip.vocabulary import units

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location
    from stickslip_rig.api import RigTests
    from stickslip_rig.settings import Settings

CONFIG_OPTION = click.option(
    "-c", "--config", type=click.Path(path_type=Path), help="YAML: columns, units, conditions, features, risk."
)
_FASTEST = 1.0  # m/s; a plate moves no faster, and what does so lacks its unit
_MOST_ROWS = 60  # on screen
_MOST_TRACES = 6  # drawn over each other


def PART(command: params.Command) -> params.Command:  # noqa: N802, a decorator as `CONFIG_OPTION`
    """The options `--from` and `--to`, which `time_window` reads."""
    return params.decorated(
        command,
        click.option("--from", "begin", metavar="TIME", help="Plot only from this time of each test on."),
        click.option("--to", "end", metavar="TIME", help="Plot only up to this time of each test."),
    )


@click.command(
    "features",
    epilog="""\b
Examples:
  stickslip rig features felt.csv fluid.csv
  stickslip rig features *.csv -c rig.yaml --plot traces.png -o features.nc
  stickslip rig features *.csv -o features.csv    # with a column rpn, for stickslip rig calibrate
  stickslip rig features dry.csv --bandwidth "2 kHz" --plot start.png --from 0 --to "2 s" """,
)
@params.RECORDS
@CONFIG_OPTION
@click.option("--load", metavar="FORCE", help='Normal load, for friction coefficients ("10 N").')
@click.option("--speed", metavar="SPEED", help='Of the drive, where files do not record it ("10 mm/s").')
@click.option("--bandwidth", metavar="FREQUENCY", help='Of the acceleration, limits what is used ("2 kHz").')
@params.plot_option()
@PART
@click.option(
    "-o", "--output", type=params.Target("table", "result"),
    help="File to write the features to: .csv, .xlsx, .nc or .zarr.",
)  # fmt: skip
@JSON
@reports_errors
def features(
    files: tuple[Path, ...], config: Path | None, load: str | None, speed: str | None, bandwidth: str | None,
    plot: Path | None, begin: str | None, end: str | None, output: Location | None,
) -> Answer:  # fmt: skip
    """Compute features and a risk number of rig records.

    Each FILE is a CSV with the columns time and force, and, if known, acceleration and drive_velocity or
    drive_displacement; units are given in the header, "time [ms]". The risk number is a model RPN, not the rig maker's,
    and needs the acceleration.
    """
    from stickslip.dataset.build import provenance
    from stickslip.files.targets import KINDS
    from stickslip_rig import api as rig
    from stickslip_rig.risk import band_of

    settings = _settings(config, load, speed, bandwidth)
    window = time_window(begin, end)
    records = read_files(files, [settings] * len(files), {"normal_load": load, "drive_speed": speed})
    with refuses_bad_input(", ".join(map(str, files))):
        ds = rig.feature_table(records, settings)
    show_result(ds)
    _show_what_was_read(records)
    for name, remarks in zip(records, ds["remarks"].values.tolist(), strict=True):
        if remarks:
            screen.echo(f"{name}: " + remarks.replace("\n", "\n  "))
    if plot is not None:
        from stickslip_rig.plots import plot_records

        numbers = dict(zip(records, ds["model_rpn"].values.tolist(), strict=True))
        save_plot(plot_records(records, numbers=numbers, window=window), plot)
    action = f"rig-features {' '.join(map(str, files))}"
    ds = ds.assign_attrs(provenance(settings.to_yaml(), title="Features of rig records", action=action))
    if isinstance(output, Path) and output.suffix.lower() in KINDS["table"].suffixes:
        save_table(ds, output)
    else:
        save_result(ds, output, "features")

    def answer() -> dict[str, Any]:
        rows = ds.to_dataframe().reset_index().to_dict("records")
        for record, row in zip(records.values(), rows, strict=True):
            row |= {"file": record.attrs["record_file"], "model_rpn_band": band_of(row["model_rpn"])}
        return {"rpn": rig.RPN_NAME, "records": rows, "output": output, "plot": plot}

    return answer


def read_files(
    files: Sequence[Path], settings: Sequence[Settings], options: Mapping[str, str | None]
) -> dict[str, xr.Dataset]:
    """The records of files, each with its settings, by material; with file and block where several are of the same.

    options : conditions by name; where a file says otherwise, that is printed.
    """
    from stickslip_rig.quantities import CONDITIONS
    from stickslip_rig.records import read_records

    if len({*files}) < len(files):
        fail("a file is named twice")
    records: list[xr.Dataset] = []
    for file, each in zip(files, settings, strict=True):
        with screen.progress_bar("bytes", " read") as move:  # which only moves for long records
            read = read_records(file, each.record, each.conditions, move)
        records += read
        for name, text in options.items():
            values = {float(record[name]) for record in read if text and name in record.coords}
            if others := sorted(values - {each.conditions.get(name)}):
                holds = ", ".join(f"{value:g} {units.spelled(CONDITIONS[name].units)}" for value in others)
                screen.notice(f"{file}: its {name} of {holds} holds, not the {text} of the option")
    materials = Counter(str(record["material"].item()) for record in records)
    named = {}
    for record in records:
        name, place = str(record["material"].item()), Path(record.attrs["record_file"]).with_suffix("")
        block = f", {record.attrs['block']}" * bool(record.attrs["block"])
        named[name if materials[name] == 1 else f"{name} ({place}{block})"] = record
    return named


# --- what the options say ---------------------------------------------------------------------------------------------


def _settings(config: Path | None, load: str | None, speed: str | None, bandwidth: str | None) -> Settings:
    """The settings of a configuration, with those of the options put in."""
    from stickslip.config.yaml import Setting
    from stickslip_rig.settings import load_settings

    rows = (("load", "conditions.normal_load", load), ("speed", "conditions.drive_speed", speed),
            ("bandwidth", "features.bandwidth", bandwidth))  # fmt: skip
    given = [Setting(f"--{option} {text}", key, text) for option, key, text in rows if text is not None]
    settings = load_settings(config, given)
    if speed is not None and float(settings.conditions["drive_speed"]) > _FASTEST and not units.unit_in(speed):
        message = f"drive_speed: {speed} is read as {speed} m/s; did you mean {speed} mm/s?"
        warnings.warn(message, UnitWarning, stacklevel=2)
    return settings


def time_window(begin: str | None, end: str | None) -> tuple[float, float] | None:
    """The part of a record that two options ask for, in s."""
    from stickslip.config.grid import seconds

    if begin is None and end is None:
        return None
    start = 0.0 if begin is None or begin == "0" else seconds(begin, "--from")
    stop = float("inf") if end is None else seconds(end, "--to")
    if start >= stop:
        fail(f"--from {begin} --to {end}: expected an end after the start")
    return start, stop


# --- on screen --------------------------------------------------------------------------------------------------------


def _show_what_was_read(records: Mapping[str, xr.Dataset]) -> None:
    """Print conditions and columns as they were understood, once for records that are alike."""
    from stickslip.vocabulary.display_units import quantity
    from stickslip_rig.evaluation import first_of
    from stickslip_rig.quantities import CONDITIONS

    alike: dict[str, list[str]] = {}
    for name, record in records.items():
        known = [f"{c} {quantity(float(record[c]), row.units)}" for c, row in CONDITIONS.items() if c in record.coords]
        parts = {"conditions": known, "columns": record.attrs["columns"], "not used": record.attrs["not_used"]}
        texts = [f"{word}: {', '.join(names)}" for word, names in parts.items() if names]
        alike.setdefault("\n         ".join(texts), []).append(name)
    for text, names in alike.items():
        screen.echo(f"read     {first_of(names)}\n         {text}")


def report(ds: xr.Dataset) -> Iterator[Any]:
    """The features of records or of tests, what the colours of the risk number mean, and what to mind of them."""
    from stickslip_rig.evaluation import shown_table, unfinished
    from stickslip_rig.quantities import RPN_NAME

    table = shown_table(ds)
    rows = [*table.rows]
    yield table._replace(rows=rows[:_MOST_ROWS])
    if len(rows) > _MOST_ROWS:
        yield f"... and {len(rows) - _MOST_ROWS:,} more"
    yield f"RPN: {RPN_NAME}. Green 1 to 3, yellow 4 and 5, red 6 to 10."
    for sentence in unfinished(ds) if "status" in ds else ():
        screen.notice(f"warning: {sentence}")


# --- calibration ------------------------------------------------------------------------------------------------------


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

    Prints the parameters ready to paste into a configuration, with the error of predictions.
    """
    from stickslip_rig.calibration import calibrate_file
    from stickslip_rig.settings import load_settings

    fit = calibrate_file(file, load_settings(config).risk)
    screen.echo(fit.text())
    for pair in fit.omitted:
        screen.notice(f"left out  {pair}: a feature is empty")
    return {"risk": fit.risk.resolved(), "interval": fit.interval, "unidentified": fit.unidentified,
            "leave_one_out_error": fit.error, "default_error": fit.default_error,
            "is_better_than_default": fit.is_better, "noise": fit.noise, "omitted": fit.omitted,
            "pairs": {name: getattr(fit, name) for name in ("rpn", "level", "left_out")}}  # fmt: skip


# --- the simulated rig ------------------------------------------------------------------------------------------------


@click.command(
    epilog="""\b
Examples:
  stickslip rig run configs/rig/materials.yaml
  stickslip rig run configs/rig/materials.yaml --test 0 --test 1 --from 0 --to "0.5 s"
  stickslip rig run configs/rig/test_matrix.yaml --report matrix.html
  stickslip rig run my.yaml -o my.nc --shard 1/4    # to 4/4; then: stickslip collect my.yaml
  stickslip rig run my.yaml --records signals       # CSV files, as a rig would write them"""
)
@params.CONFIG
@params.OUTPUT
@params.plot_option("Plot: signals of up to six tests, else a heat map.")
@click.option("--report", type=params.Target("page"), help="Page to write (.html): heat map, table, meanings.")
@click.option("--records", type=params.Target("folder"), help="Folder for the signals, a CSV file for each test.")
@click.option("--test", "chosen", type=int, multiple=True, metavar="N", help="Plot this test; repeatable.")
@PART
@BLOCKS
@QUIET
@JSON
@reports_errors
def run(
    config: Path, output: Location | None, plot: Path | None, report: Path | None, records: Path | None,
    chosen: tuple[int, ...], begin: str | None, end: str | None, shard: str | None,
    **blocks: Any,
) -> dict[str, Any]:  # fmt: skip
    """Compute a test matrix on a simulated rig.

    A specimen on a flat spring, a reciprocating plate, sensors: CONFIG is that of a map with a drive. Prints
    features and model RPN (not the rig maker's) of every test. Times count from the first stroke. With an output the
    same command resumes what was interrupted.
    """
    from stickslip.runs.session import Request
    from stickslip_rig.api import RigTests, load_rig

    loaded = load_rig(config, params.settings())
    output = output or params.configured_target(loaded.output.file, "result")
    plot = plot or params.configured_target(loaded.output.plot, "plot")
    tests, window = RigTests(loaded), time_window(begin, end)
    for number in chosen:
        if not 0 <= number < tests.grid.size:
            fail(f"--test {number}: tests are numbered from 0 to {tests.grid.size - 1}")
    if chosen and plot is None:
        fail("--test says what is plotted: name a plot with --plot")
    request = Request(loaded, output, shard=shard_of(shard, blocks["fresh"], output), **blocks)
    outputs = _Outputs(plot, report, tests=tests, records=records, chosen=chosen, window=window)
    return run_request(request, outputs)


@dataclass(frozen=True, kw_only=True)
class _Outputs(Outputs):
    """Files to be made of a matrix. chosen : tests to draw, in a `window` of time (s)."""

    tests: RigTests
    records: Path | None
    chosen: Sequence[int]
    window: tuple[float, float] | None

    def is_lacking(self) -> bool:
        """True if something is to be written though the result is there and was complete already."""
        return bool(self.records or params.requested_table()) or super().is_lacking()

    def save(self, ds: xr.Dataset) -> Path | None:
        """Write everything, and give the plot if there is one."""
        size = self.tests.grid.size
        drawn = self.chosen or (range(size) if size <= _MOST_TRACES else ())
        if self.plot is not None:
            from stickslip_rig.plots import plot_matrix, plot_records

            rpn = ds["model_rpn"].values.ravel()
            numbers = {self.tests.label(n): float(rpn[n]) for n in drawn}
            how: Any = {"window": self.window, "heading": self.tests.config.title}
            records = {test.name: test.record for test in self.tests.tests(drawn) if test.record is not None}
            save_plot(plot_records(records, numbers=numbers, **how) if records else plot_matrix(ds), self.plot)
        if self.records is not None:
            from stickslip_rig.records import write_record

            for test in self.tests.tests(range(size)):
                if test.record is not None:
                    write_record(test.record, self.records / f"test{test.number:0{len(str(size - 1))}d}.csv")
            screen.echo(f"records  {self.records}/test*.csv; stickslip rig features reads them")
        Outputs(page=self.page).save(ds)
        return self.plot


rig = SectionedGroup(
    "rig",
    default="run",
    sections={
        "Commands": {
            "run": "stickslip_rig.commands.rig",
            "features": "stickslip_rig.commands.rig",
            "friction": "stickslip_rig.commands.friction",
            "calibrate": "stickslip_rig.commands.rig",
        }
    },
    help="""Test rigs: simulated ones, records of measured ones, and the risk number.

    `stickslip rig my_rig.yaml` is short for `stickslip rig run my_rig.yaml`.""",
    short_help="Simulate a test rig, or evaluate records of one.",
    no_args_is_help=True,
)
