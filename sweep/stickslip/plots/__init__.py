"""Plots of datasets.

Every function returns a matplotlib Figure and touches no global state: no pyplot, no window, safe in threads.

    maps, traces, attractors, uncertainty   the plots      kinds   which of them a result has
    layout   figure, title, legend and file      axes   their axes      palette, painting, marks   inside them
    options   what may be asked of a map      fixed_values   what is equal in all cells
"""

from typing import Any

from stickslip import extensions
from stickslip.dataset.selection import MAX_PANELS
from stickslip.errors import PlotError
from stickslip.plots.attractors import plot_attractors, plot_branches, plot_of_ramp, plot_ramp
from stickslip.plots.kinds import is_drawn, is_over_map, plot_result, subject
from stickslip.plots.layout import DPI, name_of, save
from stickslip.plots.maps import plot_map
from stickslip.plots.marks import BORDERS
from stickslip.plots.options import Look, Mark
from stickslip.plots.traces import plot_trace
from stickslip.plots.uncertainty import plot_probability
from stickslip.vocabulary.flags import kind_of

__all__ = [
    "BORDERS", "DPI", "Look", "MAX_PANELS", "Mark", "PlotError", "is_drawn", "is_over_map", "kind_of", "name_of",
    "plot_attractors", "plot_branches", "plot_map", "plot_of_ramp",
    "plot_probability", "plot_ramp", "plot_result", "plot_trace", "save", "subject",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    return extensions.call(name, __name__)
