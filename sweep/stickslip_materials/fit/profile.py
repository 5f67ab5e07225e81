"""Least squares where one coefficient is a scale and the model is linear in all others, and what the points leave open.

Stribeck curves are linear in all coefficients for a given decay speed, and ageing is in mu0 and beta for a given t0.
So the sum of squares that is left, as a function of the scale alone, is a linear problem (variable projection, Golub
and Pereyra 1973), and the profile likelihood of any linear combination of the others is the lower envelope of one
parabola for each scale: its confidence interval (Venzon and Moolgavkar 1988) follows without a search, however far the
likelihood is from that of a normal distribution.

Without standard deviations the scatter is taken to be sigma exp(s z), z the logarithm of the speed over its range;
s is profiled as well, by the restricted likelihood, since a wrong weighting makes intervals too narrow. How far s may
lie from 0 is limited by a normal prior: few points say nothing about it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip_materials.fit.uncertainty import Flags, Floats, Interval, student

_ZOOMS, _COARSE, _ACROSS = 14, 3, 17  # of the search for a scale: each zoom narrows its bracket eightfold
_FLAT = 1e-13  # of the sum of squares left: scales that differ by less are alike
_NODES = 61  # scales within a region
_SINGULAR = 1e-7  # columns that are closer to dependent than this determine nothing
_SLOPES = np.linspace(-3.0, 3.0, 7)  # of the logarithm of the scatter, over the whole range of speeds
_PRIOR = 1.5  # standard deviation of that slope: a scatter that differs by a factor of 4.5 is not unusual


@dataclass(frozen=True, eq=False)
class Cone:
    """Coefficients that are sums of `parts` (p, m), the first `bounded` of them with weights >= 0, the others free.

    The best in a cone is the free optimum of one of its faces (Lawson and Hanson 1974), each with some parts left out.
    """

    parts: Floats
    bounded: int = 0

    @cached_property
    def faces(self) -> Flags:
        """Return which parts each face has, (f, p); one at least."""
        free = len(self.parts) - self.bounded
        bounded = np.array([*product((True, False), repeat=self.bounded)], bool).reshape(2**self.bounded, -1)
        faces = np.hstack([bounded, np.ones((len(bounded), free), bool)])
        return np.asarray(faces[faces.any(axis=1)])


class Conditional(NamedTuple):
    """The best coefficients for each of k scales: (k, m); the weighted sum of squares left, (k,), inf where the columns
    are dependent."""

    values: Floats
    left: Floats


@dataclass(frozen=True)
class Model:
    """Points and the columns that coefficients multiply: `fixed` (n, m - 1), and one that depends on the scale.

    target, weight : (n,), the latter 1/sigma. column : scales (k,) to (k, n). ends : of the scales looked for.
    """

    target: Floats
    weight: Floats
    fixed: Floats
    column: Callable[[Floats], Floats]
    ends: Interval

    @cached_property
    def grid(self) -> Floats:
        """Scales tried first."""
        return np.geomspace(*self.ends, 100)

    def basis(self, scale: Floats) -> Floats:
        """All columns for k scales, weighted: (k, n, m)."""
        fixed = np.broadcast_to(self.fixed, (scale.size, *self.fixed.shape))
        return np.asarray(np.concatenate([fixed, self.column(scale)[:, :, None]], axis=2) * self.weight[:, None])

    def solve(self, scale: Floats, cone: Cone) -> Conditional:
        """The best coefficients in a cone for each scale."""
        basis, target = self.basis(scale), self.target * self.weight
        columns = basis @ cone.parts.T
        weights, explained = _optimum(columns.transpose(0, 2, 1) @ columns, target @ columns, cone.faces)
        inside = np.isfinite(explained) & (weights[:, :, : cone.bounded] >= 0).all(axis=2)
        explained = np.where(inside, explained, -np.inf)
        best = np.arange(scale.size), np.argmax(explained, axis=1)
        values = np.where(inside[best][:, None], weights[best], 0.0) @ cone.parts
        residuals = target - (basis @ values[:, :, None])[:, :, 0]
        return Conditional(values, np.where(inside[best], np.sum(residuals**2, axis=1), np.inf))

    def covariance(self, scale: Floats, parts: Floats) -> Floats:
        """Of these coefficients for unit variance, (k, m, m)."""
        columns = self.basis(scale) @ parts.T
        size = np.linalg.norm(columns, axis=1)[:, None, :]
        inverse = np.linalg.inv(np.swapaxes(columns / size, 1, 2) @ (columns / size))
        return np.asarray(parts.T @ (inverse / (size * np.swapaxes(size, 1, 2))) @ parts)


def _optimum(normal: Floats, right: Floats, faces: Flags) -> tuple[Floats, Floats]:
    """The weights (k, f, p) that solve normal equations (k, p, p) on each face by Cholesky's factors, 0 where a part is
    left out, and how much of the sum of squares they explain, (k, f); NaN where the columns are dependent."""
    count = range(right.shape[1])
    length = np.sqrt([normal[:, i, i] for i in count])
    lower: dict[tuple[int, int], Floats] = {}
    along: list[Floats] = []
    weights: dict[int, Floats] = {}
    with np.errstate(divide="ignore", invalid="ignore"):
        for i in count:
            for j in range(i):
                rest = (normal[:, i, j] / (length[i] * length[j]))[:, None] - sum(
                    lower[i, n] * lower[j, n] for n in range(j)
                )
                lower[i, j] = np.where(faces[:, i] & faces[:, j], rest / lower[j, j], 0.0)
            pivot = np.where(length[i] > 0, 1.0, np.nan)[:, None] - sum(lower[i, n] ** 2 for n in range(i))
            lower[i, i] = np.where(faces[:, i], np.sqrt(np.where(pivot > _SINGULAR**2, pivot, np.nan)), 1.0)
            rest = (right[:, i] / length[i])[:, None] - sum(lower[i, n] * along[n] for n in range(i))
            along.append(np.where(faces[:, i], rest / lower[i, i], 0.0))
        for i in reversed(count):
            rest = along[i] - sum(lower[n, i] * weights[n] for n in count[i + 1 :])
            weights[i] = rest / lower[i, i]
        values = [np.where(faces[:, i], weights[i] / length[i][:, None], 0.0) for i in count]
    return np.stack(values, axis=2), np.sum(np.square(along), axis=0)


def bottom(left: Callable[[Floats], Floats], grid: Floats, zooms: int = _ZOOMS) -> float:
    """The scale with the smallest `left`, to rounding unless there are fewer zooms."""
    values = left(grid)
    i = int(np.argmin(values))
    low, high = (math.log(grid[min(max(i + side, 0), grid.size - 1)]) for side in (-1, 1))
    tried = np.linspace(low, high, _ACROSS)
    for _ in range(zooms):
        values = left(np.exp(tried))
        i = int(np.argmin(values))
        if not np.ptp(values) > _FLAT * values[i]:
            return float(np.exp(tried[i]))
        tried = np.linspace(tried[max(i - 1, 0)], tried[min(i + 1, _ACROSS - 1)], _ACROSS)
    return float(np.exp(tried[_ACROSS // 2]))


def within(left: Callable[[Floats], Floats], best: float, allowed: float, grid: Floats) -> Interval:
    """The outermost scales at which `left` is allowed; 0 and inf where it still is at the ends of the grid."""
    inside = np.sort(np.append(grid[left(grid) <= allowed], best))

    def end(last: float, beyond: float) -> float:
        for _ in range(4):
            tried = np.linspace(math.log(last), math.log(beyond), _ACROSS)
            outside = left(np.exp(tried)) > allowed
            i = max(int(np.argmax(outside)), 1)
            last, beyond = math.exp(tried[i - 1]), math.exp(tried[i])
        return 0.5 * (last + beyond)

    low = 0.0 if inside[0] <= grid[0] else end(inside[0], grid[np.searchsorted(grid, inside[0]) - 1])
    high = math.inf if inside[-1] >= grid[-1] else end(inside[-1], grid[np.searchsorted(grid, inside[-1], "right")])
    return float(low), float(high)


# --- what the points allow --------------------------------------------------------------------------------------------


class Weighting(NamedTuple):
    """One slope of the scatter: the model so weighted, its best scale, how much its deviance is raised, the slope."""

    model: Model
    best: float
    offset: float
    slope: float


class Region:
    """The coefficients that points allow: profile likelihood over scale and scatter.

    freedom : points to spare; inf where the deviations are known. order : (n,) over a range of 1; None: the weights are
        known. bounded : position of a coefficient that is >= 0, None for none.
    """

    def __init__(
        self, model: Model, cone: Cone, freedom: float, order: Floats | None,
        bounded: int | None = None, reach: float | None = None,
    ) -> None:  # fmt: skip
        self._cone, self._freedom, self._bounded = cone, freedom, bounded
        self._known = math.isinf(freedom)
        slopes = [0.0] if order is None else [*_SLOPES]
        self._all = [self._weighting(model, order, slope) for slope in slopes]
        rounding = 1e-26 * float(np.sum((model.target * model.weight) ** 2))
        least = [max(float(self._left(weighting)(np.array([weighting.best]))[0]), rounding) for weighting in self._all]
        self._deviance = np.array(
            [self._raised(weighting, left) for weighting, left in zip(self._all, least, strict=True)]
        )
        self._reach = reach or student(freedom)

    def _weighting(self, model: Model, order: Floats | None, slope: float) -> Weighting:
        weighted = model if order is None else replace(model, weight=np.exp(-slope * order))
        best = bottom(lambda scale: weighted.solve(scale, self._cone).left, weighted.grid, _COARSE)
        near = weighted.basis(best * np.array([1.0, 1.0 + 1e-5]))
        tangent = np.column_stack([near[0], 1e5 * (near[1] - near[0])[:, -1]])
        information = float(np.sum(np.log(np.maximum(np.linalg.svd(tangent, compute_uv=False), 1e-12))))
        offset = 2.0 * (information - float(np.sum(np.log(weighted.weight)))) + (slope / _PRIOR) ** 2
        return Weighting(weighted, best, offset, float(slope))

    def _left(self, weighting: Weighting) -> Callable[[Floats], Floats]:
        """The weighted sum of squares left, as a function of the scale."""
        return lambda scale: weighting.model.solve(scale, self._cone).left

    def _raised(self, weighting: Weighting, left: float) -> float:
        return left if self._known else weighting.offset + self._freedom * math.log(left)

    @cached_property
    def _nodes(self) -> list[tuple[Weighting, float, Interval]]:
        """The weightings that are allowed, with the sum of squares up to which coefficients are within `reach` standard
        errors, and the scales that leave less."""
        nodes, lowest, reach = [], float(self._deviance.min()), self._reach
        for weighting, deviance in zip(self._all, self._deviance, strict=True) if self._freedom > 0 else ():
            if self._known:
                allowed = lowest + reach**2
            else:
                above = self._freedom * math.log1p(reach**2 / self._freedom)
                allowed = math.exp((lowest + above - weighting.offset) / self._freedom)
            if self._raised(weighting, allowed) >= deviance:
                nodes.append(
                    (weighting, allowed, within(self._left(weighting), weighting.best, allowed, weighting.model.grid))
                )
        return nodes

    @property
    def slope(self) -> tuple[float, float]:
        """The likeliest slope of the scatter, and by how much its deviance is below that of an even one."""
        i = int(np.argmin(self._deviance))
        even = next(j for j, weighting in enumerate(self._all) if weighting.slope == 0)
        return self._all[i].slope, float(self._deviance[even] - self._deviance[i])

    @cached_property
    def scale(self) -> Interval:
        """The confidence interval of the scale; 0 or inf where it is open."""
        if not self._nodes:
            return 0.0, math.inf
        return float(min(ends[0] for *_, ends in self._nodes)), float(max(ends[1] for *_, ends in self._nodes))

    def extent(self, direction: Callable[[Floats], Floats]) -> tuple[Floats, Floats]:
        """Confidence intervals of linear combinations of the coefficients: lower and upper ends, (c,).

        direction : scales (k,) to the combinations, (k, c, m).
        """
        start = np.inf if self._nodes else -np.inf
        low, high = np.asarray(start), np.asarray(-start)
        for weighting, allowed, (first, last) in self._nodes:
            ends = max(first, weighting.model.ends[0]), min(last, weighting.model.ends[1])
            scale = np.geomspace(*ends, _NODES)
            along = direction(scale)
            cone = self._cone.parts
            low, high = _extremes(weighting.model, scale, cone, along, allowed, self._bounded, (low, high))
            if self._bounded is not None:
                face = cone[cone[:, self._bounded] == 0]
                low, high = _extremes(weighting.model, scale, face, along, allowed, None, (low, high))
        return np.asarray(low), np.asarray(high)

    def draw(self, count: int, random: np.random.Generator, among: Interval | None = None) -> tuple[Floats, Floats]:
        """Coefficients (count, m) and scales (count,) as likely as the points leave them, bounds apart.

        The scale has the profile likelihood's confidence distribution, the others are t-distributed about the best
        ones for it: in a linear problem together the multivariate t distribution. among : where the points say nothing
        of the scale, the range in which it may be, by ratio.
        """
        odds = np.exp(-0.5 * (self._deviance - self._deviance.min()))
        counts = random.multinomial(count, odds / odds.sum())
        drawn = [self._drawn(weighting, n, random, among) for weighting, n in zip(self._all, counts, strict=True) if n]
        values, scale = (np.concatenate(parts) for parts in zip(*drawn, strict=True))
        order = random.permutation(count)
        return values[order], scale[order]

    def _drawn(
        self, weighting: Weighting, count: int, random: np.random.Generator, among: Interval | None
    ) -> tuple[Floats, Floats]:
        whole = Cone(self._cone.parts)

        def free(scale: Floats) -> Floats:
            return weighting.model.solve(scale, whole).left

        best = bottom(free, weighting.model.grid)
        least = float(free(np.array([best]))[0])
        variance = 1.0 if self._known else least / self._freedom
        ends = within(free, best, least + variance * (2.0 * student(self._freedom)) ** 2, weighting.model.grid)
        low, high = max(ends[0], weighting.model.ends[0]), min(ends[1], weighting.model.ends[1])
        scale = np.unique(np.concatenate([np.geomspace(low, best, _NODES), np.geomspace(best, high, _NODES)]))
        if among is not None:
            scale = np.geomspace(*among, 2 * _NODES)
        solved = weighting.model.solve(scale, whole)
        usable = np.isfinite(solved.left)
        scale, middle, left = scale[usable], solved.values[usable], solved.left[usable]
        root = np.sqrt(np.maximum(left - least, 0.0) / max(variance, 1e-300)) * np.sign(scale - best)
        below = scipy.stats.norm.cdf(root) if self._known else scipy.stats.t.cdf(root, self._freedom)
        below = np.linspace(0.0, 1.0, scale.size) if among is not None else np.maximum.accumulate(below)
        i = np.minimum(np.searchsorted(below, random.uniform(size=count)), scale.size - 1)
        values, vectors = np.linalg.eigh(weighting.model.covariance(scale, whole.parts))
        roots = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
        normal = np.einsum("kij,kj->ki", roots[i], random.standard_normal((count, values.shape[1])))
        if not self._known:
            spare = self._freedom + 1.0
            normal *= np.sqrt(left[i] / random.chisquare(spare, count))[:, None]
        return middle[i] + normal, scale[i]


def _extremes(
    model: Model, scale: Floats, parts: Floats, along: Floats, allowed: float, bounded: int | None,
    so_far: tuple[Floats, Floats],
) -> tuple[Floats, Floats]:  # fmt: skip
    """The least and greatest combinations over the ellipsoids of coefficients that leave no more than allowed."""
    solved = model.solve(scale, Cone(parts))
    usable = solved.left <= allowed
    if not usable.any():
        return so_far
    values, along = solved.values[usable], along[usable]
    moved = np.einsum("kij,kcj->kci", model.covariance(scale[usable], parts), along)
    spread = np.einsum("kci,kci->kc", along, moved)
    step = np.sqrt((allowed - solved.left[usable])[:, None] / np.where(spread > 0, spread, np.inf))
    middle = np.einsum("kci,ki->kc", along, values)
    ends = []
    for side in (-1.0, 1.0):
        reached = middle + side * step * spread
        if bounded is not None:
            inside = values[:, None, bounded] + side * step * moved[:, :, bounded] >= 0
            reached = np.where(inside, reached, -side * np.inf)
        ends.append(reached)
    return np.minimum(so_far[0], ends[0].min(axis=0)), np.maximum(so_far[1], ends[1].max(axis=0))
