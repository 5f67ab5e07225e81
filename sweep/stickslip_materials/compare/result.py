"""Materials compared, as a kind of result: on screen, for programs, as a picture, a table and a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.studies import Result, Table
from stickslip.vocabulary.display_units import DISPLAY
from stickslip.vocabulary.flags import FLAGS, QUIET_STATES
from stickslip.vocabulary.models import FITTED
from stickslip_materials.variables import MATERIAL_VARIABLES

_DIMS = {"material", "belt_speed"}  # of what is known of each material; a row for each belt speed
_ATTRIBUTES = (
    *("belt_speed", "speed_range_from", "speed_range_to", "searched_from", "searched_to"),
    *("tendency_at", "confidence", "draws", "seed"),
)


class Comparison(Result):
    """Materials compared."""

    variables, subject, places = MATERIAL_VARIABLES, "quiet_above", "materials"

    @classmethod
    def report(cls, ds: xr.Dataset) -> Iterator[str | Table]:
        """The ranks, the answer, and what is to be known of them."""
        from stickslip_materials.compare.table import RankTable

        ranking = RankTable(ds)
        yield f"system   {', '.join(f'{name} {value}' for name, value in ranking.conditions())}\n"
        yield ranking.table()
        if ranking.speeds:
            yield ranking.answer()
        yield from (f"note     {remark}" for remark in ranking.remarks())

    @classmethod
    def answer(cls, ds: xr.Dataset) -> Mapping[str, Any]:
        """The comparison for programs, in SI."""
        from stickslip.dataset.export import table_of
        from stickslip_materials.compare.table import RankTable

        ranking = RankTable(ds)
        several = "belt_speed" in ds.dims
        shared = ds.drop_dims("belt_speed") if several else ds
        materials = _rows(shared)
        if several:
            own = [str(name) for name in ds.data_vars if name not in shared.data_vars]
            at_speeds = ds[[*own, "quiet_above", "quiet_state"]]
            for j, speed in enumerate(ranking.speeds):
                for material, row in zip(materials, _rows(at_speeds.isel(belt_speed=j)), strict=True):
                    at = {name: value for name, value in row.items() if name not in material}
                    material.setdefault("at", []).append(at | {"belt_speed": speed})
        columns = table_of(ds).columns
        return {
            "materials": materials,
            "units": {name: str(array.attrs["units"]) for name, array in columns.items() if "units" in array.attrs},
            "system": {name.removeprefix("system_"): ds.attrs[name] for name in ds.attrs if name.startswith("system_")},
            **{name: ds.attrs[name] for name in _ATTRIBUTES if name in ds.attrs},
            "remarks": ranking.remarks(),
            "written": {},
        }

    @classmethod
    def figure(
        cls, ds: xr.Dataset, variable: str | None, select: Mapping[str, Any], title: str | None, look: Any, state: str
    ) -> Any:
        """The curves, and where each material becomes quiet. Raises PlotError."""
        from stickslip.plots import check_plain
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
                                   or not {*ds[name].dims} <= _DIMS]  # fmt: skip
        return ds.drop_vars(beside)


def _rows(ds: xr.Dataset) -> list[dict[str, Any]]:
    """The variables of each material by name, flags as words."""
    from stickslip.dataset.export import table_of

    columns = {"name": ds["material"].values.tolist()}
    for name, array in table_of(ds).columns.items():
        if name != "material":
            values, words = array.values.tolist(), [*FLAGS.get(name, ())]
            columns[name] = [words[value] for value in values] if words else values
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


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
    for name, end in (("searched_from", "slowest"), ("searched_to", "fastest")):
        ends = np.full(ds.sizes["material"], float(ds.attrs[name]))
        about = speed | {"long_name": f"{end} belt speed searched"}
        changed[name] = xr.DataArray(ends, dims="material", attrs=about)
    return ds.assign(changed)
