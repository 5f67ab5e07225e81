"""Changes of cells: how far parameters may go, the nearest border along one, and the cheapest change of several that
leads over one.

A change is the logarithm of the ratio to the value that the cell has; where that is 0, or where a parameter may change
its sign (the starting state), it is the difference over a scale of the cell.
In the space of changes, each multiplied by its cost, a cell is the origin, and the cheapest change the nearest point
beyond a border. Rays from the origin into many directions are searched together; the best of them are turned to all
sides, by smaller and smaller steps, to wherever the border is nearer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.engine import Options, Scales, StopFlag, solve
from stickslip.studies.lines import decided, growth_of, guide_of
from stickslip.studies.search import Brackets, Flags, Floats, GuideAt, Integers, Labels, Looked, Scan, search_lines
from stickslip.vocabulary.cells import Parameters, impossible, taken
from stickslip.vocabulary.models import LAWS, laws_with, model_of, model_with
from stickslip.vocabulary.quantities import DECIDED, MEASURED, REGIMES, SEARCHABLE, UNDECIDED, VIBRATING, listed

OPPOSITE = "opposite"  # regimes, in a list of those to be entered: quiet ones of what vibrates, else vibrating ones
_QUIET = tuple(name for name in DECIDED if name not in VIBRATING)
_SIGNED = ("displacement", "velocity")  # changed by amounts, not by factors
_MOST_STEPS = 1e7  # of integration for a cell, some ten seconds: where damping is weak, each of 20,000 takes 30,000
_RAYS, _MOST_RAYS = 5, 9  # powers of two: rays for one parameter, and twice as many for every two more
_STARTS = 3  # rays of a cell that are turned
_AT_ONCE = 16  # rays looked along together, after which the best few are known better
_INNER = 8  # places of a ray looked at first, inside the best cost known
_COARSE = 1e-3  # tolerance of the first rays
_TURNS = 0.3 * 0.5 ** np.arange(14)  # radians; the error of the cost is the square of the last
_TRIES = 6  # of each
_OF_TURN = 0.01  # of the square of a turn, which the cost may change by: how exactly it is looked for
_VIBRATING = [REGIMES.index(name) for name in VIBRATING]


@dataclass(frozen=True, eq=False)
class Reach:
    """One parameter in n cells: its value, how far down and up it may go, all in SI and (n,).

    by_factor : whether changes are logarithms of ratios. scale : what other changes are divided by. A value of NaN
    means that the cell does not have this parameter.
    """

    name: str
    value: Floats
    low: Floats
    high: Floats
    by_factor: Flags
    scale: Floats

    def at(self, change: Floats, cells: Integers) -> Floats:
        """Values after changes, one for each of `cells`, no further than the reach."""
        value = self.value[cells]
        with np.errstate(over="ignore"):
            changed = np.where(self.by_factor[cells], value * np.exp(change), value + change * self.scale[cells])
        return np.where(change == 0.0, value, np.clip(changed, self.low[cells], self.high[cells]))

    def change(self, value: Floats) -> Floats:
        """The changes (n,) that lead to values."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.by_factor, np.log(value / self.value), (value - self.value) / self.scale)

    @property
    def room(self) -> tuple[Floats, Floats]:
        """The largest change against and with the sign of the value, both at least 0; 0 where there is no value."""
        ends = self.change(self.low), self.change(self.high)
        down, up = np.minimum(*ends), np.maximum(*ends)
        return np.nan_to_num(np.maximum(-down, 0.0)), np.nan_to_num(np.maximum(up, 0.0))


def reach_of(name: str, cells: Parameters, within: float | tuple[float, float]) -> Reach:
    """Return how far a parameter may be changed: within a factor or a range, and within what is possible."""
    model, by = model_with(cells), Scales(cells)
    value = np.where(np.isinf(cells[name]), np.nan, cells[name].astype(np.float64))
    if name == model.static:  # where it is not given it is that at break-away
        value = np.where(np.isnan(value), model.start_of(cells), value)
    scale = 2.0 * by.impedance if name == "damping" else model.change_scale(name, cells, by)
    scale = np.broadcast_to(scale, value.shape).astype(np.float64)
    by_factor = (value != 0) & ~np.isnan(value) & (name not in _SIGNED)
    if isinstance(within, tuple):
        low, high = (np.full_like(value, end) for end in within)
        low, high = np.minimum(low, value), np.maximum(high, value)
        low = np.where(by_factor & (value > 0), np.maximum(low, np.minimum(value, 1e-12 * np.abs(high))), low)
        high = np.where(by_factor & (value < 0), np.minimum(high, np.maximum(value, -1e-12 * np.abs(low))), high)
    else:
        ends = np.where(by_factor, value / within, value - scale), np.where(by_factor, value * within, value + scale)
        low, high = np.minimum(*ends), np.maximum(*ends)
    row, like = SEARCHABLE[name], np.ones_like(cells["mass"])
    bounds = -np.inf if row.at_least is None else row.at_least, np.inf if row.at_most is None else row.at_most
    least, most = model.within(name, cells, *(like * bound for bound in bounds))  # beside the others of the cell
    return Reach(name, value, np.minimum(np.maximum(low, least), value), np.maximum(np.minimum(high, most), value),
                 by_factor, scale)  # fmt: skip


def misfit(names: Iterable[str], options: Options) -> str | None:
    """Return why not all parameters of these names are of the law."""
    wrong = next((name for name in names if options.law not in laws_with(name)), None)
    if wrong is None:
        return None
    laws = listed(other for other in laws_with(wrong) if other in LAWS)
    what = f"the form of {', '.join(MEASURED)}" if wrong in MEASURED else wrong
    return f"{what} is for the law {laws}, not {options.law}"


@dataclass(frozen=True, eq=False)
class MarginSearch:
    """Cells, by parameters of length n, and how they are computed, until `stop` is raised.

    speeds : belt speeds (m/s) at all of which a cell is computed: the worst of its regimes counts. None: its own.
    moved : as of a study. home : regimes of the cells, where those of the other kind are looked for: quiet ones of what
    vibrates, else vibrating ones. steps : of integration that each cell took so far (n,).
    """

    cells: Parameters
    options: Options
    stop: StopFlag
    speeds: tuple[float, ...] = ()
    moved: Callable[[int], None] | None = None
    home: Labels | None = field(default=None, kw_only=True)
    steps: Floats = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", np.zeros(next(iter(self.cells.values())).size))

    def regimes(self, which: Integers, changed: Parameters) -> Labels:
        """Regimes of the cells `which` (m,) with other values (m,) of some parameters; impossible ones are not
        computed. Raises StoppedError."""
        return self._computed(which, changed)[0]

    def looked(self, which: Integers, changed: Parameters, into: list[int] | None) -> Looked:
        """The same as a search takes it: labels (with `into`, whether it is one of these regimes), and the guide to
        where stick-slip ends by grazing."""
        regimes, guide = self._computed(which, changed)
        if into is None:
            return Looked(regimes, decided(regimes), guide)
        entered = np.isin(regimes, into)
        if self.home is not None:
            entered |= np.isin(regimes, _VIBRATING) != np.isin(self.home[which], _VIBRATING)
        return Looked(entered.astype(np.int8), decided(regimes), guide)

    def guide_at(self, cells_at: Callable[[Integers, Floats], tuple[Integers, Parameters]]) -> GuideAt | None:
        """The guide by theory, where it knows one. cells_at : which cells, and what is changed, by line and place."""
        if self.speeds:
            return None
        return growth_of(lambda line, place: self._changed(*cells_at(line, place)), self.options)

    def _changed(self, which: Integers, changed: Parameters) -> Parameters:
        return model_of(self.options.law).without_measured(taken(self.cells, which) | changed)

    def _computed(self, which: Integers, changed: Parameters) -> tuple[Labels, Floats]:
        cells = self._changed(which, changed)
        possible = np.flatnonzero(~impossible(cells, model_of(self.options.law).rules[self.options.law]))
        regimes, guide = np.full(which.size, REGIMES.index("not_computed"), np.int8), np.full(which.size, np.nan)
        if possible.size:
            each = max(len(self.speeds), 1)
            lanes = taken(cells, np.repeat(possible, each))
            if self.speeds:
                lanes["belt_speed"] = np.tile(self.speeds, possible.size)
            results = solve(lanes, self.options, self.stop, self.moved)
            np.add.at(self.steps, which[possible], results["steps"].reshape(-1, each).sum(axis=1))
            regimes[possible] = worst(results["regime"].reshape(-1, each))
            if not self.speeds:  # of several speeds none leads to where all are quiet
                guide[possible] = guide_of(results, self.options)
        return regimes, guide


def worst(regimes: Labels) -> Labels:
    """Of regimes (n, k) those that matter most: a vibration, else one that is not decided, else the first."""
    rank = np.zeros(len(REGIMES), np.int8)
    rank[list(UNDECIDED)] = 1
    rank[[REGIMES.index(name) for name in reversed(VIBRATING)]] = 2, 3
    return np.take_along_axis(regimes, np.argmax(rank[regimes], axis=1)[:, None], 1)[:, 0]


def entered(into: Sequence[str] | None, home: str) -> tuple[str, ...]:
    """The regimes, by name, that a cell is to enter. home : its own. into : as in the section."""
    if into is None:
        return tuple(name for name in DECIDED if name != home)
    other_kind = _QUIET if home in VIBRATING else VIBRATING
    return tuple(dict.fromkeys(name for wanted in into for name in (other_kind if wanted == OPPOSITE else (wanted,))))


class Borders(NamedTuple):
    """The nearest borders of n cells: (n, 2), below and above the value; NaN, and regime 0, where there is none.

    low, high : the last bracket in SI. border : in it. change : of the side beyond, as `Reach` measures it.
    beyond : regime there.
    """

    low: Floats
    high: Floats
    border: Floats
    change: Floats
    beyond: Labels


def nearest(
    search: MarginSearch, reach: Reach, home: Labels, into: list[int] | None, points: int, tolerance: float
) -> Borders:
    """The first change of regime on the way down and up.

    home : regimes of the cells as they are; those that are undecided have no border. into : codes of the regimes to be
    entered; None for any other. points : places looked at first on either side, evenly spaced in the change.
    """
    room, sign = np.stack(reach.room), np.array([-1.0, 1.0])
    searched = np.flatnonzero(decided(home))
    cells, ways = np.repeat(searched, 2), np.tile([0, 1], searched.size)
    cells, ways = np.stack([cells, ways])[:, room[ways, cells] > 0]

    def change_at(line: Integers, place: Floats) -> Floats:
        return np.asarray(place * room[ways[line], cells[line]] * sign[ways[line]])

    def cells_at(line: Integers, place: Floats) -> tuple[Integers, Parameters]:
        return cells[line], {reach.name: reach.at(change_at(line, place), cells[line])}

    brackets, _ = search_lines(
        cells.size, Scan(0.0, 1.0, points + 1, "linear"), tolerance,
        lambda line, place: search.looked(*cells_at(line, place), into), search.guide_at(cells_at),
    )  # fmt: skip
    first = first_entries(brackets, into)
    line = first["line"]
    at, beyond = (cells[line], ways[line]), np.zeros((home.size, 2), np.int8)
    low, high, border, change = (np.full((home.size, 2), np.nan) for _ in range(4))
    near, far, border[at] = (cells_at(line, first[end])[1][reach.name] for end in ("low", "high", "place"))
    low[at], high[at], change[at] = np.minimum(near, far), np.maximum(near, far), change_at(line, first["high"])
    beyond[at] = search.regimes(at[0], {reach.name: far})
    return Borders(low, high, border, change, beyond)


def first_entries(brackets: Brackets, into: list[int] | None) -> Brackets:
    """The first bracket of each line; with `into`, whose labels are 0 and 1, the first that enters."""
    entries = brackets if into is None else brackets[brackets["above"] == 1]
    _, first = np.unique(entries["line"], return_index=True)
    return entries[first]


class ChangeSpace:
    """Changes times costs: what a ray is in. most : steps of integration of a cell, after which its search ends."""

    def __init__(
        self, search: MarginSearch, reaches: Sequence[Reach], costs: Floats, into: list[int] | None, most: float
    ) -> None:
        self.search, self.reaches, self.costs, self.into = search, reaches, costs, into
        self.room = np.stack([reach.room for reach in reaches], axis=-1)  # (2, n, k): against and with the sign
        self._ends = search.steps + most

    def goes_on(self, cell: Integers) -> Flags:
        """Return whether the search of cells has not come to its end."""
        return np.asarray(self.search.steps[cell] < self._ends[cell])

    def _room(self, cell: Integers, direction: Floats) -> Floats:
        down, up = self.room[:, cell]
        return np.asarray(np.where(direction < 0, down, up))

    def allowed(self, cell: Integers, direction: Floats) -> Floats:
        """Directions (m, k) of length 1 without the parts for which there is no room; 0 where nothing is left."""
        possible = np.where(self._room(cell, direction) > 0, direction, 0.0)
        length = np.linalg.norm(possible, axis=1, keepdims=True)
        return np.asarray(np.divide(possible, length, out=np.zeros_like(possible), where=length > 0))

    def entries(self, cell: Integers, direction: Floats, limit: Floats, tolerance: float, points: int) -> Floats:
        """Where rays first enter another regime (of `into`), no further than `limit`; inf where they do not.

        points : places looked at first on each, of at most the length at which a parameter meets its end.
        """
        room = self._room(cell, direction) * self.costs
        with np.errstate(divide="ignore", invalid="ignore"):  # 0/0: no room, and not that way
            ends = np.min(np.where(direction == 0, np.inf, room / np.abs(direction)), axis=1)
        rays = np.flatnonzero(direction.any(axis=1))
        cells, towards, length = cell[rays], direction[rays], np.minimum(limit, ends)[rays]

        def labels_at(line: Integers, place: Floats) -> Looked:
            changes = towards[line] * (place * length[line])[:, np.newaxis] / self.costs
            changed = {r.name: r.at(changes[:, i], cells[line]) for i, r in enumerate(self.reaches)}
            return self.search.looked(cells[line], changed, self.into)

        brackets, _ = search_lines(rays.size, Scan(0.0, 1.0, points + 1, "linear"), tolerance, labels_at)
        first = first_entries(brackets, self.into)
        entries = np.full(cell.size, np.inf)
        entries[rays[first["line"]]] = first["high"] * length[first["line"]]
        return entries


def cheapest(
    search: MarginSearch, reaches: Sequence[Reach], costs: Floats, home: Labels, into: list[int] | None, points: int,
    tolerance: float, single: Floats,
) -> tuple[Floats, Floats, Flags]:  # fmt: skip
    """The cheapest joint change of each cell; arguments as in `nearest`, costs (k,) per unit of change.

    Returns its cost (n,), NaN where no ray met a border; the changes of each parameter (n, k); and whether the search
    ended before it was done, so that there may be a cheaper change (n,).

    single : cost (n,) of the cheapest change of one parameter, inf where there is none. No joint change costs more, so
    nothing is looked at beyond. The search of a cell ends after `_MOST_STEPS` of integration.
    """
    space, k = ChangeSpace(search, reaches, costs, into, _MOST_STEPS), len(reaches)
    cell = np.flatnonzero(decided(home) & (space.room > 0).any(axis=(0, 2)))
    least, changes = np.full(home.size, np.nan), np.full((home.size, k), np.nan)
    ended = np.zeros(home.size, np.bool_)
    if not cell.size:
        return least, changes, ended
    direction, cost = _best_rays(space, cell, points, single[cell])
    few = cost.shape[1]
    direction, cost = turned_in(space, np.repeat(cell, few), direction.reshape(-1, k), cost.ravel(), tolerance)
    best = np.argmin(cost.reshape(-1, few), axis=1) + few * np.arange(cell.size)
    best, met = best[np.isfinite(cost[best])], cell[np.isfinite(cost[best])]
    least[met], changes[met] = cost[best], direction[best] * cost[best, np.newaxis] / costs
    ended[cell] = ~space.goes_on(cell)
    return least, changes, ended


def _best_rays(space: ChangeSpace, cell: Integers, points: int, single: Floats) -> tuple[Floats, Floats]:
    """The best few of many rays of each cell: directions (cells, few, k) and costs (cells, few).

    Rays are no longer than the cheapest change of one parameter, nor than the last of the best few so far.
    """
    k = len(space.reaches)
    towards = np.concatenate([np.eye(k), -np.eye(k)])
    if k > 1:
        rays = 2 ** min(_RAYS + k // 2, _MOST_RAYS)
        towards = np.concatenate([towards, scipy.stats.qmc.MultivariateNormalQMC(np.zeros(k), seed=14).random(rays)])
    few = min(_STARTS, len(towards))
    directions = space.allowed(np.repeat(cell, len(towards)), np.tile(towards, (cell.size, 1)))
    directions = directions.reshape(cell.size, -1, k)
    costs = np.full(directions.shape[:2], np.inf)
    for first in range(0, len(towards), _AT_ONCE):
        going, now = np.flatnonzero(space.goes_on(cell)), slice(first, first + _AT_ONCE)
        part = directions[going, now]
        limit = np.minimum(single * (1 + _COARSE), np.partition(costs, few - 1, axis=1)[:, few - 1])[going]
        owner, limits = (np.repeat(values, part.shape[1]) for values in (cell[going], limit))
        costs[going, now] = space.entries(owner, part.reshape(-1, k), limits, _COARSE, points).reshape(part.shape[:2])
    order = np.argsort(costs, axis=1, kind="stable")[:, :few]
    return np.take_along_axis(directions, order[..., np.newaxis], axis=1), np.take_along_axis(costs, order, axis=1)


def turned_in(
    space: ChangeSpace, cell: Integers, direction: Floats, cost: Floats, tolerance: float
) -> tuple[Floats, Floats]:
    """Directions (m, k) and costs (m,) of rays, turned to all sides to wherever it is cheaper.

    cost : known roughly, inf of rays that are left as they are; in the end to the tolerance, unless the search of a
    cell ended before.
    """
    direction, cost = direction.copy(), cost.copy()
    k = direction.shape[1]
    bases = np.random.default_rng(14).standard_normal((_TURNS.size, _TRIES, k, k))  # the same for all cells
    for turn, of_tries in zip(_TURNS, bases, strict=True):
        fine = max(_OF_TURN * turn**2, tolerance)
        active = np.flatnonzero(np.isfinite(cost))
        for basis in of_tries:
            active = active[space.goes_on(cell[active])]
            if not active.size:
                break
            sides = turn * _across(direction[active], basis)
            rays = direction[active, np.newaxis] + np.pad(sides, ((0, 0), (1, 0), (0, 0)))  # the first as it is
            owner, limit = np.repeat(cell[active], rays.shape[1]), np.repeat(cost[active], rays.shape[1])
            flat = space.allowed(owner, rays.reshape(-1, k))
            entries = space.entries(owner, flat, (1 + 2 * _COARSE) * limit, fine, _INNER).reshape(rays.shape[:2])
            choice = np.argmin(entries * np.where(np.arange(rays.shape[1]), 1 + fine, 1.0), axis=1)
            rows = np.arange(active.size)
            met = np.isfinite(entries[rows, choice])
            cost[active[met]] = entries[rows, choice][met]
            direction[active[met]] = flat.reshape(rays.shape)[rows, choice][met]
            active = active[met & (choice > 0)]
    return direction, cost


def _across(direction: Floats, basis: Floats) -> Floats:
    """Unit vectors across directions (m, k), to both sides along a basis turned at random: (m, 2 (k - 1), k)."""
    bases = np.repeat(basis[np.newaxis], len(direction), axis=0)
    bases[:, :, 0] = direction
    across = np.linalg.qr(bases)[0][:, :, 1:].transpose(0, 2, 1)
    return np.concatenate([across, -across], axis=1)


def checked(search: MarginSearch, reaches: Sequence[Reach], changes: Floats, beyond: float) -> tuple[Labels, Floats]:
    """Regimes of cells a little past the border, and the values there; 0 and NaN where there is none.

    changes : (n, k) up to the border. The length of the change grows by the share `beyond`, or by as much as a single
    parameter has to change by that share of its value, if that is more; not at all where no cell is possible there.
    """
    there = np.flatnonzero(~np.isnan(changes).any(axis=1))
    regimes, values = np.zeros(len(changes), np.int8), np.full(changes.shape, np.nan)
    length = np.linalg.norm(changes, axis=1, keepdims=True)
    by_factor = np.stack([reach.by_factor for reach in reaches], axis=1).any(axis=1, keepdims=True)
    more = np.where(by_factor, np.maximum(beyond * length, np.log1p(beyond)), beyond * length)
    for further in (changes * (1 + more / np.where(length > 0, length, 1.0)), changes):
        for i, reach in enumerate(reaches):
            values[there, i] = reach.at(further[there, i], there)
        regimes[there] = search.regimes(there, {reach.name: values[there, i] for i, reach in enumerate(reaches)})
        there = there[regimes[there] == REGIMES.index("not_computed")]
    return regimes, values
