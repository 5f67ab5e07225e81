"""What a configuration amounts to in a workshop's terms, and which of its values no friction contact has.

Natural frequency, static deflection, damping: closed forms of a few quantities over the whole grid, from its smallest
to its largest cell.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.config.model import Config
from stickslip.config.rules import members
from stickslip.vocabulary import units
from stickslip.vocabulary.quantities import QUANTITIES

_FARTHEST = 1.0  # m, static deflection of a spring that holds a sliding contact
_FAR = 0.2  # m, the same in the middle of the grid, where the numbers had no unit ...
_NEAR = 0.01  # m, ... and in its stiffest cell
_FREQUENCIES = 0.1, 50e3  # Hz; a hanging garden gate, an ultrasonic motor
_HEAVY = 1000.0  # kg; from here on it may be a fault of the earth, whose springs are long and slow
# A belt this many times faster than the speed over which friction falls never reaches the drop, whatever the spring.
_FASTER = 30.0
_SLOW = 1.0  # m/s; up to here any ratio may be meant, since curves that fall at once are common
_OVERDAMPED = 10.0  # of critical damping
FRICTION = 1.5  # a friction coefficient; rubber on rough ground and clean metals in vacuum reach more ...
_IMPOSSIBLE = (
    5.0  # ... and from here on it is a share in %, or a force; in a study of ratios nothing below is asked about
)
_ORDER_ONE = 0.2, 5.0  # mass and load of a dimensionless study ...
_FRICTION_OF_RATIOS = 0.8  # ... and its friction coefficient, as in the article; few dry contacts have more
_NEVER = {"belt_speed": 200.0, "velocity": 200.0, "a4": 5.0, "v_reversal": 20.0, "stroke": 10.0}  # SI, even with units
_OTHERS = {"kg": "g", "m": "mm", "m s-1": "mm/s", "N m-1": "N/mm"}  # the unit that was likely meant
_COEFFICIENTS = ("a1", "a3", "mu_start", "mu_reversal", "mu_stop", "mu_static")


class Span(NamedTuple):
    """The smallest and the largest magnitude of something over the grid."""

    least: float
    most: float

    @property
    def middle(self) -> float:
        """The geometric mean, for grids over decades."""
        return math.sqrt(self.least * self.most)

    def text(self, unit: str) -> str:
        """`1 to 500 m/s`."""
        ends = dict.fromkeys((f"{self.least:.3g}", f"{self.most:.3g}"))
        return f"{' to '.join(ends)} {unit}".rstrip()


class Doubt(NamedTuple):
    """A value that is implausible: what was understood, why, and what was likely meant, in words and as a unit."""

    name: str
    value: str
    reason: str
    meant: str | None = None
    unit: str | None = None


def span(config: Config, name: str) -> Span | None:
    """Magnitudes of a quantity, fixed or along an axis; None if it is not given, or uncertain, or a word."""
    fixed = config.fixed().get(name)
    if fixed is not None:
        return None if math.isnan(fixed) else Span(abs(fixed), abs(fixed))
    points = [np.abs(m.points()) for axis in config.axes for m in members(axis) if m.name == name]
    numbers = points[0][~np.isnan(points[0])] if points else np.array([])
    return Span(float(numbers.min()), float(numbers.max())) if numbers.size else None


def natural_frequency(config: Config) -> Span | None:
    """sqrt(k/m)/(2 pi), Hz."""
    stiffness, mass = span(config, "stiffness"), span(config, "mass")
    if stiffness is None or mass is None:
        return None
    return Span(*(math.sqrt(k / m) / (2.0 * math.pi) for k, m in zip(stiffness, reversed(mass), strict=True)))


def static_deflection(config: Config) -> Span | None:
    """mu_start N/k, m: how far the belt drags the mass before it breaks away."""
    load, stiffness = span(config, "normal_load"), span(config, "stiffness")
    start = _start(config)
    if load is None or stiffness is None or start is None:
        return None
    return Span(start.least * load.least / stiffness.most, start.most * load.most / stiffness.least)


def damping_ratio(config: Config) -> Span | None:
    """c/(2 sqrt(k m)), of the damper alone."""
    damping, stiffness, mass = (span(config, name) for name in ("damping", "stiffness", "mass"))
    if damping is None or stiffness is None or mass is None:
        return None
    critical = [2.0 * math.sqrt(k * m) for k, m in zip(stiffness, mass, strict=True)]
    return Span(damping.least / critical[1], damping.most / critical[0])


def doubts(config: Config, bare: Collection[str]) -> Iterator[Doubt]:
    """What is implausible about a configuration; `bare` are the quantities that were given without a unit."""
    yield from _never(config)
    yield from _coefficients(config)
    yield from _fast_belt(config, bare)
    yield from _overdamped(config, bare)
    yield from _slope(config, bare)
    if not _is_normalised(config):
        yield from _long_spring(config, bare)
        yield from _odd_frequency(config, bare)


def _is_normalised(config: Config) -> bool:
    """Whether the study is one of ratios: two of mass, stiffness and load are 1, or all is of order one."""
    fixed = config.fixed()
    if sum(fixed.get(name) == 1.0 for name in ("mass", "stiffness", "normal_load")) >= 2:
        return True
    start, (low, high) = _start(config), _ORDER_ONE
    spans = (span(config, "mass"), span(config, "normal_load"))
    of_order_one = all(found is not None and low <= found.least <= high for found in spans)
    return of_order_one and start is not None and start.most >= _FRICTION_OF_RATIOS


def _never(config: Config) -> Iterator[Doubt]:
    """Single values that no contact has, whatever unit was written."""
    for name, limit in _NEVER.items():
        found = span(config, name)
        if found is not None and found.most > limit:
            declared, upto = QUANTITIES[name].units, "up to " if found.least < found.most else ""
            value = f"{upto}{found.most:.3g} {units.spelled(declared)}"
            yield Doubt(name, value, "", f"{found.most:.3g} {_OTHERS[declared]}")


def _coefficients(config: Config) -> Iterator[Doubt]:
    limit = _IMPOSSIBLE if _is_normalised(config) else FRICTION
    spans = {name: found for name in _COEFFICIENTS if (found := span(config, name)) is not None and found.most > limit}
    for name, found in spans.items():
        share = Span(found.least / 100.0, found.most / 100.0)
        meant = f"{share.text('')}, which is a share in %" if found.most > _IMPOSSIBLE else None
        yield Doubt(name, found.text(""), ", a friction coefficient", meant)
    start = _start(config)
    if not spans and start is not None and start.most > limit:
        yield Doubt("a3", f"mu_start = a1 + a3 = {start.text('')}", ", a friction coefficient")


def odd_friction(cells: Mapping[str, NDArray[np.float64]]) -> float | None:
    """The largest friction coefficient at break-away among cells, if no contact has it; None if all are plausible.

    Cells of ratios, of which two of mass, stiffness and load are 1, are not questioned.
    """
    start = np.fmax(cells["a1"] + cells["a3"], cells["mu_static"])
    if not (start > FRICTION).any():
        return None
    ones = sum((cells[name] == 1.0).astype(np.int8) for name in ("mass", "stiffness", "normal_load"))
    odd = start[(start > FRICTION) & (ones < 2)]
    return float(odd.max()) if odd.size else None


def question_about_points(mu_start: float, measured: ArrayLike | None) -> str | None:
    """What to ask about a fitted curve whose friction is implausible, at its points or at break-away; None if it is
    not."""
    most = 0.0 if measured is None else float(np.max(measured))
    if most > FRICTION:
        return question_about_friction(most, "measured friction")
    follows = " It follows from the fit, not from a point."
    return f"{question_about_friction(mu_start)}{follows}" if mu_start > FRICTION else None


def question_about_friction(coefficient: float, what: str = "mu_start") -> str:
    """What to ask about a friction coefficient that is implausible."""
    share = (
        f"is that {coefficient / 100:.3g}, which is a share in %?" if coefficient > _IMPOSSIBLE else "is that meant?"
    )
    return f"{what} = {coefficient:.3g} is more than the friction coefficient of most contacts ({FRICTION:g}); {share}"


def _fast_belt(config: Config, bare: Collection[str]) -> Iterator[Doubt]:
    belt, fall = span(config, "belt_speed"), span(config, "a4")
    if belt is None or fall is None or "belt_speed" not in bare:
        return
    if belt.least > max(_SLOW, _FASTER * fall.most):
        more = " and more" if belt.most > belt.least else ""
        yield _doubt(config, "belt_speed", f", {belt.least / fall.most:.0f} times a4{more}")


def _overdamped(config: Config, bare: Collection[str]) -> Iterator[Doubt]:
    ratio = damping_ratio(config)
    if ratio is not None and ratio.least > _OVERDAMPED and "damping" in bare:
        yield _doubt(config, "damping", f", {ratio.least:.3g} times critical damping, under which nothing oscillates")


def _slope(config: Config, bare: Collection[str]) -> Iterator[Doubt]:
    slope, belt = span(config, "a2"), span(config, "belt_speed")
    if slope is not None and belt is not None and "a2" in bare and (adds := slope.least * belt.least) > _IMPOSSIBLE:
        yield _doubt(config, "a2", f", which adds {adds:.3g} to the friction coefficient at the speed of the belt")


def _long_spring(config: Config, bare: Collection[str]) -> Iterator[Doubt]:
    deflection, mass = static_deflection(config), span(config, "mass")
    if deflection is None or mass is None or mass.least > _HEAVY:
        return
    may_lack = bool({"stiffness", "normal_load"} & set(bare))
    if deflection.least > _FARTHEST or (may_lack and deflection.middle > _FAR and deflection.least > _NEAR):
        load = span(config, "normal_load")
        assert load is not None
        reason = f": under {load.text('N')} the belt drags the mass {deflection.text('m')} far before it breaks away"
        yield _doubt(config, "stiffness", reason)


def _odd_frequency(config: Config, bare: Collection[str]) -> Iterator[Doubt]:
    """A natural frequency that no machine has; of mass and stiffness the one without unit is asked about."""
    frequency, mass = natural_frequency(config), span(config, "mass")
    if frequency is None or mass is None or mass.least > _HEAVY:
        return
    lowest, highest = _FREQUENCIES
    name = "mass" if "mass" in bare and "stiffness" not in bare else "stiffness"
    reason = f": the natural frequency is {frequency.text('Hz')}"
    if frequency.most < lowest:
        heavy = mass.least >= 10.0 and "mass" in bare
        yield _doubt(config, "mass" if heavy else name, reason)
    elif frequency.least > highest:
        yield _doubt(config, name, reason)._replace(meant=None, unit=None)


def _doubt(config: Config, name: str, reason: str) -> Doubt:
    """The doubt about a quantity, with the unit that was likely meant."""
    found, declared = span(config, name), QUANTITIES[name].units
    assert found is not None
    unit = _OTHERS.get(declared)
    return Doubt(name, found.text(units.spelled(declared)), reason, None if unit is None else found.text(unit), unit)


def _start(config: Config) -> Span | None:
    """mu_start, by either form of the curve."""
    return span(config, "mu_start") or _sum(span(config, "a1"), span(config, "a3"))


def _sum(one: Span | None, other: Span | None) -> Span | None:
    return None if one is None or other is None else Span(one.least + other.least, one.most + other.most)
