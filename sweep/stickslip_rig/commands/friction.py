"""`rig friction`: friction while slip speeds up and slows down, from records of stick-slip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.outputs import save_plot, save_result, show_file
from stickslip.cli.screen import JSON, Answer, fail, refuses_bad_input, reports_errors
from stickslip_rig.commands.rig import CONFIG_OPTION, read_files

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.files.locations import Location


@click.command(
    "friction",
    epilog="""\b
Examples:
  stickslip rig friction felt.csv --mass "100 g" --stiffness "5 N/mm" -o friction.csv
  stickslip fit friction.csv                                   # the curve, with mu_stop
  stickslip rig friction a.csv b.csv --stiffness "5 N/mm" --stiffness "20 N/mm" """,
)
@params.RECORDS
@CONFIG_OPTION
@click.option("--mass", metavar="MASS", help='Of the specimen and what moves with it ("100 g").')
@click.option("--stiffness", metavar="STIFFNESS", multiple=True, help='Of the spring ("5 N/mm"); one, or one per file.')
@click.option("--damping", metavar="DAMPING", help='Beside friction ("0.5 N s/m").  [default: none]')
@click.option("--load", metavar="FORCE", help='Normal load ("10 N").')
@click.option("--speed", metavar="SPEED", help='Of the drive, where files do not record it ("10 mm/s").')
@params.plot_option("Plot of friction over slip speed: .png, .svg or .pdf.")
@click.option("-o", "--output", type=params.Target("points", "result"),
              help="File: .csv with the points, for stickslip fit; .nc or .zarr with all that is known.")  # fmt: skip
@JSON
@reports_errors
def friction(
    files: tuple[Path, ...], config: Path | None, mass: str | None, stiffness: tuple[str, ...], damping: str | None,
    load: str | None, speed: str | None, plot: Path | None, output: Location | None,
) -> Answer:  # fmt: skip
    """Friction while slip speeds up and slows down, from records of stick-slip.

    Each FILE is a record as of `stickslip rig features`, with the acceleration. Remarks in it, "# mass: 100 g", hold
    before options. Prints friction at break-away, at the turning point and just before standstill, and the
    tendency of Eq. (3), mu_start - 2 mu_reversal + mu_stop, with 95 % intervals; what a record does not tell is a dash,
    with the reason.
    """
    from stickslip.config.yaml import Setting
    from stickslip.dataset.build import provenance
    from stickslip_rig import api as rig
    from stickslip_rig.friction import friction_table

    if len(stiffness) not in (0, 1, len(files)):
        fail(f"--stiffness: got {len(stiffness)} for {len(files)} files, expected one, or one for each")
    settings = []
    for i in range(len(files)):
        spring = stiffness[i % len(stiffness)] if stiffness else None
        rows = {"mass": mass, "stiffness": spring, "damping": damping, "normal_load": load, "drive_speed": speed}
        given = [Setting(f"--{key} {text}", f"conditions.{key}", text) for key, text in rows.items() if text]
        settings.append(rig.load_settings(config, given))
    records = read_files(files, settings, {"normal_load": load, "drive_speed": speed})
    with refuses_bad_input(", ".join(map(str, files))):
        ds = friction_table(records, settings[0].features)
    action = f"rig-friction {' '.join(map(str, files))}"
    ds = ds.assign_attrs(provenance(settings[0].to_yaml(), title=str(ds.attrs["title"]), action=action))
    show(ds)
    if plot is not None:
        from stickslip_rig.plots import plot_friction

        save_plot(plot_friction(ds), plot)
    if isinstance(output, Path) and output.suffix.lower() == ".csv":
        write_points(ds, output)
        show_file("points", output, "stickslip fit reads them")
    else:
        save_result(ds, output, "friction")
    return lambda: {"records": answers(ds), "output": output, "plot": plot}


def write_points(ds: xr.Dataset, path: Path) -> None:
    """The points of records as CSV that `stickslip fit` and `stickslip compare` read: a material each."""
    from stickslip.files.targets import replaced

    speed, names = "speed [mm/s]", ("slip_speed", "friction", "friction_sigma", "friction_scatter")
    table = ds[[*names]].reset_coords(drop=True).to_dataframe().dropna(subset="friction_sigma").reset_index()
    table["slip_speed"] *= 1e3
    table = table.sort_values(["record", "direction", "slip_speed"], ascending=[True, False, True])
    table = table.rename(columns=dict(zip(names, (speed, "mu", "sigma", "scatter"), strict=True), record="material"))
    shown = ["material"] * (ds.sizes["record"] > 1) + [speed, "mu", "sigma", "direction", "scatter"]
    with replaced(path) as temporary:
        table[shown].to_csv(temporary, index=False, float_format="%.6g")


def show(ds: xr.Dataset) -> None:
    """Print the coefficients of records, and what to mind of each."""
    from stickslip.config.studies import ReportTable
    from stickslip.vocabulary.display_units import number, quantity
    from stickslip_rig.friction import COEFFICIENTS

    def cell(row: Mapping[str, Any], name: str) -> str:
        value, factor = row[name], 1e3 if name == "v_reversal" else 1.0
        return f"{value * factor:.4g} ± {number((row[f'{name}_high'] - value) * factor, 2)}" if value == value else "–"

    rows = answers(ds)
    lines: list[Sequence[str]] = []
    for row in rows:
        head = [row["record"], quantity(row["stiffness"], "N m-1"), f"{row['slips_used']:.0f}"]
        lines.append([*head, *(cell(row, name) for name in COEFFICIENTS)])
    headings = [name if name != "v_reversal" else "v_reversal [mm/s]" for name in COEFFICIENTS]
    screen.echo(ReportTable("", ("record",), ("stiffness", "slips", *headings), lines).text())
    for row in rows:
        if row["remarks"]:
            screen.echo(f"{row['record']}: " + row["remarks"].replace("\n", "\n  "))


def answers(ds: xr.Dataset) -> list[dict[str, Any]]:
    """What is known of each record, without its points."""
    return [
        {str(k): v for k, v in row.items()}
        for row in ds.drop_dims(["direction", "bin"]).to_dataframe().reset_index().to_dict("records")
    ]
