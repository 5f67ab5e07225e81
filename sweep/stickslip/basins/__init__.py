"""Which attractors a cell has, and which starting states lead to which.

`exact.py` decides by theorems of the plane (`plain.py`) which states settle on a plain Stribeck curve: those inside its
unstable cycle, which `cycle.py` finds backwards in time and `area.py` measures. `sampled.py` draws starting states for
all other cells. `find.py` puts them together, cell by cell, and `study.py` does so for a run; `ramp.py` follows
attractors as a parameter goes slowly up and down, and `branches.py` adds what is unstable.
"""

from stickslip.basins.box import Box, Sampling
from stickslip.basins.branches import between_branches
from stickslip.basins.find import COLUMNS, find_attractors
from stickslip.basins.ramp import Ramp, follow_ramp
from stickslip.basins.study import AttractorStudy, asked_of_cells, asked_of_config, attractor_study

__all__ = [
    "COLUMNS", "AttractorStudy", "Box", "Ramp", "Sampling", "asked_of_cells", "asked_of_config", "attractor_study",
    "between_branches", "find_attractors", "follow_ramp",
]  # fmt: skip
