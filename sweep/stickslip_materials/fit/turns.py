"""Sweeps of speed that turn: what was measured while the speed rose or fell, by order or as a column says, and friction
that differs on the way down.

While the slip speed falls and is below that of the minimum of the curve, friction may follow the straight line from
there to (0, mu_stop): Eq. (2a) of the article.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.theory import reversal_speed, stribeck
from stickslip.vocabulary.models import CURVE
from stickslip_materials.fit.curve import CurveFit, MeasuredPoints
from stickslip_materials.fit.uncertainty import TAILS, Flags, Floats, chance_of, rms
from stickslip_materials.fit.words import plain

_BACK = 0.25  # of all points that the speed passes again before it has turned; less is the scatter of a step
_SHOWN, _CHANCE = 0.01, 0.002  # chance of a line where there is none, and of another difference
_ROUNDS = 4  # of fits, until the same points lie on the line
_DRAWN = 4000  # curves, of whose mu_stop the interval is quantiles
_LEG, _MOST = 4, 0.75  # points of a leg, and the share of all points in legs: a sweep, and no points in any order
_WORDS = {
    1.0: "up upward upwards rising increasing increase accelerating forward forwards hin hinauf hinweg auf aufwarts "
    "hoch steigend vor vorwarts aller montee montant croissant + +1 ↑ →",
    -1.0: "down downward downwards falling decreasing decrease decelerating backward backwards back return her herab "
    "runter ruckweg ab abwarts fallend zuruck ruckwarts retour descente descendant decroissant - − -1 −1 ↓ ←",
}  # fmt: skip
_SIGNS = {word: sign for sign, words in _WORDS.items() for word in words.split()}


def course(speed: Floats) -> Floats | None:
    """1 for points of a sweep that were measured while the speed rose, -1 while it fell; None where it did not turn,
    or where the points are in no such order."""
    from scipy.signal import find_peaks  # type: ignore[import-untyped]

    rank, n = scipy.stats.rankdata(speed) / speed.size, speed.size
    tops = find_peaks(rank, prominence=_BACK, plateau_size=0)[1]["right_edges"]
    turns = [0, *sorted([*tops, *find_peaks(-rank, prominence=_BACK)[0]]), n - 1]
    direction = np.zeros(n)
    for begin, end in pairwise(turns):
        way, steps = np.sign(rank[end] - rank[begin]), np.sign(np.diff(speed[begin : end + 1]))
        if end - begin + 1 >= _LEG and np.sum(steps == way) >= 3 * np.sum(steps == -way):
            direction[begin + (begin > 0) : end + 1] = way
    is_sweep = {1.0, -1.0} <= {*direction.tolist()} and np.count_nonzero(direction) >= _MOST * n
    return direction if is_sweep else None


def directions(texts: Sequence[str], speed: Floats) -> Floats:
    """As `course`, from what a column says of each point: a direction, or else the number or name of a ramp."""
    known = [next((_SIGNS[w] for w in (text, *re.split(r"[\s()/\d]+", plain(text))) if w in _SIGNS), 0.0)
             for text in (text.strip() for text in texts)]  # fmt: skip
    if {*known} != {0.0} and {*texts} != {"1"}:
        return np.array(known)
    names = np.array(texts)
    ramps = {name: np.diff(speed[names == name]) for name in {*texts}}
    ways = {name: float(np.sign(np.sum(np.sign(steps)))) for name, steps in ramps.items()}
    return np.array([ways[name] for name in texts])


def branch_of(name: str) -> tuple[str, float]:
    """A name without the word for a direction, and that direction; 0 where it has none."""
    words = name.split()
    signs = [_SIGNS.get(plain(word.strip("()[],;:")), 0.0) for word in words]
    sign = next((sign for sign in signs if sign), 0.0)
    return " ".join(word for word, own in zip(words, signs, strict=True) if not own), sign


@dataclass(frozen=True)
class SlowingLine:
    """Points measured below the minimum of a curve while the speed fell.

    speed, mu, weight : (n,). peak : from which the speed fell. variance : of a point of weight 1; freedom : with which
    that is known.
    """

    speed: Floats
    mu: Floats
    weight: Floats
    peak: float
    variance: float
    freedom: float

    def stop(self, curves: Mapping[str, Floats]) -> tuple[Floats, Floats]:
        """The best mu_stop for each of these curves, and its standard deviation over that of a point."""
        start = reversal(curves, self.peak)
        share = np.minimum(self.speed / np.maximum(start, 1e-300)[:, None], 1.0)
        lever = (1.0 - share) * self.weight
        level = stribeck(start, *(curves[name] for name in CURVE))[:, None]
        square = np.sum(lever**2, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            best = np.sum(lever * (self.mu - share * level) * self.weight, axis=1) / square
            return best, 1.0 / np.sqrt(square)

    def draw(self, curves: Mapping[str, Floats], random: np.random.Generator) -> Floats:
        """A mu_stop for each of these curves, as likely as the points leave it; that of break-away at most."""
        best, spread = self.stop(curves)
        known = math.isinf(self.freedom)
        scatter = random.standard_normal(best.size) if known else random.standard_t(self.freedom, best.size)
        drawn = best + math.sqrt(self.variance) * spread * scatter
        most = curves[CURVE.level] + curves[CURVE.drop]
        return np.asarray(np.clip(np.where(np.isfinite(drawn), drawn, most), 0.0, most))


def reversal(curves: Mapping[str, Floats], peak: float) -> Floats:
    """The speed at which the line of each curve begins; 0 for one that does not fall first."""
    slope, drop, decay = (np.asarray(curves[name]) for name in CURVE[1:])
    return np.atleast_1d(np.minimum(np.nan_to_num(reversal_speed(slope, drop, decay), nan=0.0, posinf=peak), peak))


@dataclass(frozen=True)
class Sweep:
    """Points in the order of the sweep, with the direction of each, and the curve through all or a part of them."""

    speed: Floats
    mu: Floats
    sigma: Floats | None
    direction: Floats
    fitted: Callable[[Flags, bool], CurveFit]

    def fit(self) -> CurveFit:
        """One curve, with mu_stop where friction falls to it on the way down.

        The curve is fitted to all points but those of the line, and mu_stop to these, for the best curve and for each
        of those drawn: so its interval holds what the curve leaves open. A line counts where it leaves less than one
        curve through all points does (F test, 1 %), and nothing else differs: friction above the minimum, or with the
        order of the points, as where it drifts or runs in.
        """
        whole = self.fitted(np.ones(self.speed.size, bool), False)
        if whole.law != "stribeck":
            return whole
        curve, on_line = self._on_the_way_up(whole)
        spare = self.speed.size - len(CURVE) - 1
        if np.count_nonzero(on_line) < 2 or spare < 1:
            return self._checked(whole, whole)
        weight = self._weight
        line = SlowingLine(self.speed[on_line], self.mu[on_line], weight[on_line], self._peak, 1.0, math.inf)
        stop = float(line.stop(curve.row())[0][0])
        left, of_whole = (self._left(model) for model in (replace(curve, mu_stop=stop), whole))
        gain = (of_whole - left) if self.sigma is not None else (of_whole - left) / left * spare
        tail = scipy.stats.chi2(1) if self.sigma is not None else scipy.stats.f(1, spare)
        if not tail.sf(gain) < _SHOWN or not 0.0 <= stop <= curve.mu_start:
            return self._checked(whole, whole)
        if self.sigma is None:
            line = replace(line, variance=left / spare, freedom=float(spare))
        turned = replace(curve, mu_stop=stop, line=line, points=self.speed.size)
        drawn = turned.draw(_DRAWN, falling=True)
        low, high = (0.0, math.inf) if drawn is None else np.quantile(drawn.coefficients["mu_stop"], TAILS)
        turned = replace(turned, interval={**curve.interval, "mu_stop": (float(low), float(high))},
                         residual_rms=rms(self.mu - self._predicted(turned)))  # fmt: skip
        return self._checked(turned, whole)

    @property
    def _peak(self) -> float:
        return float(self.speed.max())

    @property
    def _weight(self) -> Floats:
        return np.ones_like(self.speed) if self.sigma is None else 1.0 / self.sigma

    def _on_the_way_up(self, whole: CurveFit) -> tuple[CurveFit, Flags]:
        """The curve through what is not on the line, and the points that are on it."""
        on_line = np.zeros(self.speed.size, bool)
        falls = self.direction < 0
        try:
            start = self.fitted(~falls, True)
        except ValueError:  # too few
            start = whole
        for _ in range(_ROUNDS):
            below = falls & (self.speed < reversal((start if start.declines else whole).row(), self._peak)[0])
            if (below == on_line).all():
                break
            on_line, start = below, self.fitted(~below, True)
        return self.fitted(~on_line, False) if on_line.any() else whole, on_line

    def _predicted(self, model: CurveFit) -> Floats:
        """Friction at the points."""
        on_curve = model.predict(self.speed)
        if math.isnan(model.mu_stop):
            return on_curve
        start = reversal(model.row(), self._peak)[0]
        share = self.speed / start
        on_line = model.mu_stop + (model.predict(start) - model.mu_stop) * share
        return np.where((self.direction < 0) & (share < 1.0), on_line, on_curve)

    def _left(self, model: CurveFit) -> float:
        return float(np.sum(((self.mu - self._predicted(model)) * self._weight)[self._used(model)] ** 2))

    def _used(self, model: CurveFit) -> Flags:
        return ~np.isin(np.arange(self.speed.size), model.outliers)

    def _checked(self, model: CurveFit, whole: CurveFit) -> CurveFit:
        """The model where nothing else differs; else the curve through all points, which says that something does."""
        used, left = self._used(model), self._predicted(model) - self.mu
        if used.sum() <= len(CURVE) + 2 or not rms(left[used]) > 1e-9 * float(self.mu.max()):
            return model
        points, falls = MeasuredPoints(self.speed, self.mu, self.sigma, model.law), self.direction < 0
        start = reversal(model.row(), self._peak)[0] or self._peak
        lever = falls * (1.0 - np.minimum(self.speed / start, 1.0))
        on_line = lever * (not math.isnan(model.mu_stop))
        curve = points.jacobian(np.array([*model.row().values()])[:, 0] / points.units) * (on_line == 0)[:, None]
        followed = np.column_stack([curve, on_line * points.weight])
        ways = np.column_stack([falls & (lever == 0), lever, np.arange(left.size) - 0.5 * left.size])
        weight = points.weight[:, None]
        if chance_of((left * weight[:, 0])[used], followed[used], (ways * weight)[used]) >= _CHANCE:
            return model
        quality = "Friction differs while the speed falls, or drifts with the order of the points, by more than a line "
        quality += f"to mu_stop: one curve goes through all points. {whole.quality}"
        return replace(whole, good=False, quality=quality)
