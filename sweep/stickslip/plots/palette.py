"""Colours: the same for a regime in every plot.

The palette is that of Okabe and Ito, which colour-blind readers can tell apart; what was not decided is white, grey or
black.
"""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import AsinhNorm, BoundaryNorm, Colormap, ListedColormap, LogNorm, Normalize, to_hex, to_rgb
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.dataset.coarse import Coarse
from stickslip.errors import PlotError
from stickslip.vocabulary.quantities import FLAGS, flag_label

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
        "hysteresis_undefined": "#3d3d3d",
        "irregular": "#8a4b20",
    },
    "computed": {"inferred": WHITE, "computed": BLACK},
}
FLAG_COLOURS |= {
    "verdict": dict(zip(FLAGS["verdict"], (WHITE, VERMILLION, SKY, GREY, BLACK), strict=True)),
    "regime_from_stick": FLAG_COLOURS["regime"],
    "regime_from_sliding": FLAG_COLOURS["regime"],
    "share_method": {"not_computed": WHITE, "exact": BLUE, "sampled": ORANGE},
}
# On a page without colours areas are told apart by their hatching; the most frequent of the bright ones has none.
HATCHES = {VERMILLION: "//", BLUE: "...", GREEN: "---", YELLOW: "++", GREY: "xxx"}
DIVERGING = ("damping_ratio", "restick_margin", "tendency")  # whose sign matters: colours part at 0
UNDEFINED_COLOUR = "#dddddd"  # cells where a continuous variable has no value
UNDEFINED_HATCH = "////"  # for in grey the brightest values look like them
_LOG_FROM = 100.0  # ratio of largest to smallest value from which colours are logarithmic
_MOST_RATIO = 1e4  # of the largest value to those around zero on a scale that is linear there and logarithmic beyond
_SEQUENTIAL, _ABOUT_ZERO = "viridis", "RdBu"  # the second: red below zero, where sliding is unstable
_INK = 0.4  # how far the colour of hatching lies from that of its area on the way to black or white
_BRIGHTNESS = (0.299, 0.587, 0.114)  # of red, green and blue
_PALENESS = 0.62  # how far the colour of a mixed pixel lies on the way to white
_PALE_WHITE = "#ececec"

Entry = Patch | tuple[Patch, ...]  # of a legend; several patches stand side by side under the label of the first


@dataclass(frozen=True)
class Paint:
    """Colours of the values of one variable, the same in every panel of a figure.

    flags : names and colours of the flags that occur; None for a number. hidden : those that occur in mixed pixels
        only, where others are more frequent. mixed : colours of mixed pixels.
    has_gaps : whether some cells have no value. beyond : at which end values lie beyond the colours, as matplotlib says
        it: "neither", "min", "max", "both". span : of a number, what its colour bar shows.
    """

    colours: Colormap
    norm: Normalize
    flags: dict[str, str] | None = None
    hidden: Collection[str] = ()
    mixed: tuple[str, ...] = ()
    has_gaps: bool = False
    beyond: str = "neither"
    span: tuple[float, float] = (0.0, 1.0)

    def handles(self) -> list[Entry]:
        """Legend entries: the flags that occur, and mixed pixels; or the colour of cells without a value."""
        if self.flags is None:
            return [_swatch("undefined", UNDEFINED_COLOUR, UNDEFINED_HATCH)] if self.has_gaps else []
        remark = dict.fromkeys(self.hidden, " (only in mixed)")
        entries: list[Entry] = [
            _swatch(regime_label(name) + remark.get(name, ""), colour, HATCHES.get(colour))
            for name, colour in self.flags.items()
        ]
        mixed = tuple(_swatch("mixed (pale: the most frequent)", colour) for colour in self.mixed)
        return [*entries, mixed] if mixed else entries


def paint(
    variable: str, values: NDArray[np.generic], present: Collection[int] = (), *,
    limits: tuple[float, float] | None = None, log: bool = False,
) -> Paint:  # fmt: skip
    """Fixed colours for flags; for numbers viridis, logarithmic if they are positive and span two decades, or colours
    that part at zero where the sign matters.

    values : flags may be marked as mixed (`marked`). present : flags that occur besides those in `values`.
    limits : of the colours of numbers. log : whether these are logarithmic in any case.
    Raises PlotError for logarithmic colours of numbers that are not positive.
    """
    if variable in FLAG_COLOURS:
        return _flag_paint(variable, {int(code) for code in np.unique(values)}, set(present))
    numbers = values.astype(np.float64)
    finite = numbers[np.isfinite(numbers)]
    least, most = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    low, high = limits or (least, most)
    beyond = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}
    colours, norm = _scale(variable, low, high, log, finite, (least, most))
    return Paint(colours, norm, has_gaps=finite.size < values.size, beyond=beyond[least < low, most > high],
                 span=(low, high))  # fmt: skip


def _scale(
    variable: str, low: float, high: float, log: bool, numbers: NDArray[np.float64], whole: tuple[float, float]
) -> tuple[Colormap, Normalize]:
    """Colours of numbers from `low` to `high`; limits do not change the scale that the `whole` has."""
    if log and not low > 0:
        raise PlotError(f"{variable} is not positive everywhere (least {low:.4g}): no logarithmic colours\n"
                        f"hint: limits that are positive: --limits {variable}=LOW..HIGH")  # fmt: skip
    wide = any(least > 0 and most / least > _LOG_FROM for least, most in ((low, high), whole))
    if log or (low > 0 and wide and not _has_sign(variable)):
        return colormaps[_SEQUENTIAL], LogNorm(low, high)
    if _has_sign(variable) and low < 0 < high:
        most, usual = max(-low, high), float(np.median(np.abs(numbers)))
        if usual * _LOG_FROM >= most:
            return colormaps[_ABOUT_ZERO], Normalize(-most, most)
        return colormaps[_ABOUT_ZERO], AsinhNorm(max(usual, most / _MOST_RATIO), vmin=-most, vmax=most)
    return colormaps[_SEQUENTIAL], Normalize(low, high)


def _has_sign(variable: str) -> bool:
    """True if the sign of a variable says something, so that its colours part at zero."""
    return variable in DIVERGING or variable.startswith("margin_")


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
    pale = [_PALE_WHITE if colour == WHITE else _blend(colour, WHITE, _PALENESS) for colour in pure]
    shown = {code % len(names) for code in drawn}
    return Paint(
        ListedColormap(pure + pale),
        BoundaryNorm(np.arange(2 * len(names) + 1) - 0.5, 2 * len(names)),
        flags={names[code]: pure[code] for code in sorted(shown | present)},
        hidden={names[code] for code in present - shown},
        mixed=tuple(pale[code % len(names)] for code in sorted(drawn) if code >= len(names)),
    )


def ink(colour: str) -> str:
    """The colour of lines that show on an area of a colour: light ones on what is dark in grey."""
    return _blend(colour, WHITE if np.dot(_BRIGHTNESS, to_rgb(colour)) < 0.5 else BLACK, _INK)


def _blend(colour: str, other: str, share: float) -> str:
    """The colour that lies a share of the way to another one."""
    here, there = np.array(to_rgb(colour)), np.array(to_rgb(other))
    return to_hex(here + share * (there - here))


def regime_label(name: str) -> str:
    """The name of a regime, or of another flag, on plots and pages: stick_slip is written stick-slip."""
    return flag_label(name).replace("stick_slip", "stick-slip").replace("_", " ")


def _swatch(label: str, colour: str, hatch: str | None = None) -> Patch:
    return Patch(facecolor=colour, edgecolor=ink(colour) if hatch else "black", hatch=hatch, linewidth=0.5, label=label)


# --- lines that are told apart ----------------------------------------------------------------------------------------

# Ten of each; with the marks and lines they are told apart without colours.
COLOURS = (BLUE, VERMILLION, BLACK, ORANGE, PURPLE, GREEN, "#542788", SKY, "#8c510a", "#7f7f7f")
MARKS = "os^DvPX*<>"
STYLES: tuple[Any, ...] = (
    "solid", (0, (6, 2)), (0, (1.5, 1.5)), (0, (7, 2, 1.5, 2)), (0, (3, 1.5)), (0, (1, 3)), (0, (12, 2)),
    (0, (6, 1.5, 1.5, 1.5, 1.5, 1.5)), (0, (2, 4)), (0, (10, 2, 3, 2)),
)  # fmt: skip


def look_of(number: int) -> dict[str, Any]:
    """The colour, mark and line of one of several, by its place in their order."""
    colour = COLOURS[number % len(COLOURS)]
    return {
        "color": colour, "marker": MARKS[number % len(MARKS)], "linestyle": STYLES[number % len(STYLES)],
        "markerfacecolor": colour if number % 2 else "white",
    }  # fmt: skip
