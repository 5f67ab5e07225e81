"""Where inside a step a mode ends, located to the method's order.

A step only says that an event lies inside it. A polynomial through the ends of the step gives a first guess; then the
step is repeated from its start with the guessed size, until a Taylor step from there to the event is as exact as the
integration itself. (A polynomial root alone spoils a good step: 3e-4 at rtol 1e-6, measured.)
"""

from .jit import compiled
from .layout import (
    B, DROP, DW, DW_NEW, EXPONENT, G, JERK, JERK_NEW, LEVEL, OFFSET, RATE, SIDE, SLOPE, TAKEN, TURN, W, WORK, W_NEW,
    Y, Y_NEW,
)  # fmt: skip
from .polynomial import deflated, derivative, hermite, minus, root, scaled, value
from .lanes import stage_jerk
from .rk import friction_power, rk_step

NO_EVENT, LEVEL_REACHED, TURNED = range(3)
MOST_TRIES = 12


@compiled
def step_again(law, s, i, h):
    """The step of lane i repeated with size h: y, w, w', w'', friction work."""
    y, w, dw, work = rk_step(
        law, h, s[Y + i], s[W + i], s[DW + i], s[B + i], s[G + i],
        s[OFFSET + i], s[SLOPE + i], s[DROP + i], s[RATE + i], s[EXPONENT + i],
    )  # fmt: skip
    return y, w, dw, stage_jerk(law, s, i, y, w, dw), work


@compiled
def taylor_end(s, i, h, dt, y, w, dw, jerk, work):
    """State at h + dt from that at h, dt being tiny."""
    b = s[B + i]
    work += dt * friction_power(y, w, dw, s[G + i], s[OFFSET + i])
    y += dt * ((b - w) - dt * (0.5 * dw + dt * jerk / 6.0))
    return h + dt, y, w + dt * (dw + 0.5 * dt * jerk), dw + dt * jerk, work


@compiled
def locate_level(law, s, i, guess, limit, rtol):
    """Time from the step start, state and work where w crosses LEVEL, near `guess` and no later than `limit`."""
    level = s[LEVEL + i]
    good_enough = 0.1 * rtol**0.3333
    h = guess
    for attempt in range(MOST_TRIES):
        y, w, dw, jerk, work = step_again(law, s, i, h)
        # One step of Halley's method for w + dw dt + jerk dt^2 / 2 = level: leaves an error of third order in dt.
        newton = (level - w) / dw
        dt = newton / (1.0 + 0.5 * newton * jerk / dw)
        if not abs(dt) < limit:  # a grazing crossing: dw is nearly zero
            dt = 0.0
        if abs(dt) < good_enough or attempt == MOST_TRIES - 1:
            h, y, w, dw, work = taylor_end(s, i, h, dt, y, w, dw, jerk, work)
            break
        h = min(max(h + dt, 0.0), limit)
    return h, y, level, dw, work


@compiled
def locate_turn(law, s, i, guess, limit, rtol):
    """Time, state and work where w' vanishes, near `guess` and no later than `limit`."""
    good_enough = 0.1 * rtol**0.5
    h = guess
    for attempt in range(MOST_TRIES):
        y, w, dw, jerk, work = step_again(law, s, i, h)
        dt = -dw / jerk
        if not abs(dt) < limit:
            dt = 0.0
        if abs(dt) < good_enough or attempt == MOST_TRIES - 1:
            h, y, w, dw, work = taylor_end(s, i, h, dt, y, w, dw, jerk, work)
            break
        h = min(max(h + dt, 0.0), limit)
    return h, y, w, 0.0, work


@compiled
def guess_turn(p, d1):
    """Where in the step (theta) the derivative of p first vanishes, or -1.

    p is turned so that the level lies above it; d1 is its slope at the end.
    """
    slope = derivative(p)
    if d1 <= 0.0:
        return root(deflated(slope), 0.0, 1.0)
    # Both ends rise: the derivative may still dip below zero between them.
    bottom = root(derivative(slope), 0.0, 1.0)
    if value(slope, bottom) * d1 > 0.0:
        return -1.0
    return root(deflated(slope), 0.0, bottom)


@compiled
def find_event(law, s, i, rtol):
    """What ends the mode of lane i inside the step it has just tried.

    Returns (kind, time from the step start, y, w, w', friction work up to there); for NO_EVENT the end of the step.
    """
    h, side, level = s[TAKEN + i], s[SIDE + i], s[LEVEL + i]
    w0, w1, dw1 = s[W + i], s[W_NEW + i], s[DW_NEW + i]
    d0, d1 = side * s[DW + i], side * dw1
    reached = side * w1 >= side * level
    # An extremum inside the step is no further out than the nearer end plus h times the smaller slope there.
    grazed = d0 > 0.0 and d1 <= 0.0 and max(side * w0, side * w1) + h * min(d0, -d1) >= side * level
    if not (reached or grazed or s[TURN + i] > 0.0):
        return NO_EVENT, h, s[Y_NEW + i], w1, dw1, s[WORK + i]
    p = hermite(h, w0, s[DW + i], s[JERK + i], w1, dw1, s[JERK_NEW + i])
    bound = 1.0  # the level, if reached, is reached before this
    if s[TURN + i] > 0.0 or (grazed and not reached):
        theta = guess_turn(scaled(p, side), d1)
        if theta >= 0.0:
            end, y, w, dw, work = locate_turn(law, s, i, theta * h, h, rtol)
            if side * w < side * level:
                if s[TURN + i] > 0.0:
                    return TURNED, end, y, w, dw, work
            else:
                reached = True
                bound = end / h
    if not reached:
        return NO_EVENT, h, s[Y_NEW + i], w1, dw1, s[WORK + i]
    theta = root(deflated(minus(p, level)), 0.0, bound)
    end, y, w, dw, work = locate_level(law, s, i, theta * h, h, rtol)
    return LEVEL_REACHED, end, y, w, dw, work
