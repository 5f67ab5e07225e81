"""What the command says of a result: a map, borders, ...; each kind knows what is worth a line, and how it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.cli import screen

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.cli.backdrop import Extras
    from stickslip.cli.picture import Picture
    from stickslip.cli.screen import Done
    from stickslip.config.model import Config
    from stickslip.files.locations import Location


def show(ds: xr.Dataset, done: Done, output: Location | None, plot: Path | None) -> None:
    """The summary a run ends with: what came out, how long it took, and the files."""
    if tell := teller(ds):
        tell(ds)
    else:
        screen.show_map(ds, output)
    if "audit" in ds.attrs:
        screen.echo(f"refined  {ds.attrs['refine_cells_computed']:,} cells computed for {ds['regime'].size:,}")
        screen.echo(f"audit    {ds.attrs['audit']}")
    screen.echo(screen.rate(done))
    if output is not None:
        name = "map" if "regime" in ds else "written"
        screen.echo(f"{name:8} {output} ({screen.size_of(output)})")
    if plot is not None:
        screen.echo(f"plot     {plot}")


def teller(ds: xr.Dataset) -> Callable[[xr.Dataset], None] | None:
    """What says on screen what was found in a result; None for maps and lists of cells."""
    from stickslip.cli import attractor_rows, border_rows, probability_rows

    found = {"border_found": border_rows.show_borders, "contour_found": border_rows.show_contours,
             "margin_found": border_rows.show_margins}  # fmt: skip
    if "settling_share" in ds:
        return attractor_rows.show_attractors
    if "probability" in ds:
        return probability_rows.show_probabilities
    return next((tell for name, tell in found.items() if name in ds.attrs), None)


def is_drawn(ds: xr.Dataset) -> bool:
    """Whether there is a plot of this result: borders of single lines, and one rare event, are no plots."""
    from stickslip import plots

    if "probability" in ds:
        return "levels" not in ds or ds["probability"].ndim > 1
    return plots.is_over_map(ds) or any(name in ds and ds[name].ndim > 0 for name in ("regime", "settling_share"))


def figure(ds: xr.Dataset, extras: Extras | None = None, picture: Picture | None = None) -> Figure:
    """The plot of a result that `is_drawn`: a map; of borders, the map they lie in, with them over it.

    picture : what is asked of one over a map.
    """
    from stickslip import plots
    from stickslip.cli.backdrop import Extras
    from stickslip.cli.picture import Picture

    if plots.is_over_map(ds):
        picture = picture or Picture()
        behind = picture.prepared((extras or Extras()).map_behind(ds))
        behind = fitting(behind.assign_attrs(title=ds.attrs.get("title", "")))
        return plots.plot_result(ds, behind=behind, title=picture.title, look=picture.look(behind))
    return plots.plot_result(fitting(ds))


def fitting(ds: xr.Dataset) -> xr.Dataset:
    """What of a result fits on a picture, said on screen where it is a part."""
    from stickslip.dataset.selection import part_that_fits

    name = next((name for name in ("probability", "settling_share", "regime") if name in ds), None)
    part, told = (ds, []) if name is None else part_that_fits(ds, ds[name].dims)
    for point in told:
        screen.echo(f"drawn    {point}; others with stickslip plot --select")
    return part


def will_be_drawn(config: Config) -> str | None:
    """What the plot of a configuration will leave out, in words; None for nothing."""
    from stickslip.config.grid import build_grid
    from stickslip.dataset.selection import left_out
    from stickslip.studies import coarse_map

    grid = build_grid(coarse_map(config))
    return left_out(dict(zip(grid.dims, grid.shape, strict=True)))


def write_page(ds: xr.Dataset, target: Path, extras: Extras | None = None, picture: Picture | None = None) -> None:
    """Write the page of a result, and say so: its plots, what was held fixed, what the words mean, how exact it is."""
    from stickslip import pages, plots
    from stickslip.cli.picture import Picture
    from stickslip.errors import PlotError
    from stickslip.pages.result import Picture as Shown
    from stickslip.pages.result import pictures_of, result_page

    picture = picture or Picture()
    if "quiet_above" in ds:
        from stickslip.materials.page import material_page

        pages.write_page(target, material_page(picture.prepared(ds), title=picture.title))
        return screen.echo(f"page     {target} ({screen.size_of(target)})")
    if plots.is_over_map(ds):
        try:
            found = [Shown("borders between regimes", figure(ds, extras, picture))]
        except PlotError as error:
            found = [Shown(str(error))]
    else:
        ds = picture.prepared(ds)
        part = fitting(ds) if is_drawn(ds) else ds
        found = pictures_of(part, picture.look(part), picture.title) if is_drawn(ds) else []
    pages.write_page(target, result_page(ds, found, picture.title))
    screen.echo(f"page     {target} ({screen.size_of(target)})")
