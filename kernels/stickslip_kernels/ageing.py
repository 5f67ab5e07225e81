"""Static friction that grows with the time in contact, and the exact moment of break-away.

mu_static + ageing ln(1 + t/ageing_time): Rabinowicz (1958); Dieterich (1972) for the logarithm. `ageing` counts per
e-fold of time here; per decade it is ln(10) times as much.
"""

from math import log1p

from .jit import compiled
from .layout import AGEING, AGEING_TIME, MU_STATIC

MOST_STEPS = 200


@compiled
def static_friction(cells, c, age):
    """Largest load the contact of cell c bears after a time in contact."""
    if cells[AGEING, c] == 0.0:
        return cells[MU_STATIC, c]
    return cells[MU_STATIC, c] + cells[AGEING, c] * log1p(age / cells[AGEING_TIME, c])


@compiled
def dwell_to_breakaway(cells, c, load, rate, age):
    """Time from now until a load that grows at `rate` > 0 passes static friction, which it does not exceed now.

    The excess of load over friction is convex in time, so right of its last zero Newton's method falls onto it from
    above, without a tolerance: until it no longer moves. A zero at the very start, from which friction first grows
    faster than the load, is not that zero.
    """
    ageing, scale = cells[AGEING, c], cells[AGEING_TIME, c]
    if ageing == 0.0:
        return (cells[MU_STATIC, c] - load) / rate
    missing = static_friction(cells, c, age) - load
    later = scale + age
    if missing <= 0.0 and rate * later >= ageing:
        return 0.0
    # excess(t) = rate t - missing - ageing ln(1 + t/later); its minimum is where rate (later + t) = ageing.
    t = max(missing / rate, 2.0 * (ageing / rate - later), later)
    while rate * t - missing - ageing * log1p(t / later) < 0.0:
        t *= 2.0
    for _ in range(MOST_STEPS):
        new = t - (rate * t - missing - ageing * log1p(t / later)) / (rate - ageing / (later + t))
        if not new < t:
            break
        t = new
    return t
