"""The cheapest change of several parameters that leads to another regime.

In the space of changes, each multiplied by its cost, a cell is the origin, and the cheapest change the nearest point
beyond a border. Rays from the origin into many directions are searched together; around the best of them the search
goes on in smaller and smaller steps of direction, every ray with its exact border.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

from stickslip.studies.borders.search import Looked, Scan, search_lines
from stickslip.studies.margins.reach import Reach
from stickslip.studies.margins.single import Floats, Integers, Labels, Search, decided, first_entries

MOST_STEPS = 1e7  # of integration for a cell, some ten seconds: where damping is weak, each of 20,000 takes 30,000
_RAYS, _MOST_RAYS = 5, 9  # powers of two: rays for one parameter, and twice as many for every two more
_STARTS = 3  # directions per cell from which the search goes on
_FIRST, _SHRINK, _GROW = 0.3, 0.4, 1.5  # steps of direction (radians), and how they change
_COARSE = 1e-3  # tolerance of the first rays
_LAST = 3e-5  # the cost is stationary in the direction: its error is the square of this
_OF_STEP = 0.01  # of the square of a step of direction, which the cost may change by: how exactly it is looked for
_ROUNDS = 60
_AT_ONCE = 16  # rays looked along together, after which the best few are known better
_INNER = 8  # places of a ray looked at first, inside the best cost known


@dataclass(frozen=True, eq=False)
class Cheapest:
    """Of n cells: cost (n,), inf where no ray met a border; the changes of each parameter there (n, k); whether the
    search ended before it was done, so that there may be a cheaper change."""

    cost: Floats
    changes: Floats
    ended: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Space:
    """Changes times costs: what a ray is in. down, up : room (n, k) on both sides of each parameter. ends : steps of
    integration of each cell at which its search ends."""

    search: Search
    reaches: Sequence[Reach]
    costs: Floats
    into: list[int] | None
    down: Floats
    up: Floats
    ends: Floats

    @classmethod
    def of(cls, search: Search, reaches: Sequence[Reach], costs: Floats, into: list[int] | None, ends: Floats) -> Space:
        """The space of some reaches."""
        down, up = (np.stack(rooms, axis=1) for rooms in zip(*(reach.room for reach in reaches), strict=True))
        return cls(search, reaches, costs, into, down, up, ends)

    def goes_on(self, cell: Integers) -> NDArray[np.bool_]:
        """Return whether the search of cells has not come to its end."""
        return np.asarray(self.search.steps[cell] < self.ends[cell])

    def allowed(self, cell: Integers, direction: Floats) -> Floats:
        """Directions (m, k) of length 1 without the parts for which there is no room; 0 where nothing is left."""
        room = np.where(direction < 0, self.down[cell], self.up[cell])
        kept = np.where(room > 0, direction, 0.0)
        length = np.linalg.norm(kept, axis=1, keepdims=True)
        return np.asarray(np.divide(kept, length, out=np.zeros_like(kept), where=length > 0))

    def longest(self, cell: Integers, direction: Floats) -> Floats:
        """Return how long rays are, until a parameter meets its end."""
        room = np.where(direction < 0, self.down[cell], self.up[cell]) * self.costs
        with np.errstate(divide="ignore", invalid="ignore"):  # 0/0: no room, and not that way
            return np.asarray(np.min(np.where(direction == 0, np.inf, room / np.abs(direction)), axis=1))

    def entries(self, cell: Integers, direction: Floats, length: Floats, points: int, tolerance: float) -> Floats:
        """Return where rays of a length first enter another regime (of `into`); inf where they do not."""

        def labels_at(line: Integers, place: Floats) -> Looked:
            changes = direction[line] * (place * length[line])[:, np.newaxis] / self.costs
            at = np.flatnonzero(self.goes_on(cell[line]))
            changed = {r.name: r.at(changes[at, i], cell[line[at]]) for i, r in enumerate(self.reaches)}
            found = self.search.looked(cell[line[at]], changed, self.into)
            if at.size == line.size:
                return found
            labels, known, guide = (
                np.zeros(line.size, np.int8),
                np.zeros(line.size, np.bool_),
                np.full(line.size, np.nan),
            )
            labels[at], known[at], guide[at] = found
            return Looked(labels, known, guide)

        brackets, _ = search_lines(cell.size, Scan(0.0, 1.0, points + 1, "linear"), tolerance, labels_at)
        first = first_entries(brackets, self.into)
        found = np.full(cell.size, np.inf)
        found[first["line"]] = first["high"] * length[first["line"]]
        return found


def cheapest(
    search: Search, reaches: Sequence[Reach], costs: Floats, home: Labels, into: list[int] | None, points: int,
    tolerance: float, single: Floats,
) -> Cheapest:  # fmt: skip
    """The cheapest joint change of each cell; arguments as in `single.nearest`, costs (k,) per unit of change.

    single : cost (n,) of the cheapest change of one parameter, inf where there is none. No joint change costs more, so
    nothing is looked at beyond. The search of a cell ends after `MOST_STEPS` of integration.
    """
    space = Space.of(search, reaches, costs, into, search.steps + MOST_STEPS)
    cell = np.flatnonzero(decided(home) & ((space.down > 0) | (space.up > 0)).any(axis=1))
    size, k = home.size, len(reaches)
    best = Cheapest(np.full(size, np.inf), np.full((size, k), np.nan), np.zeros(size, np.bool_))
    if not cell.size:
        return best
    start_cell, direction, cost = _starts(space, cell, points, single)
    cost, direction = refined(space, start_cell, direction, cost, tolerance)
    best.ended[cell] = ~space.goes_on(cell)
    for one in np.argsort(-cost, kind="stable"):  # the cheapest of each cell is written last
        if np.isfinite(cost[one]):
            best.cost[start_cell[one]] = cost[one]
            best.changes[start_cell[one]] = direction[one] * cost[one] / costs
    return best


def _starts(space: Space, cell: Integers, points: int, single: Floats) -> tuple[Integers, Floats, Floats]:
    """The best few directions of each cell out of many: cells, directions, costs.

    Rays are as long as may still be among the best: no longer than the cheapest change of one parameter, nor than the
    last of the best few so far.
    """
    k = len(space.reaches)
    rays = 2 ** min(_RAYS + k // 2, _MOST_RAYS)
    spread = scipy.stats.qmc.MultivariateNormalQMC(np.zeros(k), seed=14).random(rays) if k > 1 else np.zeros((0, k))
    towards = np.concatenate([np.eye(k), -np.eye(k), spread])
    wanted = _STARTS if k > 1 else 2
    directions = space.allowed(np.repeat(cell, len(towards)), np.tile(towards, (cell.size, 1)))
    directions = directions.reshape(cell.size, -1, k)
    costs = np.full(directions.shape[:2], np.inf)
    for first in range(0, len(towards), _AT_ONCE):
        least = np.partition(costs, wanted - 1, axis=1)[:, wanted - 1]
        longest = np.minimum(single[cell] * (1 + _COARSE), least)
        some = np.any(directions[:, first : first + _AT_ONCE] != 0, axis=2)
        row, ray = np.nonzero(some & space.goes_on(cell)[:, np.newaxis])
        ray += first
        costs[row, ray] = _scanned(space, cell[row], directions[row, ray], longest[row], points)
    order = np.argsort(costs, axis=1, kind="stable")[:, :wanted]
    rows = np.arange(cell.size)[:, np.newaxis]
    return np.repeat(cell, order.shape[1]), directions[rows, order].reshape(-1, k), costs[rows, order].ravel()


def _scanned(space: Space, cell: Integers, direction: Floats, longest: Floats, points: int) -> Floats:
    """Scan rays up to some length for another regime, at places as close as `points` over all there is room for,
    or closer."""
    room = space.longest(cell, direction)
    length, found = np.minimum(room, longest), np.full(cell.size, np.inf)
    many = np.exp2(np.ceil(np.log2(np.maximum(points * length / room, _INNER))))
    for one in np.unique(many):
        some = many == one
        found[some] = space.entries(cell[some], direction[some], length[some], min(int(one), points), _COARSE)
    return found


def refined(space: Space, cell: Integers, direction: Floats, cost: Floats, tolerance: float) -> tuple[Floats, Floats]:
    """Steps of direction to all sides, to wherever it is cheaper; smaller ones where it is nowhere.

    cell, direction, cost : of rays whose costs are known roughly (m,), (m, k), (m,). Returns costs and directions.
    """
    k = direction.shape[1]
    met = np.isfinite(cost)
    cost[met] = _exact(space, cell[met], direction[met], cost[met], tolerance)
    step = np.where(np.isfinite(cost) & (k > 1), _FIRST, 0.0)
    random = np.random.default_rng(14)
    for _ in range(_ROUNDS):
        turns = random.standard_normal((k, k))  # the same for all, so that no cell depends on its neighbours in a block
        active = np.flatnonzero((step > _LAST) & space.goes_on(cell))
        if not active.size:
            break
        fine = _fineness(step[active], tolerance)
        for one in np.unique(fine):
            _step(space, cell, direction, cost, step, active[fine == one], turns, float(one))
    cost[met] = _exact(space, cell[met], direction[met], cost[met], tolerance)
    return cost, direction


def _step(
    space: Space, cell: Integers, direction: Floats, cost: Floats, step: Floats, active: Integers, turns: Floats,
    tolerance: float,
) -> None:  # fmt: skip
    """One step of direction of those that are active, to the cheapest side, if that is cheaper."""
    k = direction.shape[1]
    sides = _across(direction[active], turns)
    tried = direction[active, np.newaxis] + step[active, np.newaxis, np.newaxis] * sides
    owner = np.repeat(active, tried.shape[1])
    rays = space.allowed(cell[owner], tried.reshape(-1, k))
    length = np.minimum(cost[owner] * (1 - tolerance), space.longest(cell[owner], rays))
    real = np.any(rays != 0, axis=1)
    found = np.full(owner.size, np.inf)
    found[real] = space.entries(cell[owner[real]], rays[real], length[real], _INNER, tolerance)
    choice = np.argmin(found.reshape(active.size, -1), axis=1) + tried.shape[1] * np.arange(active.size)
    better = found[choice] < cost[active]
    gained = active[better]
    cost[gained], direction[gained] = found[choice[better]], rays[choice[better]]
    step[active] *= np.where(better, _GROW, _SHRINK)
    step[gained] = np.minimum(step[gained], _FIRST)


def _fineness(step: Floats, tolerance: float) -> Floats:
    """Return how exactly borders are needed: what the cost may change by in a step, in powers of ten."""
    return np.asarray(np.maximum(10.0 ** np.round(np.log10(_OF_STEP * step**2)), tolerance))


def _exact(space: Space, cell: Integers, direction: Floats, cost: Floats, tolerance: float) -> Floats:
    """Costs of rays known roughly, to the tolerance; as they are where the search has ended."""
    length = np.minimum(cost * (1 + 2 * _COARSE), space.longest(cell, direction))
    goes_on, found = space.goes_on(cell), space.entries(cell, direction, length, _INNER, tolerance)
    return np.where(goes_on & (np.isfinite(found) | space.goes_on(cell)), found, cost)


def _across(direction: Floats, turns: Floats) -> Floats:
    """Unit vectors across directions (m, k), to both sides along a basis turned at random: (m, 2 (k - 1), k)."""
    m, k = direction.shape
    basis = np.repeat(turns[np.newaxis], m, axis=0)
    basis[:, :, 0] = direction
    across = np.linalg.qr(basis)[0][:, :, 1:].transpose(0, 2, 1)
    return np.concatenate([across, -across], axis=1)
