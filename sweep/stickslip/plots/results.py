"""The plot of any result: which kind it is, and what is drawn of it, for the command, for Python and for pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from stickslip.dataset.selection import selected
from stickslip.errors import PlotError
from stickslip.plots.attractors import plot_attractors
from stickslip.plots.branches import plot_of_ramp
from stickslip.plots.figure import Figure
from stickslip.plots.look import PLAIN, Look
from stickslip.plots.maps import plot_map
from stickslip.plots.materials import plot_materials
from stickslip.plots.traces import plot_trace
from stickslip.plots.uncertainty import plot_probability

_ABOUT = ("settling_share", "acceleration_level_a", "regime")  # what a map is about, by the first that it has


def subject(ds: xr.Dataset) -> str:
    """The variable that a map shows unless another is named."""
    return next((name for name in _ABOUT if name in ds), "regime")


def is_over_map(ds: xr.Dataset) -> bool:
    """Whether a result is drawn over a map: borders of many lines, or contours."""
    if "border_found" in ds.attrs:
        return ds["border"].ndim > 1 and "configuration" in ds.attrs and "cell" not in ds.dims
    return "contour_found" in ds.attrs


def plot_result(
    ds: xr.Dataset, variable: str | None = None, *, select: Mapping[str, Any] | None = None, title: str | None = None,
    look: Look = PLAIN, borders: bool = True, lines: xr.Dataset | None = None, state: str = "stick_slip",
) -> Figure:  # fmt: skip
    """The plot of a result of any kind, but for those that lie over a map (`is_over_map`).

    Parameters
    ----------
    variable : what to draw; None for what this kind of result is about.
    select : fixes dimensions, as for `plot_map`; of probabilities also the `state`.
    title, look, borders, lines : as for `plot_map`; a look of anything but a map is refused.
    state : whose probability is drawn.

    Raises
    ------
    PlotError
        for what cannot be drawn.
    """
    places = dict(select or {})

    def no_map(what: str) -> None:
        if look.log or look.limits or look.marks:
            raise PlotError(f"scales, limits and marks are for maps, and this is {what}")

    if "model_rpn" in ds:
        raise PlotError("features of rig tests, no map: `stickslip rig run CONFIG --plot PICTURE` draws them, --report "
                        "makes a page; of records, `stickslip rig features FILES --plot PICTURE`")  # fmt: skip
    if "probability" in ds and variable in (None, "regime"):
        state = places.pop("state", state)
        return plot_probability(selected(ds, places)[0], state, title=title, look=look)
    if "direction" in ds.dims:
        no_map("a ramp")
        return plot_of_ramp(ds, variable, select=places, title=title)
    if "time" in ds.dims and variable is None:
        no_map("a trajectory")
        return plot_trace(ds, title=title)
    if "quiet_above" in ds and variable is None:
        no_map("a comparison of materials")
        return plot_materials(ds, title=title)
    variable = variable or subject(ds)
    if variable == "settling_share" and variable in ds and len(set(ds[variable].dims) - set(places)) == 1:
        no_map("no map: lines over one parameter")
        return plot_attractors(ds, select=places, title=title)
    return plot_map(ds, variable, select=places, borders=borders, lines=lines, title=title, look=look)
