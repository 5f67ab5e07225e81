"""Friction that differs on the way down: one curve for both branches of a sweep, or a line to mu_stop.

While the slip speed falls and is below that of the minimum of the curve, friction may follow the straight line from
there to (0, mu_stop): Eq. (2a) of the article. The curve is fitted to all points but those of the line, and mu_stop to
these, for the best curve and for each of those drawn: so its interval holds what the curve leaves open. A line counts
where it leaves less than one curve through all points does (F test, 1 %), and nothing else differs: friction above the
minimum, or with the order of the points, as where it drifts or runs in.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.vocabulary.models import CURVE
from stickslip_materials.fit.curve import CurveFit
from stickslip_materials.fit.turns import SlowingLine, reversal
from stickslip_materials.fit.uncertainty import Flags, Floats, Residuals

_SHOWN, _CHANCE = 0.01, 0.002  # chance of a line where there is none, and of another difference
_ROUNDS = 4  # of fits, until the same points lie on the line
_DRAWN = 4000  # curves, of whose mu_stop the interval is quantiles


@dataclass(frozen=True)
class Sweep:
    """Points in the order of the sweep, with the direction of each, and the curve through all or a part of them."""

    speed: Floats
    mu: Floats
    sigma: Floats | None
    direction: Floats
    fitted: Callable[[Flags, bool], CurveFit]

    def fit(self) -> CurveFit:
        """One curve, with mu_stop where friction falls to it on the way down."""
        whole = self.fitted(np.ones(self.speed.size, bool), False)
        if whole.law != "stribeck":
            return whole
        curve, on_line = self._on_the_way_up(whole)
        spare = self.speed.size - len(CURVE) - 1
        if np.count_nonzero(on_line) < 2 or spare < 1:
            return self._checked(whole, whole)
        weight = self._weight(curve)
        peak = float(self.speed.max())
        line = SlowingLine(self.speed[on_line], self.mu[on_line], weight[on_line], peak, 1.0, math.inf)
        stop = float(line.stop(_row(curve))[0][0])
        left, of_whole = (self._left(model, weight) for model in (replace(curve, mu_stop=stop), whole))
        gain = (of_whole - left) if self.sigma is not None else (of_whole - left) / left * spare
        tail = scipy.stats.chi2(1) if self.sigma is not None else scipy.stats.f(1, spare)
        if not tail.sf(gain) < _SHOWN or not 0.0 <= stop <= curve.mu_start:
            return self._checked(whole, whole)
        if self.sigma is None:
            line = replace(line, variance=left / spare, freedom=float(spare))
        turned = replace(curve, mu_stop=stop, line=line, points=self.speed.size)
        drawn = turned.draw(_DRAWN, falling=True)
        ends = (0.0, math.inf) if drawn is None else tuple(np.quantile(drawn.coefficients["mu_stop"], (0.025, 0.975)))
        turned = replace(turned, interval={**curve.interval, "mu_stop": (float(ends[0]), float(ends[1]))},
                         residual_rms=float(np.sqrt(np.mean((self.mu - self._predicted(turned)) ** 2))))  # fmt: skip
        return self._checked(turned, whole)

    def _on_the_way_up(self, whole: CurveFit) -> tuple[CurveFit, Flags]:
        """The curve through what is not on the line, and the points that are on it."""
        curve, on_line = whole, np.zeros(self.speed.size, bool)
        falls, peak = self.direction < 0, float(self.speed.max())
        try:
            start = self.fitted(~falls, True)
        except ValueError:  # too few
            start = whole
        for _ in range(_ROUNDS):
            start = start if start.declines else whole
            below = falls & (self.speed < reversal(_row(start), peak)[0])
            if (below == on_line).all():
                break
            on_line, curve = below, self.fitted(~below, True)
            start = curve
        return self.fitted(~on_line, False) if on_line.any() else whole, on_line

    def _weight(self, curve: CurveFit) -> Floats:
        """1 over the standard deviation of each point, in any unit where it is not given."""
        if self.sigma is not None:
            return 1.0 / self.sigma
        place = np.log(np.maximum(self.speed, self.speed[self.speed > 0].min() / 3.0))
        return np.asarray(np.exp(-math.log(curve.scatter) * (place - place.min()) / np.ptp(place)))

    def _predicted(self, model: CurveFit) -> Floats:
        """Friction at the points."""
        on_curve = model.predict(self.speed)
        if math.isnan(model.mu_stop):
            return on_curve
        start = reversal(_row(model), float(self.speed.max()))[0]
        share = self.speed / start
        on_line = model.mu_stop + (model.predict(start) - model.mu_stop) * share
        return np.where((self.direction < 0) & (share < 1.0), on_line, on_curve)

    def _left(self, model: CurveFit, weight: Floats) -> float:
        used = np.ones(self.speed.size, bool)
        used[list(model.outliers)] = False
        return float(np.sum(((self.mu - self._predicted(model)) * weight)[used] ** 2))

    def _checked(self, model: CurveFit, whole: CurveFit) -> CurveFit:
        """The model where nothing else differs; else the curve through all points, which says what does."""
        falls = self.direction < 0
        weight = np.ones_like(self.speed) if self.sigma is None else 1.0 / self.sigma  # a shift may look like scatter
        used = np.ones(self.speed.size, bool)
        used[list(model.outliers)] = False
        left = ((self._predicted(model) - self.mu) * weight)[used]
        if used.sum() <= len(CURVE) + 2 or not np.sqrt(np.mean(left**2)) > 1e-9 * float(self.mu.max()):
            return model
        names = [*CURVE, *([] if math.isnan(model.mu_stop) else ["mu_stop"])]
        slopes = np.column_stack([self._slope(model, name) * weight for name in names])[used]
        residuals = Residuals(left, slopes, self.speed[used])
        start = reversal(_row(model), float(self.speed.max()))[0]
        lever = 1.0 - np.minimum(self.speed / start, 1.0) if start > 0 else 1.0 - self.speed / self.speed.max()
        ways = {
            "above the minimum of the curve" if start > 0 else "at all speeds": falls & (self.speed >= start),
            "at low speed, but not along a line": falls * lever,
            "and with their order, as where friction drifts or runs in": np.arange(self.speed.size)
            - self.speed.size / 2,
        }
        ways = {where: (way * weight)[used] for where, way in ways.items() if np.count_nonzero(way[used]) > 1}
        where = max(ways, key=lambda where: residuals.share_of(ways[where]))
        if residuals.chance_of(ways[where]) < _CHANCE:
            quality = f"Friction differs while the speed falls, {where}: one curve goes through all points."
            return replace(whole, good=False, quality=f"{quality} {whole.quality}")
        return model

    def _slope(self, model: CurveFit, name: str) -> Floats:
        value = getattr(model, name)
        step = 1e-5 * (abs(value) or model.mu_start)
        moved = (self._predicted(replace(model, **{name: value + sign * step})) for sign in (1.0, -1.0))
        above, below = moved
        return np.asarray((above - below) / (2.0 * step))


def _row(curve: CurveFit) -> dict[str, Floats]:
    return {name: np.array([getattr(curve, name)]) for name in CURVE}
