"""Axes of figures in the browser: titles, ticks and ranges that change with what is drawn."""

from __future__ import annotations

from bokeh.models import (
    BasicTicker,
    BasicTickFormatter,
    CustomJSTicker,
    CustomJSTickFormatter,
    FixedTicker,
    PlainText,
    Plot,
)
from bokeh.models.axes import Axis
from bokeh.plotting import figure

from stickslip.explore.maps import Side

_MOST_LABELS = 16
_LONGEST = 40  # letters of all labels along x, beyond which they are written at a slant

# Places are logarithms to base 10. Decades; with less of them in sight multiples; then even steps of the value.
_LOG_TICKS = """
const [low, high] = [Math.min(cb_data.start, cb_data.end), Math.max(cb_data.start, cb_data.end)]
const span = high - low
const found = []
if (span < 0.5) {
  const [a, b] = [10**low, 10**high]
  const raw = (b - a)/6, unit = 10**Math.floor(Math.log10(raw))
  const step = unit*[1, 2, 5, 10].find((k) => unit*k >= raw)
  for (let v = Math.ceil(a/step)*step; v <= b; v += step) found.push(Math.log10(v))
  return found
}
const every = Math.max(1, Math.ceil(span/9))
const factors = span > 3 ? [1] : span > 1.2 ? [1, 2, 5] : [1, 2, 3, 4, 5, 7]
for (let k = Math.floor(low); k <= Math.ceil(high); k++) {
  if (k % every == 0) for (const f of factors) found.push(k + Math.log10(f))
}
return found.filter((t) => t >= low - 1e-9 && t <= high + 1e-9)
"""
_LOG_MINOR = """
const [low, high] = [Math.min(cb_data.start, cb_data.end), Math.max(cb_data.start, cb_data.end)]
if (high - low > 6 || high - low < 0.5) return []
const found = []
for (let k = Math.floor(low); k <= Math.ceil(high); k++) for (let f = 1; f < 10; f++) found.push(k + Math.log10(f))
return found.filter((t) => t >= low && t <= high)
"""
_LOG_WORDS = """
const value = Number((10**tick).toPrecision(4))
return value >= 1e6 || value < 1e-4 ? value.toExponential().replace("e+", "e") : value.toString()
"""
# What a slider or a scale shows: a value in its unit, from its place; what is smaller than `least` came of rounding.
PLACE_WORDS = """
const value = Number((log ? 10**tick : Math.abs(tick) < least ? 0 : tick).toPrecision(4))
return `${value} ${unit}`.trim()
"""


def quiet(plot: figure) -> figure:
    """A figure without the logo and with what all of them have in common."""
    plot.toolbar.logo = None
    plot.toolbar.autohide = True
    plot.min_border_right = 12
    plot.xgrid.grid_line_color = plot.ygrid.grid_line_color = "#e8e8e8"
    for axis in plot.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = "12px"
        axis.axis_label_standoff = 4
        axis.major_label_text_font_size = "11px"
    return plot


def lay_out(plot: Plot, side: Side, which: str) -> None:
    """Give a side of a map its title and ticks; `which` is "x" or "y"."""
    (axis,) = plot.below if which == "x" else plot.left
    assert isinstance(axis, Axis)
    axis.axis_label = PlainText(text=side.title)  # a string would be searched for formulas
    axis.major_label_overrides = {}
    axis.major_label_orientation = "horizontal"
    if side.kind == "listed":
        _name_points(axis, side, which)
    elif side.kind == "log":
        axis.ticker = CustomJSTicker(major_code=_LOG_TICKS, minor_code=_LOG_MINOR)
        axis.formatter = CustomJSTickFormatter(code=_LOG_WORDS)
    else:
        axis.ticker, axis.formatter = BasicTicker(), BasicTickFormatter()


def _name_points(axis: Axis, side: Side, which: str) -> None:
    """Ticks at listed points, under their names."""
    step = -(-len(side.labels) // _MOST_LABELS)
    shown = range(0, len(side.labels), step)
    axis.ticker = FixedTicker(ticks=[*shown])
    axis.formatter = BasicTickFormatter()
    axis.major_label_overrides = {i: PlainText(text=side.labels[i]) for i in shown}
    if which == "x" and sum(len(side.labels[i]) for i in shown) > _LONGEST:
        axis.major_label_orientation = 0.6


def words_of(log: bool, unit: str, least: float) -> CustomJSTickFormatter:
    """Places on a slider as values in their unit. least : what is closer to zero is zero."""
    return CustomJSTickFormatter(code=PLACE_WORDS, args={"log": log, "unit": unit, "least": least})
