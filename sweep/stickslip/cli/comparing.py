"""`compare`: which material keeps a contact quiet."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip.cli import screen
from stickslip.cli.common import JSON, Target, fail, points_file, prepare_kernels, reports_wrong_input, tell_json
from stickslip.cli.fits import POINTS, columns, fitted, tell_columns, wanted_of
from stickslip.cli.progress import progress_bar
from stickslip.cli.tables import tell_table, write_table

if TYPE_CHECKING:
    from collections.abc import Iterable

    import xarray as xr

    from stickslip.materials.table import RankColumn, RankTable

_ASKED = (
    "belt_speed",
    "speed_range_from",
    "speed_range_to",
    "friction_scale",
    "searched_from",
    "searched_to",
    "tendency_at",
    "confidence",
    "draws",
    "seed",
)
_EXAMPLES = {"mass": "100 g", "stiffness": "5 N/mm", "load": "10 N"}


class _Asking(click.Command):
    """A command that names all options it lacks at once."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As of any command. Raises UsageError."""
        given = list(args)
        try:
            return super().parse_args(ctx, args)
        except click.MissingParameter:
            found = self.make_parser(ctx).parse_args(given)[0]
            is_given = {name: isinstance(value, str | tuple) and bool(value) for name, value in found.items()}
            lacking = [one for one in self.params if one.required and not is_given.get(str(one.name))]
            names = ", ".join(one.get_error_hint(ctx).replace("'", "") for one in lacking)
            told = [f'{one.opts[0]} "{_EXAMPLES[str(one.name)]}"' for one in lacking if one.name in _EXAMPLES]
            hint = f"\nhint: for instance {' '.join(told)}" if told else ""
            raise click.UsageError(f"missing {names}{hint}", ctx) from None


@click.command(
    cls=_Asking,
    epilog="""\b
Examples:
  stickslip compare configs/measured/dry.csv configs/measured/grease_a.csv \\
      --mass "100 g" --stiffness "5 N/mm" --load "10 N" --damping "1 N s/m" --speed "30 mm/s"
  stickslip compare configs/measured/table.csv --mass "100 g" --stiffness "5 N/mm" \\
      --load "10 N" --plot materials.png -o ranks.xlsx""",
)
@POINTS
@click.option("--mass", required=True, help='Of the oscillator: kg, or with a unit ("100 g").')
@click.option("--stiffness", required=True, help='Of its spring: N/m, or with a unit ("5 N/mm").')
@click.option(
    "--load",
    required=True,
    multiple=True,
    help='Normal load: N, or with a unit ("2 kN"); several, or a range ("5..20 N").',
)
@click.option(
    "--damping",
    multiple=True,
    help='Of its damper: N s/m, "1 N s/m" or, of critical damping, "3 %"; several, or a range ("0.5..5 %").'
    "  [default: 0]",
)
@click.option(
    "--speed",
    multiple=True,
    metavar="SPEED",
    help='Belt speed at which regime and margin are told; several, a column each; or a range ("5..60 mm/s"), '
    "in which it is to be quiet throughout.",
)
@click.option(
    "--scale-friction",
    multiple=True,
    metavar="FACTOR",
    help="Multiply friction, where the part has another than the rig; several, or a range.  [default: 1]",
)
@click.option("--between", nargs=2, metavar="LOW HIGH", help="Belt speeds to search.  [default: from the points]")
@columns
@click.option("--level", type=float, default=0.95, show_default=True, help="Of confidence of the intervals.")
@click.option("--draws", type=int, default=1000, show_default=True, help="Curves drawn a material; 0: no intervals.")
@click.option("--seed", type=int, default=1, show_default=True, help="Of the draws.")
@click.option(
    "--decimal-comma", is_flag=True, help="Write decimal commas, and semicolons between columns, into CSV."
)  # fmt: skip
@click.option(
    "-o", "--output", "outputs", type=Target("table", "result"), multiple=True,
    help="File to write: .csv or .xlsx (the table), .nc or .zarr (all of it); repeatable.",
)  # fmt: skip
@click.option("--plot", type=Target("plot"), help="Plot to write: .png, .svg or .pdf.")
@click.option("--title", help="Of plot and page.")
@click.option("--report", type=Target("page"), help="Page to write (.html, .pdf): ranks, plot, fits.")
@JSON
@reports_wrong_input
def compare(
    files: tuple[Path, ...], mass: str, stiffness: str, load: tuple[str, ...], damping: tuple[str, ...],
    speed: tuple[str, ...], scale_friction: tuple[str, ...],
    between: tuple[str, str] | None, unit: str | None, speed_column: str | None, friction_column: tuple[str, ...],
    same: tuple[str, ...], level: float, draws: int, seed: int, outputs: tuple[Path, ...], plot: Path | None,
    title: str | None, report: Path | None, decimal_comma: bool, as_json: bool,
) -> None:  # fmt: skip
    """Rank materials by the belt speed above which each is quiet.

    Fits a friction curve to the points of each FILE (of each column of friction in a table of several), and finds where
    the vibration that begins in stick ends for good, to nine digits, with the interval that the scatter of the points
    leaves. FILES are CSV as instruments and Excel write it; see `stickslip fit`.
    """
    from stickslip.dataset.display import with_units
    from stickslip.errors import Interrupted
    from stickslip.materials import compare as compared
    from stickslip.materials.table import RankTable

    one_load = load[0] if len(load) == 1 and ".." not in load[0] else None
    wanted = wanted_of(unit, speed_column, friction_column, load=one_load)
    fits = fitted([points_file(file) for file in files], wanted, not as_json, same)
    if not as_json:
        tell_columns(fits)
    prepare_kernels("stribeck")
    try:
        with progress_bar(1, " compared", "curves") as move:
            ds = compared(
                fits, mass=mass, stiffness=stiffness, normal_load=_one(load),
                damping=_one(damping) if damping else None, belt_speed=_one(speed) if speed else None,
                friction_scale=_one(scale_friction) if scale_friction else 1.0, between=between, level=level,
                draws=draws, seed=seed, progress=move,
            )  # fmt: skip
    except Interrupted:
        fail("interrupted: nothing was written; a comparison takes seconds, run it again")
    except ValueError as error:
        fail(error)
    if unit_shown := _unit_of(speed):
        ds = with_units(
            ds, {str(name): unit_shown for name, one in ds.variables.items() if one.attrs.get("units") == "m s-1"}
        )
    ds = ds if title is None else ds.assign_attrs(title=title)
    ranking = RankTable(ds)
    if not as_json:
        _show(ranking)
    written = _write(ds, outputs, plot, report, as_json, "," if decimal_comma else ".")
    if as_json:
        from stickslip.fit.report import columns_of

        every = [each for one in fits for each in one.repeats or (one,)]
        read = {one.name: {"file": str(one.path), **columns_of(one)} for one in every}
        tell_json(_answer(ds, ranking, written) | {"read": read})


def _one(given: tuple[str, ...]) -> str | tuple[str, ...]:
    """What an option that may be repeated was given: the only text, or all of them."""
    return given[0] if len(given) == 1 else given


def _unit_of(speeds: tuple[str, ...]) -> str | None:
    """The unit in which the belt speeds were given, for the table."""
    found = [speed.rpartition("..")[2].lstrip("+-.0123456789eE ").strip() for speed in speeds]
    return next(filter(None, found), None)


def tell(ds: xr.Dataset, as_json: bool) -> None:
    """Say what is in the file of a comparison: what the command said."""
    from stickslip.materials.table import RankTable

    if as_json:
        return tell_json(_answer(ds, RankTable(ds), {}))
    _show(RankTable(ds))


def _show(ranking: RankTable) -> None:
    """The table of ranks, and remarks."""
    screen.echo(f"system   {', '.join(f'{name} {value}' for name, value in ranking.conditions())}\n")
    _print_table(ranking.columns())
    if ranking.speeds:
        screen.echo(ranking.answer())
    for remark in ranking.remarks():
        screen.echo(f"note     {remark}")
    for _, borders, remarks in ranking.variations():
        _print_table(borders)
        for remark in remarks:
            screen.echo(f"note     {remark}")
    for text in ranking.method():
        screen.echo(text)


def _print_table(columns: Iterable[RankColumn]) -> None:
    from rich.markup import escape
    from rich.table import Table

    shown = [*columns]
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in shown:
        table.add_column(f"{escape(column.name)}\n{escape(column.unit)}", justify="left" if column.is_text else "right")
    for row in zip(*(column.cells for column in shown), strict=True):
        table.add_row(*map(escape, row))
    screen.terminal().print(table)


def _write(
    ds: xr.Dataset,
    outputs: tuple[Path, ...],
    plot: Path | None,
    report: Path | None,
    silent: bool,
    decimal: str,
) -> dict[str, str]:
    """Everything that is asked for; what was written, by kind."""
    from stickslip.files import writing
    from stickslip.files.targets import KINDS

    written = {}
    for output in outputs:
        if output.suffix.lower() in KINDS["table"].suffixes:
            table = write_table(ds, output, decimal=decimal)
            if not silent:
                tell_table(table, output)
        else:
            writing.write(ds, output)
            if not silent:
                screen.echo(f"written  {output} ({screen.size_of(output)})")
        written[output.suffix[1:].lower()] = str(output)
    if plot is not None:
        from stickslip import plots

        plots.save(plots.plot_materials(ds), plot)
        written["plot"] = str(plot)
        if not silent:
            screen.echo(f"plot     {plot}")
    if report is not None:
        from stickslip.materials.page import material_page
        from stickslip.pages import write_page

        write_page(report, material_page(ds))
        written["report"] = str(report)
        if not silent:
            screen.echo(f"report   {report}")
    return written


def _answer(ds: xr.Dataset, ranking: RankTable, written: dict[str, str]) -> dict[str, Any]:
    """The comparison for programs, in SI."""
    from stickslip.dataset.export import table_of

    several = "belt_speed" in ds.dims
    shared = ds.drop_dims("belt_speed") if several else ds
    materials = [_row(shared, i) for i in range(ds.sizes["material"])]
    for i, one in enumerate(materials):
        if several:
            at = ds.drop_vars([name for name in shared.data_vars if name not in ("quiet_above", "quiet_state")])
            rows = [_row(at.isel(belt_speed=j), i) for j in range(len(ranking.speeds))]
            one["at"] = [{name: value for name, value in row.items() if name not in one or name == "margin"}
                         | {"belt_speed": speed} for row, speed in zip(rows, ranking.speeds, strict=True)]  # fmt: skip
        for name in ranking.varied:
            one[f"quiet_above_over_{name}"] = ds[f"quiet_above_over_{name}"].values[i].tolist()
    units = {name: str(array.attrs["units"]) for name, array in table_of(ds).columns.items() if "units" in array.attrs}
    system = {name.removeprefix("system_"): ds.attrs[name] for name in ds.attrs if name.startswith("system_")}
    asked = {name: ds.attrs[name] for name in _ASKED if name in ds.attrs}
    asked |= {name: ds[name].values.tolist() for name in ranking.varied}
    return {"materials": materials, "units": units, "system": system, **asked, "remarks": ranking.remarks(),
            "written": written}  # fmt: skip


def _row(ds: xr.Dataset, i: int) -> dict[str, Any]:
    """What is known of a material, flags as words."""
    from stickslip.dataset.export import table_of
    from stickslip.vocabulary.flags import FLAGS

    found = {"name": str(ds["material"].values[i])}
    for name, array in table_of(ds).columns.items():
        if name != "material":
            value = array.values[i].tolist() if hasattr(array.values[i], "tolist") else array.values[i]
            found[name] = [*FLAGS[name]][value] if name in FLAGS else value
    return found
