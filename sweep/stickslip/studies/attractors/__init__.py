"""Which attractors a cell has, and which starting states lead to which.

`exact.py` decides by theorems of the plane (`plain.py`) which states settle on a plain Stribeck curve: those inside its
unstable cycle, which `cycle.py` finds backwards in time and `area.py` measures. `sampled.py` draws starting states for
all other cells. `study.py` puts them together, cell by cell; `ramp.py` follows
attractors as a parameter goes slowly up and down.
"""

from stickslip.studies.attractors.ramp import Ramp, RampStudy
from stickslip.studies.attractors.section import Attractors
from stickslip.studies.attractors.study import COLUMNS, AttractorStudy, find_attractors

__all__ = ["COLUMNS", "AttractorStudy", "Attractors", "Ramp", "RampStudy", "find_attractors"]
