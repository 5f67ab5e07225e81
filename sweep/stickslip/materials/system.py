"""The system that materials are compared in, as people give it: numbers, texts with units, shares of critical damping,
several values of one quantity, ranges."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from stickslip.engine import Options
from stickslip.errors import QuantityError
from stickslip.studies.borders import Border
from stickslip.vocabulary.cell_values import scales_of
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.units import ends_of, is_number

Amount = float | str
Amounts = Amount | Iterable[Amount]

_STEPS = 5  # values that a range of the system is looked at
_SCALE = "friction_scale"
VARIED = ("damping", "normal_load", _SCALE)  # quantities of which several values may be given
_ROWS = {**PARAMETERS, _SCALE: Parameter(_SCALE, "1", "scale of friction", "", above=0)}


class Values(NamedTuple):
    """The values of a quantity, in SI: one, several, or the two ends of a range."""

    values: tuple[float, ...]
    is_range: bool = False

    @property
    def steps(self) -> tuple[float, ...]:
        """The values, those of a range by equal ratios (from 0 on by equal differences)."""
        if not self.is_range:
            return self.values
        low, high = self.values
        return tuple(map(float, (np.geomspace if low > 0 else np.linspace)(low, high, _STEPS)))


@dataclass(frozen=True)
class Request:
    """A comparison to compute.

    system : in which materials are ranked, by names of PARAMETERS, in SI, with `friction_scale`, by which friction is
    multiplied. over : the values of those quantities that vary, ascending.
    speeds : m/s; none, one, several, or the ends of a range. between : speeds searched, None for a range about the
    measured ones. level : of confidence. draws : curves drawn per material, 0 for no intervals.
    """

    system: Mapping[str, float]
    over: Mapping[str, tuple[float, ...]]
    speeds: Values
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

    @property
    def load(self) -> float:
        """The load times the scale of friction, N."""
        return self.system["normal_load"] * self.system[_SCALE]


def system_of(given: Mapping[str, Amounts]) -> tuple[dict[str, float], dict[str, tuple[float, ...]]]:
    """The system in which materials are ranked, and the values of those of its quantities that vary.

    given : mass, stiffness, damping, normal_load and friction_scale. Damping may be in percent of critical ("3 %"). Of
    several values the least damping counts for the ranks, the largest load and the largest scale of friction: there
    vibration goes on to the highest speeds. Raises ValueError.
    """
    system: dict[str, float] = {}
    for name in ("mass", "stiffness"):
        value = given[name]
        if not isinstance(value, str | int | float | np.number) or (isinstance(value, str) and ".." in value):
            raise ValueError(f"{name}: got {value!r}, expected one value")
        system[name] = quantity(name, value)
    critical = float(scales_of(system).critical_damping)
    steps = {name: values_of(name, given[name], critical).steps for name in VARIED}
    over = {name: values for name, values in steps.items() if len(values) > 1}
    return system | {name: (min if name == "damping" else max)(values) for name, values in steps.items()}, over


def critical_damping(ds: xr.Dataset) -> float:
    """2 sqrt(k m) of the system of a comparison, N s/m."""
    return float(scales_of({name: ds.attrs[f"system_{name}"] for name in ("mass", "stiffness")}).critical_damping)


def values_of(name: str, given: Amounts, critical: float = math.nan) -> Values:
    """The values of a quantity as people give it: one, several in ascending order, or a text that is a range.

    critical : damping (N s/m), of which a damping may be a share. Raises TypeError or ValueError.
    """
    several = _each(given)
    ranges = [value for value in several if isinstance(value, str) and ".." in value]
    if not several:
        raise ValueError(f"{name}: got no value")
    if ranges and len(several) > 1:
        raise ValueError(f"{name}: got {several!r}, expected several values or one range, not both")
    if ranges:
        return _range(name, ends_of(name, ranges[0]), name, critical)
    return Values(tuple(sorted({_read(name, value, critical) for value in several})))


def speeds_of(belt_speed: Amounts | None, speed_range: tuple[Amount, Amount] | None) -> Values:
    """The belt speeds of a request. Raises TypeError or ValueError."""
    if belt_speed is not None and speed_range is not None:
        raise TypeError("got belt_speed and speed_range, expected one of them")
    if speed_range is not None:
        speeds = _range("speed_range", speed_range, "belt_speed")
    else:
        speeds = Values(()) if belt_speed is None else values_of("belt_speed", belt_speed)
    for speed in speeds.values:
        if not speed > 0:
            raise ValueError(f"belt_speed: got {speed:g}, expected a speed above 0 m/s")
    return speeds


def _range(called: str, ends: tuple[Amount, Amount], name: str, critical: float = math.nan) -> Values:
    """The range between two ends, the lower one first. Raises TypeError or ValueError."""
    if not isinstance(ends, tuple | list) or len(ends) != 2:
        raise TypeError(f"{called}: got {ends!r}, expected the two ends of a range")
    low, high = (_read(name, end, critical) for end in ends)
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        raise ValueError(f"{called}: got {ends[0]} to {ends[1]}, expected the lower end first and one above it{hint}")
    return Values((low, high), True)


def quantity(name: str, value: Amount, called: str = "") -> float:
    """A quantity in SI, from a number, also as text, or a text with a unit. Raises ValueError."""
    try:
        return _ROWS[name].read(float(value) if is_number(value) else value)
    except QuantityError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise ValueError(f"{called or name}: got {value!r}, expected {error.expected}{hint}") from None


def is_plain(given: Amounts | None) -> bool:
    """True where a number was given without a unit."""
    texts = (value.lower().replace("e", "") if isinstance(value, str) else "" for value in _each(given))
    return any(not any(character.isalpha() or character == "%" for character in text) for text in texts)


def in_percent(damping: Amounts | None) -> bool:
    """True where a damping was given in percent of critical damping."""
    return any(_share(value) is not None for value in _each(damping))


def _each(given: Amounts | None) -> list[Amount]:
    """The values that were given."""
    if given is None or isinstance(given, str) or np.ndim(given) == 0:  # type: ignore[arg-type]
        return [] if given is None else [given]  # type: ignore[list-item]
    return [*given]  # type: ignore[misc]


def _read(name: str, value: Amount, critical: float) -> float:
    """A quantity in SI; damping may be a share of critical damping ("3 %"). Raises ValueError."""
    share = _share(value) if name == "damping" else None
    if share is None:
        return quantity(name, value)
    if not (is_number(share) and float(share) >= 0.0):
        raise ValueError(f"damping: got {value!r}, expected a share of critical damping such as '3 %', at least 0")
    return float(share) / 100.0 * critical


def _share(value: object) -> str | None:
    """The number of "3 %", as it is written; None where nothing is in percent."""
    text = value.strip().removesuffix("of critical").strip() if isinstance(value, str) else ""
    return text.removesuffix("%").strip() if text.endswith("%") else None
