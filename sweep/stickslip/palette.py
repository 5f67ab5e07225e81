"""Colours: the same for a regime in every picture.

The palette is that of Okabe and Ito, which colour-blind readers can tell apart; what was not decided is white, grey or
black.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize
from matplotlib.patches import Patch
from numpy.typing import NDArray

from .variables import FLAGS

WHITE, GREY, BLACK = "#ffffff", "#b8b8b8", "#000000"
VERMILLION, ORANGE, YELLOW = "#d55e00", "#e69f00", "#f0e442"
GREEN, SKY, BLUE, PURPLE = "#009e73", "#56b4e9", "#0072b2", "#cc79a7"

FLAG_COLOURS: dict[str, dict[str, str]] = {
    "regime": {
        "not_computed": WHITE,
        "stick_slip": VERMILLION,
        "damped": SKY,
        "creep": BLUE,
        "sustained": YELLOW,
        "stuck": GREEN,
        "unresolved": GREY,
        "failed": BLACK,
    },
    "status": {
        "not_run": WHITE,
        "cycle_closed": VERMILLION,
        "settled": SKY,
        "oscillation_sustained": YELLOW,
        "never_breaks_away": GREEN,
        "horizon_reached": GREY,
        "step_limit": ORANGE,
        "step_underflow": PURPLE,
        "not_finite": BLACK,
    },
}
UNDEFINED_COLOUR = "#dddddd"  # cells where a continuous variable has no value
_LOG_FROM = 100.0  # ratio of largest to smallest value from which colours are logarithmic


@dataclass(frozen=True)
class Paint:
    """How the values of one variable become colours, the same in every panel of a figure.

    flags : names and colours of the flags that occur; None for a number.
    has_gaps : whether some cells have no value.
    """

    colours: Colormap
    norm: Normalize
    flags: dict[str, str] | None = None
    has_gaps: bool = False

    def handles(self) -> list[Patch]:
        """Legend entries: the flags that occur, or the colour of cells without a value."""
        if self.flags is not None:
            return [_swatch(name, colour) for name, colour in self.flags.items()]
        return [_swatch("undefined", UNDEFINED_COLOUR)] if self.has_gaps else []


def paint(variable: str, values: NDArray[np.generic]) -> Paint:
    """Fixed colours for flags; viridis for numbers, logarithmic if they are positive and span two decades."""
    if variable in FLAG_COLOURS:
        names = list(FLAGS[variable])
        colours = [FLAG_COLOURS[variable][name] for name in names]
        norm = BoundaryNorm(np.arange(len(names) + 1) - 0.5, len(names))
        return Paint(ListedColormap(colours), norm, {names[int(i)]: colours[int(i)] for i in np.unique(values)})
    numbers = values.astype(np.float64)
    finite = numbers[np.isfinite(numbers)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    scale = LogNorm if low > 0 and high / low > _LOG_FROM else Normalize
    return Paint(colormaps["viridis"], scale(low, high), has_gaps=finite.size < values.size)


def _swatch(name: str, colour: str) -> Patch:
    """A legend entry. stick_slip is written as the field writes it."""
    label = "stick-slip" if name == "stick_slip" else name.replace("_", " ")
    return Patch(facecolor=colour, edgecolor="black", linewidth=0.5, label=label)
