"""Inputs that scatter: probabilities of regimes, spread of metrics, and which input decides.

`design.py` says which draw an item of a run is, from scrambled Sobol points, `inputs.py` which cells are behind draws;
`sampling.py` computes them as a study, and `reduction.py` reduces all draws to numbers with errors. `subset.py` has
subset simulation of rare events, and that of stick-slip as a study.
"""

from stickslip.studies.uncertainty.sampling import SampleStudy
from stickslip.studies.uncertainty.subset import RareStudy

__all__ = ["RareStudy", "SampleStudy"]
