"""`rig`: a test matrix on a simulated rig, and the commands for records of measured ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

from stickslip.cli import params, rig_features, rig_fits, screen
from stickslip.cli.exits import fail, reports_errors
from stickslip.cli.groups import SectionedGroup, renamed
from stickslip.cli.listen import check_sounds, save_sounds
from stickslip.cli.outputs import save_plot, save_result, show_file
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.files.locations import Location
    from stickslip.rig.config import RigConfig
    from stickslip.rig.simulation import RigTests
    from stickslip.sound import Sound

_MOST_TRACES = 6  # drawn over each other
_MOST_ROWS = 60  # on screen
_FINE, _COARSE = 8, 2  # samples computed per sample of sound: of short tests, and of long ones, which take much memory
_SHORT = 20.0  # s


@click.command(
    epilog="""\b
Examples:
  stickslip rig run configs/rig/materials.yaml
  stickslip rig run configs/rig/materials.yaml --test 0 --test 1 --from 0 --to "0.5 s"
  stickslip rig run configs/rig/test_matrix.yaml --report matrix.html
  stickslip rig run my.yaml --records signals       # CSV files, as a rig would write them"""
)
@params.CONFIG
@click.option(
    "-o", "--output", type=params.Target("result"),
    help="File of features to write, .nc or .zarr, or the URL of a .zarr.",
)  # fmt: skip
@params.plot_option("Plot: signals of up to six tests, else a heat map.")
@click.option("--report", type=params.Target("page"), help="Page to write (.html, .pdf): maps, traces, table.")
@click.option("--records", type=params.Target("folder"), help="Folder for the signals, a CSV file for each test.")
@click.option("--sound", type=params.Target("sound", "folder"), help="Folder for the sounds, a WAV file for each test.")
@click.option("--test", "chosen", type=int, multiple=True, metavar="N", help="Plot this test; repeatable.")
@click.option("--beside", is_flag=True, help="Plot signals beside each other instead of over each other.")
@click.option("--from", "begin", metavar="TIME", help="Plot only from this time of each test on.")
@click.option("--to", "end", metavar="TIME", help="Plot only up to this time of each test.")
@reports_errors
def run(
    config: Path, output: Location | None, plot: Path | None, report: Path | None, records: Path | None,
    sound: Path | None, chosen: tuple[int, ...], beside: bool, begin: str | None, end: str | None,
) -> None:  # fmt: skip
    """Compute a test matrix on a simulated rig.

    A specimen on a flat spring, a reciprocating plate, sensors: CONFIG is that of a map with a drive. Prints
    features and model RPN (not the rig maker's) of every test. Times count from the first stroke.
    """
    from stickslip import engine
    from stickslip.rig.config import load_rig
    from stickslip.rig.simulation import RigTests, run_matrix

    loaded = load_rig(config, params.settings())
    output = output or params.configured_target(loaded.config.output.file, "result")
    plot = plot or params.configured_target(loaded.config.output.plot, "plot")
    tests, window = RigTests(loaded), rig_features.time_window(begin, end)
    grid, size = tests.grid, tests.grid.size
    for number in chosen:
        if not 0 <= number < size:
            fail(f"--test {number}: tests are numbered from 0 to {size - 1}")
    if chosen and plot is None and report is None:
        fail("--test says what is plotted: name a plot with --plot, or a page with --report")
    check_sounds(sound, size)
    engine.warm_up(loaded.config.friction.law, signals=True)
    along = " x ".join(f"{dim} ({length})" for dim, length in zip(grid.dims, grid.shape, strict=True))
    screen.echo(f"{loaded.config.title}\n{f'{size:,} tests: {along}' if along else 'one test'}")
    began = perf_counter()
    with screen.progress_bar("tests") as move:
        ds = run_matrix(loaded, move)
    _show(ds, tests, perf_counter() - began)
    drawn = list(chosen) or (list(range(size)) if size <= _MOST_TRACES else [])
    if plot is not None:
        save_plot(_figure(ds, tests, drawn, beside, window), plot)
    save_result(ds, output, "features")
    if records is not None:
        _save_records(records, tests)
    if sound is not None:
        save_sounds(sound, _sounds(loaded))
    if report is not None:
        from stickslip.rig.report import write_report

        write_report(report, ds, _records(tests, drawn or list(range(min(size, _MOST_TRACES)))), loaded)
        show_file("report", report)


def _show(ds: xr.Dataset, tests: RigTests, seconds: float) -> None:
    """Print the table, tests that were not integrated to their end, and how long it took."""
    import numpy as np

    from stickslip.rig.simulation import as_table

    size = tests.grid.size
    table = as_table(ds, [tests.name(n) for n in range(min(size, _MOST_ROWS))])
    rig_features.show_features(table, f"... and {size - _MOST_ROWS:,} more" if size > _MOST_ROWS else "")
    rig_features.warn_of_extrapolation(table, tests.rig.risk)
    status = ds["status"].values
    for code in np.unique(status[status != STATUSES.index("horizon_reached")]).tolist():
        number, message = int((status == code).sum()), STATUS_MESSAGES[STATUSES[code]]
        many = "1 test was" if number == 1 else f"{number:,} tests were"
        screen.notice(f"warning: {many} not integrated to the end: {message}")
    screen.echo(f"{size:,} tests in {screen.duration_text(seconds)}")


def _figure(
    ds: xr.Dataset, tests: RigTests, drawn: list[int], beside: bool, window: tuple[float, float] | None
) -> Figure:
    """Signals where some were chosen or there are few tests, else the matrix."""
    from stickslip.rig.plots import plot_matrix, plot_records

    records = _records(tests, drawn)
    if not records:
        return plot_matrix(ds)
    rpn = ds["model_rpn"].values.ravel()
    numbers = {tests.name(n): float(rpn[n]) for n in drawn}
    return plot_records(records, beside=beside, numbers=numbers, window=window, heading=tests.rig.config.title)


def _records(tests: RigTests, numbers: list[int]) -> dict[str, xr.Dataset]:
    """Records by name, of the tests that were integrated to their end."""
    return {test.name: test.record for test in tests.tests(numbers) if test.record is not None}


def _save_records(folder: Path, tests: RigTests) -> None:
    from stickslip.rig.records import write_record

    for test in tests.tests(range(tests.grid.size)):
        if test.record is not None:
            write_record(test.record, folder / f"{_file_name(tests, test.number)}.csv")
    screen.echo(f"records  {folder}/test*.csv; stickslip rig features reads them")


def _file_name(tests: RigTests, number: int) -> str:
    return f"test{number:0{len(str(tests.grid.size - 1))}d}"


def _sounds(loaded: RigConfig) -> Iterator[tuple[str, Sound]]:
    """Names and sounds of tests integrated to their end, from the first stroke on: of the acceleration itself, not of
    what a sensor shows."""
    from stickslip import sound
    from stickslip.rig.simulation import RigTests

    tests = RigTests(loaded)
    for number in range(tests.grid.size):
        cell = {name: float(values[0]) for name, values in tests.grid[number : number + 1].items()}
        seconds = float(tests.drive(cell)[:, 0].sum()) - cell["waiting_time"]
        changes = {
            "rate": float(sound.RATE), "bandwidth": None, "force_noise": 0.0, "acceleration_noise": 0.0,
            "oversampling": _FINE if seconds <= _SHORT else _COARSE,
        }  # fmt: skip
        sensor = loaded.sensor.model_copy(update=changes)
        ideal = replace(loaded, config=loaded.config.model_copy(update={"sensor": sensor}))
        (test,) = RigTests(ideal).tests([number])
        if test.record is not None:
            values, title = test.record["acceleration"].values, f"{loaded.config.title}: {test.name}"
            yield _file_name(tests, number), sound.of_record(values, sensor.rate, title=title)


rig = SectionedGroup(
    "rig",
    default="run",
    sections={"Commands": (run, rig_features.features, rig_fits.calibrate, rig_fits.identify)},
    help="""Test rigs: simulated ones, records of measured ones, and the risk number.

    `stickslip rig my_rig.yaml` is short for `stickslip rig run my_rig.yaml`.""",
    short_help="Simulate a test rig, or evaluate records of one.",
    no_args_is_help=True,
)
OLD = (  # spellings of earlier versions, which go on working
    renamed(rig_features.features, "rig-features"),
    renamed(rig_fits.calibrate, "calibrate"),
)
