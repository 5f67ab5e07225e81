"""The system that materials are compared in, as people give it: numbers, texts with units, shares of critical damping,
several values of one quantity, ranges."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import xarray as xr

from stickslip.engine import Options
from stickslip.errors import QuantityError
from stickslip.studies.borders import Border
from stickslip.vocabulary.quantities import PARAMETERS

Amount = float | str
Amounts = Amount | Iterable[Amount]

_STEPS = 5  # values that a range of the system is looked at
_SCALE = "friction_scale"
VARIED = ("damping", "normal_load", _SCALE)  # quantities of which several values may be given


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
    system = {}
    for name in ("mass", "stiffness"):
        value = given[name]
        if not isinstance(value, str | int | float | np.number) or (isinstance(value, str) and ".." in value):
            raise ValueError(f"{name}: got {value!r}, expected one value")
        system[name] = quantity(name, value)
    critical = 2.0 * math.sqrt(system["stiffness"] * system["mass"])
    steps = {
        "damping": values_of("damping", given["damping"], lambda value: _damping(value, critical)).steps,
        "normal_load": values_of("normal_load", given["normal_load"]).steps,
        _SCALE: values_of(_SCALE, given[_SCALE], _scale).steps,
    }
    over = {name: values for name, values in steps.items() if len(values) > 1}
    return system | {name: (min if name == "damping" else max)(values) for name, values in steps.items()}, over


def critical_damping(ds: xr.Dataset) -> float:
    """2 sqrt(k m) of the system of a comparison, N s/m."""
    return 2.0 * math.sqrt(float(ds.attrs["system_stiffness"]) * float(ds.attrs["system_mass"]))


def values_of(name: str, given: Amounts, read: Callable[[Amount], float] | None = None) -> Values:
    """The values of a quantity as people give it: one, several in ascending order, or a text that is a range.

    Raises TypeError or ValueError.
    """
    reader = read or (lambda value: quantity(name, value))
    if not isinstance(given, str) and np.ndim(given) > 0:  # type: ignore[arg-type]
        several = list(given)  # type: ignore[arg-type]
        if any(isinstance(value, str) and ".." in value for value in several) and len(several) > 1:
            raise ValueError(f"{name}: got {several!r}, expected several values or one range, not both")
        if not several:
            raise ValueError(f"{name}: got no value")
        if len(several) > 1:
            return Values(tuple(sorted({reader(value) for value in several})))
        given = several[0]
    if isinstance(given, str) and ".." in given:
        return _range(name, ends_of(name, given), reader)
    return Values((reader(given),))  # type: ignore[arg-type]


def speeds_of(belt_speed: Amounts | None, speed_range: tuple[Amount, Amount] | None) -> Values:
    """The belt speeds of a request. Raises TypeError or ValueError."""
    if belt_speed is not None and speed_range is not None:
        raise TypeError("got belt_speed and speed_range, expected one of them")
    if speed_range is not None:
        speeds = _range("speed_range", speed_range, lambda value: quantity("belt_speed", value))
    else:
        speeds = Values(()) if belt_speed is None else values_of("belt_speed", belt_speed)
    for speed in speeds.values:
        if not speed > 0:
            raise ValueError(f"belt_speed: got {speed:g}, expected a speed above 0 m/s")
    return speeds


def _range(name: str, ends: tuple[Amount, Amount], read: Callable[[Amount], float]) -> Values:
    """The range between two ends, the lower one first. Raises TypeError or ValueError."""
    if not isinstance(ends, tuple | list) or len(ends) != 2:
        raise TypeError(f"{name}: got {ends!r}, expected the two ends of a range")
    low, high = map(read, ends)
    if not low < high:
        hint = "; swap the ends" if low > high else ""
        raise ValueError(f"{name}: got {ends[0]} to {ends[1]}, expected the lower end first and one above it{hint}")
    return Values((low, high), True)


def ends_of(name: str, text: str) -> tuple[Amount, Amount]:
    """The ends of "5..60 mm/s", where the lower one has the unit of the upper one. Raises ValueError."""
    parts = [part.strip() for part in text.split("..")]
    if len(parts) != 2 or not all(parts) or parts[1].startswith(".") or parts[0].endswith("."):
        raise ValueError(f"{name}: got {text!r}, expected a range such as '5..60 mm/s', with two dots between its ends")
    low, high = parts
    unit = high.lstrip("+-.0123456789eE ")
    if _is_number(low) and unit:
        return f"{low} {unit}", high
    if _is_number(high) and not _is_number(low):
        raise ValueError(f"{name}: got {text!r}, whose upper end has no unit; write it as well")
    return float(low) if _is_number(low) else low, float(high) if _is_number(high) else high


def quantity(name: str, value: Amount, called: str = "") -> float:
    """A quantity in SI, from a number, also as text, or a text with a unit. Raises ValueError."""
    try:
        return PARAMETERS[name].read(float(value) if _is_number(value) else value)
    except QuantityError as error:
        hint = f"; {error.hint}" if error.hint else ""
        raise ValueError(f"{called or name}: got {value!r}, expected {error.expected}{hint}") from None


def is_plain(value: object) -> bool:
    """True where numbers were given without a unit."""
    if isinstance(value, str):
        return not any(character.isalpha() or character == "%" for character in value.lower().replace("e", ""))
    if value is None or isinstance(value, int | float | np.number):
        return value is not None
    return any(map(is_plain, value))  # type: ignore[call-overload]


def in_percent(damping: Amounts | None) -> bool:
    """True where a damping was given in percent of critical damping."""
    given = [damping] if damping is None or isinstance(damping, str | int | float | np.number) else list(damping)
    return any(_share(value) is not None for value in given)


def _damping(value: Amount, critical: float) -> float:
    """A damping in N s/m, which may be given as a share of critical damping ("3 %"). Raises ValueError."""
    share = _share(value)
    if share is None:
        return quantity("damping", value)
    if not (_is_number(share) and 0.0 <= float(share) < math.inf):
        raise ValueError(f"damping: got {value!r}, expected a share of critical damping such as '3 %', at least 0")
    return float(share) / 100.0 * critical


def _share(value: object) -> str | None:
    """The number of "3 %", as it is written; None where nothing is in percent."""
    text = value.strip().removesuffix("of critical").strip() if isinstance(value, str) else ""
    return text.removesuffix("%").strip() if text.endswith("%") else None


def _scale(value: Amount) -> float:
    if not (_is_number(value) and 0.0 < float(value) < math.inf):
        raise ValueError(f"{_SCALE}: got {value!r}, expected a number above 0, without unit")
    return float(value)


def _is_number(value: Amount) -> bool:
    try:
        return not isinstance(value, bool) and math.isfinite(float(value))
    except ValueError:
        return False
