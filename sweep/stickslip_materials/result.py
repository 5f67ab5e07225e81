"""Materials compared, as a kind of result: on screen, in a picture, a table and on a page of their own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.studies import Result
from stickslip.vocabulary.display_units import DISPLAY
from stickslip.vocabulary.flags import QUIET_STATES
from stickslip.vocabulary.models import FITTED
from stickslip_materials.variables import MATERIAL_VARIABLES

_KEPT = {"material", "belt_speed"}  # dimensions of what is known of each material; a row for each belt speed


class Comparison(Result):
    """Materials compared."""

    variables, subject, places = MATERIAL_VARIABLES, "quiet_above", "materials"

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[Any]:
        """The ranks, the answer, and what is to be known of them."""
        from stickslip_materials.commands.compare import report

        return report(ds)

    @classmethod
    def answer(cls, ds: xr.Dataset) -> Mapping[str, Any]:
        """The comparison for programs, in SI."""
        from stickslip_materials.commands.compare import answer

        return answer(ds)

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Any:
        """The curves, and where each material becomes quiet. Raises PlotError."""
        from stickslip.plots.kinds import check_plain
        from stickslip_materials.plots import plot_materials

        if variable is not None:
            return None
        check_plain(look, "a comparison of materials")
        return plot_materials(ds, title=title)

    @classmethod
    def page(cls, ds: xr.Dataset, title: str | None) -> str:
        """The report of a comparison."""
        from stickslip_materials.compare.page import material_page

        return material_page(ds, title=title)

    @classmethod
    def tabular(cls, ds: xr.Dataset, whole: bool) -> xr.Dataset:
        """Without bounds that do not stand for a border; a row a material, or one for each of several belt speeds."""
        ds = _without_bounds(ds)
        beside = [] if whole else [name for name in ds.data_vars if ds[name].dims[:1] != ("material",)
                                   or not {*ds[name].dims} <= _KEPT]  # fmt: skip
        return ds.drop_vars(beside)


def _without_bounds(ds: xr.Dataset) -> xr.Dataset:
    """Materials compared, where a bound of a border does not stand for one: it is empty, beside its state, and the ends
    of the range that was searched have columns of their own. Ends of intervals that are open are empty too."""
    speed = {name: ds["quiet_above"].attrs[name] for name in ("units", DISPLAY) if name in ds["quiet_above"].attrs}
    known = ds["quiet_state"] == QUIET_STATES.index("border")
    changed = {str(name): v.where(np.isfinite(v)) for name, v in ds.data_vars.items()
               if v.dtype.kind == "f" and v.dims[:1] == ("material",)}  # fmt: skip
    for name in FITTED if f"{FITTED[0]}_low" in ds else ():  # from 0 to inf: not determined
        changed[f"{name}_low"] = ds[f"{name}_low"].where(np.isfinite(ds[f"{name}_high"]))
    changed |= {name: ds[name].where(known) for name in ("quiet_above", "margin") if name in ds}
    for name in ("searched_from", "searched_to"):
        ends = np.full(ds.sizes["material"], float(ds.attrs[name]))
        long_name = f"{'slowest' if name.endswith('from') else 'fastest'} belt speed searched"
        changed[name] = xr.DataArray(ends, dims="material", attrs=speed | {"long_name": long_name})
    return ds.assign(changed)
