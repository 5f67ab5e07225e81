"""`ds.stickslip`: what our datasets can do besides what xarray offers.

xarray's way for libraries to add to datasets. It is there once `stickslip` is imported and xarray is in use, and in
datasets that plain `xr.open_dataset` read (`backend.py`).
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import xarray as xr

from stickslip import extensions
from stickslip.vocabulary.quantities import listed, or_meant

if TYPE_CHECKING:
    from stickslip.config.model import Config
    from stickslip.plots.layout import Figure

__all__ = ["StickslipAccessor"]


class StickslipAccessor:
    """`ds.stickslip`: the plot, the summary and the configuration of a result, and its cells one by one."""

    def __init__(self, ds: xr.Dataset) -> None:
        self._ds = ds

    # --- what it is ---------------------------------------------------------------------------------------------------

    @property
    def configuration(self) -> Config:
        """The configuration that the result was computed from: `run` computes it again.

        Raises ConfigError for a list of cells, which has none.
        """
        from stickslip.config.reader import parse_config

        return parse_config(str(self._ds.attrs.get("configuration", "")), "the attribute configuration")

    def summary(self) -> Any:
        """Count the cells of each regime, and their share, as a table of pandas. What `where` left out does not count.

        Raises ValueError for a result without regimes.
        """
        import pandas as pd

        from stickslip.dataset.summary import summary

        if "regime" not in self._ds.data_vars:
            raise ValueError(f"no regimes in {', '.join(map(str, self._ds.data_vars))}; expected a map or cells")
        shares = summary(self._ds)
        columns = {"cells": [row.cells for row in shares.values()], "share": [row.fraction for row in shares.values()]}
        return pd.DataFrame(columns, pd.Index(list(shares), name="regime"))

    def mask(self, *names: str, flag: str = "regime") -> xr.DataArray:
        """Return a mask of where a flag has one of these names: `ds.where(ds.stickslip.mask("stick_slip"))`.

        flag : any variable with flag meanings: regime, status, ... Raises ValueError for a name that it does not have.
        """
        meanings = self._ds[flag].attrs.get("flag_meanings", "").split()
        if unknown := [name for name in names if name not in meanings]:
            expected = (listed(meanings) if meanings else "a flag") + or_meant(unknown[0].replace("-", "_"), meanings)
            raise ValueError(f"{flag} has no {listed(unknown)}, expected {expected}")
        return self._ds[flag].isin([meanings.index(name) for name in names])

    def report(self) -> str:
        """What `stickslip inspect` prints of the result of a study: of the margins of a cell, which changes cure it.

        Raises ValueError for a result of no study.
        """
        from stickslip.config.studies import ReportTable, result_class

        if (study := result_class(self._ds)) is None:
            raise ValueError("a result of no study; `summary` counts the cells of a map")
        return "\n".join(part.text() if isinstance(part, ReportTable) else part for part in study.report(self._ds))

    # --- pictures -----------------------------------------------------------------------------------------------------

    def plot(self, variable: str | None = None, **how: Any) -> Figure:
        """The plot that `stickslip plot` draws of this result.

        variable : what to draw; None for what this kind of result is about. how : arguments of `plots.plot_result`
            (select, title, look, ...). Borders and contours lie over a coarse map, which is computed unless it is given
            (`behind`).
        Raises PlotError for what cannot be drawn.
        """
        from stickslip import plots

        if variable is None and "behind" not in how and plots.is_over_map(self._ds):
            how["behind"] = map_behind(self._ds)
        return plots.plot_result(self._ds, variable, **how)

    # --- cells --------------------------------------------------------------------------------------------------------

    def cell(self, **at: Any) -> dict[str, float]:
        """The parameters of one cell, in SI, as `evaluate` takes them and `simulate` does.

        at : by quantity a value in SI or a text with a unit, whether the axis has it or not; by dimension a label, or a
            position along one that has neither values nor labels. What the dataset says of no other value of a quantity
            (an axis after `sel`, a parameter that is equal in all cells) need not be given.
        Raises ValueError for what is missing or unknown.
        """
        from stickslip.dataset.selection import one_cell

        return one_cell(self._ds, at)

    def simulate(self, duration: float | str | None = None, samples: int = 2001, **at: Any) -> xr.Dataset:
        """One cell over time.

        duration : s, or a text with a unit; None for eight cycles, or until it has settled.
        at : which cell, as for `cell`.
        The law and the tolerance are those of the result. Returns and raises what `stickslip.simulate` does.
        """
        from stickslip.api.cells import evaluate, simulate, time_span
        from stickslip.config.grid import shared_by

        cell, how = self.cell(**at), shared_by(self._ds)
        if duration is None:
            duration = time_span(evaluate(cell, **how)).duration
        return simulate(cell, duration=duration, samples=samples, **how)

    def __getattr__(self, name: str) -> Any:
        """Return a method that an extension brings."""
        places = {} if name.startswith("_") else extensions.brought("methods")
        if name not in places:
            raise AttributeError(f"datasets of stickslip have no {name!r}")
        return partial(extensions.imported(places[name]), self._ds)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *extensions.brought("methods")})

    # --- what a notebook shows ----------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        lines = [str(self._ds.attrs.get("title", "a dataset of stickslip"))]
        if "regime" in self._ds.data_vars:
            lines += [f"  {name:12} {row.cells:12,.0f} {row.share:8.1%}" for name, row in self.summary().iterrows()]
        return "\n".join(lines)


def map_behind(ds: xr.Dataset) -> xr.Dataset:
    """The map over which borders or contours that have a configuration are drawn, computed with few cells.

    Its title is theirs.
    """
    from stickslip.api.runs import run
    from stickslip.api.studies import coarse_map
    from stickslip.config.reader import parse_config
    from stickslip.vocabulary.display_units import units_shown

    config = parse_config(str(ds.attrs["configuration"]), "the configuration of the borders")
    return run(coarse_map(config).shown_in(units_shown(ds))).assign_attrs(title=ds.attrs.get("title", ""))


if getattr(xr.Dataset, "stickslip", None) is not StickslipAccessor:
    xr.register_dataset_accessor("stickslip")(StickslipAccessor)  # type: ignore[no-untyped-call]
