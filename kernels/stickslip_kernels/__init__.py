"""Kernels of the stick-slip engine: numbers in, numbers out, in dimensionless units (`layout.py`)."""
