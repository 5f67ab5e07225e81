"""When a load that follows the drive exceeds what the contact bears: exact, for stick and hold.

A load counts as above the limit once it is so by more than rounding; then it is truly rising where it passes.
"""

from math import inf, log1p

from ... import layout as at
from ... import observers
from ...drive import belt_in_lane, flip, next_segment, pass_time, segment_is_over, steady_load
from ...jit import compiled
from .slip import begin_slip

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


# --- static friction that grows with the time in contact --------------------------------------------------------------
# Rabinowicz (1958); Dieterich (1972) for the logarithm. `ageing` counts per e-fold of time here; per decade it is
# ln(10) times as much.


@compiled
def static_friction(cells, c, age):
    """Largest load the contact of cell c bears after a time in contact."""
    if cells[at.AGEING, c] == 0.0:
        return cells[at.MU_STATIC, c]
    return cells[at.MU_STATIC, c] + cells[at.AGEING, c] * log1p(age / cells[at.AGEING_TIME, c])


# --- stick: the mass moves with the belt until the load reaches static friction ---------------------------------------
# u, w, b are displacement, slip speed and belt speed in the frame of `layout.py`, and alpha + u + gamma b is the load.


# A re-stick shorter than the integration can resolve is a grazing contact, not a stick phase. A dip of the slip speed
# below zero, had it not stuck, of this many tolerances is called grazing; one turn of an undamped oscillation loses
# half as much (measured at any tolerance). Only a slip in the direction of the belt can graze: one that comes back from
# the other arrives at a rate, and how long it then sticks is as exact as the load.
GRAZING_ERRORS = 0.1
# Without any drag (Coulomb's friction, no damper) a slip from break-away comes back to standstill exactly there: a dip
# of this share is an error of the integration, and no cycle of stick-slip exists.
WITHOUT_DRAG = 1e-4


@compiled
def stick(m, i, u, after_slip):
    """The slip speed is zero at u: move with the belt until break-away, or slip the other way at once.

    The belt holds the mass while the load is within static friction; in each segment the load is a quadratic of the
    time, so the moment of break-away is exact.
    """
    s, cells, c = m.s, m.cells, int(m.s[at.CELL + i])
    comes_back = belt_in_lane(m, i, 0.0) < 0.0
    if comes_back:
        flip(s, i)
        u = -u
    b, alpha, gamma = belt_in_lane(m, i, 0.0), m.s[at.ALPHA + i], s[at.G + i]
    load, impulse, start, u_start = alpha + u + gamma * b, 0.0, s[at.TAU + i], u
    amplitude = max(abs(u - steady_load(m, i)), b)
    s[at.MODE + i] = at.STICK
    s[at.AGE + i] = 0.0 if after_slip else cells[at.CONTACT_START, c]
    if after_slip:
        observers.observe_contact(m, i, static_friction(cells, c, 0.0) - abs(load), comes_back)
    while True:
        left, rate, age = s[at.TAU_END + i] - s[at.TAU + i], b + gamma * alpha, s[at.AGE + i]
        limit, growth, later = static_friction(cells, c, age), cells[at.AGEING, c], cells[at.AGEING_TIME, c] + age
        up = first_passage(load, rate, alpha, limit, growth, later, left)
        down = first_passage(-load, -rate, -alpha, limit, growth, later, left)
        t = min(up, down, left)
        if min(up, down) == inf:
            observers.observe_load_that_stays(m, i, u, b)
            if observers.is_over(m, i):
                observers.observe_stick(m, i, start, u_start, load, after_slip, False)
                return observers.finish(m, i, s[at.DECIDED_BY + i], u, b)
        observers.observe_constant_speed(m, i, u, b, 0.0, t)
        u += t * (b + 0.5 * alpha * t)
        impulse += t * (load + t * (0.5 * rate + alpha * t / 6.0))
        pass_time(m, i, t)
        s[at.AGE + i] = age + t
        if min(up, down) < inf and not segment_is_over(s, i):
            break
        if not next_segment(m, i):
            b += alpha * t
            observers.observe_stick(m, i, start, u_start, alpha + u + gamma * b, after_slip, False)
            return observers.finish(m, i, at.HORIZON_REACHED, u, b)
        b, alpha = belt_in_lane(m, i, 0.0), m.s[at.ALPHA + i]
        load = alpha + u + gamma * b
    smooth = not is_above(abs(load) - limit, alpha, limit)
    limit = static_friction(cells, c, s[at.AGE + i])
    if down < up:
        flip(s, i)
        u, u_start, impulse = -u, -u_start, -impulse
    if smooth:  # then the load is the limit, exactly
        u = limit - m.s[at.ALPHA + i] - gamma * belt_in_lane(m, i, 0.0)
    dip = limit * (s[at.TAU + i] - start) - impulse  # of the slip speed below zero, had it not stuck
    at_once = s[at.TAU + i] == start
    error = max(GRAZING_ERRORS * m.rtol, WITHOUT_DRAG * has_no_drag(cells, c))
    grazing = after_slip and (at_once or (not comes_back and dip < error * amplitude))
    if not grazing:
        thrown = not smooth and at_once
        observers.observe_stick(m, i, start, u_start, limit, after_slip, thrown)
        observers.observe_breakaway(m, i, start, limit, thrown)
        if observers.is_over(m, i):
            return observers.finish(m, i, s[at.DECIDED_BY + i], u, belt_in_lane(m, i, 0.0))
    # Where static friction ends on the curve, w and w' vanish together here and w'' > 0 starts the slip.
    return begin_slip(m, i, at.RISE, u, 0.0, smooth and limit <= cells[at.A1, c] + cells[at.A3, c], not grazing)


@compiled
def has_no_drag(cells, c):
    """Return whether friction is Coulomb's, no greater at break-away, and nothing else damps or feeds cell c."""
    constant = cells[at.A2, c] == 0.0 and cells[at.A3, c] == 0.0 and cells[at.GAMMA, c] == 0.0
    return constant and cells[at.AGEING, c] == 0.0 and cells[at.MU_STATIC, c] <= cells[at.A1, c] * (1.0 + ROUNDING)
