"""A fitted friction curve, the curves that the points allow beside it, and draws of these."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip.theory.curve import SHAPES
from stickslip.vocabulary.models import CURVE
from stickslip_materials.fit.models import Form, MeasuredPoints
from stickslip_materials.fit.uncertainty import Floats, Interval

if TYPE_CHECKING:
    from stickslip_materials.fit.turns import SlowingLine

_BAND = 2000  # curves drawn for a band
_BATCHES = 200  # of draws, until enough of them lie within the bounds


class Drawn(NamedTuple):
    """Curves drawn. coefficients : a1 to a4 by name, and mu_stop of a fit that has it, each (count,)."""

    coefficients: dict[str, Floats]


@dataclass(frozen=True)
class CurveFit:
    """A friction curve through measured points, in SI.

    a1, a3 pure numbers, a2 s/m, a4 m/s; all >= 0, except where friction rises from zero speed: there a3 < 0, and a2 may
    be. Points without a branch have a3 = 0, and then a4 means nothing.
    standard_error : by name, of a1 to a4 and of mu_start = a1 + a3, to first order.
    interval : by name, 95 % by profile likelihood, without the part below a bound at 0; an end that the points
        leave open is inf, or 0; all are where another curve is said to fit better.
    covariance : (4, 4), in the order a1 to a4, to first order. freedom : points to spare, inf where sigma was given.
    speeds : the slowest and the fastest point, m/s. searched : between which a4 was looked for, m/s.
    residual_rms : of mu. r_squared : explained share of the variance of mu, NaN if mu does not vary.
    unidentified : coefficients that the points do not determine. assumed : those of them that were fixed.
    at_bound : those (and mu_start) that the points would have beyond their bound.
    outliers : positions of points that were left out.
    determined : whether the points tell where vibration ends; a material whose points do not is not ranked.
    has_intervals : whether what follows from the curve has an interval: points are to spare, and follow its shape.
    good : whether the curve may be used without reservation. quality : why, or why not, in plain words.
    law : of the curve.
    measured, form : points and form of the curve, which bands and draws come from.
    mu_stop : friction while the speed falls to 0, Eq. (2a); NaN where the points were not measured on the way down, or
        do not differ there. line : the points it follows from.
    """

    a1: float
    a2: float
    a3: float
    a4: float
    standard_error: Mapping[str, float]
    interval: Mapping[str, Interval]
    covariance: Floats = field(repr=False)
    freedom: float
    speeds: Interval
    searched: Interval
    residual_rms: float
    r_squared: float
    points: int
    assumed: tuple[str, ...]
    at_bound: tuple[str, ...]
    outliers: tuple[int, ...]
    has_intervals: bool
    law: str
    measured: MeasuredPoints = field(repr=False, compare=False)
    form: Form = field(repr=False, compare=False)
    unidentified: tuple[str, ...] = ()
    determined: bool = False
    good: bool = False
    quality: str = ""
    mu_stop: float = math.nan
    line: SlowingLine | None = field(default=None, repr=False, compare=False)

    @property
    def mu_start(self) -> float:
        """Friction coefficient at break-away, a1 + a3."""
        return self.a1 + self.a3

    @property
    def declines(self) -> bool:
        """True where friction falls from standstill on."""
        return self.a3 > 0

    def coefficients(self) -> dict[str, float]:
        """a1 to a4 by name, and mu_stop if there is one, as `evaluate` and `simulate` take them."""
        names = CURVE if math.isnan(self.mu_stop) else (*CURVE, "mu_stop")
        return {name: float(getattr(self, name)) for name in names}

    def row(self) -> dict[str, Floats]:
        """a1 to a4 as arrays of one, as those of curves drawn are."""
        return {name: np.array([getattr(self, name)]) for name in CURVE}

    def predict(self, speed: ArrayLike) -> Floats:
        """Friction coefficient at slip speeds (m/s)."""
        w = np.asarray(speed, np.float64)
        return np.asarray(self.a1 + self.a2 * w + self.a3 * SHAPES[self.law](w / self.a4))

    def band(self, speed: ArrayLike) -> tuple[Floats, Floats]:
        """Lower and upper end of the 95 % confidence band of the curve at slip speeds (m/s): quantiles of draws; not
        below 0, and infinite where none can be drawn.
        """
        w = np.asarray(speed, np.float64)
        if (drawn := self.draw(_BAND, falling=True)) is None:
            return np.zeros_like(w), np.full_like(w, np.inf)
        level, slope, drop, decay = (drawn.coefficients[name] for name in CURVE)
        curves = level + slope * w[..., None] + drop * SHAPES[self.law](w[..., None] / decay)
        low, high = np.quantile(curves, (0.025, 0.975), axis=-1)
        middle = self.predict(w)
        return np.minimum(np.maximum(low, 0.0), middle), np.maximum(high, middle)

    def draw(self, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
        """Curves as likely as the points leave them.

        a4 has the confidence distribution of the fit's profile likelihood, the others are t-distributed about the best
        ones for it, with the fit's degrees of freedom: quantiles of what follows from draws are profile-likelihood
        intervals. Draws beyond the bounds of the fit are drawn again. What the fit assumed is in all of them; where the
        points show no branch, the draws have those that they may hide.

        Parameters
        ----------
        count : of the curves
        seed : the same gives the same draws
        falling : include curves with a2 < 0, which fall for ever: where the points do not show that friction rises
            again, leaving these out would make it look certain

        Returns
        -------
        Drawn or None
            None where the points are too few to draw any.
        """
        if not self.measured.can_draw(self.form):
            return None
        random, inside = np.random.default_rng(seed), np.zeros((0, 4))
        for _ in range(_BATCHES):
            values = self.measured.draw(self.form, count, random)
            inside = np.concatenate([inside, values if falling or self.a3 < 0 else values[values[:, 1] >= 0]])
            if len(inside) >= count:
                coefficients = dict(zip(CURVE, inside[:count].T, strict=True))
                stop = {} if self.line is None else {"mu_stop": self.line.draw(coefficients, random)}
                return Drawn(coefficients | stop)
        return None


def draw_curves(fit: CurveFit, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
    """Curves as likely as the points leave them: `CurveFit.draw`."""
    return fit.draw(count, seed, falling=falling)
