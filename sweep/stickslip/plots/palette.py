"""Colours: the same for a regime in every plot.

The palette is that of Okabe and Ito, which colour-blind readers can tell apart; what was not decided is white, grey or
black.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize, to_hex, to_rgb
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.dataset.coarse import Coarse
from stickslip.vocabulary.flags import FLAGS, flag_label

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
        "slip_cycle": YELLOW,
        "never_breaks_away": GREEN,
        "horizon_reached": GREY,
        "step_limit": ORANGE,
        "step_underflow": PURPLE,
        "not_finite": BLACK,
        "neutral_ringing": "#fff7a8",
        "two_way_slip_cycle": "#b8a800",
        "fall_hold_cycle": "#806000",
        "settling_observed": "#a6dcf5",
        "settling_certain": BLUE,
        "too_slow_to_tell": "#8c8c8c",
        "negative_friction": "#5c2a4d",
    },
    "computed": {"inferred": WHITE, "computed": BLACK},
}
FLAG_COLOURS |= {
    "regime_from_stick": FLAG_COLOURS["regime"],
    "regime_from_sliding": FLAG_COLOURS["regime"],
    "share_method": {"not_computed": WHITE, "exact": BLUE, "sampled": ORANGE},
}
UNDEFINED_COLOUR = "#dddddd"  # cells where a continuous variable has no value
_LOG_FROM = 100.0  # ratio of largest to smallest value from which colours are logarithmic
_PALENESS = 0.62  # how far the colour of a mixed pixel lies on the way to white
_PALE_WHITE = "#ececec"

Entry = Patch | tuple[Patch, ...]  # of a legend; several patches stand side by side under the label of the first


@dataclass(frozen=True)
class Paint:
    """How the values of one variable become colours, the same in every panel of a figure.

    flags : names and colours of the flags that occur; None for a number. hidden : those that occur in mixed pixels
        only, where others are more frequent. mixed : colours of mixed pixels.
    has_gaps : whether some cells have no value.
    """

    colours: Colormap
    norm: Normalize
    flags: dict[str, str] | None = None
    hidden: Collection[str] = ()
    mixed: tuple[str, ...] = ()
    has_gaps: bool = False

    def handles(self) -> list[Entry]:
        """Legend entries: the flags that occur, and mixed pixels; or the colour of cells without a value."""
        if self.flags is None:
            return [_swatch("undefined", UNDEFINED_COLOUR)] if self.has_gaps else []
        found: list[Entry] = [
            _swatch(flag_label(name), colour, " (only in mixed)" if name in self.hidden else "")
            for name, colour in self.flags.items()
        ]
        if self.mixed:
            found.append(tuple(_swatch("mixed", colour, " (pale: the most frequent)") for colour in self.mixed))
        return found


def paint(variable: str, values: NDArray[np.generic], present: Collection[int] = ()) -> Paint:
    """Fixed colours for flags; viridis for numbers, logarithmic if they are positive and span two decades.

    values : flags may be marked as mixed (`marked`). present : flags that occur besides those in `values`.
    """
    if variable in FLAG_COLOURS:
        return _flag_paint(variable, {int(code) for code in np.unique(values)}, set(present))
    numbers = values.astype(np.float64)
    finite = numbers[np.isfinite(numbers)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    scale = LogNorm if low > 0 and high / low > _LOG_FROM else Normalize
    return Paint(colormaps["viridis"], scale(low, high), has_gaps=finite.size < values.size)


def marked(variable: str, coarse: Coarse) -> NDArray[np.generic]:
    """The values of pixels as `paint` takes them: a mixed pixel has the code of its flag plus the number of flags."""
    if coarse.mixed is None:
        return coarse.values
    values = np.where(coarse.mixed, coarse.values + len(FLAGS[variable]), coarse.values)
    return np.ma.masked_array(values, coarse.values.mask) if isinstance(coarse.values, np.ma.MaskedArray) else values


def _flag_paint(variable: str, drawn: set[int], present: set[int]) -> Paint:
    """The colours of a flag, those of mixed pixels after the others."""
    names = list(FLAGS[variable])
    pure = [FLAG_COLOURS[variable][name] for name in names]
    pale = [_pale(colour) for colour in pure]
    shown = {code % len(names) for code in drawn}
    return Paint(
        ListedColormap(pure + pale),
        BoundaryNorm(np.arange(2 * len(names) + 1) - 0.5, 2 * len(names)),
        flags={names[code]: pure[code] for code in sorted(shown | present)},
        hidden={names[code] for code in present - shown},
        mixed=tuple(pale[code % len(names)] for code in sorted(drawn) if code >= len(names)),
    )


def _pale(colour: str) -> str:
    """A tint, which no pure colour of the palette looks like."""
    if colour == WHITE:
        return _PALE_WHITE
    red, green, blue = (channel + _PALENESS * (1.0 - channel) for channel in to_rgb(colour))
    return to_hex((red, green, blue))


def _swatch(name: str, colour: str, remark: str = "") -> Patch:
    """A legend entry. stick_slip is written stick-slip."""
    label = "stick-slip" if name == "stick_slip" else name.replace("_", " ")
    return Patch(facecolor=colour, edgecolor="black", linewidth=0.5, label=label + remark)
