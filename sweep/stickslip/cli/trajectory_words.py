"""What `simulate` says of a cell: its regime, tone, force, share of sticking and amplitudes; and how long to look."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, floor, isfinite, log10, pi, sqrt
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import customary
from stickslip.vocabulary.flags import REGIME_MESSAGES, REGIMES, STATUS_MESSAGES, STATUSES, flag_label
from stickslip.vocabulary.results import VARIABLES

if TYPE_CHECKING:
    import xarray as xr

CYCLES = 8.0  # shown after the first break-away
_SETTLED = 1.1  # settling times shown
_SLOW = 30.0  # natural periods, for what neither sticks nor settles
_PER_PERIOD = 60  # samples a natural period
_MOST_SAMPLES = 40_001
_LONGEST = 1e3  # natural periods, of what does not stick
_WIDTH = 90  # characters of a title
_SHOWN = (  # row, variable and what it is, in this order, where it is finite
    ("frequency", "frequency"), ("period", "period"), ("stick_fraction", "sticking"),
    ("displacement_amplitude", "amplitude"), ("velocity_amplitude", "velocity amplitude"),
    ("spring_force_max", "peak spring force"), ("spring_force_min", "least spring force"),
    ("acceleration_max", "peak acceleration"), ("slip_speed_max", "peak slip speed"),
    ("breakaway_time", "first break-away"), ("settling_time", "settling time"), ("settled_displacement", "settles at"),
    ("damping_ratio", "damping ratio"),
)  # fmt: skip
_OF_CYCLES = ("displacement_amplitude", "velocity_amplitude")  # 0 elsewhere, which says nothing
_FORCES = ("spring_force_max", "spring_force_min")
_ROUNDING = 1e-9  # of the largest force; less is none


@dataclass(frozen=True)
class Look:
    """How long a trajectory is looked at (s), with how many samples, and why, in words."""

    duration: float
    samples: int
    why: str


def look_at(found: xr.Dataset) -> Look:
    """The duration that shows what becomes of a cell.

    found : what `evaluate` says of it: eight cycles after the first break-away; a decay until it has settled.
    """
    values = {name: float(found[name].values[0]) for name in ("breakaway_time", "period", "settling_time")}
    regime, natural = REGIMES[int(found["regime"].values[0])], _natural_period(found)
    began = values["breakaway_time"] if isfinite(values["breakaway_time"]) else 0.0
    after, why = _SLOW * natural, f"{_SLOW:g} natural periods"
    if regime == "stick_slip":
        after, why = CYCLES * values["period"], f"{CYCLES:g} cycles"
    elif regime == "sustained":
        after, why = max(_SLOW * natural, CYCLES * values["period"]), f"{_SLOW:g} natural periods"
    elif regime in ("damped", "creep") and isfinite(values["settling_time"]):
        after, why = max(_SETTLED * values["settling_time"], natural), "until it has settled"
    if regime != "stick_slip" and after > _LONGEST * natural:
        after, why = _LONGEST * natural, f"{_LONGEST:g} natural periods, no more"
    duration = _rounded_up(began + after)
    return Look(duration, samples_for(duration, natural), why)


def look_for(found: xr.Dataset, duration: float) -> Look:
    """The same for a duration that was asked for."""
    return Look(duration, samples_for(duration, _natural_period(found)), "")


def samples_for(duration: float, natural: float) -> int:
    """Points in time that show vibrations of the natural period (s): 2001, or more."""
    return min(max(2001, ceil(_PER_PERIOD * duration / natural) + 1), _MOST_SAMPLES)


def rows(found: xr.Dataset) -> list[tuple[str, str]]:
    """What there is to say of a cell, as rows of a table: what, and how much."""
    regime, status = REGIMES[int(found["regime"].values[0])], STATUSES[int(found["status"].values[0])]
    told = [("regime", f"{flag_label(regime)}: {REGIME_MESSAGES[regime]}"), ("", STATUS_MESSAGES[status])]
    values = {name: float(found[name].values[0]) for name, _ in _SHOWN}
    largest = max(abs(values[name]) for name in _FORCES)
    values |= {name: 0.0 for name in _FORCES if abs(values[name]) < _ROUNDING * largest}
    hidden = set() if regime in ("stick_slip", "sustained") else set(_OF_CYCLES)
    hidden |= set() if regime == "stick_slip" else {"stick_fraction"}
    if regime == "damped" and abs(values["damping_ratio"]) < 1.0:
        decay = sqrt(1.0 - values["damping_ratio"] ** 2) / _natural_period(found)
        told.append(("vibrates at", f"{quantity('frequency', decay)} while it decays, by linear theory"))
    for name, what in _SHOWN:
        if isfinite(values[name]) and name not in hidden:
            told.append((what, _text(name, values[name])))
    return told


def _text(name: str, value: float) -> str:
    return f"{value:.1%} of the period" if name == "stick_fraction" else quantity(name, value)


def _natural_period(found: xr.Dataset) -> float:
    """Of the mass on its spring, s."""
    return 2.0 * pi * sqrt(float(found["mass"].values[0]) / float(found["stiffness"].values[0]))


def answer(found: xr.Dataset) -> dict[str, Any]:
    """The same for programs: every variable of the cell, in SI, flags by their names."""
    values = {name: found[name].values[0].item() for name in VARIABLES if name in found}
    values["regime"], values["status"] = REGIMES[values["regime"]], STATUSES[values["status"]]
    return values


def quantity(name: str, value: float) -> str:
    """A variable of a cell in a customary unit: ``81.2 ms``."""
    unit = VARIABLES[name].units
    if unit == "s-1":
        return f"{value / 1e3:.4g} kHz" if value >= 1e3 else f"{value:.4g} Hz"
    return customary(unit, value) or f"{value:.4g} {units.spelled(unit)}".rstrip()


def titled(title: str, at: Iterable[str]) -> str:
    """The title of a picture of one cell: that of the configuration, and below it what was set."""
    from stickslip.dataset.axis import spoken

    pairs = (text.partition("=") for text in at)
    named = [f"{spoken(name.strip())} = {value.strip()}" for name, _, value in pairs]
    return "\n".join([*wrap(title, _WIDTH), *wrap(", ".join(named), _WIDTH)])


def time(seconds: float) -> str:
    """A time in a customary unit."""
    return customary("s", seconds) or f"{seconds:.4g} s"


def _rounded_up(seconds: float) -> float:
    """A duration with two digits, no shorter."""
    scale = 10.0 ** (floor(log10(seconds)) - 1)
    return float(f"{ceil(seconds / scale * (1.0 - 1e-12)) * scale:.12g}")
