"""Margins in words: changes that lead to another regime, and the cheapest of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, isfinite, isnan, log

import numpy as np
import xarray as xr

from stickslip.dataset.display import Unit, unit_of
from stickslip.dataset.studies import SIDES
from stickslip.distances import without_measured
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.quantities import MEASURED, SEARCHABLE

_AS_PERCENT = 0.8  # changes up to this share of the value are told in percent, larger ones as a factor
_SMALL = 0.01  # of the square of the cost: what changes by less is left out of a joint proposal, if it holds without
_DIGITS = 4


@dataclass(frozen=True)
class Change:
    """A border along one parameter: on which side, where, what lies past it, and what was simulated there."""

    name: str
    side: str
    value: float
    border: float
    width: float
    beyond: str
    checked: str
    holds: bool
    unit: Unit

    def size(self) -> float:
        """The logarithm of the factor; infinite where there is none."""
        ratio = self.border / self.value if self.value else 0.0
        return abs(log(ratio)) if ratio > 0 else inf

    def words(self) -> str:
        """`belt speed above 0.83 m/s (+66 %)`; parameters without unit by name."""
        told = f"{_plain(self.name)} {self.side} {self.unit.text(self.border, _DIGITS)}"
        return f"{told} ({by(self.value, self.border, self.unit)})"

    def row(self) -> tuple[str, ...]:
        """The change as a row of a table."""
        border = f"{self.side} {self.unit.text(self.border, 9)}"
        if self.width > 1e-6 * abs(self.border):
            border += f" (undecided over {self.unit.of(self.width):.2g})"
        past = self.checked if self.holds else f"{self.checked}: does not hold"
        return self.name, border, by(self.value, self.border, self.unit), self.beyond, past


@dataclass(frozen=True)
class Joint:
    """The cheapest joint change as it is shown, rounded: parameters with old and new values, and its simulation.

    values : in SI. units : in which they are shown.
    """

    values: dict[str, tuple[float, float]]
    units: dict[str, Unit]
    cost: float
    checked: str
    holds: bool

    def words(self) -> str:
        """`belt_speed 0.6 m/s (+20 %) and damping 0.1 N s/m`."""
        told = []
        for name, (old, new) in self.values.items():
            unit = self.units[name]
            told.append(f"{_plain(name)} {unit.text(new, _DIGITS)} ({by(old, new, unit)})")
        return " and ".join(filter(None, [", ".join(told[:-1]), *told[-1:]]))

    def told(self, which: str = "cheapest") -> str:
        """The line under the table. which : of all, or of those looked at."""
        past = f"{self.checked}" if self.holds else f"{self.checked}: does not hold, and is no cure"
        return f"{which} {self.words()}, simulated: {past}; cost {self.cost:.3g}"


def by(value: float, border: float, unit: Unit) -> str:
    """A change: in percent, as a factor, or, from 0, as the amount."""
    if value == 0 or border / value <= 0:
        return f"{unit.of(border - value):+.{_DIGITS}g} {unit.name}".rstrip()
    ratio = border / value
    return f"{100 * (ratio - 1):+.3g} %" if abs(ratio - 1) <= _AS_PERCENT else f"x {ratio:.3g}"


def single_changes(ds: xr.Dataset, wanted: Sequence[str]) -> list[Change]:
    """Every border along a single parameter, by how large the change is; those of parameters at 0 last."""
    one = ds if "cell" not in ds.dims else ds.isel(cell=0)
    found = []
    for name in _parameters(ds):
        value = _value(one, name)
        for side in SIDES:
            here = one.sel(side=side)
            border = float(here[f"border_{name}"])
            if not isnan(border):
                beyond, checked = (REGIMES[int(here[f"{kind}_{name}"])] for kind in ("beyond", "checked"))
                width = float(here[f"border_width_{name}"])
                unit = unit_of(one[name])
                found.append(Change(name, side, value, border, width, beyond, checked, checked in wanted, unit))
    return sorted(found, key=Change.size)


def without_border(ds: xr.Dataset) -> list[str]:
    """Parameters along which no border was found."""
    return [name for name in _parameters(ds) if isnan(float(ds[f"margin_{name}"].values.ravel()[0]))]


def absent(ds: xr.Dataset) -> dict[str, str]:
    """Why parameters without a border cannot change in this cell at all."""
    one, found = ds if "cell" not in ds.dims else ds.isel(cell=0), {}
    for name in without_border(ds):
        if name == "mu_stop" and isnan(float(one[name])):
            found[name] = "is not given, so that friction stops as it starts; give the pair a mu_stop"
        elif name in MEASURED and not isfinite(float(one[name])):
            found[name] = "is no property of this curve, which has no minimum"
    return found


def joint_change(ds: xr.Dataset, regime: Callable[[dict[str, float]], int], wanted: Sequence[str]) -> Joint | None:
    """The cheapest joint change, rounded, without what changes next to nothing; simulated as it is shown."""
    if "joint_cost" not in ds or isnan(float(ds["joint_cost"].values.ravel()[0])):
        return None
    one = ds if "cell" not in ds.dims else ds.isel(cell=0)
    cell = {name: float(one[name]) for name in SEARCHABLE if name in one.coords}
    for least in (_SMALL, 0.0):
        values = {}
        for name in _parameters(ds):
            if float(one[f"joint_share_{name}"]) > least:
                values[name] = _value(one, name), float(f"{float(one[f'joint_proposed_{name}']):.{_DIGITS}g}")
        changed = {name: np.array(value) for name, value in cell.items()} | {
            n: np.array(v[1]) for n, v in values.items()
        }
        there = {name: float(value) for name, value in without_measured(changed).items()}
        checked = "failed" if isnan(there["a1"]) else REGIMES[regime(there)]  # NaN: rounded to what no curve has
        if checked in wanted:
            break
    return Joint(
        values, {name: unit_of(one[name]) for name in values}, float(one["joint_cost"]), checked, checked in wanted
    )


def least_cost(changes: Sequence[Change], joint: Joint | None) -> float:
    """The cost of the cheapest change that holds; infinite where none does."""
    costs = [change.size() for change in changes if change.holds]
    return min([*costs, *([joint.cost] if joint is not None and joint.holds else [])], default=inf)


def sentence(
    home: str, wanted: Sequence[str], changes: Sequence[Change], joint: Joint | None, which: str = "cheapest"
) -> str:
    """`in stick_slip; leaves it above 0.83 m/s (+66 %), ...; cheapest: ...`. What does not hold is no cure."""
    cures = [change.words() for change in changes if change.holds]
    verb = "leaves it" if home in ("stick_slip", "sustained") else f"enters {' or '.join(wanted)}"
    told = f"in {home}; {verb} with {', '.join(cures)}" if cures else f"in {home}; no single change within reach {verb}"
    if joint is not None and joint.holds:
        told += f"; {which}: {joint.words()}"
    return told


def _plain(name: str) -> str:
    """The name of a parameter in a sentence: `belt speed`, but `mu_stop`."""
    return name if name.startswith(("mu_", "v_", "a")) else name.replace("_", " ")


def _parameters(ds: xr.Dataset) -> list[str]:
    return [name for name in SEARCHABLE if f"margin_{name}" in ds]


def _value(one: xr.Dataset, name: str) -> float:
    """The value of a parameter; static friction that is not given is that at break-away."""
    value = float(one[name])
    return float(one["a1"]) + float(one["a3"]) if isnan(value) and name == "mu_static" else value
