"""When a load that follows the drive exceeds what the contact bears: exact, for stick and hold.

A load counts as above the limit once it is so by more than rounding; then it is truly rising where it passes.
"""

from math import inf, log1p

from ...jit import compiled

MOST_STEPS = 200
ROUNDING = 1e-14  # of the sizes that make up the load


@compiled(inline=True)
def is_above(over, alpha, limit):
    """Return whether a load that exceeds `limit` by `over` does so by more than rounding."""
    return over > ROUNDING * (abs(alpha) + abs(limit))


@compiled(inline=True)
def excess(load, rate, alpha, limit, growth, later, t):
    """Load minus limit after t: load + rate t + alpha t^2/2 minus limit + growth ln(1 + t/later)."""
    over = load + t * (rate + 0.5 * alpha * t) - limit
    return over if growth == 0.0 else over - growth * log1p(t / later)


@compiled
def first_passage(load, rate, alpha, limit, growth, later, left):
    """The first time in [0, left] from which on the load exceeds the limit; inf if there is none.

    load, rate, alpha : load now, its derivative and its second derivative, which is constant. limit, growth, later :
        the limit now; it grows by `growth` per e-fold of the time, reckoned from `later` > 0 ago.
    A steady rise has its own search. Else the times at which load and limit grow alike are roots of a quadratic:
    between them the excess is monotone, and the first piece that ends above the limit holds the answer.
    """
    if is_above(load - limit, alpha, limit):
        return 0.0
    if alpha == 0.0:
        t = steady_passage(load, rate, limit, growth, later) if rate > 0.0 else inf
        return t if t <= left else inf
    first, second = extrema(rate, alpha, growth, later)
    low = 0.0
    for piece in range(3):
        high = min(left, first if piece == 0 else second if piece == 1 else left)
        if high > low:
            if is_above(excess(load, rate, alpha, limit, growth, later, high), alpha, limit):
                return rising_root(load, rate, alpha, limit, growth, later, low, high)
            low = high
    return inf


@compiled
def steady_passage(load, rate, limit, growth, later):
    """The same for a load that grows at `rate` > 0 and does not exceed the limit now, without an end.

    The excess is convex in time, so right of its last zero Newton's method falls onto it from above, without a
    tolerance: until it no longer moves. A zero at the very start, from which the limit first grows faster than the
    load, is not that zero.
    """
    missing = limit - load
    if growth == 0.0:
        return max(missing / rate, 0.0)
    if missing <= 0.0 and rate * later >= growth:
        return 0.0
    # The excess rate t - missing - growth ln(1 + t/later) has its minimum where rate (later + t) = growth.
    t = max(missing / rate, 2.0 * (growth / rate - later), later)
    while rate * t - missing - growth * log1p(t / later) < 0.0:
        t *= 2.0
    for _ in range(MOST_STEPS):
        new = t - (rate * t - missing - growth * log1p(t / later)) / (rate - growth / (later + t))
        if not new < t:
            break
        t = new
    return t


@compiled
def extrema(rate, alpha, growth, later):
    """The positive times, ascending and inf where there are none, at which (rate + alpha t)(later + t) = growth."""
    a, b, c = alpha, alpha * later + rate, rate * later - growth
    root2 = b * b - 4.0 * a * c
    if root2 < 0.0:
        return inf, inf
    q = -0.5 * (b + root2**0.5) if b >= 0.0 else -0.5 * (b - root2**0.5)  # nothing cancels
    one, other = q / a, c / q if q != 0.0 else inf
    one, other = one if one > 0.0 else inf, other if other > 0.0 else inf
    return min(one, other), max(one, other)


@compiled
def rising_root(load, rate, alpha, limit, growth, later, low, high):
    """The zero of the excess in [low, high], over which it rises: Newton's method in a shrinking bracket."""
    t = high
    for _ in range(MOST_STEPS):
        over = excess(load, rate, alpha, limit, growth, later, t)
        if over > 0.0:
            high = t
        else:
            low = t
        slope = rate + alpha * t - (growth / (later + t) if growth != 0.0 else 0.0)
        new = t - over / slope
        if not low < new < high:
            new = 0.5 * (low + high)
        if new == t or high - low <= 1e-16 * high:
            break
        t = new
    return t
