"""Inputs that scatter: probabilities of regimes, spread of metrics, and which input decides.

points      scrambled Sobol points, any of them at once         design    which draw an item of a run is
estimate    sums over draws to numbers with errors
"""
