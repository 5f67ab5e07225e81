"""Results on screen: regimes of a map, what studies say of theirs; how long a run took."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.cli import screen
from stickslip.vocabulary.flags import flag_label

if TYPE_CHECKING:
    import xarray as xr

    from stickslip.engine import Options
    from stickslip.files.locations import Location


def show_result(ds: xr.Dataset, output: Location | None = None) -> None:
    """Print what a result of any kind holds. output : its file, which remarks name."""
    if not is_reported(ds):
        _show_map(ds, output)
    if "audit_bound" in ds.attrs:
        computed, points, wrong = (ds.attrs[key] for key in ("refine_cells_computed", "audit_points", "audit_wrong"))
        screen.echo(f"refined  {computed:,} cells computed for {ds['regime'].size:,}")
        screen.echo(f"audit    {points:,} random points among the inferred cells, {wrong:,} of them wrong: "
                    f"at most {100 * ds.attrs['audit_bound']:.3g} % of all cells (95 %, Clopper-Pearson)")  # fmt: skip


def is_reported(ds: xr.Dataset) -> bool:
    """Print the result of a study; False for maps and lists of cells."""
    from stickslip.config.studies import Table, result_class

    if (study := result_class(ds)) is None:
        return False
    for part in study.report(ds):
        if isinstance(part, Table | str):
            screen.echo(part.text() if isinstance(part, Table) else part)
        else:
            screen.terminal().print(part)
    return True


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
    from stickslip.config.studies import Table
    from stickslip.dataset.summary import remark, step_limit_remark, summary, table_remark

    shares, file = summary(ds), None if output is None else str(output)
    rows = [(flag_label(name), f"{share.cells:,}", screen.share_text(share.fraction)) for name, share in shares.items()]
    screen.echo(Table("", ("regime",), ("cells", "share"), rows).text())
    remarks = remark(shares, file), step_limit_remark(ds, file), table_remark(ds)
    for text in filter(None, remarks):
        screen.echo(text)
