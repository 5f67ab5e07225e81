"""Where along a parameter the regime changes, to as many digits as asked for.

`search.py` finds where labels change along lines and knows nothing of friction (`secant.py`: where to look next);
`lines.py` says which cells lie on a line, from a list of cells or a configuration; `find.py` puts the two together
through the engine.

In planes of two parameters: `plane.py` says which cells lie in it, `walk.py` follows borders over the cells of a grid,
`tracing.py` joins crossings to lines, `junctions.py` closes in on where three regimes meet; `contours.py` puts these
together.
"""

from stickslip.borders.contours import ContourStudy, contour_study
from stickslip.borders.find import BorderStudy, Limits, border_study
from stickslip.borders.lines import Lines, lines_of_cells, lines_of_config
from stickslip.borders.plane import Plane, plane_of_cells, plane_of_config
from stickslip.borders.search import Looked, Scan, search_lines

__all__ = [
    "BorderStudy", "ContourStudy", "Limits", "Lines", "Looked", "Plane", "Scan", "border_study", "contour_study",
    "lines_of_cells", "lines_of_config", "plane_of_cells", "plane_of_config", "search_lines",
]  # fmt: skip
