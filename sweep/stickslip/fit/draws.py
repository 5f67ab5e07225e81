"""Curves drawn from what a fit knows: its coefficients with their covariance, within their bounds."""

from __future__ import annotations

import math
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
    """Curves as likely as the points leave them; None where these determine too little to draw any.

    The coefficients are jointly t-distributed about those of the fit, with its covariance and degrees of freedom (they
    are normal where the standard deviation of the points was given). Draws beyond the bounds of the
    fit are drawn again: below 0, and a4 outside of where it was looked for. What the fit assumed is in all of them. The
    same seed gives the same draws.

    falling : keep curves with a2 < 0 as well, which fall for ever: where the points do not show that friction rises
    again, leaving these out would make it look certain.
    """
    covariance = fit.free_covariance()
    if not np.isfinite(covariance).all() or fit.freedom <= 0:
        return None
    random = np.random.default_rng(seed)
    best = np.array(list(fit.coefficients().values()))
    root = _root(covariance)
    found: list[Floats] = []
    enough = tried = 0
    for _ in range(_BATCHES):
        drawn = best + (random.standard_normal((count, 4)) @ root.T) / _shrinking(random, fit.freedom, count)[:, None]
        inside = drawn[_within(fit, drawn, falling)]
        found.append(inside)
        enough, tried = enough + len(inside), tried + count
        if enough >= count:
            chosen = np.concatenate(found)[:count]
            named = {name: chosen[:, i] for i, name in enumerate(COEFFICIENTS)}
            return Drawn(named, enough / tried)
    return None


def _root(covariance: Floats) -> Floats:
    """A matrix R with R R^T = covariance, which may be singular: coefficients that are fixed have no variance."""
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(safe, safe))
    return np.asarray(scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0)))


def _shrinking(random: np.random.Generator, freedom: float, count: int) -> Floats:
    """What normal draws are divided by to be t-distributed."""
    if math.isinf(freedom):
        return np.ones(count)
    return np.asarray(np.sqrt(random.chisquare(freedom, count) / freedom))


def _within(fit: CurveFit, drawn: Floats, falling: bool) -> Flags:
    """Which draws are curves of the kind that was fitted."""
    a1, a2, a3, a4 = drawn.T
    low, high = fit.searched
    inside = (a1 >= 0) & (a1 + a3 >= 0) & (a4 >= low) & (a4 <= high)
    return np.asarray(inside & ((a2 >= 0) | falling) & (a3 >= 0) if fit.a3 >= 0 else inside & (a3 <= 0))
