"""What becomes of results: said on screen, and written as files, tables, plots and pages, each with a line.

Their names were checked when the options were read (`params.Target`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.cli import screen
from stickslip.cli.params import requested_table
from stickslip.cli.screen import drawing
from stickslip.vocabulary.quantities import flag_label

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.engine import Options
    from stickslip.files.locations import Location
    from stickslip.plots import Look


# --- on screen --------------------------------------------------------------------------------------------------------


def show_result(ds: xr.Dataset, output: Location | None = None) -> None:
    """Print what a result of any kind holds. output : its file, which remarks name."""
    from stickslip.config.studies import ReportTable, result_class

    if (study := result_class(ds)) is None:
        _show_map(ds, output)
    for part in study.report(ds) if study else ():
        if isinstance(part, ReportTable | str):
            screen.echo(part.text() if isinstance(part, ReportTable) else part)
        else:
            screen.terminal().print(part)
    if "audit_bound" in ds.attrs:
        computed, points, wrong = (ds.attrs[key] for key in ("refine_cells_computed", "audit_points", "audit_wrong"))
        screen.row("refined", f"{computed:,} cells computed for {ds['regime'].size:,}")
        screen.row("audit", f"{points:,} random points among the inferred cells, {wrong:,} of them wrong: at most "
                   f"{100 * ds.attrs['audit_bound']:.3g} % of all cells (95 %, Clopper-Pearson)")  # fmt: skip


def rate_text(computed: int, counted: str, seconds: float, machines: str) -> str:
    """`57,600 cells in 0.1 s, 576,000 cells/s on 2 threads`."""
    per_second = computed / max(seconds, 1e-9)
    each = f"{per_second:,.0f} {counted}/s" if per_second >= 10.0 else f"{per_second:.2g} {counted}/s"
    items = counted if computed != 1 else counted.removesuffix("s")
    return f"{computed:,} {items} in {screen.duration_text(seconds)}, {each} on {machines}"


def threads_text(options: Options) -> str:
    """`2 threads`: what a computation with these options runs on."""
    from stickslip import engine

    count = options.threads or engine.processors()
    return f"{count} thread{'s' if count != 1 else ''}"


def _show_map(ds: xr.Dataset, output: Location | None) -> None:
    """Print the regimes of a map, and remarks on cells that have none."""
    from stickslip.config.studies import ReportTable
    from stickslip.dataset.coarse import remark, summary, table_remark

    shares = summary(ds)
    rows = [(flag_label(name), f"{share.cells:,}", screen.share_text(share.fraction)) for name, share in shares.items()]
    screen.echo(ReportTable("", ("regime",), ("cells", "share"), rows).text())
    for text in filter(None, (output and remark(shares, str(output)), table_remark(ds))):
        screen.echo(text)


# --- files ------------------------------------------------------------------------------------------------------------


def show_file(kind: str, target: Location, note: str = "") -> None:
    """Print `kind  file (note, size)`."""
    screen.row(kind, f"{target} ({f'{note}, ' if note else ''}{screen.size_of(target)})")


def save_result(ds: xr.Dataset, target: Location | None, kind: str = "written", note: str = "") -> None:
    """Write a result, if it has a place, and the table that is made of it, if one is asked for."""
    from stickslip.files import writing

    if target is None:
        return
    writing.write(ds, target)
    show_file(kind, target, note)
    save_table(ds, requested_table())


def save_plot(figure: Figure | Callable[[Any], Figure], target: Path | None, note: str = "") -> None:
    """Write a plot, if it has a place. Raises PlotError, StoreError.

    figure : or what makes it of the module `plots`, which is imported once there is something to draw.
    """
    if target is None:
        return
    from stickslip import plots

    plots.save(figure(plots) if callable(figure) else figure, target)
    screen.row("plot", f"{target}{f' ({note})' if note else ''}")


def save_table(ds: xr.Dataset, target: Path | None, variables: tuple[str, ...] = ()) -> None:
    """Write a table, if it has a place. What is left out is said."""
    if target is None:
        return
    from stickslip.dataset import export

    table = export.write_table(ds, target, variables)
    show_file("table", target, f"{table.rows:,} row{'s' * (table.rows != 1)}, {len(table.columns)} columns")
    if table.left_out:
        names = ", ".join(table.left_out)
        screen.row("left out", f"{names}: of other dimensions; write them with stickslip export --variable")


@dataclass(frozen=True)
class Outputs:
    """Files to be made of a result beside it: a plot, a page."""

    plot: Path | None = None
    page: Path | None = None

    def is_lacking(self) -> bool:
        """True if something is to be written though the result is there and was complete already."""
        return bool(self.page or self.plot and not self.plot.exists())

    def save(self, ds: xr.Dataset) -> Path | None:
        """Write everything, and give the plot if there is one. A plot or page that fails is said, and goes without."""
        drawn = None
        if self.plot is not None:
            from stickslip import plots

            with drawing(self.plot):
                if plots.is_drawn(ds):
                    save_plot(result_figure(ds), self.plot)
                    drawn = self.plot
        if self.page is not None:
            with drawing(self.page):
                save_page(ds, self.page)
        save_table(ds, requested_table())
        return drawn


# --- pictures ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PictureOptions:
    """The options of `plot` that shape a picture, as texts."""

    title: str | None = None
    size: str | None = None
    dpi: int | None = None
    units: tuple[str, ...] = ()
    log: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()

    def with_units(self, ds: xr.Dataset) -> xr.Dataset:
        """The dataset, to be shown in the units that are asked for, or that limits have. Raises PlotError."""
        from stickslip.dataset.display import with_units
        from stickslip.plots.marks import pairs
        from stickslip.vocabulary import units

        ends = [end for text in self.limits for end in pairs(text, "LOW..HIGH with a unit")]
        shown = {name: unit for name, text in ends if (unit := units.unit_in(text.rpartition("..")[2]))}
        shown |= {name: unit for text in self.units for name, unit in pairs(text, "UNIT")}
        return with_units(ds, shown) if shown else ds

    def look(self, ds: xr.Dataset) -> Look:
        """The look of a map. Raises PlotError."""
        from stickslip.plots import Look
        from stickslip.plots.marks import marks_in

        files = [text for text in self.marks if "=" not in text]
        marks = [text for text in self.marks if text not in files]
        look = Look.of(ds, log=self.log, limits=self.limits, marks=marks)
        return replace(look, marks=(*look.marks, *(mark for file in files for mark in marks_in(ds, Path(file)))))


PLAIN = PictureOptions()


# --- pictures of results ----------------------------------------------------------------------------------------------


def result_figure(ds: xr.Dataset, picture: PictureOptions = PLAIN) -> Figure:
    """The plot of a result that has one: a map; of borders, a coarse map they lie in, with them over it."""
    from stickslip import accessor, plots

    if not plots.is_over_map(ds):
        return plots.plot_result(part_that_fits(ds))
    behind = picture.with_units(accessor.map_behind(ds))
    behind = part_that_fits(behind.assign_attrs(title=ds.attrs.get("title", "")))
    return plots.plot_result(ds, behind=behind, title=picture.title, look=picture.look(behind))


def part_that_fits(ds: xr.Dataset) -> xr.Dataset:
    """The part of a result that fits on a picture, said on screen where it is not the whole."""
    from stickslip import plots
    from stickslip.dataset import selection

    name = plots.subject(ds)
    part, places = selection.part_that_fits(ds, ds[name].dims) if name in ds else (ds, [])
    for place in places:
        screen.row("drawn", f"{place}; others with stickslip plot --select")
    return part


def save_page(ds: xr.Dataset, target: Path, picture: PictureOptions = PLAIN) -> None:
    """Write the page of a result: its plots, what was held fixed, what the words mean, how exact it is."""
    from stickslip import plots
    from stickslip.config.studies import result_class
    from stickslip.errors import PlotError
    from stickslip.plots import pages

    if plots.is_over_map(ds):
        try:
            drawn = [pages.Picture("borders between regimes", result_figure(ds, picture))]
        except PlotError as error:
            drawn = [pages.Picture(str(error))]
        text = pages.result_page(ds, drawn, picture.title)
    else:
        ds, drawn = picture.with_units(ds), []
        if (kind := result_class(ds)) and (own := kind.page(ds, picture.title)):
            pages.write_page(target, own)
            return show_file("page", target)
        if plots.is_drawn(ds):
            part = part_that_fits(ds)
            drawn = pages.pictures_of(part, picture.look(part), picture.title)
        text = pages.result_page(ds, drawn, picture.title)
    pages.write_page(target, text)
    show_file("page", target)
