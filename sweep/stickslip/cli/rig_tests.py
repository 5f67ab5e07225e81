"""`rig`: a test matrix on a simulated rig."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

import click

from stickslip.cli import rig_sounds, screen
from stickslip.cli.common import (
    CONFIG,
    Target,
    fail,
    incomplete,
    location_or_none,
    prepare_kernels,
    reports_wrong_input,
    settings,
)
from stickslip.cli.progress import progress_bar
from stickslip.cli.rig import feature_screen_table, time_window, warn_of_extrapolation

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location
    from stickslip.rig.config import RigConfig
    from stickslip.rig.simulation import RigTests

_MOST_TRACES = 6  # drawn over each other
_MOST_ROWS = 60  # on screen


@click.command(
    epilog="""\b
Examples:
  stickslip rig run configs/rig/materials.yaml
  stickslip rig run configs/rig/materials.yaml --test 0 --test 1 --from 0 --to "0.5 s"
  stickslip rig run configs/rig/test_matrix.yaml --report matrix.html
  stickslip rig run my.yaml --records signals       # CSV files, as a rig would write them"""
)
@CONFIG
@click.option(
    "-o", "--output", type=Target("result"), help="File of features to write, .nc or .zarr, or the URL of a .zarr."
)
@click.option("--plot", type=Target("plot"), help="Plot: signals of up to six tests, else a heat map.")
@click.option("--report", type=Target("page"), help="Page to write (.html, .pdf): maps, traces, table.")
@click.option("--records", type=Target("folder"), help="Folder for the signals, a CSV file for each test.")
@click.option("--sound", type=Target("sound", "folder"), help="Folder for the sounds, a WAV file for each test.")
@click.option("--test", "chosen", type=int, multiple=True, metavar="N", help="Plot this test; repeatable.")
@click.option("--beside", is_flag=True, help="Plot signals beside each other instead of over each other.")
@click.option("--from", "begin", metavar="TIME", help="Plot only from this time of each test on.")
@click.option("--to", "end", metavar="TIME", help="Plot only up to this time of each test.")
@reports_wrong_input
def rig(
    config: Path,
    output: Location | None,
    plot: Path | None,
    report: Path | None,
    records: Path | None,
    sound: Path | None,
    chosen: tuple[int, ...],
    beside: bool,
    begin: str | None,
    end: str | None,
) -> None:
    """Compute a test matrix on a simulated rig.

    A specimen on a flat spring, a reciprocating plate, sensors: CONFIG is that of a map with a drive. Prints
    features and model RPN (not the rig maker's) of every test. Times count from the first stroke.
    """
    from stickslip.files import writing
    from stickslip.rig.config import load_rig
    from stickslip.rig.simulation import RigTests, run_matrix

    asked = load_rig(config, settings())
    output = output or location_or_none(asked.config.output.file, "result")
    plot = plot or location_or_none(asked.config.output.plot, "plot")
    tests, window = RigTests(asked), time_window(begin, end)
    drawn = _drawn(tests, chosen)
    if chosen and plot is None and report is None:
        fail("--test says what is plotted: name a plot with --plot, or a page with --report")
    if sound is not None:
        rig_sounds.check(sound, tests.grid.size)
    prepare_kernels(asked.config.friction.law, signals=True)
    size = tests.grid.size
    screen.echo(f"{asked.config.title}\n{_counted(tests)}")
    began = perf_counter()
    try:
        with progress_bar(size, of="tests") as moved:
            found = run_matrix(asked, moved)
    except KeyboardInterrupt:
        incomplete("interrupted: nothing was written; a matrix takes seconds, run it again")
    _show(found, tests, perf_counter() - began)
    if plot is not None:
        _draw(plot, found, tests, drawn, beside, window)
    if output is not None:
        writing.write(found, output)
        screen.echo(f"features  {output} ({screen.size_of(output)})")
    if records is not None:
        _write_records(records, tests)
    if sound is not None:
        rig_sounds.write_tests(sound, asked)
    if report is not None:
        _write_report(report, found, asked, tests, drawn)


def _drawn(tests: RigTests, chosen: tuple[int, ...]) -> list[int]:
    """The tests whose signals are drawn; none where there are too many to choose automatically."""
    size = tests.grid.size
    for number in chosen:
        if not 0 <= number < size:
            fail(f"--test {number}: tests are numbered from 0 to {size - 1}")
    return list(chosen) or (list(range(size)) if size <= _MOST_TRACES else [])


def _counted(tests: RigTests) -> str:
    """`108 tests: material (4) x belt_speed (3) x ...`."""
    grid = tests.grid
    along = " x ".join(f"{dim} ({size})" for dim, size in zip(grid.dims, grid.shape, strict=True))
    return f"{grid.size:,} tests: {along}" if along else "one test"


def _show(found: xr.Dataset, tests: RigTests, seconds: float) -> None:
    """The table, tests that were not integrated to their end, and how long it took."""
    import numpy as np

    from stickslip import rig as rigs
    from stickslip.rig.simulation import as_table
    from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES

    console = screen.terminal()
    table = as_table(found, [tests.name(n) for n in range(min(tests.grid.size, _MOST_ROWS))])
    console.print(feature_screen_table(table, console.width))
    if tests.grid.size > _MOST_ROWS:
        console.print(f"... and {tests.grid.size - _MOST_ROWS:,} more", markup=False)
    console.print(f"RPN: {rigs.RPN_NAME}. Green 1 to 3, yellow 4 and 5, red 6 to 10.", markup=False)
    warn_of_extrapolation(table, tests.rig.risk)
    status = found["status"].values
    for code in np.unique(status[status != STATUSES.index("horizon_reached")]).tolist():
        number, message = int((status == code).sum()), STATUS_MESSAGES[STATUSES[code]]
        many = "1 test was" if number == 1 else f"{number:,} tests were"
        screen.echo(f"warning: {many} not integrated to the end: {message}", err=True)
    console.print(f"{tests.grid.size:,} tests in {screen.duration_text(seconds)}", markup=False)


def _draw(
    plot: Path,
    found: xr.Dataset,
    tests: RigTests,
    drawn: list[int],
    beside: bool,
    window: tuple[float, float] | None,
) -> None:
    """Signals where some were chosen or there are few tests, else the matrix."""
    from stickslip import plots

    records = _records(tests, drawn)
    if records:
        from stickslip.rig.plots import plot_records

        rpn = found["model_rpn"].values.ravel()
        numbers = {tests.name(n): float(rpn[n]) for n in drawn}
        figure = plot_records(records, beside=beside, numbers=numbers, window=window, heading=tests.rig.config.title)
    else:
        from stickslip.rig.plots import plot_matrix

        figure = plot_matrix(found)
    plots.save(figure, plot)
    screen.echo(f"plot      {plot}")


def _records(tests: RigTests, numbers: list[int]) -> dict[str, xr.Dataset]:
    """Records by name, of the tests that were integrated to their end."""
    return {test.name: test.record for test in tests.tests(numbers) if test.record is not None}


def _write_records(folder: Path, tests: RigTests) -> None:
    from stickslip.rig.records import write_record

    digits = len(str(tests.grid.size - 1))
    for test in tests.tests(range(tests.grid.size)):
        if test.record is not None:
            write_record(test.record, folder / f"test{test.number:0{digits}d}.csv")
    screen.echo(f"records   {folder}/test*.csv; stickslip rig features reads them")


def _write_report(report: Path, found: xr.Dataset, asked: RigConfig, tests: RigTests, drawn: list[int]) -> None:
    from stickslip.rig.report import write_report

    write_report(report, found, _records(tests, drawn or list(range(min(tests.grid.size, _MOST_TRACES)))), asked)
    screen.echo(f"report    {report} ({screen.size_of(report)})")
