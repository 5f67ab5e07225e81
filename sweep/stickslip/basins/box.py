"""What is asked: the box of starting states, and how finely it is sampled where it has to be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from math import isfinite
from numbers import Integral
from typing import Any

Interval = tuple[float, float]
_NAMES = ("displacement", "velocity")
RANDOMISATIONS = 16  # of the points: enough for their scatter to be known to a fifth


@dataclass(frozen=True)
class Box:
    """Starting states: a rectangle of displacements (m) and velocities (m/s), each (low, high)."""

    displacement: Interval
    velocity: Interval

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Box:
        """From a mapping of both intervals. Raises TypeError or ValueError for anything that is no box."""
        if not isinstance(given, Mapping):
            raise TypeError(f"box: got {given!r}, expected {{'displacement': (low, high), 'velocity': (low, high)}}")
        for name in given:
            if name not in _NAMES:
                near = get_close_matches(str(name), _NAMES, 1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                raise TypeError(f"box: {name!r} is not one of {', '.join(_NAMES)}{hint}")
        for name in _NAMES:
            if name not in given:
                raise ValueError(f"box: {name} is missing, expected (low, high)")
        return cls(*(_interval(name, given[name]) for name in _NAMES))

    @property
    def area(self) -> float:
        """Area in the plane of states (m2/s)."""
        (left, right), (low, high) = self.displacement, self.velocity
        return (right - left) * (high - low)


def _interval(name: str, ends: Any) -> Interval:
    try:
        low, high = (float(end) for end in ends)
    except (TypeError, ValueError):
        raise TypeError(f"box: {name}: got {ends!r}, expected two numbers (low, high)") from None
    for word, end in (("lower", low), ("upper", high)):
        if not isfinite(end):
            raise ValueError(f"box: {name}: got {end:g} as {word} end, expected a finite number")
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        raise ValueError(f"box: {name}: got {low:g} to {high:g}, expected the lower end first and the upper above it{hint}")
    return low, high


@dataclass(frozen=True)
class Sampling:
    """Starting states drawn per cell where its share is not exact: a multiple of `RANDOMISATIONS`; and the seed."""

    samples: int = 1024
    seed: int = 1

    def __post_init__(self) -> None:
        for name, least in (("samples", RANDOMISATIONS), ("seed", 0)):
            value: object = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
                raise ValueError(f"{name}: got {value!r}, expected a whole number of at least {least}")
        points, rest = divmod(self.samples, RANDOMISATIONS)
        if rest or points & (points - 1):
            raise ValueError(f"samples: got {self.samples}, expected {RANDOMISATIONS} times a power of 2")
