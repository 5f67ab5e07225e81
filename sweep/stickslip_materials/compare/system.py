"""The system that materials are compared in, as people give it: numbers, texts with units, shares of critical damping;
and the belt speeds, one, several, or the ends of a range."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from stickslip.engine import Options
from stickslip.errors import QuantityError
from stickslip.studies.borders import Border
from stickslip.vocabulary.cells import scales_of
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.units import each_with_unit, ends_of, is_number

Amount = float | str
Amounts = Amount | Iterable[Amount]

SYSTEM = ("mass", "stiffness", "damping", "normal_load")


class Speeds(NamedTuple):
    """Belt speeds (m/s) in ascending order, or the two ends of a range."""

    values: tuple[float, ...]
    is_range: bool = False


@dataclass(frozen=True)
class CompareRequest:
    """A comparison to compute.

    system : by the names of `SYSTEM`, in SI. speeds : at which motions are computed; there may be none. between :
    speeds searched, None for a range about the measured ones. level : of confidence. draws : curves drawn per material,
    0 for no intervals.
    """

    system: Mapping[str, float]
    speeds: Speeds
    between: tuple[float, float] | None
    level: float
    draws: int
    seed: int
    search: Border
    options: Options

    @property
    def several_speeds(self) -> bool:
        """True where there are numbers at several belt speeds."""
        return len(self.speeds.values) > 1 and not self.speeds.is_range


def system_of(given: Mapping[str, Amount]) -> dict[str, float]:
    """The system, in SI. given : by the names of `SYSTEM`; damping may be in percent of critical. Raises ValueError."""
    system = {name: quantity(name, given[name]) for name in SYSTEM if name != "damping"}
    share = share_of_critical(given["damping"])
    if share is None:
        return system | {"damping": quantity("damping", given["damping"])}
    if not (is_number(share) and float(share) >= 0.0):
        expected = "expected a share of critical damping such as '3 %', at least 0"
        raise ValueError(f"damping: got {given['damping']!r}, {expected}")
    return system | {"damping": float(share) / 100.0 * float(scales_of(system).critical_damping)}


def speeds_of(belt_speed: Amounts | None, speed_range: tuple[Amount, Amount] | None) -> Speeds:
    """The belt speeds of a request. Raises TypeError or ValueError."""
    if belt_speed is not None and speed_range is not None:
        raise TypeError("got belt_speed and speed_range, expected one of them")
    several = _each(belt_speed)
    ranges = [value for value in several if isinstance(value, str) and ".." in value]
    if belt_speed is not None and not several:
        raise ValueError("belt_speed: got no value")
    if ranges and len(several) > 1:
        raise ValueError(f"belt_speed: got {several!r}, expected several values or one range, not both")
    ends = ends_of("belt_speed", ranges[0]) if ranges else speed_range
    if ends is None:
        speeds = Speeds(tuple(sorted({quantity("belt_speed", value) for value in alike("belt_speed", several)})))
    else:
        speeds = _range("belt_speed" if ranges else "speed_range", ends)
    for speed in speeds.values:
        if not speed > 0:
            raise ValueError(f"belt_speed: got {speed:g}, expected a speed above 0 m/s")
    return speeds


def _range(called: str, ends: tuple[Amount, Amount]) -> Speeds:
    """The range between two ends, the lower one first. Raises TypeError or ValueError."""
    if not isinstance(ends, tuple | list) or len(ends) != 2:
        raise TypeError(f"{called}: got {ends!r}, expected the two ends of a range")
    low, high = (quantity("belt_speed", end) for end in alike(called, ends))
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        raise ValueError(f"{called}: got {ends[0]} to {ends[1]}, expected the lower end first and one above it{hint}")
    return Speeds((low, high), True)


def quantity(name: str, value: Amount, called: str = "") -> float:
    """A quantity in SI, from a number, also as text, or a text with a unit. Raises ValueError."""
    if not isinstance(value, str | int | float | np.number) or (isinstance(value, str) and ".." in value):
        raise ValueError(f"{called or name}: got {value!r}, expected one value")
    try:
        return PARAMETERS[name].read(float(value) if is_number(value) else value)
    except QuantityError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise ValueError(f"{called or name}: got {value!r}, expected {error.expected}{hint}") from None


def is_plain(given: Amounts | None) -> bool:
    """True where a number was given without a unit."""
    texts = (value.lower().replace("e", "") if isinstance(value, str) else "" for value in _each(given))
    return any(not any(character.isalpha() or character == "%" for character in text) for text in texts)


def share_of_critical(damping: object) -> str | None:
    """The number of a damping such as "3 %", as it is written; None where it is not in percent."""
    text = damping.strip().removesuffix("of critical").strip() if isinstance(damping, str) else ""
    return text.removesuffix("%").strip() if text.endswith("%") else None


def _each(given: Amounts | None) -> list[Amount]:
    """The values that were given."""
    if given is None or isinstance(given, str) or np.ndim(given) == 0:  # type: ignore[arg-type]
        return [] if given is None else [given]  # type: ignore[list-item]
    return [*given]  # type: ignore[misc]


def alike(called: str, speeds: Sequence[Amount]) -> Sequence[Amount]:
    """Speeds of which numbers without a unit take that of the others. Raises ValueError."""
    numbers = [float(value) if is_number(value) else value for value in speeds]
    try:
        values: Sequence[Amount] = each_with_unit(numbers, PARAMETERS["belt_speed"].units)
        return values
    except QuantityError as error:
        raise ValueError(f"{called}: got {speeds!r}, expected {error.expected}") from None
