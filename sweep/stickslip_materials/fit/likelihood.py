"""Least squares where one coefficient is a scale and the model is linear in all others, and what the points leave open.

Stribeck curves are linear in all coefficients for a given decay speed, and ageing is in mu0 and beta for a given t0: so
what is left, as a function of the scale, is a linear problem (variable projection, Golub and Pereyra 1973), with
coefficients that may have to be >= 0. Intervals are those of MINOS (James and Roos 1975), along the profile likelihood
of any linear combination. Where the scale is flat and MINOS finds no end, it is that over all scales tried.
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
_CALLS = 500  # of the sum of squares, in a search of Minuit and on either side of MINOS
_RIDGE = 1e-15  # for columns that are one
_ROUNDING = 1e-7  # of the target: as near as the best scale is found


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Points, and a model of which coefficients (m,) are sums of `parts` (p, m).

    target, weight : (n,), the latter 1/sigma. columns : of k scales, (k, n, m). ends : of the scales looked for.
    bounded : how many of the parts, the first ones, have weights >= 0. freedom : points to spare; inf where the
    deviations are known. reach : standard errors to either side of an interval.
    """

    target: Floats
    weight: Floats
    columns: Callable[[Floats], Floats]
    ends: Interval
    parts: Floats
    bounded: int
    freedom: float
    reach: float

    @cached_property
    def grid(self) -> Floats:
        """Logarithms of scales tried first."""
        return np.linspace(math.log(self.ends[0]), math.log(self.ends[1]), _GRID)

    def solve(self, u: float, along: Floats | None = None, value: float = 0.0) -> tuple[Floats, float]:
        """The best coefficients for a scale exp(u), and the weighted sum of squares they leave; of those whose
        combination `along` has this value."""
        columns = (self.columns(np.array([math.exp(u)]))[0] * self.weight[:, None]) @ self.parts.T
        target, bounded, parts, offset = self.target * self.weight, self.bounded, self.parts, 0.0
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

    @cached_property
    def _on_grid(self) -> Floats:
        """What is left at the scales tried first."""
        return np.array([self.solve(u)[1] for u in self.grid.tolist()])

    @cached_property
    def scale(self) -> float:
        """The logarithm of the best scale."""
        i = int(np.argmin(self._on_grid))
        bounds = float(self.grid[max(i - 1, 0)]), float(self.grid[min(i + 1, _GRID - 1)])
        search = scipy.optimize.minimize_scalar(
            lambda u: self.solve(u)[1], bounds=bounds, method="bounded", options={"xatol": 1e-10}
        )
        return float(search.x) if search.fun < self._on_grid[i] else float(self.grid[i])

    # --- intervals ----------------------------------------------------------------------------------------------------

    @cached_property
    def _least(self) -> float:
        return self.solve(self.scale)[1]

    @cached_property
    def _allowed(self) -> float:
        """By how much more is left within an interval; inf without points to spare."""
        if math.isinf(self.freedom):
            return self.reach**2
        return self._least * self.reach**2 / self.freedom if self.freedom > 0 else math.inf

    @cached_property
    def _is_exact(self) -> bool:
        """True where nothing but rounding is left."""
        return self._least <= _ROUNDING**2 * float(np.sum((self.target * self.weight) ** 2))

    @cached_property
    def scale_interval(self) -> Interval:
        """The interval of the scale; 0 and inf where it is open."""
        if self._is_exact:
            return math.exp(self.scale), math.exp(self.scale)
        inside = np.flatnonzero(self._on_grid <= self._least + self._allowed)
        if inside.size and inside[0] == 0 and inside[-1] == _GRID - 1:
            return 0.0, math.inf
        low, high = self._minos(lambda u: self.solve(u)[1], u=self.scale)
        if inside.size:  # another valley; one that reaches the end of the scales is open there
            low = -math.inf if inside[0] == 0 else min(low, float(self.grid[inside[0]]))
            high = math.inf if inside[-1] == _GRID - 1 else max(high, float(self.grid[inside[-1]]))
        return math.exp(low), math.exp(high)

    def _minos(self, left: Callable[..., float], **start: float) -> Interval:
        """The ends of the interval of the first of these, by what is left; -inf and inf where MINOS finds none."""
        search = Minuit(lambda *at: left(*at) / self._allowed, *start.values(), name=[*start])
        search.limits["u"], search.errors["u"] = (self.grid[0], self.grid[-1]), 0.05
        if "value" in start:
            search.errors["value"] = 0.01 * abs(start["value"]) or 1e-3
        search.migrad(ncall=_CALLS, iterate=2)
        name, lowest = next(iter(start)), self._least / self._allowed
        search.errordef = max(1.0 + lowest - search.fval, 1e-12)  # lower where a bound was left out
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
        row = along(math.exp(self.scale))
        value = float(row @ self.solve(self.scale)[0])
        if self._is_exact:
            return value, value
        own = [i < self.bounded and bool(np.linalg.matrix_rank(np.array([part, row])) == 1)
               for i, part in enumerate(self.parts)]  # fmt: skip
        free = replace(self, parts=self.parts[np.argsort(own, kind="stable")], bounded=self.bounded - sum(own))
        ends = self._minos(lambda value, u: free.solve(u, along(math.exp(u)), value)[1], value=value, u=self.scale)
        if not np.isfinite(ends).all():
            ends = tuple(np.where(np.isfinite(ends), ends, self._envelope(along)).tolist())
        return ends

    def _envelope(self, along: Callable[[float], Floats]) -> Interval:
        """The ends over the scales tried first, bounds left out: where the scale is flat, and MINOS lost."""
        low, high, most = math.inf, -math.inf, self._least + self._allowed
        for u in self.grid[self._on_grid <= most].tolist():
            values, left = self.solve(u)
            columns, row = self.columns(np.array([math.exp(u)]))[0] * self.weight[:, None], along(math.exp(u))
            reach = math.sqrt(most - left) * float(np.linalg.norm(row @ np.linalg.pinv(columns)))
            low, high = min(low, float(row @ values) - reach), max(high, float(row @ values) + reach)
        return (low, high) if low < high else (-math.inf, math.inf)

    # --- draws --------------------------------------------------------------------------------------------------------

    def draw(self, count: int, random: np.random.Generator, among: Interval | None = None) -> tuple[Floats, Floats]:
        """Coefficients (count, m) and scales (count,) as likely as the points leave them, bounds apart.

        The scale has the profile likelihood's confidence distribution, the others are t-distributed about the best
        ones for it: nearly the multivariate t distribution of a linear problem, of one degree of freedom less, since
        the scatter may be uneven. among : where the points say nothing of the scale, the range in which it may be, by
        ratio.
        """
        known, free = math.isinf(self.freedom), replace(self, parts=np.eye(self.parts.shape[1]), bounded=0)
        variance = 1.0 if known else max(free._least, 1e-300) / self.freedom
        near = np.flatnonzero(free._on_grid <= free._least + variance * (2.0 * student(self.freedom)) ** 2)
        above = np.searchsorted(self.grid, free.scale)
        first, last = min([*near - 1, above - 1, _GRID - 1]), max([*near + 1, above])
        u = np.linspace(self.grid[max(first, 0)], self.grid[min(last, _GRID - 1)], _NODES)
        u = np.unique(np.append(u, free.scale)) if among is None else np.log(np.geomspace(*among, _NODES))
        columns, target = self.columns(np.exp(u)) * self.weight[:, None], self.target * self.weight
        size = np.maximum(np.linalg.norm(columns, axis=1)[:, None, :], 1e-300)
        q, r = np.linalg.qr(columns / size)
        usable = np.abs(np.diagonal(r, axis1=1, axis2=2)).min(axis=1) > 1e-7
        u, q, r, size = u[usable], q[usable], r[usable], size[usable, 0]
        along = np.einsum("knm,n->km", q, target)
        left = np.sum((target - np.einsum("knm,km->kn", q, along)) ** 2, axis=1)
        root = np.sqrt(np.maximum(left - left.min(), 0.0) / variance) * np.sign(u - u[np.argmin(left)])
        below = scipy.stats.norm.cdf(root) if known else scipy.stats.t.cdf(root, self.freedom)
        below = np.linspace(0.0, 1.0, u.size) if among is not None else np.maximum.accumulate(below)
        i = np.minimum(np.searchsorted(below, random.uniform(size=count)), u.size - 1)
        scatter = random.standard_normal((count, along.shape[1]))
        if not known:
            scatter *= np.sqrt(left[i] / random.chisquare(self.freedom, count))[:, None]
        values = np.linalg.solve(r[i], (along[i] + scatter)[:, :, None])[:, :, 0]
        return values / size[i], np.exp(u[i])
