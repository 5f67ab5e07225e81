"""Quality of a fit in plain words: what speaks against using a curve, and what the points do not determine."""

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
_BETTER, _ALIKE = 6.0, 2.0  # by which the AICc of another law is lower: twenty times as likely, or hardly more
_FEW = 4  # points to spare below which a branch that is not seen may well be there
_STRONGEST = 2.0  # friction at break-away, and its ratio to the largest measured: more is extrapolated

SENTENCES = {
    # of a curve
    "left out": "Left out as no scatter of the others: {points}. See what happened there.",
    "few": "{count} points do not test the fit of four coefficients: measure more points.",
    "no branch": "The points show no declining branch between {slowest} and {fastest}: a3 was taken as 0, and a4 means "
    "nothing. Measure at lower speed if friction is known to fall.",
    "falling": "Friction falls all the way from {first:.3g} at {slowest} to {last:.3g} at {fastest}, and the points do "
    "not determine a2, which was taken as 0: measure at higher speed, or more points.",
    "extrapolated": "mu_start = {start:.3g} is extrapolated: the points, from {slowest} on, see little of the branch. "
    "Measure at lower speed.",
    "open": "The points do not determine {names}.",
    "bound": "{name} is at its bound, {value:.3g}: beyond the points the curve is a guess.",
    "little": "The curve explains only {share:.0f} % of the variance of the points.",
    "uneven": "The points scatter {times:.2g} times as much at the {where} speeds as at the others, and were weighted "
    "so; a column sigma would say it better.",
    "shape": "The points follow a curve of another shape than {law}: the residuals are not those of chance.",
    "other law": "{law} follows them better (AICc lower by {lower:.2g}): --law {law}.",
    "sigma": "The residuals are {times:.2g} times sigma: the points follow another curve, or sigma is too small.",
    "good": "The curve explains {share:.3g} % of the variance of {count} points, with a residual rms of {rms:.2g}, "
    "and they determine {known}.",
    "rising": "Friction rises from zero speed: a3 is negative, and there is no declining branch.",
    "no rise": "a2 may be 0 (95 %): a rise up to {fastest} is not certain.",
    "mu_stop": "While the speed falls, friction follows a line to mu_stop = {stop:.3g} (95 %: {low:.3g} to "
    "{high:.3g}).",
    "branches": "Friction differs while the speed falls, {where}: no mu_stop was fitted, and one curve to all points.",
    # of ageing
    "no ageing": "The points show no ageing: the slope may be anything from {low:.2g} to {high:.2g} per decade.",
    "proportional": "As far as measured, static friction grows in proportion to time (t0 above {least:.2g} s): beta "
    "and t0 cannot be distinguished. Measure at longer waiting times.",
    "grows": "Static friction grows by {beta:.3g} per decade of waiting time; residual rms {rms:.2g}.",
    "t0": "The waiting times, of {shortest:.3g} s and more, do not determine t0: taken as {t0:.3g} s.",
    # of contacts with memory
    "record": "The contact explains {share:.3g} % of the variance of the record, with a residual rms of {rms:.2g}.",
    "record other": "What is left is no scatter: it is another law, another stiffness of the drive, or a drift.",
    "record open": "The record does not determine {names}: sample more often where the speed changes, or take steps of "
    "other sizes.",
}


def say(code: str, **values: object) -> str:
    """One of the sentences with these values."""
    return SENTENCES[code].format(**values)


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
        fit, form, slowest = self.fit, self.chosen.form, self._speed(self.fit.speeds[0])
        if fit.outliers:
            places = (f"{self.given.mu[i]:.3g} at {self._speed(float(self.given.speed[i]))}" for i in fit.outliers)
            yield say("left out", points=", ".join(places))
        if self.freedom <= 0 or form is STRAIGHT and self.points.freedom(WEAKENING) < _FEW:
            yield say("few", count=fit.points)
        elif form is STRAIGHT:
            yield say("no branch", slowest=slowest, fastest=self._speed(fit.speeds[1]))
        elif form is FALLING:
            first, last = (float(self.points.mu[self.points.speed == end].mean()) for end in fit.speeds)
            fastest = self._speed(fit.speeds[1])
            yield say("falling", first=first, slowest=slowest, last=last, fastest=fastest)
        elif self._is_far() or fit.speeds[0] > fit.a4 or fit.speeds[0] > 0 and self._rests():
            yield say("extrapolated", start=fit.mu_start, slowest=slowest)
        if self.chosen.seen and (unknown := [name for name in self.unidentified() if name not in fit.assumed]):
            yield say("open", names=" and ".join(unknown))
        if self.chosen.seen:  # an active bound of a2 says no more than that no rise is seen
            bounds = [name for name in ("a1", BREAKAWAY, "a4") if name in fit.at_bound]
            yield from (say("bound", name=name, value=getattr(fit, name)) for name in bounds)
        if self.chosen.seen and fit.r_squared < 0.5:
            yield say("little", share=100 * fit.r_squared)
        if slope := self.points.slope:
            yield say("uneven", times=math.exp(abs(slope)), where="slowest" if slope < 0 else "fastest")

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
                hint = f" {say('other law', law=best, lower=lower)}" if is_better else ""
                yield say("shape", law=law) + hint
        chi_squared = points.left(self.chosen.best)
        if points.deviation is not None and self.freedom > 0 and scipy.stats.chi2(self.freedom).sf(chi_squared) < 1e-3:
            yield say("sigma", times=math.sqrt(chi_squared / self.freedom))

    def praise(self) -> str:
        """The sentences of a good fit."""
        fit, limit = self.fit, self.criterion(self.points.law) + _ALIKE
        is_open = self.chosen.form is not STRENGTHENING and fit.interval["a2"][0] <= 0
        known = "a1, a3 and a4" if is_open else "all four coefficients"
        sentences = [say("good", share=100 * fit.r_squared, count=fit.points, rms=fit.residual_rms, known=known)]
        sentences += [say("no rise", fastest=self._speed(fit.speeds[1]))] if is_open else []
        sentences += [say("rising")] if self.chosen.form is STRENGTHENING else []
        alike = [law for law in CURVE_LAWS if law != self.points.law and self.criterion(law) < limit]
        return " ".join([*sentences, *([f"{', '.join(alike)} would fit as well (AICc)."] if alike else [])])
