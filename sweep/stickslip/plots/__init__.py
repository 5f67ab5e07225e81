"""Plots of datasets, and of any result by its kind: for the command, for Python and for pages.

Every function returns a matplotlib Figure and touches no global state: no pyplot, no window, safe in threads.

    maps, lines, attractors   the plots                        pages     HTML files with plots
    layout   figure, axes, title, notes, legend, file          palette   colours, hatching
    marks    what may be asked of a map, and is drawn over it
"""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from stickslip import extensions
from stickslip.config.studies import result_class
from stickslip.dataset.selection import MAX_PANELS, check_dataset, part_that_fits
from stickslip.errors import PlotError
from stickslip.plots.attractors import plot_attractors, plot_branches, plot_of_ramp, plot_ramp
from stickslip.plots.layout import DPI, Figure, name_of, save
from stickslip.plots.lines import plot_probability, plot_trace
from stickslip.plots.maps import plot_map
from stickslip.plots.marks import BORDERS, PLAIN, Look, Mark
from stickslip.vocabulary.quantities import kind_of

__all__ = [
    "BORDERS", "DPI", "Look", "MAX_PANELS", "Mark", "PlotError", "check_plain", "is_drawn", "is_over_map", "kind_of",
    "name_of", "plot_attractors", "plot_branches", "plot_map", "plot_of_ramp",
    "plot_probability", "plot_ramp", "plot_result", "plot_trace", "save", "subject",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    return extensions.call(name, __name__)


def subject(ds: xr.Dataset) -> str:
    """The variable that a result shows unless another is named."""
    study = result_class(ds)
    if study is not None:
        return study.subject
    brought = (name for extension in extensions.installed() for name in extension.subjects if name in ds)
    return next(brought, "regime")


def is_over_map(ds: xr.Dataset) -> bool:
    """True if a result is drawn over a map: borders of many lines, or contours."""
    study = result_class(ds)
    return study is not None and study.over_map and study.is_drawn(ds)


def is_drawn(ds: xr.Dataset) -> bool:
    """True if there is a plot of this result: borders of single lines, and one rare event, are numbers alone."""
    study = result_class(ds)
    return study.is_drawn(ds) if study else "regime" in ds and ds["regime"].ndim > 0


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
    check_dataset(ds)
    kind, study, places = kind_of(ds), result_class(ds), dict(select or {})
    if kind == "trajectory" and variable is None:
        check_plain(look, "a trajectory")
        return plot_trace(ds, title=title)
    if study and study.over_map and variable is None:
        if not study.is_drawn(ds):
            raise PlotError("borders of single lines, or of cells without a configuration, are numbers, no plot")
        if behind is None:
            raise PlotError(f"{kind} is drawn over a map, which is missing\nhint: ds.stickslip.plot() computes it")
        behind, _ = part_that_fits(behind, behind["regime"].dims)
        return plot_map(behind, select=places, borders=borders, lines=ds, title=title, look=look)
    figure: Figure | None = study.figure(ds, variable, places, title, look, state) if study else None
    if figure is not None:
        return figure
    return plot_map(ds, variable or subject(ds), select=places, borders=borders, lines=lines, title=title, look=look)


def check_plain(look: Look, what: str) -> None:
    """Raise PlotError if a look of maps is asked of something else."""
    if look.log or look.limits or look.marks:
        raise PlotError(f"scales, limits and marks are for maps, and this is {what}")
