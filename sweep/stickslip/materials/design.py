"""Which two measurements would tell most about something that follows from a friction curve."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from stickslip.fit.uncertainty import Floats
from stickslip.theory import stribeck

_FEWEST = 100  # curves drawn, from which covariances are known well enough
_CANDIDATES = 40  # speeds, by equal ratios


class Design(NamedTuple):
    """Two speeds (m/s), the slower one first, and what the standard deviation of the target becomes, as a factor."""

    speeds: tuple[float, float]
    factor: float


def best_measurements(
    target: Floats, curves: Mapping[str, Floats], between: tuple[float, float], sigma: float
) -> Design | None:
    """The two speeds at which another point each would narrow the target most.

    The target and the friction at any speed scatter together over the curves drawn; of a point measured there, with
    its own scatter, follows what is left of the variance of the target (linear regression; c-optimal design).

    Parameters
    ----------
    target : (n,), what follows from each of n drawn curves. curves : a1 to a4 by name, each (n,).
    between : the slowest speed tried, above 0, and the fastest, m/s. sigma : standard deviation of a point.

    Returns
    -------
    The design, or None where fewer than 100 curves tell or nothing scatters.
    """
    if target.size < _FEWEST or not np.ptp(target) > 0:
        return None
    tried = np.geomspace(*between, _CANDIDATES)
    friction = stribeck(tried[:, None], *(curves[name] for name in ("a1", "a2", "a3", "a4")))
    together = np.cov(np.vstack([target, friction]))
    variance, with_target, among = together[0, 0], together[0, 1:], together[1:, 1:]
    own = np.diag(among) + sigma**2
    one, other = np.triu_indices(_CANDIDATES)
    c1, c2, cross = with_target[one], with_target[other], among[one, other]
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = own[one] * own[other] - cross**2
        explained = (c1**2 * own[other] - 2.0 * c1 * c2 * cross + c2**2 * own[one]) / determinant
    explained[~np.isfinite(explained)] = 0.0
    best = int(np.argmax(explained))
    left = max(1.0 - float(explained[best] / variance), 0.0)
    return Design((float(tried[one[best]]), float(tried[other[best]])), left**0.5)
