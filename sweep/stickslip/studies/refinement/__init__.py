"""Maps without most of the pixels: boxes of cells are computed at few points, and split where these differ.

`boxes.py` knows labels of points and nothing else; `tiles.py` cuts grids, `rounds.py` asks round by round for what must
be computed next, and audits the rest; `painting.py` makes full maps of it, `study.py` is what a run
computes.
"""

from stickslip.studies.refinement.study import RefinedMap

__all__ = ["RefinedMap"]
