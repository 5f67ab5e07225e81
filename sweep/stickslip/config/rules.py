"""What must hold between quantities, in every cell of the grid.

Grids have up to 1e10 cells, so nothing here walks over cells. Each rule is a margin that is monotone in every quantity
it involves: along an axis that varies one of them only the worst end can break it; of quantities that vary together all
points are tried. What is reported is the worst cell.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.config.model import Axis, Group, Range, Values
from stickslip.config.scatter import Uncertain
from stickslip.errors import Path
from stickslip.vocabulary.curve import coefficients
from stickslip.vocabulary.laws import NO_MINIMUM, rise_to_a_maximum
from stickslip.vocabulary.quantities import MEASURED, QUANTITIES

MOST_CELLS = 10_000_000_000
_ROUNDING = 1e-12  # relative; 0.1 + 0.2 is above 0.3
_TRIED_DRAWS = 2**12  # what is rarer is met while computing, and such draws are `failed` there

Floats = NDArray[np.float64]


class Finding(NamedTuple):
    """One inconsistency: the value at `path` does not fit the rest.

    got : what was found, where that is not the value itself: of uncertain quantities, the worst of their draws.
    """

    path: Path
    expected: str
    hint: str
    got: str | None = None


@dataclass(frozen=True)
class Space:
    """The quantities that were read without problems: what is fixed (NaN for words), varied, and uncertain."""

    fixed: Mapping[str, float]
    axes: Sequence[Axis]
    uncertain: Uncertain | None = None
    law: str = "stribeck"

    @cached_property
    def drawn(self) -> Mapping[str, Floats]:
        """Some draws of the uncertain quantities, as many of each, to hold the rules against."""
        if self.uncertain is None:
            return {}
        normals = np.random.default_rng(1).standard_normal((_TRIED_DRAWS, len(self.uncertain.names)))
        return self.uncertain.values(normals)

    @property
    def draws_per_cell(self) -> int:
        """Cells computed for each cell of the axes."""
        return 1 if self.uncertain is None else self.uncertain.draws_per_cell

    def names(self) -> set[str]:
        """All quantities, fixed, varied or uncertain."""
        return set(self.fixed) | set(self.drawn) | {member.name for axis in self.axes for member in members(axis)}


def members(axis: Axis) -> tuple[Range | Values, ...]:
    """The quantities along an axis."""
    return axis.members if isinstance(axis, Group) else (axis,)


def findings(space: Space) -> Iterator[Finding]:
    """Everything that is wrong between the quantities of `space`. Rules about absent quantities are left out."""
    cells = math.prod(axis.size for axis in space.axes) * space.draws_per_cell
    if cells > MOST_CELLS:
        shape = " x ".join(str(axis.size) for axis in space.axes)
        shape += f" x {space.draws_per_cell} draws" if space.draws_per_cell > 1 else ""
        number = f"{cells:.3g}" if cells < 10**15 else f"10^{len(str(cells)) - 1}"  # no float is as large as some grids
        got = f"{number} cells ({shape})"
        yield Finding(("axes",), f"at most {MOST_CELLS:.0e}", "use fewer points, or fewer axes", got)
    for axis in space.axes:
        if isinstance(axis, Values):
            yield from _order(axis)
    curve = {"mu_start": 1} if set(MEASURED) & space.names() else {"a1": 1, "a3": 1}
    below_zero = list(_start(space))
    yield from below_zero
    if not below_zero:  # else nothing could be right beside it
        yield from _stop(space, curve)
        yield from _static(space, curve)
        yield from _minimum(space)
    yield from _measured(space)
    yield from _drive(space)


def _order(axis: Values) -> Iterator[Finding]:
    """Values of an axis differ, and numbers are monotone: they become a coordinate."""
    seen: dict[float | str, int] = {}
    for i, value in enumerate(map(QUANTITIES[axis.name].written, axis.values)):
        if value in seen:
            hint = f"it is the same as value number {seen[value] + 1}"
            yield Finding(("axes", axis.name, "values", i), "a value that is not in the list yet", hint)
        seen.setdefault(value, i)
    steps = np.diff(axis.points())
    if len(seen) == axis.size and not np.isnan(steps).any() and not ((steps > 0).all() or (steps < 0).all()):
        turn = 1 + int(np.flatnonzero(np.sign(steps) != np.sign(steps[0]))[0])
        hint = "sort them; a group (zip) keeps any order"
        yield Finding(("axes", axis.name, "values", turn), "values that rise or fall all the way", hint)


# --- rules of the friction curve --------------------------------------------------------------------------------------


def _start(space: Space) -> Iterator[Finding]:
    """mu_start = a1 + a3 >= 0: a3 is negative where friction rises from break-away, but static friction is not."""
    cell = _worst(space, {"a1": -1, "a3": -1}, lambda p: p["a1"] + p["a3"])
    if cell and cell.margin < -_ROUNDING * cell.values["a1"]:
        hint = "the curve starts at mu_start = a1 + a3, which is the static friction"
        yield Finding(cell.paths["a3"], f"at least -a1 = {-cell.values['a1']:.6g}", cell.hint(hint), cell.got("a3"))


def _stop(space: Space, curve: Mapping[str, int]) -> Iterator[Finding]:
    """mu_stop <= mu_start."""
    cell = _worst(space, {"mu_stop": 1, **{name: -1 for name in curve}}, lambda p: _total(p, curve) - p["mu_stop"])
    if cell and cell.margin < -_ROUNDING * cell.values["mu_stop"]:
        hint = "friction at standstill cannot exceed that at break-away"
        expected = f"at most {_start_text(cell.values, curve)}"
        yield Finding(cell.paths["mu_stop"], expected, cell.hint(hint), cell.got("mu_stop"))


def _static(space: Space, curve: Mapping[str, int]) -> Iterator[Finding]:
    """mu_static >= mu_start."""
    cell = _worst(space, {"mu_static": -1, **curve}, lambda p: p["mu_static"] - _total(p, curve))
    if cell and cell.margin < -_ROUNDING * _total(cell.values, curve):
        hint = "static friction is at least that of the curve; leave mu_static out for mu_start"
        expected = f"at least {_start_text(cell.values, curve)}"
        yield Finding(cell.paths["mu_static"], expected, cell.hint(hint), cell.got("mu_static"))


def _minimum(space: Space) -> Iterator[Finding]:
    """Hysteresis needs a curve that does not rise to a maximum and fall without end then."""

    def margin(p: Mapping[str, Floats]) -> Floats:
        return np.where(np.isnan(p["mu_stop"]), np.nan, -rise_to_a_maximum(space.law, p))

    worse = {"mu_stop": 1, "a2": 0, "a3": -1, "a4": -1, **({"delta": -1} if "delta" in space.names() else {})}
    cell = _worst(space, worse, margin)
    if cell and cell.margin < 0:
        curve = ", ".join(f"{name} = {cell.values[name]:.6g}" for name in ("a2", "a3", "a4"))
        yield Finding(cell.paths["mu_stop"], f"none with {curve}", cell.hint(NO_MINIMUM), cell.got("mu_stop"))


def _measured(space: Space) -> Iterator[Finding]:
    """mu_reversal < mu_start, and a1 >= 0."""
    cell = _worst(space, {"mu_reversal": 1, "mu_start": -1}, lambda p: p["mu_start"] - p["mu_reversal"])
    if cell and cell.margin <= 0:
        hint = "a curve without a minimum is given by a1, a2, a3 and a4, with a3: 0"
        expected = f"less than mu_start = {cell.values['mu_start']:.6g}"
        yield Finding(cell.paths["mu_reversal"], expected, cell.hint(hint), cell.got("mu_reversal"))
        return
    cell = _worst(space, {"mu_start": 1, "mu_reversal": -1, "v_reversal": -1, "a4": 1}, _constant_part)
    if cell and cell.margin < 0:
        v = cell.values
        rest = ", ".join(f"{name} = {v[name]:.6g}" for name in ("mu_start", "mu_reversal", "a4"))
        expected = f"more: with {rest} it makes a1 = {cell.margin:.3g}, which is below 0"
        hint = cell.hint("raise v_reversal or lower a4")
        yield Finding(cell.paths["v_reversal"], expected, hint, cell.got("v_reversal"))


def _drive(space: Space) -> Iterator[Finding]:
    """The belt of a rig moves, and reaches its speed within a stroke, if it has a ramp."""
    if "stroke" not in space.names():
        return
    moving = _worst(space, {"belt_speed": -1}, lambda p: p["belt_speed"])
    if moving and moving.margin <= 0:
        yield Finding(moving.paths["belt_speed"], "a speed above 0 m/s, that of the drive", "strokes are reciprocating")
        return
    cell = _worst(
        space, {"stroke": -1, "belt_speed": 1, "ramp": 1}, lambda p: p["stroke"] / p["belt_speed"] - p["ramp"]
    )
    if cell and cell.margin < -_ROUNDING * cell.values["ramp"]:
        most = cell.values["stroke"] / cell.values["belt_speed"]
        hint = "ramps up and down alone are longer than the stroke"
        got = f"{cell.values['ramp']:.4g} s"  # which may be the default
        yield Finding(cell.paths["ramp"], f"at most stroke/belt_speed = {most:.4g} s", hint, got)


def _constant_part(p: Mapping[str, Floats]) -> Floats:
    """a1, which falls with mu_start and a4 and rises with the rest, as long as mu_start > mu_reversal."""
    return coefficients(p["mu_start"], p["mu_reversal"], p["v_reversal"], p["a4"]).a1


def _total(p: Mapping[str, Any], names: Mapping[str, int]) -> Any:
    """Sum of some quantities, numbers or arrays."""
    return sum(p[name] for name in names)


def _start_text(p: Mapping[str, float], curve: Mapping[str, int]) -> str:
    """`mu_start = a1 + a3 = 1.3`, by the form in which the curve is given."""
    sources = [] if "mu_start" in curve else [" + ".join(curve)]
    return " = ".join(["mu_start", *sources, f"{_total(p, curve):.6g}"])


# --- the worst cell ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Cell:
    """One cell: the margin there, the values it comes from, and their positions in the file.

    wrong_draws : share of the draws with a margin below 0 in some cell; None where nothing uncertain is involved.
    """

    margin: float
    values: Mapping[str, float]
    paths: Mapping[str, Path]
    wrong_draws: float | None = None

    def got(self, name: str) -> str | None:
        """What was found, where that is not what the file says but a draw of it, or of what it is compared with."""
        if self.wrong_draws is None:
            return None
        return f"{self.values[name]:.6g} in the worst draw ({100 * self.wrong_draws:.2g} % of them are impossible)"

    def hint(self, otherwise: str) -> str:
        """The next step."""
        return otherwise if self.wrong_draws is None else f"{otherwise}; truncate the distribution"


def _worst(space: Space, worse: Mapping[str, int], margin: Callable[[Mapping[str, Floats]], Floats]) -> _Cell | None:
    """The cell with the smallest margin.

    worse : by quantity, +1 if the margin falls as it grows, -1 if it rises, 0 if it is not monotone.
    Cells where a quantity is absent (NaN) do not count. None if there is no other, or a quantity is not in `space`.
    """
    if not set(worse) <= space.names():
        return None
    columns: dict[str, Floats] = {n: np.asarray(space.fixed[n], np.float64) for n in worse if n in space.fixed}
    indices: dict[str, tuple[Axis, int, NDArray[np.intp]]] = {}
    involved = [axis for axis in space.axes if any(m.name in worse for m in members(axis))]
    drawn = {name: values for name, values in space.drawn.items() if name in worse}
    dimensions = len(involved) + bool(drawn)
    for number, axis in enumerate(involved):
        here = {m.name: m.points() for m in members(axis) if m.name in worse}
        chosen = _candidates(here, worse)
        for name, points in here.items():
            columns[name] = points[chosen].reshape([-1 if i == number else 1 for i in range(dimensions)])
            indices[name] = (axis, number, chosen)
    columns |= drawn  # along the last dimension
    margins = np.atleast_1d(margin(columns))
    if np.isnan(margins).all():
        return None
    at = np.unravel_index(int(np.nanargmin(margins)), margins.shape)
    values = {n: float(np.broadcast_to(c, margins.shape)[at]) for n, c in columns.items()}
    paths = {
        n: _path(indices[n][0], n, int(indices[n][2][at[indices[n][1]]])) if n in indices else _section_path(n)
        for n in worse
    }
    paths |= {name: ("uncertain", "quantities", name) for name in drawn}
    wrong = float((margins < 0).any(axis=tuple(range(margins.ndim - 1))).mean()) if drawn else None
    return _Cell(float(margins[at]), values, paths, wrong)


def _candidates(points: Mapping[str, Floats], worse: Mapping[str, int]) -> NDArray[np.intp]:
    """Points of an axis that can be the worst: one for a lone quantity, all for several that vary together."""
    if len(points) > 1 or not all(worse[name] for name in points):
        return np.arange(len(next(iter(points.values()))))
    ((name, values),) = points.items()
    ranked = worse[name] * values
    return np.array([0 if np.isnan(ranked).all() else int(np.nanargmax(ranked))])


def _section_path(name: str) -> Path:
    return (QUANTITIES[name].section, name)


def _path(axis: Axis, name: str, i: int) -> Path:
    """The position of value number `i` of the quantity `name` along `axis`."""
    if isinstance(axis, Group):
        return ("axes", axis.name, "zip", name, i)
    if isinstance(axis, Range):
        return ("axes", axis.name, "start" if i == 0 else "stop")
    return ("axes", axis.name, "values", i)
