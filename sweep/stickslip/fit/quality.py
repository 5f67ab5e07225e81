"""Quality of a fitted curve, in plain words: what speaks against using it, and what the points do not determine."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy  # type: ignore[import-untyped]

from stickslip.fit.curve import CurveFit
from stickslip.fit.models import FALLING, STRAIGHT, STRENGTHENING, WEAKENING, Chosen, MeasuredPoints
from stickslip.vocabulary import units
from stickslip.vocabulary.models import CURVE, CURVE_LAWS

_SHARE = 0.5  # of the mean friction: a coefficient that moves the curve by more, within its interval, is not known
_RATIO = 8.0  # of the ends of an interval: a3 or a4 is not determined if it is more
_CHANCE = 0.005  # of residuals as regular, where the curve has the right shape
_BETTER, _ALIKE = 6.0, 2.0  # by which the AICc of another law is lower: twenty times as likely, or hardly more
_FEW = 4  # points to spare below which a branch that is not seen may well be there
_TIMES = 2.0  # the largest friction measured: what is extrapolated beyond is not supported by any point
_STRONGEST = 2.0  # a friction coefficient at break-away; those beyond are extrapolated, or of another unit

SENTENCES = {
    # against using a curve
    "left out": "Left out as no scatter of the others: {points}. See what happened there.",
    "no test": "{count} points for four coefficients do not test the fit: measure more points.",
    "few": "{count} points are too few to show whether friction declines {where}: measure more.",
    "not followed": "Most points fall {where}, but none of these curves follows them: a3 and a4 mean nothing. Look for "
    "outliers, and measure more points.",
    "no branch": "The points show no declining branch {where}, so a3 was taken as 0, and a4 means nothing; friction "
    "below {slowest} was not measured. Measure at lower speed if it is known to fall.",
    "over": "The slowest point, at {slowest}, is {times:.3g} times a4: the {branch} is over before the points begin, "
    "and mu_start = {start:.3g} is extrapolated. Measure at lower speed.",
    "one point": "The {branch} is seen by the slowest point alone, {slowest}: of mu_start and a4 that says little. "
    "Measure more points there, and at lower speed.",
    "open": "The points do not determine {names}.",
    "no end": "The {branch} does not end before {fastest}: measure at higher speed.",
    "falling": "Friction falls all the way from {first:.3g} at {slowest} to {last:.3g} at {fastest}, and the points do "
    "not determine a2, which was taken as 0 (no rise at speed).{lost}{scale} Use the curve between these speeds; "
    "{missing}.",
    "a1 at bound": "a1 is at its bound, 0: beyond the points the curve is a guess.",
    "mu_start at bound": "mu_start is at its bound, 0: the curve has no static friction.",
    "a4 at bound": "a4 = {a4} is at the end of the range that was searched.",
    "extrapolated": "mu_start = {start:.3g} is extrapolated far beyond the points.",
    "explains little": "The curve explains only {share:.0f} % of the variance of the points.",
    "uneven": "The points scatter about {times:.2g} times as much at the {where} speeds as at the others, and were "
    "weighted so; a column sigma would say it better.",
    "other shape": "The points follow a curve of another shape than {law}: the residuals are not those of chance.",
    "other law": "{law} follows them better (AICc lower by {lower:.2g}): --law {law}.",
    "sigma": "The residuals are {times:.2g} times sigma: the points follow another curve, or sigma is too small.",
    # for it
    "good": "The curve explains {share:.3g} % of the variance of {count} points, with a residual rms of {rms:.2g}, and "
    "they determine {known}.",
    "no rise": "a2 is at its bound, 0: they show no rise up to {fastest}.",
    "perhaps no rise": "a2 may be 0 (95 %): a rise up to {fastest} is not certain.",
    "rising": "Friction rises from zero speed: a3 is negative, and there is no declining branch.",
    "alike": "{laws} would fit as well (AICc).",
    # of the way down
    "mu_stop": "While the speed falls, friction follows a line to mu_stop = {stop:.3g} (95 %: {low:.3g} to "
    "{high:.3g}).",
    "branches": "Friction differs while the speed falls, {where}: no mu_stop was fitted, and one curve goes through "
    "all points.",
    # of ageing
    "no ageing": "Static friction falls with waiting time: this is not ageing.",
    "any slope": "The points show no ageing: the slope may be anything from {low:.2g} to {high:.2g} per decade.",
    "growth explains little": "The growth explains only {share:.0f} % of the variance of the points.",
    "proportional": "As far as measured, static friction grows in proportion to time (t0 above {least:.2g} s): beta "
    "and t0 cannot be distinguished. Measure at longer waiting times.",
    "grows": "Static friction grows by {beta:.3g} per decade of waiting time; residual rms {rms:.2g}.",
    "t0 taken": "t0 is taken as {t0:.3g} s.",
    # of contacts with memory
    "record": "The contact explains {share:.3g} % of the variance of the record, with a residual rms of {rms:.2g}.",
    "record other": "What is left is no scatter: it is another law, another stiffness of the drive, or a drift.",
    "record open": "The record does not determine {names}: sample more often where the speed changes, or take steps of "
    "other sizes.",
    "t0 open": "The waiting times, of {shortest:.3g} s and more, do not determine t0 ({others} fits as well): taken as "
    "{t0:.3g} s.",
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
        if self.freedom <= 0 or self._is_extrapolated():
            return False
        if self.chosen.form is STRAIGHT:
            return self.points.freedom(WEAKENING) >= _FEW
        has_end = math.isfinite(self.fit.interval["mu_start"][1])
        return self.chosen.form is not WEAKENING or (has_end and not self._rests())

    def reservations(self) -> Iterator[str]:
        """Sentences against using the curve; those about its shape apart."""
        fit = self.fit
        if fit.outliers:
            places = (f"{self.given.mu[i]:.3g} at {self._speed(float(self.given.speed[i]))}" for i in fit.outliers)
            yield say("left out", points=", ".join(places))
        if self.freedom <= 0:
            yield say("no test", count=fit.points)
        else:
            yield from self._branch()
        if self.chosen.seen:  # an active bound of a2 says no more than that no rise is seen
            for name in ("a1", "mu_start", "a4"):
                if name in fit.at_bound:
                    yield say(f"{name} at bound", a4=self._speed(fit.a4))
        if self._is_extrapolated():
            yield say("extrapolated", start=fit.mu_start)
        if self.chosen.seen and fit.r_squared < 0.5:
            yield say("explains little", share=100 * fit.r_squared)
        if slope := self.points.slope:
            yield say("uneven", times=math.exp(abs(slope)), where="slowest" if slope < 0 else "fastest")

    def _is_extrapolated(self) -> bool:
        """True where mu_start is far above all points, or implausible and none of the points has it."""
        start, most = self.fit.mu_start, float(self.points.mu.max())
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
            return bool(gained < scipy.stats.chi2(2).ppf(0.95))
        variance = points.left(self.chosen.best) / max(self.freedom, 1)
        gained *= (float(rest.mu.max()) / float(points.mu.max())) ** 2
        return bool(gained < 2 * variance * scipy.stats.f(2, self.freedom).ppf(0.95))

    def _speed(self, speed: float, digits: int = 3) -> str:
        rounded = float(f"{speed / units.factor(self.unit, 'm s-1'):.{digits}g}")
        return f"{rounded:g} {self.unit}"

    # --- the branch ---------------------------------------------------------------------------------------------------

    def _branch(self) -> Iterator[str]:
        """Branches that are not seen, begin before the points, or end behind them."""
        form, fit, (slow, fast) = self.chosen.form, self.fit, self.fit.speeds
        slowest, fastest = self._speed(slow), self._speed(fast)
        where = f"between {slowest} and {fastest}"
        branch = "rise from zero speed" if form is STRENGTHENING else "decline"
        if form is FALLING:
            yield self._falling()
        elif form is STRAIGHT and self.points.freedom(WEAKENING) < _FEW:
            yield say("few", count=fit.points, where=where)
        elif form is STRAIGHT:
            yield say("not followed" if self.points.falls() else "no branch", where=where, slowest=slowest)
        elif slow > fit.a4:
            yield say("over", slowest=slowest, times=slow / fit.a4, branch=branch, start=fit.mu_start)
        elif slow > 0 and self._rests():
            yield say("one point", branch=branch, slowest=slowest)
        elif unknown := self.unidentified():
            yield say("open", names=" and ".join(unknown))
            if fast < 2 * fit.a4:
                yield say("no end", branch=branch, fastest=fastest)

    def _falling(self) -> str:
        """Points that fall all the way, but do not determine four coefficients."""
        fit, (slowest, fastest) = self.fit, self.fit.speeds
        first, last = (float(self.points.mu[self.points.speed == end].mean()) for end in fit.speeds)
        others = [name for name in self.unidentified() if name not in fit.assumed]
        lost = f" Neither do they determine {' and '.join(others)} singly, only the curve between." if others else ""
        low, high = fit.interval["a4"]
        scale = " Of a4 they say nothing."
        if low > 0 or math.isfinite(high):
            ends = "from {} on" if math.isinf(high) else "from {} to {}"
            ends = ends.format(*(self._speed(end, 2) for end in (low, high) if math.isfinite(end)))
            scale = f" With that a4 = {self._speed(fit.a4)} may be anything {ends} (95 %)."
        missing = "higher speeds would show where the fall ends"
        if fastest > 3 * fit.a4:
            missing = "more points would show whether it rises again"
        return say("falling", first=first, slowest=self._speed(slowest), last=last, fastest=self._speed(fastest),
                   lost=lost, scale=scale, missing=missing)  # fmt: skip

    # --- the shape ----------------------------------------------------------------------------------------------------

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
                yield say("other shape", law=law) + hint
        chi_squared = points.left(self.chosen.best)
        if points.deviation is not None and self.freedom > 0 and scipy.stats.chi2(self.freedom).sf(chi_squared) < 1e-3:
            yield say("sigma", times=math.sqrt(chi_squared / self.freedom))

    def praise(self) -> str:
        """The sentences of a good fit."""
        fit, limit = self.fit, self.criterion(self.points.law) + _ALIKE
        fastest, known, more = self._speed(fit.speeds[1]), "a1, a3 and a4", []
        if "a2" in fit.at_bound:
            more.append(say("no rise", fastest=fastest))
        elif "a2" in self.chosen.form.nonnegative and fit.interval["a2"][0] <= 0:
            more.append(say("perhaps no rise", fastest=fastest))
        else:
            known = "all four coefficients"
        if self.chosen.form is STRENGTHENING:
            more.append(say("rising"))
        if alike := [law for law in CURVE_LAWS if law != self.points.law and self.criterion(law) < limit]:
            more.append(say("alike", laws=", ".join(alike)))
        good = say("good", share=100 * fit.r_squared, count=fit.points, rms=fit.residual_rms, known=known)
        return " ".join([good, *more])
