"""The quality of a fitted curve, in plain words."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy import stats  # type: ignore[import-untyped]

from stickslip.fit.forms import COEFFICIENTS, FALLING, STRENGTHENING, Form
from stickslip.fit.uncertainty import Floats, rms, run_score
from stickslip.vocabulary import units

_SHARE = 0.5  # of the mean friction: a coefficient that moves the curve by more, within its interval, is not known
_SYSTEMATIC = -3.0  # standard deviations of the number of runs; one random sample in 700 goes below
_CERTAIN = 0.99  # confidence with which a branch must be seen
_TREND = 0.05  # chance of as many falls among points without a trend
_FEW = 4  # points to spare below which a branch that is not seen may well be there
_ROUNDING = 1e-9  # of the friction: smaller residuals are none
_VISIBLE = 0.01  # of the span of the points: smaller residuals do no harm, however regular they are


@dataclass(frozen=True)
class Verdict:
    """A fit and what is known of it.

    seen : whether the points show a branch of this form, declining or rising from zero speed.
    reach : half widths of the confidence intervals. at_bound : coefficients at the end of their range.
    freedom : points to spare. unit : in which speeds are told.
    """

    form: Form
    seen: bool
    estimates: Mapping[str, float]
    reach: Mapping[str, float]
    at_bound: tuple[str, ...]
    speed: Floats
    mu: Floats
    residuals: Floats
    r_squared: float
    freedom: int
    unit: str = "m/s"

    def unidentified(self) -> tuple[str, ...]:
        """Coefficients that the points do not determine."""
        allowed = _SHARE * float(self.mu.mean())
        effect = {"a1": self.reach["a1"], "a2": self.reach["a2"] * float(self.speed.max())}
        unknown = {name for name, moved in effect.items() if not moved < allowed}
        unknown |= {name for name in ("a3", "a4") if not self.reach[name] < abs(self.estimates[name])}
        if not self.seen:
            unknown |= {"a3", "a4"}
        return tuple(name for name in COEFFICIENTS if name in unknown)

    def findings(self) -> Iterator[str]:
        """What speaks against using the curve."""
        slowest, fastest = float(self.speed.min()), float(self.speed.max())
        if self.freedom <= 0:
            yield f"{self.speed.size} points for four coefficients do not test the fit: measure more points."
        elif self.form is FALLING:
            yield self._falling(slowest, fastest)
        elif not self.seen:
            yield self._unseen(slowest, fastest)
        else:
            yield from self._undetermined(slowest, fastest)
        yield from self._bounds()
        if self.seen and self.r_squared < 0.5:
            yield f"The curve explains only {100 * self.r_squared:.0f} % of the variance of the points."
        harmless = max(_VISIBLE * float(np.ptp(self.mu)), _ROUNDING * float(self.mu.max()))
        if rms(self.residuals) > harmless and run_score(self._in_order()) < _SYSTEMATIC:
            yield "The residuals change sign too seldom over the speed: the points follow a curve of another shape."

    def _falling(self, slowest: float, fastest: float) -> str:
        """Points that fall all the way, but do not determine four coefficients."""
        first, last = (float(self.mu[self.speed == speed].mean()) for speed in (slowest, fastest))
        others = [name for name in self.unidentified() if name not in self.form.assumed]
        lost = f" Neither do they determine {' and '.join(others)} singly, only the curve between." if others else ""
        over = fastest > 3 * self.estimates["a4"]
        missing = (
            "more points would show whether it rises again" if over else "higher speeds would show where the fall ends"
        )
        return (
            f"Friction falls all the way from {first:.3g} at {self._told(slowest)} to {last:.3g} at "
            f"{self._told(fastest)}, and the points do not determine a2, which was taken as 0 (no rise at "
            f"speed).{lost}{self._scale()} Use the curve between these speeds; {missing}."
        )

    def _told(self, speed: float, digits: int = 3) -> str:
        """A speed in m/s with the unit in which it is told."""
        rounded = float(f"{speed / units.factor(self.unit, 'm s-1'):.{digits}g}")
        return f"{rounded:g} {self.unit}"

    def _scale(self) -> str:
        """How far a4 is known, where four coefficients are too many."""
        a4, reach = self.estimates["a4"], self.reach["a4"]
        if not math.isfinite(reach):
            return " Of a4 they say nothing."
        low = max(a4 - reach, 0.0)
        return (
            f" a4 = {self._told(a4)} may be anything from {self._told(low, 2)} to {self._told(a4 + reach, 2)} (95 %)."
        )

    def _unseen(self, slowest: float, fastest: float) -> str:
        """Points without a declining branch, or too few to tell."""
        where = f"between {self._told(slowest)} and {self._told(fastest)}"
        if self.freedom < _FEW:
            return f"{self.speed.size} points are too few to show whether friction declines {where}: measure more."
        if falls(self.speed, self.mu):
            return (
                f"Most points fall {where}, but none of these curves follows them: a3 and a4 mean nothing. Look for "
                "outliers, and measure more points."
            )
        return (
            f"The points show no declining branch {where}, so a3 and a4 mean nothing: use a3 = 0, or measure at "
            "lower speed if the friction is known to fall."
        )

    def _undetermined(self, slowest: float, fastest: float) -> Iterator[str]:
        """Branches that begin before the points, or end behind them."""
        a4, unknown = self.estimates["a4"], self.unidentified()
        branch = "rise from zero speed" if self.form is STRENGTHENING else "decline"
        if slowest > a4:
            yield (
                f"The slowest point, at {self._told(slowest)}, is {slowest / a4:.3g} times a4: the {branch} is over "
                f"before the points begin, and mu_start = {self.estimates['mu_start']:.3g} is extrapolated. Measure at "
                "lower speed."
            )
        elif unknown:
            ends = f" The {branch} does not end before {self._told(fastest)}: measure at higher speed."
            beyond = ends if fastest < 2 * a4 else ""
            yield f"The points do not determine {' and '.join(unknown)}.{beyond}"

    def _bounds(self) -> Iterator[str]:
        """Active bounds. That of a2 says no more than that no rise is seen."""
        if not self.seen and self.form is not FALLING:
            return
        if "a1" in self.at_bound:
            yield "a1 is at its bound, 0: beyond the points the curve is a guess."
        if "mu_start" in self.at_bound:
            yield "mu_start is at its bound, 0: the curve has no static friction."
        if "a4" in self.at_bound:
            yield f"a4 = {self._told(self.estimates['a4'])} is at the end of the range that was searched."

    def praise(self) -> str:
        """What a good fit is told."""
        known, no_rise = "all four coefficients", ""
        if "a2" in self.at_bound:
            known = "a1, a3 and a4"
            no_rise = f" a2 is at its bound, 0: they show no rise up to {self._told(float(self.speed.max()))}."
        elif "a2" in self.form.nonnegative and self.reach["a2"] >= self.estimates["a2"]:
            known = "a1, a3 and a4"
            no_rise = f" a2 may be 0 (95 %): a rise up to {self._told(float(self.speed.max()))} is not certain."
        rising = " Friction rises from zero speed: a3 is negative, and there is no declining branch."
        return (
            f"The curve explains {100 * self.r_squared:.3g} % of the variance of {self.speed.size} points, "
            f"with a residual rms of {rms(self.residuals):.2g}, and they determine {known}."
            f"{no_rise}{rising if self.form is STRENGTHENING else ''}"
        )

    def _in_order(self) -> Floats:
        """One residual per speed, the mean of repetitions, from slow to fast."""
        _, group = np.unique(self.speed, return_inverse=True)
        return np.asarray(np.bincount(group, self.residuals) / np.bincount(group))


def is_seen(gain: float, chi_squared: float | None, freedom: int) -> bool:
    """Whether the two coefficients of a branch lower the sum of squares by more than chance does.

    gain : see `ScaledPoints.gain`. chi_squared : of the whole curve, where sigma is known. freedom : points left over.
    """
    if chi_squared is not None and chi_squared > 0:
        return gain * chi_squared > float(stats.chi2(2).ppf(_CERTAIN))
    return freedom > 0 and gain * freedom / 2.0 > float(stats.f(2, freedom).ppf(_CERTAIN))


def falls(speed: Floats, mu: Floats) -> bool:
    """Whether friction falls over the whole range of speeds, by the order of the points alone (Kendall)."""
    return bool(stats.kendalltau(speed, mu, alternative="less").pvalue < _TREND)


def excess(chi_squared: float, freedom: int) -> Iterator[str]:
    """Residuals that the standard deviations given do not explain, in fewer than one of a thousand samples."""
    if freedom > 0 and stats.chi2(freedom).sf(chi_squared) < 1e-3:
        times = math.sqrt(chi_squared / freedom)
        yield f"The residuals are {times:.2g} times sigma: the points follow another curve, or sigma is too small."
