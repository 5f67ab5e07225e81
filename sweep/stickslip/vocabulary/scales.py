"""The scales of a cell, by which everything is converted between SI and kernel units.

They are the load N for forces, N/k for displacements, sqrt(m/k) for times, N/sqrt(k m) for speeds, N/m for
accelerations.
"""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.vocabulary.quantities import PARAMETERS

Floats = NDArray[np.float64]


class Scales:
    """The scales of cells, each (n,)."""

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


def scales_of(given: Mapping[str, ArrayLike]) -> Scales:
    """The scales of cells of which some quantities are given, in SI: the others are at their defaults, or NaN.

    Mass, stiffness and load of an oscillator are asked of `Scales` alone: further parameters may add to them.
    """
    defaults = {name: np.nan if row.default is None else row.default for name, row in PARAMETERS.items()}
    known = {name: value for name, value in given.items() if name in PARAMETERS}
    return Scales({name: np.asarray(value, np.float64) for name, value in (defaults | known).items()})
