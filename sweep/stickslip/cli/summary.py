"""Results on screen: regimes of a map, borders, contours, margins, attractors, probabilities; how long a run took."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import TYPE_CHECKING, Any

from stickslip.cli import screen
from stickslip.vocabulary.flags import METHODS, REGIMES, flag_label

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from stickslip.engine import Options
    from stickslip.files.locations import Location

_MOST_ROWS = 30


def show_result(ds: xr.Dataset, output: Location | None = None) -> None:
    """Print what a result of any kind holds. output : its file, which remarks name."""
    (printer_for(ds) or (lambda ds: _show_map(ds, output)))(ds)
    if "audit" in ds.attrs:
        screen.echo(f"refined  {ds.attrs['refine_cells_computed']:,} cells computed for {ds['regime'].size:,}")
        screen.echo(f"audit    {ds.attrs['audit']}")


def printer_for(ds: xr.Dataset) -> Callable[[xr.Dataset], None] | None:
    """The function that prints a result of this kind; None for maps and lists of cells."""
    printers = {"border_found": _show_borders, "contour_found": _show_contours, "margin_found": _show_margins}
    if "settling_share" in ds:
        return _show_attractors
    if "probability" in ds:
        return _show_probabilities
    if "model_rpn" in ds:
        from stickslip.cli.rig_features import show_features

        return show_features
    return next((printer for name, printer in printers.items() if name in ds.attrs), None)


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
    from stickslip.dataset.summary import one_regime_remark, remark, step_limit_remark, summary

    shares, file = summary(ds), None if output is None else str(output)
    table = screen.new_table("regime", numbers=("cells", "share"))
    for name, share in shares.items():
        table.add_row(flag_label(name), f"{share.cells:,}", screen.share_text(share.fraction))
    screen.print_table(table)
    for text in filter(None, (remark(shares, file), one_regime_remark(ds, shares), step_limit_remark(ds, file))):
        screen.echo(text)


def _print_first(rows: Iterator[str], count: int) -> None:
    """Print the first rows of so many."""
    for row in islice(rows, _MOST_ROWS):
        screen.echo(row)
    if count > _MOST_ROWS:
        screen.echo(f"... and {count - _MOST_ROWS} more")


def _print_attributes(ds: xr.Dataset, **labels: str) -> None:
    """Print attributes, each behind its label."""
    for label, name in labels.items():
        screen.echo(f"{label:8} {ds.attrs[name]}")


def _cells_over(ds: xr.Dataset, dims: tuple[Any, ...]) -> Iterator[tuple[str, xr.Dataset]]:
    """Each cell over some dimensions: its place as the beginning of a line of text, and its part of the dataset."""
    import numpy as np

    from stickslip.dataset.display import MapAxis

    axes = [MapAxis(ds, dim, plain=True) for dim in dims]
    for place in np.ndindex(tuple(ds.sizes[dim] for dim in dims)):
        where = ", ".join(axis.heading(i) for axis, i in zip(axes, place, strict=True))
        yield f"{where}: " if where else "", ds.isel(dict(zip(dims, place, strict=True)))


# --- borders ----------------------------------------------------------------------------------------------------------


def _show_borders(ds: xr.Dataset) -> None:
    """Print the first borders, how many there are, and what can be missed."""
    rows = int(ds["border"].notnull().sum())
    if "regime_throughout" in ds:
        rows += int((ds["regime_throughout"] != 0).sum())
    _print_first(_borders(ds), rows)
    _print_attributes(ds, borders="border_found", scan="border_scan")


def _borders(ds: xr.Dataset) -> Iterator[str]:
    """A line of text per border: the regimes on either side, where it is, how it was found; or for a line without."""
    import numpy as np

    from stickslip.dataset.display import unit_of

    unit = unit_of(ds["border"])
    for where, line in _cells_over(ds, ds["border"].dims[:-1]):
        crossings = np.flatnonzero(line["border"].notnull().values)
        if not crossings.size and (code := int(line["regime_throughout"]) if "regime_throughout" in line else 0):
            yield f"{where}{REGIMES[code]} throughout, no border"
        for crossing in crossings:
            border = line.isel(crossing=crossing)
            below, above = (REGIMES[int(border[name])] for name in ("regime_below", "regime_above"))
            how = f"width {unit.of(float(border['border_width'])):.2g}, by {METHODS[int(border['method'])]}"
            yield f"{where}{below} -> {above} at {unit.text(float(border['border']), 12)} ({how})"


def _show_contours(ds: xr.Dataset) -> None:
    """Print the first lines, how many there are, and what can be missed."""
    _print_first(_contours(ds), ds.sizes["line"])
    _print_attributes(ds, lines="contour_found", grid="contour_grid", scan="contour_scan")
    screen.echo(f"looked   at {ds.attrs['contour_looked_at']}")


def _contours(ds: xr.Dataset) -> Iterator[str]:
    """A line of text per contour."""
    from stickslip.dataset.display import unit_of
    from stickslip.dataset.polylines import plane_names, polylines

    names = plane_names(ds)
    units = [unit_of(ds[name]) for name in names]
    panels = [name for name, coordinate in ds.coords.items() if coordinate.dims == ("line",)]
    for number, line in enumerate(polylines(ds)):
        where = ", ".join(f"{name} = {ds[name].values[number]}" for name in panels)
        ranges = ", ".join(
            f"{name} {unit.of(values.min()):.6g} to {unit.text(values.max())}"
            for name, values, unit in zip(names, (line.x, line.y), units, strict=True)
        )
        kind = "loop" if line.closed else "line"
        sides = f"{REGIMES[line.left]} | {REGIMES[line.right]}"
        yield f"{where}{': ' if where else ''}{sides}: {kind} of {len(line.x)} points, {ranges}"


def _show_margins(ds: xr.Dataset) -> None:
    """Print of how many cells which parameter leads to a border, and how far it has to go."""
    import numpy as np

    table = screen.new_table("parameter", numbers=("cells with a border", "nearest", "median", "farthest"))
    for name in (str(name).removeprefix("margin_") for name in ds.data_vars if str(name).startswith("margin_")):
        ratio, margin = ds[f"ratio_{name}"].values.ravel(), ds[f"margin_{name}"].values.ravel()
        by_factor = bool(np.isfinite(ratio).any())
        sizes = np.sort(np.exp(np.abs(np.log(ratio[ratio > 0]))) if by_factor else np.abs(margin[~np.isnan(margin)]))
        texts = [f"x {size:.3g}" if by_factor else f"{size:.3g}" for size in sizes]
        three = [texts[0], texts[len(texts) // 2], texts[-1]] if texts else ["-"] * 3
        table.add_row(name, f"{np.count_nonzero(~np.isnan(margin)):,} of {margin.size:,}", *three)
    screen.print_table(table)
    _print_attributes(ds, found="margin_found", within="margin_within", scan="margin_scan")


# --- attractors -------------------------------------------------------------------------------------------------------


def _show_attractors(ds: xr.Dataset) -> None:
    """Print which regimes coexist, how much of the box settles, and what a shock may be."""
    import numpy as np

    share, masks = ds["settling_share"].values, ds["coexisting"].values
    if share.size <= _MOST_ROWS:
        for where, cell in _cells_over(ds, ds["settling_share"].dims):
            regimes = _regimes_in(int(cell["coexisting"])) or "not computed"
            screen.echo(f"{where}{regimes}; {_share(cell)}; {_shock(cell)}")
    else:
        for mask, count in zip(*np.unique(masks, return_counts=True), strict=True):
            screen.echo(f"cells    {count:,} with {_regimes_in(int(mask)) or 'nothing computed'}")
        if (known := share[np.isfinite(share)]).size:
            screen.echo(f"settling {known.mean():.1%} of the starting states on average")
    screen.echo(f"shares   {ds.attrs['attractors_found']}")
    screen.echo(f"box      displacement {ds.attrs['box_displacement']}, velocity {ds.attrs['box_velocity']}")


def _regimes_in(mask: int) -> str:
    """`stick_slip or damped`: the regimes of a mask."""
    return " or ".join(name for code, name in enumerate(REGIMES) if code and mask >> (code - 1) & 1)


def _share(cell: xr.Dataset) -> str:
    share, error = float(cell["settling_share"]), float(cell["share_error"])
    low, high = float(cell["settling_share_low"]), float(cell["settling_share_high"])
    bounds = f", {low:.4g} to {high:.4g} with undecided states" if high > low else ""
    return f"share that settles {share:.6g} ({f'+- {error:.2g}' if error else 'exact'}{bounds})"


def _shock(cell: xr.Dataset) -> str:
    from stickslip.dataset.display import unit_of

    shock = float(cell["critical_shock"])
    if shock != shock:
        return "critical shock unknown"
    if shock == float("inf"):
        return "no shock ends sliding"
    return f"critical shock {unit_of(cell['critical_shock']).text(shock)}" if shock else "any shock ends sliding"


def show_ramp(ds: xr.Dataset) -> None:
    """Print where the regime changes on the way up, and on the way down."""
    from stickslip.dataset.display import displayed

    *dims, _, along = ds["regime"].dims
    values, unit = displayed(ds[along])
    for number, (where, line) in enumerate(_cells_over(ds, tuple(dims))):
        if number == _MOST_ROWS:
            return screen.echo("... and more lines; --output FILE.nc keeps them all")
        for direction, step in (("up", 1), ("down", -1)):
            codes = line["regime"].sel(direction=direction).values[::step]
            screen.echo(f"{where}{direction:4} {'; '.join(_changes(codes, values[::step], unit))}")


def _changes(codes: NDArray[Any], values: NDArray[Any], unit: str) -> list[str]:
    """`stick_slip -> damped from 0.79 to 0.8 m/s` for each change on the way."""
    import numpy as np

    changes = [
        f"{REGIMES[codes[i]]} -> {REGIMES[codes[i + 1]]} from {values[i]:.6g} to {values[i + 1]:.6g} {unit}".rstrip()
        for i in np.flatnonzero(np.diff(codes))
    ]
    return changes or [f"{REGIMES[codes[0]]} all the way"]


# --- probabilities ----------------------------------------------------------------------------------------------------


def _show_probabilities(ds: xr.Dataset) -> None:
    """Print the probability of each regime (of many cells its range), which quantity decides, what is not known."""
    dims = [str(dim) for dim in ds["probability"].dims if dim != "state"]
    headings = ("probability", "standard error") if not dims else ("from", "to", "largest error")
    table = screen.new_table("regime", numbers=headings)
    for name in ds["state"].values:
        regime = ds.sel(state=name)
        value, error = regime["probability"], regime["probability_error"]
        if "levels" in ds or float(regime["probability_high"].max()) > 0:
            numbers = (value, error) if not dims else (value.min(), value.max(), error.max())
            table.add_row(flag_label(str(name)), *(f"{float(number):.4g}" for number in numbers))
    screen.print_table(table)
    if not dims and "sobol_total" in ds:
        _show_indices(ds)
    if float(ds["undecided"].max()) > 0:
        screen.echo(f"bounds   {ds.attrs['uncertain_undecided']}: probability_low and probability_high allow for them")
    screen.echo(f"method   {ds.attrs['uncertain_method']}")


def _show_indices(ds: xr.Dataset) -> None:
    """Print the Sobol indices of the first regime that has some."""
    import numpy as np

    for name in ds["state"].values:
        regime = ds.sel(state=name)
        if bool(regime["sobol_total"].isnull().all()):
            continue
        names, first, total = (regime[key].values for key in ("quantity", "sobol_first", "sobol_total"))
        texts = ", ".join(f"{names[i]} {first[i]:.2f} ({total[i]:.2f})" for i in np.argsort(-total))
        return screen.echo(f"indices  of {str(name).replace('_', '-')}, first order (total): {texts}")
