"""What is asked: the box of starting states, and how finely it is sampled where it has to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from numbers import Integral
from typing import Any

from stickslip.errors import ArgumentError, QuantityError
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.settings import ATTRACTORS, RANDOMISATIONS
from stickslip.vocabulary.suggest import suggest

Interval = tuple[float, float]
_NAMES = ("displacement", "velocity")


@dataclass(frozen=True)
class Box:
    """Starting states: a rectangle of displacements (m) and velocities (m/s), each (low, high).

    Raises TypeError or ArgumentError.
    """

    displacement: Interval
    velocity: Interval

    def __post_init__(self) -> None:
        for name in _NAMES:
            object.__setattr__(self, name, _interval(name, getattr(self, name)))

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Box:
        """From a mapping of both intervals. Raises TypeError or ArgumentError for anything that is no box."""
        if not isinstance(given, Mapping):
            raise TypeError(f"box: got {given!r}, expected {{'displacement': (low, high), 'velocity': (low, high)}}")
        for name in given:
            if name not in _NAMES:
                near = suggest(str(name), _NAMES)
                hint = f"; did you mean {near!r}?" if near else ""
                raise TypeError(f"box: {name!r} is not one of {', '.join(_NAMES)}{hint}")
        for name in _NAMES:
            if name not in given:
                raise ArgumentError("box", f"{name} is missing, expected (low, high)")
        return cls(*(given[name] for name in _NAMES))

    @property
    def area(self) -> float:
        """Area in the plane of states (m2/s)."""
        (left, right), (low, high) = self.displacement, self.velocity
        return (right - left) * (high - low)


def _interval(name: str, ends: Any) -> Interval:
    row = QUANTITIES[name]
    try:
        low, high = (row.read(end) if isinstance(end, str) else float(end) for end in ends)
    except QuantityError as error:
        raise ArgumentError("box", f"{name}: got {ends!r}, {error}") from None
    except (TypeError, ValueError):
        raise TypeError(f"box: {name}: got {ends!r}, expected two numbers (low, high)") from None
    for word, end in (("lower", low), ("upper", high)):
        if not isfinite(end):
            raise ArgumentError("box", f"{name}: got {end:g} as {word} end, expected a finite number")
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        expected = f"expected the lower end first and the upper above it{hint}"
        raise ArgumentError("box", f"{name}: got {low:g} to {high:g}, {expected}")
    return low, high


@dataclass(frozen=True)
class Sampling:
    """Starting states drawn per cell where its share is not exact: a multiple of `RANDOMISATIONS`; and the seed."""

    samples: int = 1024
    seed: int = 1

    def __post_init__(self) -> None:
        for name in ("samples", "seed"):
            row, value = ATTRACTORS[name], getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, Integral) or not row.allows(value):
                raise ArgumentError(name, f"got {value!r}, expected {row.expected}")
        if self.samples % RANDOMISATIONS or self.points & (self.points - 1):
            raise ArgumentError("samples", f"got {self.samples}, expected {RANDOMISATIONS} times a power of 2")

    @property
    def points(self) -> int:
        """Points of each randomisation."""
        return self.samples // RANDOMISATIONS
