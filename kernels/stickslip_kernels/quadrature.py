"""Gauss-Legendre rules on [0, 1]."""

# Five points: exact for polynomials of degree nine.
_NEAR, _FAR = 0.5384693101056831, 0.9061798459386640
NODES = (0.5 - 0.5 * _FAR, 0.5 - 0.5 * _NEAR, 0.5, 0.5 + 0.5 * _NEAR, 0.5 + 0.5 * _FAR)
_OUTER, _INNER = 0.11846344252809454, 0.23931433524968324
WEIGHTS = (_OUTER, _INNER, 0.28444444444444444, _INNER, _OUTER)
