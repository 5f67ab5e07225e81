"""Where along a parameter the regime changes, to as many digits as asked for.

`search.py` finds where labels change along lines and knows nothing of friction (`secant.py`: where to look next);
`lines.py` says which cells lie on a line, from a list of cells or a configuration; `find.py` puts the two together
through the engine.
"""

from stickslip.borders.find import BorderStudy, Limits, border_study
from stickslip.borders.lines import Lines, lines_of_cells, lines_of_config
from stickslip.borders.search import Looked, Scan, search_lines

__all__ = [
    "BorderStudy",
    "Limits",
    "Lines",
    "Looked",
    "Scan",
    "border_study",
    "lines_of_cells",
    "lines_of_config",
    "search_lines",
]
