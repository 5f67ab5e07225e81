"""The figure that plots are: matplotlib's, which shows itself in a notebook, and texts as they are."""

from __future__ import annotations

from io import BytesIO
from typing import Any

from matplotlib.figure import Figure as PlainFigure

from stickslip.plots.page import fit
from stickslip.plots.verbatim import show_verbatim

_DPI = 100  # of a picture in a notebook


class Figure(PlainFigure):
    """matplotlib's `Figure`, shown by a notebook whose cell ends with it.

    IPython shows figures once pyplot or `%matplotlib inline` have told it how, which plots without pyplot do not. What
    they tell it goes first, with the format and resolution that the user has chosen.

    formulas : whether texts may hold formulas between dollars, which those of people must not.
    """

    formulas = False

    def draw(self, renderer: Any) -> None:
        """Draw, texts as they are."""
        show_verbatim(self)
        super().draw(renderer)

    def _repr_png_(self) -> bytes:
        fit(self)
        picture = BytesIO()
        self.savefig(picture, format="png", dpi=_DPI)
        return picture.getvalue()
