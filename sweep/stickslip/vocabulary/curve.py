"""The Stribeck curve from what people measure, and what must hold between its friction coefficients."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

ROUNDING = 1e-12  # relative; 0.1 + 0.2 is above 0.3


class Coefficients(NamedTuple):
    """The coefficients of the Stribeck curve that the measured form stands for."""

    a1: NDArray[np.float64]
    a2: NDArray[np.float64]
    a3: NDArray[np.float64]


def coefficients(mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike, a4: ArrayLike) -> Coefficients:
    """Coefficients a1, a2, a3 of the curve S(w) = a1 + a2 w + a3 exp(-w/a4) with S(0) = mu_start and its minimum
    mu_reversal at w = v_reversal.

    Arrays that broadcast; speeds in m/s, a4 > 0, v_reversal > 0. From S'(v) = 0, S(0) and S(v), with r = v/a4:
    a2 = (mu_start - mu_reversal)/(a4 (e^r - 1) - v), a3 = a2 a4 e^r, a1 = mu_start - a3.
    """
    start, drop = np.asarray(mu_start, np.float64), np.subtract(mu_start, mu_reversal)
    with np.errstate(divide="ignore", over="ignore"):  # a minimum at zero speed: a3 and -a1 are infinite
        r = np.minimum(np.divide(v_reversal, a4), 1000.0)  # e^-r is 0 from there on
        share = -np.expm1(-r) - r * np.exp(-r)  # drop/a3; written in e^-r, which cannot overflow
        a3 = drop / share
    return Coefficients(start - a3, a3 * np.exp(-r) / a4, a3)


def broken_bounds(mu_start: Any, *, a1: Any = 0.0, mu_static: Any = np.nan, mu_stop: Any = np.nan) -> dict[str, Any]:
    """By parameter, whether it breaks 0 <= mu_start, mu_stop <= mu_start <= mu_static, but for rounding.

    Numbers, or arrays that broadcast; NaN breaks nothing. mu_start = a1 + a3, hence the parameter `a3`.
    """
    slack = abs(mu_start) * ROUNDING
    return {
        "a3": mu_start < -ROUNDING * a1,
        "mu_static": mu_static < mu_start - slack,
        "mu_stop": mu_stop > mu_start + slack,
    }
