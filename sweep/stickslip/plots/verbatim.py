"""Texts of plots as people wrote them: dollars begin no formula, control characters are written out."""

from __future__ import annotations

from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FixedFormatter, FuncFormatter

from stickslip.errors import visible


def show_verbatim(figure: Figure, part: Artist | None = None) -> None:
    """Have matplotlib show all texts of a figure, or of a part of it, as they are, unless the figure has `formulas`.

    Ticks that matplotlib labels by itself keep their powers of ten.
    """
    if getattr(figure, "formulas", False):
        return
    own = set[Artist]()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            if isinstance(axis.get_major_formatter(), FixedFormatter | FuncFormatter):  # labels that are given
                axis.get_majorticklabels()  # which makes them
            else:
                own.update(set(axis.findobj(Text)) - {axis.label})
    for text in (part or figure).findobj(Text):
        if isinstance(text, Text) and text not in own:
            text.set_parse_math(False)
            text.set_text(visible(text.get_text()))
