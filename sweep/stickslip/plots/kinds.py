"""The plot of any result, by its kind: for the command, for Python and for pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from stickslip.dataset.selection import part_that_fits, selected
from stickslip.errors import PlotError
from stickslip.plots.attractors import plot_attractors, plot_of_ramp
from stickslip.plots.layout import Figure
from stickslip.plots.maps import plot_map
from stickslip.plots.materials import plot_materials
from stickslip.plots.options import PLAIN, Look
from stickslip.plots.traces import plot_trace
from stickslip.plots.uncertainty import plot_probability

_MARKS = {  # by a variable, a dimension or an attribute that only this kind has
    "model_rpn": "rig tests", "probability": "probability", "direction": "ramp", "time": "trajectory",
    "quiet_above": "comparison", "border_found": "borders", "contour_found": "contours", "settling_share": "attractors",
}  # fmt: skip
_NO_MAPS = {"ramp": "a ramp", "trajectory": "a trajectory", "comparison": "a comparison of materials"}
_ABOUT = (
    "probability",
    "settling_share",
    "acceleration_level_a",
    "regime",
)  # what a map is about, by the first that it has


def kind_of(ds: xr.Dataset) -> str:
    """The kind of a result: map (of margins as well), borders, contours, attractors, probability, ramp, ..."""
    names = {*map(str, ds.data_vars), *map(str, ds.dims), *map(str, ds.attrs)}
    return next((kind for mark, kind in _MARKS.items() if mark in names), "map")


def subject(ds: xr.Dataset) -> str:
    """The variable that a map shows unless another is named."""
    return next((name for name in _ABOUT if name in ds), "regime")


def is_over_map(ds: xr.Dataset) -> bool:
    """True if a result is drawn over a map: borders of many lines, or contours."""
    if kind_of(ds) == "borders":
        return ds["border"].ndim > 1 and "configuration" in ds.attrs and "cell" not in ds.dims
    return kind_of(ds) == "contours"


def is_drawn(ds: xr.Dataset) -> bool:
    """True if there is a plot of this result: borders of single lines, and one rare event, are numbers alone."""
    if "probability" in ds:
        return "levels" not in ds or ds["probability"].ndim > 1
    return is_over_map(ds) or any(name in ds and ds[name].ndim > 0 for name in ("regime", "settling_share"))


def plot_result(
    ds: xr.Dataset, variable: str | None = None, *, select: Mapping[str, Any] | None = None, title: str | None = None,
    look: Look = PLAIN, borders: bool = True, lines: xr.Dataset | None = None, state: str = "stick_slip",
    behind: xr.Dataset | None = None,
) -> Figure:  # fmt: skip
    """The plot of a result of any kind.

    Parameters
    ----------
    variable : what to draw; None for what this kind of result is about.
    select : fixes dimensions, as for `plot_map`; of probabilities also the `state`.
    title, look, borders, lines : as for `plot_map`; a look of anything but a map is refused.
    state : whose probability is drawn.
    behind : the map of the same cells under borders and contours (`is_over_map`); `ds.stickslip.plot()` computes it.

    Raises
    ------
    PlotError
        for what cannot be drawn.
    """
    kind, places = kind_of(ds), dict(select or {})
    if kind == "rig tests":
        raise PlotError("features of rig tests, no map: `stickslip rig run CONFIG --plot PICTURE` draws them, --report "
                        "makes a page; of records, `stickslip rig features FILES --plot PICTURE`")  # fmt: skip
    if kind == "probability" and variable in (None, "regime"):
        state = places.pop("state", state)
        return plot_probability(selected(ds, places)[0], state, title=title, look=look)
    if kind in _NO_MAPS and (variable is None or kind == "ramp"):
        _check_plain(look, _NO_MAPS[kind])
        if kind == "ramp":
            return plot_of_ramp(ds, variable, select=places, title=title)
        return plot_trace(ds, title=title) if kind == "trajectory" else plot_materials(ds, title=title)
    if kind in ("borders", "contours") and variable is None:
        if not is_over_map(ds):
            raise PlotError("borders of single lines, or of cells without a configuration, are numbers, no plot")
        if behind is None:
            raise PlotError(f"{kind} are drawn over a map, which is missing\nhint: ds.stickslip.plot() computes it")
        behind, _ = part_that_fits(behind, behind["regime"].dims)
        return plot_map(behind, select=places, borders=borders, lines=ds, title=title, look=look)
    variable = variable or subject(ds)
    if variable == "settling_share" and variable in ds and len(set(ds[variable].dims) - set(places)) == 1:
        _check_plain(look, "no map: lines over one parameter")
        return plot_attractors(ds, select=places, title=title)
    return plot_map(ds, variable, select=places, borders=borders, lines=lines, title=title, look=look)


def _check_plain(look: Look, what: str) -> None:
    if look.log or look.limits or look.marks:
        raise PlotError(f"scales, limits and marks are for maps, and this is {what}")
