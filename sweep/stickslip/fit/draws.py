"""Curves drawn from what a fit knows: as likely as the points leave them, within the bounds of its coefficients."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.fit.curve import CurveFit
from stickslip.fit.forms import COEFFICIENTS
from stickslip.fit.uncertainty import Floats

Flags = NDArray[np.bool_]
_BATCHES = 200  # of draws, until enough of them lie within the bounds


class Drawn(NamedTuple):
    """Curves drawn. coefficients : a1 to a4 by name, each (count,). kept : share of the draws within the bounds."""

    coefficients: dict[str, Floats]
    kept: float

    @property
    def falling(self) -> Flags:
        """Which curves fall for ever, since a2 < 0."""
        return np.asarray(self.coefficients["a2"] < 0)


def draw_curves(fit: CurveFit, count: int, seed: int = 1, *, falling: bool = False) -> Drawn | None:
    """Curves as likely as the points leave them; None where these are too few to draw any.

    a4 has the confidence distribution of the fit's profile likelihood, the others are t-distributed about the best ones
    for it, with the fit's degrees of freedom: quantiles of what follows from draws are profile-likelihood intervals.
    Draws beyond the bounds of the fit are drawn again. What the fit assumed is in all of them; where the points show no
    branch, the draws have those that they may hide. The same seed gives the same draws.

    falling : keep curves with a2 < 0 as well, which fall for ever: where the points do not show that friction rises
    again, leaving these out would make it look certain.
    """
    if not fit.allowed.can_draw:
        return None
    random = np.random.default_rng(seed)
    drawn: list[Floats] = []
    enough = tried = 0
    for _ in range(_BATCHES):
        inside = fit.allowed.draw(count, random)
        inside = inside if falling or fit.a3 < 0 else inside[inside[:, 1] >= 0]
        drawn.append(inside)
        enough, tried = enough + len(inside), tried + count
        if enough >= count:
            chosen = np.concatenate(drawn)[:count]
            named = {name: chosen[:, i] for i, name in enumerate(COEFFICIENTS)}
            return Drawn(named, enough / tried)
    return None
