"""Quality of a fitted curve: what speaks against using it, and what the points do not determine."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.vocabulary import units
from stickslip.vocabulary.models import BREAKAWAY, CURVE, CURVE_LAWS
from stickslip_materials.fit.curve import CurveFit
from stickslip_materials.fit.models import FALLING, STRAIGHT, STRENGTHENING, WEAKENING, Chosen, MeasuredPoints
from stickslip_materials.fit.uncertainty import CONFIDENCE

_SHARE = 0.5  # of the mean friction: a coefficient that moves the curve by more, within its interval, is not known
_RATIO = 8.0  # of the ends of an interval: a3 or a4 is not determined if it is more
_CHANCE = 0.005  # of residuals as regular, where the curve has the right shape
_BETTER = 6.0  # by which the AICc of another law is lower: twenty times as likely
_FEW = 4  # points to spare below which a branch that is not seen may well be there
_STRONGEST = 2.0  # friction at break-away, and its ratio to the largest measured: more is extrapolated
LEAST_EXPLAINED = 0.5  # share of the variance


@dataclass(frozen=True)
class Quality:
    """A fitted curve whose quality is not judged yet, its points, and the sentences about them.

    fit : with the intervals of a curve of the right shape. points : those that were fitted; given : all of them.
    criterion : AICc of the best curve of a law. unit : in which speeds are written.
    """

    fit: CurveFit
    chosen: Chosen
    points: MeasuredPoints
    given: MeasuredPoints
    criterion: Callable[[str], float]
    unit: str

    @property
    def freedom(self) -> int:
        """Points to spare."""
        return self.points.freedom(self.chosen.form)

    def unidentified(self) -> tuple[str, ...]:
        """Coefficients that the points do not determine."""
        unknown = {*self.fit.assumed}
        for name, unit in (("a1", 1.0), ("a2", float(self.points.speed.max()))):
            (low, high), value = self.fit.interval[name], getattr(self.fit, name)
            if not max(high - value, value - low) * unit < _SHARE * float(self.points.mu.mean()):
                unknown.add(name)
        for name in ("a3", "a4"):
            low, high = self.fit.interval[name]
            least, most = sorted((abs(low), abs(high)))
            if not (math.isfinite(high) and low * high > 0 and most < _RATIO * least):
                unknown.add(name)
        return tuple(name for name in CURVE if name in unknown)

    def determined(self) -> bool:
        """True where the points tell where vibration ends."""
        if self.freedom <= 0 or self._is_far():
            return False
        if self.chosen.form is STRAIGHT:
            return self.points.freedom(WEAKENING) >= _FEW
        has_end = math.isfinite(self.fit.interval[BREAKAWAY][1])
        return self.chosen.form is not WEAKENING or (has_end and not self._rests())

    def reservations(self) -> Iterator[str]:
        """Sentences against using the curve; those about its shape apart."""
        fit, form = self.fit, self.chosen.form
        slowest, fastest = map(self._speed, fit.speeds)
        if fit.outliers:
            places = (f"{self.given.mu[i]:.3g} at {self._speed(float(self.given.speed[i]))}" for i in fit.outliers)
            yield f"Left out as no scatter of the others: {', '.join(places)}."
        if self.freedom <= 0 or form is STRAIGHT and self.points.freedom(WEAKENING) < _FEW:
            yield f"{fit.points} points do not test the fit of four coefficients: measure more points."
        elif form is STRAIGHT:
            yield f"No declining branch between {slowest} and {fastest}: a3 was taken as 0. Measure at lower speed."
        elif form is FALLING:
            yield f"Friction falls from {slowest} to {fastest}: a2 was taken as 0. Measure at higher speed."
        elif self._is_far() or fit.speeds[0] > fit.a4 or fit.speeds[0] > 0 and self._rests():
            yield f"mu_start = {fit.mu_start:.3g} is extrapolated from {slowest}. Measure at lower speed."
        if not self.chosen.seen:
            return
        if unknown := [name for name in self.unidentified() if name not in fit.assumed]:
            yield f"The points do not determine {' and '.join(unknown)}."
        if bounds := [name for name in ("a1", BREAKAWAY, "a4") if name in fit.at_bound]:  # a2: no rise is seen
            yield f"At its bound, beyond which the curve is a guess: {' and '.join(bounds)}."
        if fit.r_squared < LEAST_EXPLAINED:
            yield f"The curve explains only {100 * fit.r_squared:.0f} % of the variance of the points."
        if slope := self.points.slope:
            where = "slowest" if slope < 0 else "fastest"
            yield f"The points scatter {math.exp(abs(slope)):.2g} times as much at the {where} speeds."

    def _is_far(self) -> bool:
        """True where mu_start is far above all points, or implausible and none of the points has it."""
        start, most = self.fit.mu_start, float(self.points.mu.max())
        return start > _STRONGEST * most or start >= max(_STRONGEST, 1.1 * most)

    def _rests(self) -> bool:
        """True where the branch is seen by the points at the slowest speed alone."""
        points = self.points
        rest = points.without(tuple(np.flatnonzero(points.speed == points.speed.min()).tolist()))
        return np.unique(rest.speed).size < 3 or not (rest.mu.any() and rest.shows_branch(self.chosen.form, CONFIDENCE))

    def _speed(self, speed: float) -> str:
        rounded = float(f"{speed / units.factor(self.unit, 'm s-1'):.3g}")
        return f"{rounded:g} {self.unit}"

    def shape(self) -> Iterator[str]:
        """Residuals that follow another curve, by themselves or by another law, or that sigma does not explain."""
        points, law = self.points, self.points.law
        residuals = points.residuals(self.chosen) if self.chosen.seen else None
        if residuals is not None:
            best = min(CURVE_LAWS, key=self.criterion)
            lower = self.criterion(law) - self.criterion(best)
            is_better = math.isfinite(lower) and lower > _BETTER
            follows = residuals.chance_of_runs() < _CHANCE
            if self.freedom > 1 and self.chosen.form is not FALLING:
                follows |= residuals.chance_of(points.steepened(self.chosen.best)) < _CHANCE
            if follows or is_better:
                hint = f", such as {best} (AICc lower by {lower:.2g})" if is_better else ""
                yield f"The points follow a curve of another shape than {law}{hint}."
        chi_squared = points.left(self.chosen.best)
        if points.deviation is not None and self.freedom > 0 and scipy.stats.chi2(self.freedom).sf(chi_squared) < 1e-3:
            yield f"The residuals are {math.sqrt(chi_squared / self.freedom):.2g} times sigma."

    def praise(self) -> str:
        """Of a good fit: what is known, a2 where it is certain to be a rise."""
        is_open = self.chosen.form is not STRENGTHENING and self.fit.interval["a2"][0] <= 0
        return f"The points determine {'a1, a3 and a4' if is_open else 'all four coefficients'}."
