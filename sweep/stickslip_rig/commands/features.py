"""`rig features`: records of a test rig."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import params, screen
from stickslip.cli.exits import JSON, Answer, fail, refuses_bad_input, reports_errors
from stickslip.cli.outputs import save_plot, save_result, save_table, show_result
from stickslip.errors import UnitWarning, visible
from stickslip.vocabulary import units
from stickslip_rig.commands import sounds

if TYPE_CHECKING:
    import xarray as xr
    from rich.console import Group

    from stickslip.files.locations import Location
    from stickslip_rig.risk import Risk
    from stickslip_rig.settings import Settings

CONFIG_OPTION = click.option(
    "-c", "--config", type=click.Path(path_type=Path), help="YAML: columns, units, conditions, features, risk."
)
_FASTEST = 1.0  # m/s; a plate moves no faster, and what does so lacks its unit
_NEEDED = {"normal_load": "no normal_load (no friction coefficients)", "drive_speed": "no drive_speed"}
_MOST_NAMES = 5  # of records in a warning
_MOST_ROWS = 60  # on screen
_COLUMN_WIDTH = 9  # characters with the gap, at most
_COLOURS = {"green": "black on green", "yellow": "black on yellow", "red": "white on red", "unknown": ""}


def PART(command: params.Command) -> params.Command:  # noqa: N802, a decorator as `CONFIG_OPTION`
    """The options `--beside`, `--from` and `--to`; `time_window` reads the latter two."""
    return params.decorated(
        command,
        click.option("--beside", is_flag=True, help="Plot signals beside each other instead of over each other."),
        click.option("--from", "begin", metavar="TIME", help="Plot only from this time of each test on."),
        click.option("--to", "end", metavar="TIME", help="Plot only up to this time of each test."),
    )


def CONDITIONS(command: params.Command) -> params.Command:  # noqa: N802, a decorator as `CONFIG_OPTION`
    """The options `--load`, `--speed` and `--bandwidth`; `record_settings` reads them."""
    return params.decorated(
        command,
        click.option("--load", metavar="FORCE", help='Normal load, for friction coefficients ("10 N").'),
        click.option("--speed", metavar="SPEED", help='Of the drive, where files do not record it ("10 mm/s").'),
        click.option("--bandwidth", metavar="FREQUENCY", help='Of the acceleration, limits what is used ("2 kHz").'),
    )


@click.command(
    "features",
    epilog="""\b
Examples:
  stickslip rig features felt.csv fluid.csv
  stickslip rig features *.csv -c rig.yaml --plot traces.png --beside -o features.nc
  stickslip rig features *.csv -o features.csv    # with a column rpn, for stickslip rig calibrate
  stickslip rig features dry.csv --bandwidth "2 kHz" --plot start.png --from 0 --to "2 s" """,
)
@params.RECORDS
@CONFIG_OPTION
@CONDITIONS
@params.plot_option()
@sounds.sound_option("record")
@PART
@click.option(
    "-o", "--output", type=params.Target("table", "result"),
    help="File to write the features to: .csv, .xlsx, .nc or .zarr.",
)  # fmt: skip
@JSON
@reports_errors
def features(
    files: tuple[Path, ...], config: Path | None, load: str | None, speed: str | None, bandwidth: str | None,
    plot: Path | None, beside: bool, begin: str | None, end: str | None, output: Location | None,
    sound: Path | None = None,
) -> Answer:  # fmt: skip
    """Compute features and a risk number of rig records.

    Each FILE is a CSV with the columns time and force, and, if known, acceleration and drive_velocity or
    drive_displacement; units are given in the header, "time [ms]". The risk number is a model RPN, not the rig maker's,
    and needs the acceleration.
    """
    from stickslip.dataset.provenance import provenance
    from stickslip.files.targets import KINDS
    from stickslip_rig import api as rig
    from stickslip_rig.evaluation import as_columns
    from stickslip_rig.risk import band_of

    settings = record_settings(config, load, speed, bandwidth)
    sounds.check_sounds(sound, len(files))
    window = time_window(begin, end)
    records: dict[str, xr.Dataset] = {}
    given = {name: text for name, text in (("normal_load", load), ("drive_speed", speed)) if text is not None}
    for name, file in zip(_names(files), files, strict=True):
        with screen.progress_bar("bytes", " read") as move:  # which only moves for long records
            record = rig.read_record(file, settings.record, settings.conditions, move)
        _show_overruled(file, record, given, settings)
        if left := record.attrs["not_used"]:
            screen.echo(f"note     {file}: columns not used: {', '.join(map(repr, left))}")
        records[_title(name, file, record, records)] = record
    with refuses_bad_input(", ".join(map(str, files))):
        ds = rig.feature_table(records, settings)
    show_result(ds)
    _show_conditions(records)
    warn_of_extrapolation(ds, settings.risk)
    for name, remarks in zip(records, ds["remarks"].values.tolist(), strict=True):
        if remarks:
            screen.echo(f"{name}: " + remarks.replace("\n", "\n  "))
    if plot is not None:
        from stickslip_rig.plots import plot_records

        numbers = dict(zip(records, ds["model_rpn"].values.tolist(), strict=True))
        save_plot(plot_records(records, beside=beside, numbers=numbers, window=window), plot)
    if sound is not None:
        sounds.save_sounds(sound, _sounds(records))
    action = f"rig-features {' '.join(map(str, files))}"
    ds = ds.assign_attrs(provenance(settings.to_yaml(), title="Features of rig records", action=action))
    if isinstance(output, Path) and output.suffix.lower() in KINDS["table"].suffixes:
        save_table(as_columns(ds), output)
    else:
        save_result(ds, output, "features")

    def answer() -> dict[str, Any]:
        rows = as_columns(ds).to_dataframe().reset_index().to_dict("records")
        for file, row in zip(files, rows, strict=True):
            row |= {"file": file, "model_rpn_band": band_of(row["model_rpn"])}
        return {"rpn": rig.RPN_NAME, "records": rows, "output": output, "plot": plot}

    return answer


def _names(files: tuple[Path, ...]) -> list[str]:
    """A name for each file: its stem, with the folder before it where stems repeat, or all of its path."""
    if len(set(files)) < len(files):
        fail("a file is named twice")
    for parts in (1, 2):
        names = ["/".join(file.with_suffix("").parts[-parts:]) for file in files]
        if len(set(names)) == len(names):
            return names
    return list(map(str, files))


def _title(name: str, file: Path, record: xr.Dataset, others: Collection[str]) -> str:
    """The name of a record: its material, where the file names one and no other record has it, else `name`."""
    material = str(record["material"].item()) if "material" in record.coords else file.stem
    if material == file.stem:
        return name
    return material if material not in others else f"{material} ({name})"


def _sounds(records: Mapping[str, xr.Dataset]) -> Iterator[tuple[str, Any]]:
    """Names of files and the sound of every record, as its sensor shows it."""
    from stickslip.files.targets import NO_FILE_NAME
    from stickslip_rig.signals import evenly, sample_rate

    sound = sounds.maker()

    for name, record in records.items():
        if "acceleration" not in record:
            fail(f"{name}: no column of acceleration, which is what is heard")
        even = evenly(record)
        rate = sample_rate(even["time"].values)
        yield NO_FILE_NAME.sub("_", name), sound.of_record(even["acceleration"].values, rate, title=name)


# --- what the options say ---------------------------------------------------------------------------------------------


def record_settings(config: Path | None, load: str | None, speed: str | None, bandwidth: str | None) -> Settings:
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
    from stickslip.config.select import seconds

    if begin is None and end is None:
        return None
    start = 0.0 if begin is None or begin == "0" else seconds(begin, "--from")
    stop = float("inf") if end is None else seconds(end, "--to")
    if start >= stop:
        fail(f"--from {begin} --to {end}: expected an end after the start")
    return start, stop


# --- on screen --------------------------------------------------------------------------------------------------------


def _show_overruled(file: Path, record: xr.Dataset, given: Mapping[str, str], settings: Settings) -> None:
    """Say which conditions the file gives otherwise than the options do: those of the file hold."""
    for name, text in given.items():
        value = float(record[name])
        if value != settings.conditions[name]:
            unit = units.spelled(record[name].attrs["units"])
            screen.notice(f"{file}: its remark {name} = {value:g} {unit} holds, not the {text} of the option")


def _show_conditions(records: Mapping[str, xr.Dataset]) -> None:
    """Say which conditions and columns were understood, once for all records in which they are the same."""
    from stickslip.vocabulary.display_units import quantity
    from stickslip_rig.vocabulary import CONDITIONS

    names: dict[str, list[str]] = {}
    for name, record in records.items():
        known = [f"{c} {quantity(float(record[c]), row.units)}" for c, row in CONDITIONS.items() if c in record.coords]
        missing = [text for c, text in _NEEDED.items() if c not in record.coords]
        names.setdefault("\n         ".join([", ".join(known + missing), record.attrs["columns"]]), []).append(name)
    for understood, alike in names.items():
        screen.echo(f"read     {_first(alike)}: {understood}")


def _first(names: Sequence[str]) -> str:
    """The first of some names, and how many more there are."""
    more = f" and {len(names) - _MOST_NAMES:,} more" * (len(names) > _MOST_NAMES)
    return ", ".join(names[:_MOST_NAMES]) + more


def warn_of_extrapolation(ds: xr.Dataset, risk: Risk) -> None:
    """Say which records or tests have features outside the pairs of the calibration."""
    from stickslip_rig.evaluation import as_records, risk_inputs

    table = as_records(ds)
    inputs = risk_inputs(table)
    for feature, outside in risk.outside(inputs).items():
        values = zip(table["record"].values[outside].tolist(), inputs[feature][outside], strict=True)
        if names := [f"{name} ({value:.4g})" for name, value in values]:
            low, high = getattr(risk, f"lowest_{feature}"), getattr(risk, f"highest_{feature}")
            screen.notice(
                f"warning: {feature} of {_first(names)}: outside {low:.4g} to {high:.4g}, the range of the pairs of "
                "the calibration, so that the RPN is an extrapolation"
            )


def report(ds: xr.Dataset) -> Iterator[Any]:
    """The features of records or of tests, what the colours of the risk number mean, and tests cut short."""
    from stickslip_rig.evaluation import as_records, unfinished
    from stickslip_rig.risk import RPN_NAME

    console, table = screen.terminal(), as_records(ds)
    yield feature_screen_table(table.isel(record=slice(_MOST_ROWS)), console.width)
    if table.sizes["record"] > _MOST_ROWS:
        yield f"... and {table.sizes['record'] - _MOST_ROWS:,} more"
    yield f"RPN: {RPN_NAME}. Green 1 to 3, yellow 4 and 5, red 6 to 10."
    for sentence, _ in unfinished(ds) if "status" in ds else ():
        screen.notice(f"warning: {sentence}")


def feature_screen_table(ds: xr.Dataset, width: int) -> Group:
    """Features of records (dimension `record`) for the screen, the risk number in the colour of its band.

    width : of the screen, characters. Columns that do not fit beside the names are in further tables below.
    """
    from rich.console import Group
    from rich.text import Text

    from stickslip_rig.evaluation import SHOWN, rated, shown_text
    from stickslip_rig.risk import band_of, rpn_text

    names, numbers = ([str(value) for value in ds["record"].values.tolist()], ds["model_rpn"].values.tolist())
    name_width = min(max(6, *map(len, names)), max(width // 3, 12))
    fit, tables = max(1, (width - name_width - 6) // _COLUMN_WIDTH), []
    for first in range(0, len(SHOWN), fit):
        table, part = screen.new_table(), SHOWN[first : first + fit]
        table.add_column("record", overflow="fold", max_width=name_width)
        for heading in ("RPN", *(f"{column.heading}\n{column.below}".rstrip() for column in part)):
            table.add_column(heading, justify="right", no_wrap=True)
        columns = [[shown_text(column, value) for value in rated(ds, column.feature)] for column in part]
        for name, number, *texts in zip(names, numbers, *columns, strict=True):
            rpn = Text(f" {rpn_text(number)} ", style=_COLOURS[band_of(number)])
            table.add_row(Text(visible(name)), rpn, *texts)
        tables.append(table)
    return Group(*tables)
