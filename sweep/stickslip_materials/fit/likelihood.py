"""Least squares where one coefficient is a scale and the model is linear in all others, and what the points leave open.

Stribeck curves are linear in all coefficients for a given decay speed, and ageing is in mu0 and beta for a given t0: so
what is left, as a function of the scale, is a linear problem (variable projection, Golub and Pereyra 1973), with
coefficients that may have to be >= 0. Intervals are those of MINOS (James and Roos 1975), along the profile likelihood
of any linear combination. Where the scale is flat and MINOS finds no end, it is that over all scales tried.

Without standard deviations the scatter is taken to be sigma exp(s z), z the logarithm of the speed over its range; s is
free as well, by the restricted likelihood, since a wrong weighting makes intervals too narrow. How far it may be from
0 is limited by a normal prior: few points say nothing about it.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy  # type: ignore[import-untyped]
from iminuit import Minuit  # type: ignore[import-untyped]

from stickslip_materials.fit.uncertainty import Floats, Interval, student

_GRID, _NODES = 60, 160  # scales tried first; those of draws
_CALLS = 500  # of the likelihood, in a search of Minuit and on either side of MINOS
_RIDGE = 1e-15  # for columns that are one
_PRIOR, _MOST = 1.5, 5.0  # standard deviation of s: a factor of 4.5 is not unusual; its bound
_ROUNDING = 1e-7  # of the target: as near as the best scale is found
_SLOPES = np.linspace(-3.0, 3.0, 13)  # of draws


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Points, and a model of which coefficients (m,) are sums of `parts` (p, m).

    target, weight : (n,), the latter 1/sigma. columns : of k scales, (k, n, m). ends : of the scales looked for.
    bounded : how many of the parts, the first ones, have weights >= 0. freedom : points to spare; inf where the
    deviations are known. reach : standard errors to either side of an interval. order : (n,) over a range of 1, along
    which the scatter may differ; None where the weights are known.
    """

    target: Floats
    weight: Floats
    columns: Callable[[Floats], Floats]
    ends: Interval
    parts: Floats
    bounded: int
    freedom: float
    reach: float
    order: Floats | None = None

    @cached_property
    def grid(self) -> Floats:
        """Logarithms of scales tried first."""
        return np.linspace(math.log(self.ends[0]), math.log(self.ends[1]), _GRID)

    def solve(self, u: float, s: float = 0.0, along: Floats | None = None, value: float = 0.0) -> tuple[Floats, float]:
        """The best coefficients for a scale exp(u) and a scatter of slope s, and the weighted sum of squares they
        leave; of those whose combination `along` has this value."""
        weight = self._weight(s)
        columns = (self.columns(np.array([math.exp(u)]))[0] * weight[:, None]) @ self.parts.T
        target, bounded, parts, offset = self.target * weight, self.bounded, self.parts, 0.0
        if along is not None:  # one of the parts, whose bound is left out, makes up for the others
            row = parts @ along
            i = int(np.argmax(np.abs(row)))
            share = np.delete(row, i) / row[i]
            target = target - columns[:, i] * (value / row[i])
            columns = np.delete(columns, i, axis=1) - columns[:, i, None] * share
            offset, parts = parts[i] * (value / row[i]), np.delete(parts, i, axis=0) - share[:, None] * parts[i]
            bounded -= i < bounded
        size = np.sqrt(np.einsum("nm,nm->m", columns, columns)) + 1e-300
        columns = columns / size
        shares = np.linalg.solve(columns.T @ columns + _RIDGE * np.eye(size.size), columns.T @ target)
        if (shares[:bounded] < 0).any():
            both, _ = scipy.optimize.nnls(np.column_stack([columns, -columns[:, bounded:]]), target)
            shares = both[: size.size]
            shares[bounded:] -= both[size.size :]
        left = columns @ shares - target
        return (shares / size) @ parts + offset, float(left @ left)

    def _weight(self, s: float) -> Floats:
        return self.weight if self.order is None else self.weight * np.exp(-s * self.order)

    def _on_grid(self, s: float) -> Floats:
        """What is left at the scales tried first."""
        target = self.target * self._weight(s)
        columns = (self.columns(np.exp(self.grid)) * self._weight(s)[:, None]) @ self.parts.T
        columns /= np.linalg.norm(columns, axis=1)[:, None, :] + 1e-300
        turned = columns.transpose(0, 2, 1)
        shares = np.linalg.solve(turned @ columns + _RIDGE * np.eye(len(self.parts)), (turned @ target)[:, :, None])
        left = np.sum(((columns @ shares)[:, :, 0] - target) ** 2, axis=1)
        outside = np.flatnonzero((shares[:, : self.bounded] < 0).any(axis=(1, 2)))
        left[outside] = [self.solve(float(self.grid[i]), s)[1] for i in outside]
        return np.asarray(left)

    @cached_property
    def scale(self) -> float:
        """The logarithm of the best scale, of an even scatter."""
        return self._lowest(0.0)

    def _lowest(self, s: float) -> float:
        values = self._on_grid(s)
        i = int(np.argmin(values))
        bounds = float(self.grid[max(i - 1, 0)]), float(self.grid[min(i + 1, _GRID - 1)])
        search = scipy.optimize.minimize_scalar(
            lambda u: self.solve(u, s)[1], bounds=bounds, method="bounded", options={"xatol": 1e-10}
        )
        return float(search.x) if search.fun < values[i] else float(self.grid[i])

    # --- likelihood ---------------------------------------------------------------------------------------------------

    @cached_property
    def _tangent(self) -> Floats:
        """What the coefficients and the scale can follow about the best of an even scatter."""
        step = 1e-5
        near, moved = self.columns(np.exp(self.scale + np.array([0.0, step])))
        tangent = np.column_stack([near, (moved - near) @ np.ones(near.shape[1]) / step])
        return np.asarray(tangent / np.maximum(np.linalg.norm(tangent, axis=0), 1e-300))

    @cached_property
    def _rounding(self) -> float:
        return _ROUNDING**2 * float(np.sum((self.target * self.weight) ** 2))

    def deviance(self, u: float, s: float = 0.0) -> float:
        """-2 ln of the likelihood, restricted where the scatter is not known."""
        return self._of(self.solve(u, s)[1], s)

    def _of(self, left: float, s: float) -> float:
        """The deviance of a sum of squares."""
        if math.isinf(self.freedom):
            return left
        lost = 0.0
        if self.order is not None:
            tangent = self._tangent * np.exp(-s * self.order)[:, None]
            values = np.maximum(np.linalg.svd(tangent, compute_uv=False), math.sqrt(_RIDGE))
            lost = 2.0 * float(np.sum(np.log(values)))
        return self.freedom * math.log(left + self._rounding) + lost + (s / _PRIOR) ** 2

    def _search(self, cost: Callable[..., float], allowed: float, **start: float) -> Minuit:
        """Minuit at the lowest cost of u, s and perhaps a combination (value)."""
        search = Minuit(cost, **start)
        search.errordef = max(allowed, 1e-12)
        search.limits["u"], search.limits["s"] = (self.grid[0], self.grid[-1]), (-_MOST, _MOST)
        search.errors["u"], search.errors["s"] = 0.05, 0.2
        if "value" in start:
            search.errors["value"] = 0.01 * abs(start["value"]) or 1e-3
        search.fixed["s"] = self.order is None
        return search.migrad(ncall=_CALLS, iterate=2)

    @cached_property
    def _is_exact(self) -> bool:
        """True where nothing but rounding is left."""
        return self.solve(self.scale)[1] <= self._rounding

    @cached_property
    def best(self) -> tuple[float, float, float]:
        """The likeliest u and s, and their deviance."""
        even = self.scale, 0.0, self.deviance(self.scale)
        if self.order is None or self._is_exact:
            return even
        u, s = self._search(self.deviance, 1.0, u=self.scale, s=0.0).values
        low = self.deviance(u, s)
        return (float(u), float(s), low) if low < even[2] else even

    @property
    def allowed(self) -> float:
        """By how much the deviance of what lies within an interval is higher than the least."""
        if math.isinf(self.freedom):
            return self.reach**2
        return self.freedom * math.log1p(self.reach**2 / self.freedom) if self.freedom > 0 else math.inf

    @cached_property
    def scale_interval(self) -> Interval:
        """The interval of the scale; 0 and inf where it is open."""
        u, s, least = self.best
        if self._is_exact:
            return math.exp(u), math.exp(u)
        values = np.array([self._of(float(left), s) for left in self._on_grid(s)])
        inside = np.flatnonzero(values <= least + self.allowed)
        if inside.size and inside[0] == 0 and inside[-1] == _GRID - 1:
            return 0.0, math.inf
        low, high = self._minos(self._search(self.deviance, self.allowed, u=u, s=s), "u", least)
        if inside.size:  # another valley; one that reaches the end of the scales is open there
            low = -math.inf if inside[0] == 0 else min(low, float(self.grid[inside[0]]))
            high = math.inf if inside[-1] == _GRID - 1 else max(high, float(self.grid[inside[-1]]))
        return math.exp(low), math.exp(high)

    def _minos(self, search: Minuit, name: str, least: float) -> Interval:
        """The ends of an interval; -inf and inf where MINOS finds none."""
        search.errordef = max(self.allowed + least - search.fval, 1e-12)  # of a bound that was left out
        try:
            search.minos(name, ncall=_CALLS)
        except (RuntimeError, np.linalg.LinAlgError):
            return -math.inf, math.inf
        errors, value = search.merrors[name], search.values[name]
        low = value + errors.lower if errors.lower_valid else -math.inf
        return low, value + errors.upper if errors.upper_valid else math.inf

    def interval(self, along: Callable[[float], Floats]) -> Interval:
        """The interval of a combination (m,) of the coefficients, which may depend on the scale; its ends are infinite
        where they are open. What is bounded itself is looked for beyond its bound too: its interval is to be cut there.
        """
        u, s, least = self.best
        row = along(math.exp(u))
        value = float(row @ self.solve(u, s)[0])
        if self._is_exact:
            return value, value
        own = [i < self.bounded and bool(np.linalg.matrix_rank(np.array([part, row])) == 1)
               for i, part in enumerate(self.parts)]  # fmt: skip
        free = replace(self, parts=self.parts[np.argsort(own, kind="stable")], bounded=self.bounded - sum(own))

        def cost(value: float, u: float, s: float) -> float:
            return self._of(free.solve(u, s, along(math.exp(u)), value)[1], s)

        low, high = self._minos(self._search(cost, self.allowed, value=value, u=u, s=s), "value", least)
        if math.isinf(low) or math.isinf(high):
            first, last = self._envelope(along, s, least + self.allowed)
            low, high = first if math.isinf(low) else low, last if math.isinf(high) else high
        return low, high

    def _envelope(self, along: Callable[[float], Floats], s: float, allowed: float) -> Interval:
        """The ends over the scales tried first, bounds left out: where the scale is flat, and MINOS lost."""
        most = allowed if math.isinf(self.freedom) else math.exp((allowed - self._of(1.0, s)) / self.freedom)
        low, high = math.inf, -math.inf
        for u in self.grid.tolist():
            values, left = self.solve(u, s)
            if left <= most:
                columns, row = self.columns(np.array([math.exp(u)]))[0] * self._weight(s)[:, None], along(math.exp(u))
                reach = math.sqrt(most - left) * float(np.linalg.norm(row @ np.linalg.pinv(columns)))
                low, high = min(low, float(row @ values) - reach), max(high, float(row @ values) + reach)
        return (low, high) if low < high else (-math.inf, math.inf)

    # --- draws --------------------------------------------------------------------------------------------------------

    def draw(self, count: int, random: np.random.Generator, among: Interval | None = None) -> tuple[Floats, Floats]:
        """Coefficients (count, m) and scales (count,) as likely as the points leave them, bounds apart.

        The scale has the profile likelihood's confidence distribution, the others are t-distributed about the best
        ones for it: in a linear problem together the multivariate t distribution. among : where the points say nothing
        of the scale, the range in which it may be, by ratio.
        """
        slopes = _SLOPES if self.order is not None else np.zeros(1)
        free = replace(self, parts=np.eye(self.parts.shape[1]), bounded=0)
        deviance = np.array([self.deviance(self.best[0], float(s)) for s in slopes])
        least = deviance.min()  # -inf where all points lie on a curve
        odds = np.exp(-0.5 * (deviance - least)) if math.isfinite(least) else 1.0 * (deviance == least)
        counts = random.multinomial(count, odds / odds.sum())
        drawn = [free._drawn(float(s), n, random, among) for s, n in zip(slopes, counts, strict=True) if n]
        values, scale = (np.concatenate(parts) for parts in zip(*drawn, strict=True))
        order = random.permutation(count)
        return values[order], scale[order]

    def _drawn(
        self, s: float, count: int, random: np.random.Generator, among: Interval | None
    ) -> tuple[Floats, Floats]:
        """As `draw`, of one s."""
        known = math.isinf(self.freedom)
        best = self._lowest(s)
        least = self.solve(best, s)[1]
        variance = 1.0 if known else max(least, 1e-300) / self.freedom
        inside = np.flatnonzero(self._on_grid(s) <= least + variance * (2.0 * student(self.freedom)) ** 2)
        above = np.searchsorted(self.grid, best)
        first, last = min([*inside - 1, above - 1, _GRID - 1]), max([*inside + 1, above])
        u = np.linspace(self.grid[max(first, 0)], self.grid[min(last, _GRID - 1)], _NODES)
        u = np.unique(np.append(u, best)) if among is None else np.log(np.geomspace(*among, _NODES))
        weight = self._weight(s)
        columns = self.columns(np.exp(u)) * weight[:, None]
        size = np.maximum(np.linalg.norm(columns, axis=1)[:, None, :], 1e-300)
        q, r = np.linalg.qr(columns / size)
        usable = np.abs(np.diagonal(r, axis1=1, axis2=2)).min(axis=1) > 1e-7
        u, q, r, size = u[usable], q[usable], r[usable], size[usable, 0]
        target = self.target * weight
        along = np.einsum("knm,n->km", q, target)
        left = np.sum((target - np.einsum("knm,km->kn", q, along)) ** 2, axis=1)
        root = np.sqrt(np.maximum(left - left.min(), 0.0) / variance) * np.sign(u - u[np.argmin(left)])
        below = scipy.stats.norm.cdf(root) if known else scipy.stats.t.cdf(root, self.freedom)
        below = np.linspace(0.0, 1.0, u.size) if among is not None else np.maximum.accumulate(below)
        i = np.minimum(np.searchsorted(below, random.uniform(size=count)), u.size - 1)
        scatter = random.standard_normal((count, along.shape[1]))
        if not known:
            scatter *= np.sqrt(left[i] / random.chisquare(self.freedom + 1.0, count))[:, None]
        values = np.linalg.solve(r[i], (along[i] + scatter)[:, :, None])[:, :, 0]
        return values / size[i], np.exp(u[i])
