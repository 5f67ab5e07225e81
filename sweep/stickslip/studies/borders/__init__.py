"""Borders of regimes along a parameter, to as many digits as asked for.

`search.py` finds where labels change along lines and knows nothing of friction;
`lines.py` leaves one or two parameters of cells open; `border.py` puts the two together through the engine.

In planes of two parameters: `walk.py` follows borders over the cells of a grid, `tracing.py` joins crossings to lines
and closes in on where three regimes meet; `plane.py` puts these together, and `contours.py` makes a study of it.
"""

from stickslip.studies.borders.border import Border, BorderStudy
from stickslip.studies.borders.contours import Contours, ContourStudy
from stickslip.studies.borders.lines import Side, fine_enough, opened, search_options
from stickslip.studies.borders.search import Looked, Scan, search_lines

__all__ = [
    "Border", "BorderStudy", "ContourStudy", "Contours", "Looked", "Scan", "Side", "fine_enough", "opened",
    "search_lines", "search_options",
]  # fmt: skip
