"""Plots of datasets.

Every function returns a matplotlib Figure and touches no global state: no pyplot, no window, safe in threads.

    maps, traces, spectrogram, attractors, branches, uncertainty, curves, materials   the plots
    results   which of them a result has
    axes   their axes      page   title, legend and file      palette   colours
"""

from stickslip.dataset.selection import MAX_PANELS
from stickslip.errors import PlotError
from stickslip.plots.attractors import plot_attractors, plot_ramp
from stickslip.plots.branches import plot_branches, plot_of_ramp
from stickslip.plots.curves import plot_fits
from stickslip.plots.linear import BORDERS
from stickslip.plots.look import Look, Mark
from stickslip.plots.maps import plot_map
from stickslip.plots.materials import plot_materials
from stickslip.plots.page import DPI, request_of, save
from stickslip.plots.results import is_over_map, plot_result, subject
from stickslip.plots.spectrogram import plot_sound
from stickslip.plots.traces import plot_trace
from stickslip.plots.uncertainty import plot_probability

__all__ = [
    "BORDERS", "DPI", "Look", "MAX_PANELS", "Mark", "PlotError", "plot_attractors", "plot_branches", "plot_fits",
    "is_over_map", "plot_map", "plot_materials", "plot_of_ramp", "plot_probability", "plot_ramp", "plot_result",
    "plot_sound", "plot_trace", "request_of", "save", "subject",
]  # fmt: skip
