"""Which attractors a cell has, and which starting states lead to which.

`plain.py` decides by theorems of the plane where the plain Stribeck curve settles: inside its unstable cycle, which
`cycle.py` finds backwards in time and `area.py` measures. `sampled.py` draws starting states for all other cells.
`find.py` puts them together, cell by cell; `ramp.py` follows attractors as a parameter goes slowly up and down.
"""

from stickslip.basins.box import Box, Sampling
from stickslip.basins.find import COLUMNS, find_attractors
from stickslip.basins.ramp import Ramp, follow_ramp

__all__ = ["COLUMNS", "Box", "Ramp", "Sampling", "find_attractors", "follow_ramp"]
