"""The margins of one cell in words: which changes take it over a border, by themselves and together."""

from collections.abc import Iterator, Sequence
from math import inf, isfinite, isnan, log
from typing import NamedTuple

import xarray as xr

from stickslip.config.studies import Table
from stickslip.dataset.display import unit_of
from stickslip.studies.margins.section import SIDES, entered
from stickslip.studies.report import attributes
from stickslip.vocabulary.display_units import Unit, spoken
from stickslip.vocabulary.flags import REGIMES, VIBRATING
from stickslip.vocabulary.models import model_with
from stickslip.vocabulary.quantities import MEASURED, SEARCHABLE
from stickslip.vocabulary.suggest import listed

_AS_PERCENT = 0.8  # changes up to this share of the value are told in percent, larger ones as a factor
_SMALL = 0.01  # of the square of the cost: what changes by less is named last
_DIGITS = 4


class _Change(NamedTuple):
    """A border along one parameter: the value of the cell, the border, and the row of the table."""

    name: str
    side: str
    value: float
    border: float
    width: float
    unit: Unit
    beyond: str
    checked: str

    def size(self) -> float:
        """The logarithm of the factor; infinite where there is none."""
        ratio = self.border / self.value if self.value else 0.0
        return abs(log(ratio)) if ratio > 0 else inf

    def words(self) -> str:
        """`belt speed above 0.83 m/s (+66 %)`."""
        text = f"{spoken(self.name)} {self.side} {self.unit.text(self.border, _DIGITS)}"
        return f"{text} ({_by(self.value, self.border, self.unit)})"

    def row(self, goals: Sequence[str]) -> tuple[str, ...]:
        """The change as a row of a table."""
        border = f"{self.side} {self.unit.text(self.border, 9)}"
        if self.width > 1e-6 * abs(self.border):
            border += f" (undecided over {self.unit.of(self.width):.2g})"
        past = self.checked if self.checked in goals else f"{self.checked}: does not hold"
        return self.name, border, _by(self.value, self.border, self.unit), self.beyond, past


def advice(ds: xr.Dataset) -> Iterator[str | Table]:
    """Changes that take the cell of a result over a border; what does not hold where it was simulated is no cure."""
    cell = ds.squeeze()
    home = REGIMES[int(cell["regime"])]
    goals = entered(None if " " in (into := str(ds.attrs["margin_into"])) else into.split(","), home)
    changes = sorted(_changes(cell), key=_Change.size)
    cures = [change.words() for change in changes if change.checked in goals]
    verb = "leaves it" if home in VIBRATING else f"enters {listed(goals)}"
    if "margin_speeds" in ds.attrs:
        yield f"range    {ds.attrs['margin_speeds']} counts"
    yield f"in {home}; {verb} with {', '.join(cures)}" if cures else f"in {home}; no single change within reach {verb}"
    if changes:
        heads = ("change", "border", "by", "into", "past it")
        yield Table("", heads, (), [change.row(goals) for change in changes])
    yield from _without(cell)
    if "joint_cost" in cell and isfinite(cost := float(cell["joint_cost"])):
        checked = REGIMES[int(cell["joint_checked"])]
        end = checked if checked in goals else f"{checked}: does not hold, and is no cure"
        yield f"cheapest {_joint(cell)}, simulated: {end}; cost {cost:.3g}"
    yield from attributes(ds, **({"ended": "joint_ended"} if "joint_ended" in ds.attrs else {}))
    yield from attributes(ds, looked="margin_within", scan="margin_scan", check="margin_check")


def _changes(cell: xr.Dataset) -> Iterator[_Change]:
    for name in _parameters(cell):
        for side in SIDES:
            place = cell.sel(side=side)
            border, width = (float(place[f"{kind}_{name}"]) for kind in ("border", "border_width"))
            if not isnan(border):
                beyond, checked = (REGIMES[int(place[f"{kind}_{name}"])] for kind in ("beyond", "checked"))
                yield _Change(name, side, _value(cell, name), border, width, unit_of(cell[name]), beyond, checked)


def _joint(cell: xr.Dataset) -> str:
    """The cheapest joint change as it was simulated, by what each parameter costs; those that hardly count by value."""
    shares = {name: float(cell[f"joint_share_{name}"]) for name in _parameters(cell)}
    large, small = list[str](), list[str]()
    for name in sorted(shares, key=shares.__getitem__, reverse=True):
        unit, old, new = unit_of(cell[name]), _value(cell, name), float(cell[f"joint_proposed_{name}"])
        text = f"{spoken(name)} {unit.text(new, _DIGITS)}"
        if shares[name] > _SMALL:
            large.append(f"{text} ({_by(old, new, unit)})")
        elif unit.text(new, _DIGITS) != unit.text(old, _DIGITS):
            small.append(text)
    return listed(large, "and") + (f", beside {listed(small, 'and')}" if small else "")


def _without(cell: xr.Dataset) -> Iterator[str]:
    """Lines on the parameters along which there is no border."""
    missing = [name for name in _parameters(cell) if isnan(float(cell[f"margin_{name}"]))]
    for name in missing:
        if name == "mu_stop" and isnan(float(cell[name])):
            yield "mu_stop is not given, so that friction stops as it starts; give the pair a mu_stop"
        elif name in MEASURED and not isfinite(float(cell[name])):
            yield f"{name} is no property of this curve, which has no minimum"
    if none := [name for name in missing if isfinite(_value(cell, name))]:
        yield f"no border within reach along {', '.join(none)}"


def _by(value: float, border: float, unit: Unit) -> str:
    """A change: in percent, as a factor, or, from 0, as the amount."""
    if value == 0 or border / value <= 0:
        return f"{unit.of(border - value):+.{_DIGITS}g} {unit.name}".rstrip()
    ratio = border / value
    return f"{100 * (ratio - 1):+.3g} %" if abs(ratio - 1) <= _AS_PERCENT else f"x {ratio:.3g}"


def _parameters(cell: xr.Dataset) -> list[str]:
    return [name for name in SEARCHABLE if f"margin_{name}" in cell]


def _value(cell: xr.Dataset, name: str) -> float:
    """The value of a parameter; static friction that is not given is that at break-away."""
    value = float(cell[name])
    model = model_with(cell.coords)
    return float(sum(cell[level] for level in model.levels)) if isnan(value) and name == model.static else value
