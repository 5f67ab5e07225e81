"""Probabilities on screen: those of one cell in a table, those of many by their range."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.cli import screen

if TYPE_CHECKING:
    import xarray as xr


def show_probabilities(ds: xr.Dataset) -> None:
    """The probability of each regime, which quantity decides, and what is not known."""
    from rich.table import Table

    from stickslip.vocabulary.flags import flag_label

    dims = [str(dim) for dim in ds["probability"].dims if dim != "state"]
    table = Table("regime", box=None, pad_edge=False, header_style="bold")
    for heading in ("probability", "standard error") if not dims else ("from", "to", "largest error"):
        table.add_column(heading, justify="right")
    for name in ds["state"].values:
        one = ds.sel(state=name)
        value, error = one["probability"], one["probability_error"]
        if "levels" in ds or float(one["probability_high"].max()) > 0:
            numbers = (value, error) if not dims else (value.min(), value.max(), error.max())
            table.add_row(flag_label(str(name)), *(f"{float(number):.4g}" for number in numbers))
    screen.print_table(table)
    if not dims and "sobol_total" in ds:
        _show_indices(ds)
    if float(ds["undecided"].max()) > 0:
        screen.echo(f"bounds   {ds.attrs['uncertain_undecided']}: probability_low and probability_high allow for them")
    screen.echo(f"method   {ds.attrs['uncertain_method']}")


def _show_indices(ds: xr.Dataset) -> None:
    """The indices of the first regime that has some."""
    for name in ds["state"].values:
        one = ds.sel(state=name)
        if bool(one["sobol_total"].isnull().all()):
            continue
        order = np.argsort(-one["sobol_total"].values)
        words = ", ".join(
            f"{one['quantity'].values[i]} {one['sobol_first'].values[i]:.2f} ({one['sobol_total'].values[i]:.2f})"
            for i in order
        )
        screen.echo(f"indices  of {str(name).replace('_', '-')}, first order (total): {words}")
        return
