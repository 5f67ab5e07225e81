"""The quality of a fitted curve, in plain words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import stats  # type: ignore[import-untyped]

from stickslip.fit.allowed import Chosen, MeasuredPoints, falls
from stickslip.fit.forms import COEFFICIENTS, FALLING, STRAIGHT, STRENGTHENING, WEAKENING
from stickslip.fit.uncertainty import Floats, Interval, rms
from stickslip.vocabulary import units

_SHARE = 0.5  # of the mean friction: a coefficient that moves the curve by more, within its interval, is not known
_RATIO = 8.0  # of the ends of an interval: a3 or a4 is not determined if it is more
_CHANCE = 0.005  # of residuals as regular, where the curve has the right shape
_BETTER, _ALIKE = 6.0, 2.0  # by which the AICc of another law is lower: twenty times as likely, or hardly more
_FEW = 4  # points to spare below which a branch that is not seen may well be there
_TIMES = 2.0  # the largest friction measured: what is extrapolated beyond is not supported by any point
_STRONGEST = 2.0  # a friction coefficient at break-away; those beyond are extrapolated, or of another unit


@dataclass(frozen=True)
class Verdict:
    """A fit and what is known of it.

    points : those that were fitted; given : all of them, of which those at the positions `left_out` were not.
    interval : 95 %, by coefficient. at_bound : coefficients at the end of their range. freedom : points to spare.
    criteria : AICc of the best curve of each law. unit : in which speeds are written.
    """

    chosen: Chosen
    estimates: Mapping[str, float]
    interval: Mapping[str, Interval]
    at_bound: tuple[str, ...]
    points: MeasuredPoints
    rest: Floats
    r_squared: float
    freedom: int
    unit: str
    criteria: Mapping[str, float]
    given: MeasuredPoints
    left_out: tuple[int, ...]

    def unidentified(self) -> tuple[str, ...]:
        """Coefficients that the points do not determine."""
        allowed = _SHARE * float(self.points.mu.mean())
        reach = {
            name: max(high - self.estimates[name], self.estimates[name] - low)
            for name, (low, high) in self.interval.items()
        }
        effect = {"a1": reach["a1"], "a2": reach["a2"] * float(self.points.speed.max())}
        unknown = {name for name, moved in effect.items() if not moved < allowed}
        for name in ("a3", "a4"):
            low, high = self.interval[name]
            if not (
                math.isfinite(high) and low * high > 0 and max(abs(low), abs(high)) < _RATIO * min(abs(low), abs(high))
            ):
                unknown.add(name)
        return tuple(name for name in COEFFICIENTS if name in {*unknown, *self.chosen.form.assumed})

    def determined(self) -> bool:
        """Whether the points tell where vibration ends."""
        if self.freedom <= 0 or self._beyond():
            return False
        if self.chosen.form is STRAIGHT:
            return self.points.freedom(WEAKENING) >= _FEW
        return self.chosen.form is not WEAKENING or (math.isfinite(self.interval["mu_start"][1]) and not self._rests())

    def findings(self) -> Iterator[str]:
        """What speaks against using the curve."""
        slowest, fastest = float(self.points.speed.min()), float(self.points.speed.max())
        form = self.chosen.form
        yield from self._outliers()
        if self.freedom <= 0:
            yield f"{self.points.speed.size} points for four coefficients do not test the fit: measure more points."
        elif form is FALLING:
            yield self._falling(slowest, fastest)
        elif form is STRAIGHT:
            yield self._unseen(slowest, fastest)
        else:
            yield from self._undetermined(slowest, fastest)
        yield from self._bounds()
        if self._beyond():
            yield f"mu_start = {self.estimates['mu_start']:.3g} is extrapolated far beyond the points."
        if self.chosen.seen and self.r_squared < 0.5:
            yield f"The curve explains only {100 * self.r_squared:.0f} % of the variance of the points."
        yield from self._uneven()

    def _beyond(self) -> bool:
        """Whether mu_start is far above all points, or implausible and none of the points has it."""
        start, most = self.estimates["mu_start"], float(self.points.mu.max())
        return start > _TIMES * most or start >= max(_STRONGEST, 1.1 * most)

    # --- the points ---------------------------------------------------------------------------------------------------

    def _outliers(self) -> Iterator[str]:
        """Points that were left out."""
        if self.left_out:
            places = [f"{self.given.mu[i]:.3g} at {self._speed(float(self.given.speed[i]))}" for i in self.left_out]
            yield (f"Left out as no scatter of the others: {', '.join(places)}. See what happened there.")

    def _uneven(self) -> Iterator[str]:
        """A scatter that differs along the speed."""
        if self.points.slope:
            times = math.exp(abs(self.points.slope))
            end = "slowest" if self.points.slope < 0 else "fastest"
            yield (
                f"The points scatter about {times:.2g} times as much at the {end} speeds as at the others, and were "
                "weighted so; a column sigma would say it better."
            )

    def _rests(self) -> bool:
        """Whether the branch is seen by the points at the slowest speed alone."""
        slowest = np.flatnonzero(self.points.speed == self.points.speed.min())
        rest = self.points.without(tuple(slowest.tolist()))
        if np.unique(rest.speed).size < 3 or rest.speed.max() == 0 or not rest.mu.any():
            return True
        variance = self.points.scaled.left(self.chosen.best) / max(self.freedom, 1)
        scaled = MeasuredPoints(rest.speed, rest.mu, rest.deviation, rest.law, self.points.slope).scaled
        best = scaled.fit(self.chosen.form)
        gained = scaled.gain(best, self.chosen.form is STRENGTHENING) * scaled.left(best)
        gained *= (float(rest.mu.max()) / float(self.points.mu.max())) ** 2 if self.points.deviation is None else 1.0
        level = (
            stats.chi2(2).ppf(0.95)
            if self.points.deviation is not None
            else 2 * variance * stats.f(2, self.freedom).ppf(0.95)
        )
        return bool(gained < level)

    # --- the branch ---------------------------------------------------------------------------------------------------

    def _falling(self, slowest: float, fastest: float) -> str:
        """Points that fall all the way, but do not determine four coefficients."""
        speed, mu = self.points.speed, self.points.mu
        first, last = (float(mu[speed == end].mean()) for end in (slowest, fastest))
        others = [name for name in self.unidentified() if name not in self.chosen.form.assumed]
        lost = f" Neither do they determine {' and '.join(others)} singly, only the curve between." if others else ""
        over = fastest > 3 * self.estimates["a4"]
        missing = (
            "more points would show whether it rises again" if over else "higher speeds would show where the fall ends"
        )
        return (
            f"Friction falls all the way from {first:.3g} at {self._speed(slowest)} to {last:.3g} at "
            f"{self._speed(fastest)}, and the points do not determine a2, which was taken as 0 (no rise at "
            f"speed).{lost}{self._scale()} Use the curve between these speeds; {missing}."
        )

    def _speed(self, speed: float, digits: int = 3) -> str:
        """A speed in m/s, with its unit."""
        rounded = float(f"{speed / units.factor(self.unit, 'm s-1'):.{digits}g}")
        return f"{rounded:g} {self.unit}"

    def _scale(self) -> str:
        """How far a4 is known, where four coefficients are too many."""
        low, high = self.interval["a4"]
        if low == 0 and math.isinf(high):
            return " Of a4 they say nothing."
        ends = (
            f"from {self._speed(low, 2)} on"
            if math.isinf(high)
            else f"from {self._speed(low, 2)} to {self._speed(high, 2)}"
        )
        return f" With that a4 = {self._speed(self.estimates['a4'])} may be anything {ends} (95 %)."

    def _unseen(self, slowest: float, fastest: float) -> str:
        """Points without a declining branch, or too few to tell."""
        where = f"between {self._speed(slowest)} and {self._speed(fastest)}"
        if self.points.freedom(WEAKENING) < _FEW:
            return (
                f"{self.points.speed.size} points are too few to show whether friction declines {where}: measure more."
            )
        if falls(self.points.speed, self.points.mu):
            return (
                f"Most points fall {where}, but none of these curves follows them: a3 and a4 mean nothing. Look for "
                "outliers, and measure more points."
            )
        return (
            f"The points show no declining branch {where}, so a3 was taken as 0, and a4 means nothing; friction below "
            f"{self._speed(slowest)} was not measured. Measure at lower speed if it is known to fall."
        )

    def _undetermined(self, slowest: float, fastest: float) -> Iterator[str]:
        """Branches that begin before the points, or end behind them."""
        a4, unknown = self.estimates["a4"], self.unidentified()
        branch = "rise from zero speed" if self.chosen.form is STRENGTHENING else "decline"
        if slowest > a4:
            yield (
                f"The slowest point, at {self._speed(slowest)}, is {slowest / a4:.3g} times a4: the {branch} is over "
                f"before the points begin, and mu_start = {self.estimates['mu_start']:.3g} is extrapolated. Measure at "
                "lower speed."
            )
        elif slowest > 0 and self._rests():
            yield (
                f"The {branch} is seen by the slowest point alone, {self._speed(slowest)}: of mu_start and a4 that "
                "says little. Measure more points there, and at lower speed."
            )
        elif unknown:
            ends = f" The {branch} does not end before {self._speed(fastest)}: measure at higher speed."
            beyond = ends if fastest < 2 * a4 else ""
            yield f"The points do not determine {' and '.join(unknown)}.{beyond}"

    def _bounds(self) -> Iterator[str]:
        """Active bounds. That of a2 says no more than that no rise is seen."""
        if not self.chosen.seen:
            return
        if "a1" in self.at_bound:
            yield "a1 is at its bound, 0: beyond the points the curve is a guess."
        if "mu_start" in self.at_bound:
            yield "mu_start is at its bound, 0: the curve has no static friction."
        if "a4" in self.at_bound:
            yield f"a4 = {self._speed(self.estimates['a4'])} is at the end of the range that was searched."

    # --- the shape ----------------------------------------------------------------------------------------------------

    def _better(self) -> tuple[str, float]:
        """The law of the lowest AICc, and by how much it is lower."""
        best = min(self.criteria, key=lambda name: self.criteria[name])
        lower = self.criteria[self.points.law] - self.criteria[best]
        return best, lower if math.isfinite(lower) else 0.0

    def shape(self) -> Iterator[str]:
        """Residuals that follow another curve, by themselves or by another law."""
        residuals = self.points.residuals(self.chosen) if self.chosen.seen else None
        if residuals is None:
            return
        best, lower = self._better()
        law = f" {best} follows them better (AICc lower by {lower:.2g}): --law {best}." if lower > _BETTER else ""
        follows = residuals.chance_of_runs() < _CHANCE
        if self.freedom > 1 and self.chosen.form is not FALLING:
            follows |= residuals.chance_of(self.points.scaled.steepened(self.chosen.best)) < _CHANCE
        if follows or law:
            shape = f"The points follow a curve of another shape than {self.points.law}"
            yield f"{shape}: the residuals are not those of chance.{law}"

    def praise(self) -> str:
        """The sentence of a good fit."""
        known, no_rise = "all four coefficients", ""
        if "a2" in self.at_bound:
            known = "a1, a3 and a4"
            no_rise = f" a2 is at its bound, 0: they show no rise up to {self._speed(float(self.points.speed.max()))}."
        elif "a2" in self.chosen.form.nonnegative and self.interval["a2"][0] <= 0:
            known = "a1, a3 and a4"
            no_rise = f" a2 may be 0 (95 %): a rise up to {self._speed(float(self.points.speed.max()))} is not certain."
        own = self.criteria[self.points.law] + _ALIKE
        alike = [name for name, one in self.criteria.items() if name != self.points.law and one < own]
        others = f" {', '.join(alike)} would fit as well (AICc)." if alike else ""
        rising = " Friction rises from zero speed: a3 is negative, and there is no declining branch."
        return (
            f"The curve explains {100 * self.r_squared:.3g} % of the variance of {self.points.speed.size} points, "
            f"with a residual rms of {rms(self.rest):.2g}, and they determine {known}."
            f"{no_rise}{rising if self.chosen.form is STRENGTHENING else ''}{others}"
        )


def excess(chi_squared: float, freedom: int) -> Iterator[str]:
    """Residuals that the standard deviations given do not explain, in fewer than one of a thousand samples."""
    if freedom > 0 and stats.chi2(freedom).sf(chi_squared) < 1e-3:
        times = math.sqrt(chi_squared / freedom)
        yield f"The residuals are {times:.2g} times sigma: the points follow another curve, or sigma is too small."
