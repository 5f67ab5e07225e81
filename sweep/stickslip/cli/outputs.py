"""Files that commands write: results, tables, plots and pages, each with a line on screen.

Their names were checked when the options were read (`params.Target`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip.cli import screen
from stickslip.cli.exits import drawing, fail
from stickslip.cli.params import requested_table

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.config.model import Config
    from stickslip.files.locations import Location
    from stickslip.plots import Look, Mark

_LONG = 500_000  # rows of a table from which a bar tells how far it is
_INCH = 0.0254  # m
_PIXELS = re.compile(r"(\d+)\s*px")
_SMALLEST, _LARGEST = 1.0, 100.0  # inches of a side
NO_FILE_NAME = re.compile(r"[^\w.+-]+")


def show_file(kind: str, target: Location, note: str = "") -> None:
    """Print `kind  file (note, size)`."""
    screen.echo(f"{kind:8} {target} ({f'{note}, ' if note else ''}{screen.size_of(target)})")


def save_result(ds: xr.Dataset, target: Location | None, kind: str = "written", note: str = "") -> None:
    """Write a result, if it has a place, and the table that is made of it, if one is asked for."""
    from stickslip.files import writing

    if target is None:
        return
    writing.write(ds, target)
    show_file(kind, target, note)
    save_table(ds, requested_table())


def save_plot(figure: Figure, target: Path, note: str = "") -> None:
    """Write a plot. Raises PlotError, StoreError."""
    from stickslip import plots

    plots.save(figure, target)
    screen.echo(f"plot     {target}{f' ({note})' if note else ''}")


def save_table(
    ds: xr.Dataset, target: Path | None, variables: tuple[str, ...] = (), decimal_comma: bool = False
) -> None:
    """Write a table, if it has a place; a long one with a bar. What is left out is said.

    The workbook of a comparison begins with the table that is printed.
    """
    from stickslip.dataset import export

    if target is None:
        return
    rows, decimal = export.table_of(ds, variables).rows, "," if decimal_comma else "."
    if rows < _LONG:
        front = None
        if "quiet_above" in ds and not variables and target.suffix.lower() == ".xlsx":
            from stickslip.materials.table import RankTable

            front = RankTable(ds).sheet()
        table = export.write_table(ds, target, variables, decimal=decimal, front=front)
    else:
        with screen.progress_bar(rows, " written", "rows") as move:
            table = export.write_table(ds, target, variables, decimal=decimal, progress=move)
    show_file("table", target, f"{table.rows:,} rows, {len(table.columns)} columns")
    if table.left_out:
        names = ", ".join(table.left_out)
        screen.echo(f"left out {names}: of other dimensions; write them with stickslip export --variable")


@dataclass(frozen=True)
class Outputs:
    """Files to be made of a result: a plot, a table, a page; `map` is the file of the map behind borders."""

    plot: Path | None = None
    table: Path | None = None
    page: Path | None = None
    map: Location | None = None

    def is_lacking(self) -> bool:
        """True if something is to be written though the result is there and was complete already."""
        return bool(self.table or self.page or self.plot and not self.plot.exists())

    def save(self, ds: xr.Dataset) -> Path | None:
        """Write everything, and give the plot if there is one. A plot or page that fails is said, and goes without."""
        drawn = None
        if self.plot is not None and is_drawn(ds):
            with drawing(self.plot):
                save_plot(result_figure(ds, self.map), self.plot)
                drawn = self.plot
        save_table(ds, self.table)
        if self.page is not None:
            with drawing(self.page):
                save_page(ds, self.page, self.map)
        save_table(ds, requested_table())
        return drawn


# --- pictures ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Picture:
    """The options of `plot` that shape a picture, as texts."""

    title: str | None = None
    size: str | None = None
    dpi: int | None = None
    units: tuple[str, ...] = ()
    log: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()
    marks_file: Path | None = None
    no_hatch: bool = False
    no_note: bool = False

    def with_units(self, ds: xr.Dataset) -> xr.Dataset:
        """The dataset, to be shown in the units that are asked for, or that limits have. Raises PlotError."""
        from stickslip.dataset.display import with_units
        from stickslip.plots.options import pairs
        from stickslip.vocabulary import units

        ends = [end for text in self.limits for end in pairs(text, "LOW..HIGH with a unit")]
        shown = {name: unit for name, text in ends if (unit := units.unit_in(text.rpartition("..")[2]))}
        shown |= {name: unit for text in self.units for name, unit in pairs(text, "UNIT")}
        return with_units(ds, shown) if shown else ds

    def look(self, ds: xr.Dataset) -> Look:
        """The look of a map. Raises PlotError."""
        from stickslip.plots import Look

        look = Look.of(ds, log=self.log, limits=self.limits, marks=self.marks, hatched=not self.no_hatch,
                       held=not self.no_note)  # fmt: skip
        return look if self.marks_file is None else replace(look, marks=(*look.marks, *_points(ds, self.marks_file)))

    def save(self, figure: Figure, target: Path, request: str = "") -> None:
        """Write a figure in the size and at the resolution that are asked for. Raises PlotError."""
        from stickslip import plots
        from stickslip.plots.layout import resize

        if self.size is not None:
            resize(figure, *_inches(self.size, self.dpi or plots.DPI))
        plots.save(figure, target, self.dpi or plots.DPI, request)

    def given(self) -> dict[str, Any]:
        """Those options that are given."""
        return {name: value for name, value in vars(self).items() if value}


PLAIN = Picture()


def _points(ds: xr.Dataset, path: Path) -> list[Mark]:
    """The operating points of a file, which say their regimes: computed there, not those of the cells around."""
    from stickslip.api.cells import evaluate
    from stickslip.config.select import shared_by
    from stickslip.dataset.selection import one_cell
    from stickslip.plots.options import marks_in
    from stickslip.vocabulary.flags import REGIMES, flag_label

    points = [*marks_in(ds, path)]
    if "regime" not in ds or "configuration" not in ds.attrs:
        return points
    try:
        cells, how = [one_cell(ds, {str(name): at for name, at in mark.at.items()}) for mark in points], shared_by(ds)
    except ValueError:  # a point does not say where it is along each axis, which whoever draws it will say
        return points
    regimes = evaluate({name: [cell[name] for cell in cells] for name in cells[0]}, **how)["regime"].values
    points = [replace(mark, regime=REGIMES[int(code)]) for mark, code in zip(points, regimes, strict=True)]
    for mark in points:
        screen.echo(f"mark     {mark.label}: {flag_label(mark.regime)}")
    return points


def _inches(text: str, dpi: int) -> tuple[float, float]:
    """`16 cm x 9 cm` or `1920 px x 1080 px` as width and height; a width without a unit has that of the height."""
    from stickslip.errors import QuantityError
    from stickslip.vocabulary import units

    def length(side: str) -> float:
        if pixels := _PIXELS.fullmatch(side):
            return int(pixels[1]) / dpi
        if not units.unit_in(side):
            raise QuantityError("a length")
        return units.si_value(side, "m") / _INCH

    sides = [side.strip() for side in re.split(r"\s*[x×]\s*(?=[\d.])", text)]
    if len(sides) == 2 and (unit := _PIXELS.fullmatch(sides[1]) and "px" or units.unit_in(sides[1])):
        sides[0] += "" if re.search(r"[a-zµ]", sides[0]) else f" {unit}"
    try:
        lengths = [length(side) for side in sides]
    except QuantityError:
        fail(f"--size: got {text!r}, expected a width and a height such as '16 cm x 9 cm' or '1920 px x 1080 px'")
    if len(lengths) != 2 or not all(_SMALLEST <= side <= _LARGEST for side in lengths):
        fail(f"--size: got {text!r}, expected a width and a height between 2.54 cm and 2.54 m, such as '16 cm x 9 cm'")
    return lengths[0], lengths[1]


def free_name(stem: Path, variable: str | None, places: Mapping[str, str], request: str) -> Path:
    """The name of a picture nobody named: FILE.png, FILE-VARIABLE.png, FILE-VARIABLE-DIM=VALUE.png.

    stem : FILE, without suffix. variable : unless it is what the file shows by itself. Where another picture has the
    name, one made for another request or by somebody else, it gets a number: FILE-2.png.
    """
    from stickslip.plots import request_of

    words = [stem.name, *filter(None, [variable]), *(f"{name}={value}" for name, value in places.items())]
    base = NO_FILE_NAME.sub("_", "-".join(words).replace("=", "-")) if len(words) > 1 else stem.name
    number = 1
    while True:
        target = stem.with_name(f"{base}-{number}.png" if number > 1 else f"{base}.png")
        if not target.exists() or request_of(target) == request:
            return target
        number += 1


# --- pictures of results ----------------------------------------------------------------------------------------------


def is_drawn(ds: xr.Dataset) -> bool:
    """True if there is a plot of this result: borders of single lines, and one rare event, are no plots."""
    from stickslip.config.studies import study_of_result

    study = study_of_result(ds)
    return study.is_drawn(ds) if study else "regime" in ds and ds["regime"].ndim > 0


def result_figure(ds: xr.Dataset, map_file: Location | None = None, picture: Picture = PLAIN) -> Figure:
    """The plot of a result that `is_drawn`: a map; of borders, the map they lie in, with them over it.

    map_file : that map; without it a coarse one is computed. picture : what is asked of one over a map.
    """
    from stickslip import plots

    if not plots.is_over_map(ds):
        return plots.plot_result(part_that_fits(ds))
    behind = picture.with_units(_map_behind(ds, map_file))
    behind = part_that_fits(behind.assign_attrs(title=ds.attrs.get("title", "")))
    return plots.plot_result(ds, behind=behind, title=picture.title, look=picture.look(behind))


def _map_behind(ds: xr.Dataset, map_file: Location | None) -> xr.Dataset:
    if map_file is None:
        from stickslip.accessor import map_behind

        return map_behind(ds)
    from stickslip.files import reading

    return reading.look_into(map_file)


def part_that_fits(ds: xr.Dataset) -> xr.Dataset:
    """The part of a result that fits on a picture, said on screen where it is not the whole."""
    from stickslip import plots
    from stickslip.dataset import selection

    name = plots.subject(ds)
    part, places = selection.part_that_fits(ds, ds[name].dims) if name in ds else (ds, [])
    for place in places:
        screen.echo(f"drawn    {place}; others with stickslip plot --select")
    return part


def plot_limits(config: Config) -> str | None:
    """Text on what the plot of a configuration will leave out; None for nothing."""
    from stickslip.api.studies import coarse_map
    from stickslip.config.grid import build_grid
    from stickslip.dataset.selection import left_out

    grid = build_grid(coarse_map(config))
    return left_out(dict(zip(grid.dims, grid.shape, strict=True)))


def save_page(ds: xr.Dataset, target: Path, map_file: Location | None = None, picture: Picture = PLAIN) -> None:
    """Write the page of a result: its plots, what was held fixed, what the words mean, how exact it is."""
    from stickslip import pages, plots
    from stickslip.errors import PlotError
    from stickslip.pages.result import Picture as PagePicture
    from stickslip.pages.result import pictures_of, result_page

    if "quiet_above" in ds:
        from stickslip.materials.page import material_page

        text = material_page(picture.with_units(ds), title=picture.title)
    elif plots.is_over_map(ds):
        try:
            drawn = [PagePicture("borders between regimes", result_figure(ds, map_file, picture))]
        except PlotError as error:
            drawn = [PagePicture(str(error))]
        text = result_page(ds, drawn, picture.title)
    else:
        ds = picture.with_units(ds)
        part = part_that_fits(ds) if is_drawn(ds) else None
        text = result_page(
            ds, [] if part is None else pictures_of(part, picture.look(part), picture.title), picture.title
        )
    pages.write_page(target, text)
    show_file("page", target)
