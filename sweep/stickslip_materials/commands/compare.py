"""`compare`: which material keeps a contact quiet."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import save_page, save_plot, save_result, save_table, show_result
from stickslip.cli.screen import JSON, Answer, refuses_bad_input, reports_errors
from stickslip_materials.commands.fit import COLUMNS, column_choice, fit_files, show_columns

if TYPE_CHECKING:
    import xarray as xr

_SEVERAL = partial(click.option, multiple=True)


@click.command(
    epilog="""\b
Examples:
  stickslip compare configs/measured/dry.csv configs/measured/grease_a.csv \\
      --mass "100 g" --stiffness "5 N/mm" --load "10 N" --damping "1 N s/m" --speed "30 mm/s"
  stickslip compare configs/measured/table.csv --mass "100 g" --stiffness "5 N/mm" \\
      --load "10 N" --plot materials.png -o ranks.xlsx""",
)
@params.RECORDS
@click.option("--mass", required=True, help='Of the oscillator: kg, or with a unit ("100 g").')
@click.option("--stiffness", required=True, help='Of its spring: N/m, or with a unit ("5 N/mm").')
@click.option("--load", required=True, help='Normal load: N, or with a unit ("2 kN").')
@click.option("--damping", help='Of its damper: N s/m, "1 N s/m" or, of critical damping, "3 %".  [default: 0]')
@_SEVERAL("--speed", metavar="SPEED", help="Belt speed at which regime and margin are told; several, a column each; or "
          'a range ("5..60 mm/s"), in which it is to be quiet throughout.')  # fmt: skip
@click.option("--between", nargs=2, metavar="LOW HIGH", help="Belt speeds to search.  [default: from the points]")
@COLUMNS
@click.option("--level", type=float, default=0.95, show_default=True, help="Of confidence of the intervals.")
@click.option("--draws", type=int, default=1000, show_default=True, help="Curves drawn a material; 0: no intervals.")
@click.option("--seed", type=int, default=1, show_default=True, help="Of the draws.")
@_SEVERAL("-o", "--output", "outputs", type=params.Target("table", "result"),
          help="File to write: .csv or .xlsx (the table), .nc or .zarr (all of it); repeatable.")  # fmt: skip
@params.plot_option()
@click.option("--title", help="Of plot and page.")
@click.option("--report", type=params.Target("page"), help="Page to write (.html): ranks, plot, fits.")
@JSON
@reports_errors
def compare(
    files: tuple[Path, ...], mass: str, stiffness: str, load: str, damping: str | None, speed: tuple[str, ...],
    between: tuple[str, str] | None, level: float, draws: int, seed: int, outputs: tuple[Path, ...], plot: Path | None,
    title: str | None, report: Path | None,
) -> Answer:  # fmt: skip
    """Rank materials by the belt speed above which each is quiet.

    Fits a friction curve to the points of each FILE (of each column of friction in a table of several), and finds where
    the vibration that begins in stick ends for good, to nine digits, with the interval that the scatter of the points
    leaves. FILES are CSV as instruments and Excel write it; see `stickslip fit`.
    """
    from stickslip.dataset.display import with_units
    from stickslip_materials.compare.compare import compare as compared

    fits = fit_files(files, column_choice(load), ageing=False)
    show_columns(fits)
    with refuses_bad_input(""), screen.progress_bar("curves", " compared") as move:
        ds = compared(
            fits, mass=mass, stiffness=stiffness, normal_load=load, damping=damping,
            belt_speed=(speed[0] if len(speed) == 1 else speed) or None, between=between, level=level, draws=draws,
            seed=seed, progress=move,
        )  # fmt: skip
    if speed_unit := _unit_of(speed):
        speeds = [str(name) for name, values in ds.variables.items() if values.attrs.get("units") == "m s-1"]
        ds = with_units(ds, dict.fromkeys(speeds, speed_unit))
    ds = ds if title is None else ds.assign_attrs(title=title)
    show_result(ds)
    written = _save(ds, outputs, plot, report)

    def for_programs() -> dict[str, Any]:
        from stickslip_materials.compare.result import Comparison
        from stickslip_materials.fit.report import columns_of

        parts = [part for fit in fits for part in fit.parts]
        read = {part.name: {"file": str(part.path), **columns_of(part)} for part in parts}
        return {**Comparison.answer(ds), "written": written, "read": read}

    return for_programs


def _unit_of(speeds: tuple[str, ...]) -> str | None:
    """The unit in which the belt speeds were given, for the table."""
    units = [speed.rpartition("..")[2].lstrip("+-.0123456789eE ").strip() for speed in speeds]
    return next(filter(None, units), None)


def _save(ds: xr.Dataset, outputs: tuple[Path, ...], plot: Path | None, report: Path | None) -> dict[str, str]:
    """Write everything that is asked for; what was written, by kind."""
    from stickslip.files.targets import KINDS

    for output in outputs:
        if output.suffix.lower() in KINDS["table"].suffixes:
            save_table(ds, output)
        else:
            save_result(ds, output)
    save_plot(lambda plots: plots.plot_result(ds), plot)
    if report is not None:
        save_page(ds, report)
    files = {output.suffix[1:].lower(): output for output in outputs} | {"plot": plot, "report": report}
    return {kind: str(file) for kind, file in files.items() if file is not None}
