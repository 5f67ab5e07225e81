"""Sweeps of speed that turn: what was measured while the speed rose or fell, by order or as a column says, and the
points of the line that friction follows on the way down."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.theory import reversal_speed, stribeck
from stickslip.vocabulary.models import CURVE
from stickslip_materials.fit.uncertainty import Floats
from stickslip_materials.fit.words import plain

_BACK = 0.25  # of all points that the speed passes again before it has turned; less is the scatter of a step
_APART = 1.05  # ratio of speeds that differ by more than the scatter of a step
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
    n = speed.size
    legs = _legs(speed)
    direction = np.zeros(n)
    in_legs: dict[float, int] = {1.0: 0, -1.0: 0}
    for i, (begin, end, way) in enumerate(legs):
        first = begin + (i > 0)
        if end - begin == 1 and i + 1 < len(legs):
            way = legs[i + 1][2]  # a jump, back to where the next leg begins
        direction[first : end + 1] = way
        if way > 0 and i and legs[i - 1][2] < 0:  # of what is as slow as the turn the first half belongs to the fall
            slow = speed <= _APART * speed[begin]
            after = begin + int(np.argmin(slow[begin:]))
            before = begin - int(np.argmin(slow[begin::-1]))
            direction[(before + after + 2) // 2 : after] = way
            direction[before + 1 : (before + after + 2) // 2] = -way
        steps = np.sign(np.diff(speed[begin : end + 1]))
        if end - begin + 1 >= _LEG and np.sum(steps == way) >= 3 * np.sum(steps == -way):
            in_legs[way] += end + 1 - first
    return direction if min(in_legs.values()) and sum(in_legs.values()) >= _MOST * n else None


def _legs(speed: Floats) -> list[tuple[int, int, float]]:
    """First and last point of each stretch between turns, and its direction."""
    rank = scipy.stats.rankdata(speed) / speed.size
    legs, begin, low, high, way = [], 0, 0, 0, 0.0

    def apart(i: int, k: int) -> bool:
        return bool(rank[k] - rank[i] >= _BACK and speed[k] > _APART * speed[i])

    for i in range(speed.size):
        low, high = (i if rank[i] <= rank[low] else low), (i if rank[i] >= rank[high] else high)
        if way >= 0 and apart(i, high):
            if way:
                legs.append((begin, high, way))
            begin, low, way = (high if way else begin), i, -1.0
            high = i
        elif way <= 0 and apart(low, i):
            if way:
                legs.append((begin, low, way))
            begin, high, way = (low if way else begin), i, 1.0
            low = i
    return [*legs, (begin, speed.size - 1, way)]


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
        scatter = random.standard_normal(best.size)
        if math.isfinite(self.freedom):
            scatter = random.standard_t(self.freedom, best.size)
        drawn = best + math.sqrt(self.variance) * spread * scatter
        most = curves[CURVE.level] + curves[CURVE.drop]
        return np.asarray(np.clip(np.where(np.isfinite(drawn), drawn, most), 0.0, most))


def reversal(curves: Mapping[str, Floats], peak: float) -> Floats:
    """The speed at which the line of each curve begins; 0 for one that does not fall first."""
    slope, drop, decay = (np.asarray(curves[name]) for name in CURVE[1:])
    return np.atleast_1d(np.minimum(np.nan_to_num(reversal_speed(slope, drop, decay), nan=0.0, posinf=peak), peak))
