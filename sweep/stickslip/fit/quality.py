"""Quality of a fitted curve, in plain words: what speaks against using it, and what the points do not determine."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats  # type: ignore[import-untyped]

from stickslip.fit.models import COEFFICIENTS, FALLING, STRAIGHT, STRENGTHENING, WEAKENING, Chosen, MeasuredPoints
from stickslip.fit.uncertainty import Interval
from stickslip.vocabulary import units

_SHARE = 0.5  # of the mean friction: a coefficient that moves the curve by more, within its interval, is not known
_RATIO = 8.0  # of the ends of an interval: a3 or a4 is not determined if it is more
_CHANCE = 0.005  # of residuals as regular, where the curve has the right shape
_BETTER, _ALIKE = 6.0, 2.0  # by which the AICc of another law is lower: twenty times as likely, or hardly more
_FEW = 4  # points to spare below which a branch that is not seen may well be there
_TIMES = 2.0  # the largest friction measured: what is extrapolated beyond is not supported by any point
_STRONGEST = 2.0  # a friction coefficient at break-away; those beyond are extrapolated, or of another unit


@dataclass(frozen=True)
class Quality:
    """A fit, its points, and the sentences about them.

    points : those that were fitted; given : all of them, of which those at the positions `left_out` were not.
    interval : 95 %, by coefficient. at_bound : coefficients at the end of their range.
    criteria : AICc of the best curve of each law. unit : in which speeds are written.
    """

    chosen: Chosen
    estimates: Mapping[str, float]
    interval: Mapping[str, Interval]
    at_bound: tuple[str, ...]
    points: MeasuredPoints
    residual_rms: float
    r_squared: float
    unit: str
    criteria: Mapping[str, float]
    given: MeasuredPoints
    left_out: tuple[int, ...]

    @property
    def freedom(self) -> int:
        """Points to spare."""
        return self.points.freedom(self.chosen.form)

    def unidentified(self) -> tuple[str, ...]:
        """Coefficients that the points do not determine."""
        unknown = {*self.chosen.form.assumed}
        for name, unit in (("a1", 1.0), ("a2", float(self.points.speed.max()))):
            low, high = self.interval[name]
            moved = max(high - self.estimates[name], self.estimates[name] - low) * unit
            if not moved < _SHARE * float(self.points.mu.mean()):
                unknown.add(name)
        for name in ("a3", "a4"):
            low, high = self.interval[name]
            least, most = sorted((abs(low), abs(high)))
            if not (math.isfinite(high) and low * high > 0 and most < _RATIO * least):
                unknown.add(name)
        return tuple(name for name in COEFFICIENTS if name in unknown)

    def determined(self) -> bool:
        """True where the points tell where vibration ends."""
        if self.freedom <= 0 or self._is_extrapolated():
            return False
        if self.chosen.form is STRAIGHT:
            return self.points.freedom(WEAKENING) >= _FEW
        return self.chosen.form is not WEAKENING or (math.isfinite(self.interval["mu_start"][1]) and not self._rests())

    def reservations(self) -> Iterator[str]:
        """Sentences against using the curve; those about its shape apart."""
        if self.left_out:
            places = [f"{self.given.mu[i]:.3g} at {self._speed(float(self.given.speed[i]))}" for i in self.left_out]
            yield f"Left out as no scatter of the others: {', '.join(places)}. See what happened there."
        if self.freedom <= 0:
            yield f"{self.points.speed.size} points for four coefficients do not test the fit: measure more points."
        else:
            yield from self._branch(float(self.points.speed.min()), float(self.points.speed.max()))
        if self.chosen.seen:  # an active bound of a2 says no more than that no rise is seen
            if "a1" in self.at_bound:
                yield "a1 is at its bound, 0: beyond the points the curve is a guess."
            if "mu_start" in self.at_bound:
                yield "mu_start is at its bound, 0: the curve has no static friction."
            if "a4" in self.at_bound:
                yield f"a4 = {self._speed(self.estimates['a4'])} is at the end of the range that was searched."
        if self._is_extrapolated():
            yield f"mu_start = {self.estimates['mu_start']:.3g} is extrapolated far beyond the points."
        if self.chosen.seen and self.r_squared < 0.5:
            yield f"The curve explains only {100 * self.r_squared:.0f} % of the variance of the points."
        if slope := self.points.slope:
            yield (
                f"The points scatter about {math.exp(abs(slope)):.2g} times as much at the "
                f"{'slowest' if slope < 0 else 'fastest'} speeds as at the others, and were weighted so; "
                "a column sigma would say it better."
            )

    def _is_extrapolated(self) -> bool:
        """True where mu_start is far above all points, or implausible and none of the points has it."""
        start, most = self.estimates["mu_start"], float(self.points.mu.max())
        return start > _TIMES * most or start >= max(_STRONGEST, 1.1 * most)

    def _rests(self) -> bool:
        """True where the branch is seen by the points at the slowest speed alone."""
        points, form = self.points, self.chosen.form
        rest = points.without(tuple(np.flatnonzero(points.speed == points.speed.min()).tolist()))
        if np.unique(rest.speed).size < 3 or rest.speed.max() == 0 or not rest.mu.any():
            return True
        rest = replace(rest, slope=points.slope)
        best = rest.fit(form)
        gained = rest.gain(best, form is STRENGTHENING) * rest.left(best)
        if points.deviation is not None:
            return bool(gained < stats.chi2(2).ppf(0.95))
        variance = points.left(self.chosen.best) / max(self.freedom, 1)
        gained *= (float(rest.mu.max()) / float(points.mu.max())) ** 2
        return bool(gained < 2 * variance * stats.f(2, self.freedom).ppf(0.95))

    def _speed(self, speed: float, digits: int = 3) -> str:
        rounded = float(f"{speed / units.factor(self.unit, 'm s-1'):.{digits}g}")
        return f"{rounded:g} {self.unit}"

    # --- the branch ---------------------------------------------------------------------------------------------------

    def _branch(self, slowest: float, fastest: float) -> Iterator[str]:
        """Branches that are not seen, begin before the points, or end behind them."""
        form, a4, unknown = self.chosen.form, self.estimates["a4"], self.unidentified()
        where = f"between {self._speed(slowest)} and {self._speed(fastest)}"
        branch = "rise from zero speed" if form is STRENGTHENING else "decline"
        if form is FALLING:
            yield self._falling(slowest, fastest)
        elif form is STRAIGHT and self.points.freedom(WEAKENING) < _FEW:
            count = self.points.speed.size
            yield f"{count} points are too few to show whether friction declines {where}: measure more."
        elif form is STRAIGHT and self.points.falls():
            yield (
                f"Most points fall {where}, but none of these curves follows them: a3 and a4 mean nothing. Look for "
                "outliers, and measure more points."
            )
        elif form is STRAIGHT:
            yield (
                f"The points show no declining branch {where}, so a3 was taken as 0, and a4 means nothing; friction "
                f"below {self._speed(slowest)} was not measured. Measure at lower speed if it is known to fall."
            )
        elif slowest > a4:
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
            yield f"The points do not determine {' and '.join(unknown)}.{ends if fastest < 2 * a4 else ''}"

    def _falling(self, slowest: float, fastest: float) -> str:
        """Points that fall all the way, but do not determine four coefficients."""
        first, last = (float(self.points.mu[self.points.speed == end].mean()) for end in (slowest, fastest))
        others = [name for name in self.unidentified() if name not in self.chosen.form.assumed]
        lost = f" Neither do they determine {' and '.join(others)} singly, only the curve between." if others else ""
        a4, (low, high) = self.estimates["a4"], self.interval["a4"]
        ends = "from {} on" if math.isinf(high) else "from {} to {}"
        scale = " Of a4 they say nothing."
        if low > 0 or math.isfinite(high):
            ends = ends.format(*(self._speed(end, 2) for end in (low, high) if math.isfinite(end)))
            scale = f" With that a4 = {self._speed(a4)} may be anything {ends} (95 %)."
        missing = "higher speeds would show where the fall ends"
        if fastest > 3 * a4:
            missing = "more points would show whether it rises again"
        return (
            f"Friction falls all the way from {first:.3g} at {self._speed(slowest)} to {last:.3g} at "
            f"{self._speed(fastest)}, and the points do not determine a2, which was taken as 0 (no rise at "
            f"speed).{lost}{scale} Use the curve between these speeds; {missing}."
        )

    # --- the shape ----------------------------------------------------------------------------------------------------

    def shape(self) -> Iterator[str]:
        """Residuals that follow another curve, by themselves or by another law, or that sigma does not explain."""
        points, law = self.points, self.points.law
        residuals = points.residuals(self.chosen) if self.chosen.seen else None
        if residuals is not None:
            best = min(self.criteria, key=lambda name: self.criteria[name])
            lower = self.criteria[law] - self.criteria[best]
            is_better = math.isfinite(lower) and lower > _BETTER
            follows = residuals.chance_of_runs() < _CHANCE
            if self.freedom > 1 and self.chosen.form is not FALLING:
                follows |= residuals.chance_of(points.steepened(self.chosen.best)) < _CHANCE
            if follows or is_better:
                hint = f" {best} follows them better (AICc lower by {lower:.2g}): --law {best}." if is_better else ""
                shape = f"The points follow a curve of another shape than {law}"
                yield f"{shape}: the residuals are not those of chance.{hint}"
        chi_squared = points.left(self.chosen.best)
        if points.deviation is not None and self.freedom > 0 and stats.chi2(self.freedom).sf(chi_squared) < 1e-3:
            times = math.sqrt(chi_squared / self.freedom)
            yield f"The residuals are {times:.2g} times sigma: the points follow another curve, or sigma is too small."

    def praise(self) -> str:
        """The sentence of a good fit."""
        known, no_rise = "a1, a3 and a4", ""
        fastest = self._speed(float(self.points.speed.max()))
        if "a2" in self.at_bound:
            no_rise = f" a2 is at its bound, 0: they show no rise up to {fastest}."
        elif "a2" in self.chosen.form.nonnegative and self.interval["a2"][0] <= 0:
            no_rise = f" a2 may be 0 (95 %): a rise up to {fastest} is not certain."
        else:
            known = "all four coefficients"
        rising = " Friction rises from zero speed: a3 is negative, and there is no declining branch."
        law, limit = self.points.law, self.criteria[self.points.law] + _ALIKE
        alike = [name for name, criterion in self.criteria.items() if name != law and criterion < limit]
        others = f" {', '.join(alike)} would fit as well (AICc)." if alike else ""
        return (
            f"The curve explains {100 * self.r_squared:.3g} % of the variance of {self.points.speed.size} points, "
            f"with a residual rms of {self.residual_rms:.2g}, and they determine {known}."
            f"{no_rise}{rising if self.chosen.form is STRENGTHENING else ''}{others}"
        )
