"""Inputs that scatter: probabilities of regimes, spread of metrics, and which input decides.

points      scrambled Sobol points, any of them at once       inputs     the cells behind draws
design      which draw an item of a run is                    sampling   draws computed, as a study
estimate    sums over draws to numbers with errors            reduction  all draws to what is told of them
subset      subset simulation of rare events                  rare       that of stick-slip, as a study
told        what was drawn, in words
"""

from stickslip.uncertainty.rare import RareStudy
from stickslip.uncertainty.sampling import SampleStudy

__all__ = ["RareStudy", "SampleStudy"]
