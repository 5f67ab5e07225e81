"""The scales of a cell, by which everything is converted between SI and kernel units."""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Scales:
    """The scales of cells, each (n,).

    They are the load N for forces, N/k for displacements, sqrt(m/k) for times, N/sqrt(k m) for speeds, N/m for
    accelerations.
    """

    cells: Mapping[str, Floats]
    mass: Floats
    stiffness: Floats
    load: Floats

    def __init__(self, cells: Mapping[str, Floats]) -> None:
        self.cells = cells
        self.mass, self.stiffness = cells["mass"], cells["stiffness"]
        self.load = cells["normal_load"]

    @cached_property
    def impedance(self) -> Floats:
        """sqrt(k m), N s/m."""
        return np.asarray(np.sqrt(self.stiffness * self.mass))

    @property
    def critical_damping(self) -> Floats:
        """2 sqrt(k m), N s/m."""
        return 2.0 * self.impedance

    @property
    def natural_frequency(self) -> Floats:
        """Of the mass on its spring, Hz."""
        return self.rate / (2.0 * np.pi)

    @cached_property
    def time(self) -> Floats:
        """A radian of the free oscillation, s."""
        return np.asarray(np.sqrt(self.mass / self.stiffness))

    @cached_property
    def rate(self) -> Floats:
        """Its inverse, 1/s."""
        return np.asarray(np.sqrt(self.stiffness / self.mass))

    @cached_property
    def length(self) -> Floats:
        """Deflection of the spring by the load, m."""
        return np.asarray(self.load / self.stiffness)

    @cached_property
    def speed(self) -> Floats:
        """m/s."""
        return np.asarray(self.load / self.impedance)
