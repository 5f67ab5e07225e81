"""`rig`: a test matrix on a simulated rig, and the commands for records of measured ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import SectionedGroup, params, screen
from stickslip.cli.outputs import Outputs, save_plot
from stickslip.cli.run import BLOCKS, run_request, shard_of
from stickslip.cli.screen import JSON, QUIET, fail, reports_errors
from stickslip_rig.commands import features

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location
    from stickslip_rig.api import RigTests

_MOST_TRACES = 6  # drawn over each other


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
@features.PART
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
    tests, window = RigTests(loaded), features.time_window(begin, end)
    for number in chosen:
        if not 0 <= number < tests.grid.size:
            fail(f"--test {number}: tests are numbered from 0 to {tests.grid.size - 1}")
    if chosen and plot is None and report is None:
        fail("--test says what is plotted: name a plot with --plot, or a page with --report")
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
            "run": "stickslip_rig.commands.run",
            "features": "stickslip_rig.commands.features",
            "friction": "stickslip_rig.commands.friction",
            "calibrate": "stickslip_rig.commands.features",
        }
    },
    help="""Test rigs: simulated ones, records of measured ones, and the risk number.

    `stickslip rig my_rig.yaml` is short for `stickslip rig run my_rig.yaml`.""",
    short_help="Simulate a test rig, or evaluate records of one.",
    no_args_is_help=True,
)
