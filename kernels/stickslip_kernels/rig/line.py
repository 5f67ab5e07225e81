"""Slip along a straight line of friction on a belt that accelerates, in closed form however steep the line.

With drag = gamma + slope of the line, push = B - w at the start, and B, alpha as in `layout.py`,

    w'' + drag w' + w = B + alpha t

A slip that the drive turns round soon after break-away leaves the curve at a tiny w, and its line is so steep that
no step could follow it. Written as what is added to the state at the start, nothing cancels there.
"""

from math import exp, expm1

from ..events import LEVEL_REACHED, NO_EVENT, TURNED
from ..jit import compiled

LONGEST = 0.5  # time looked at at once: well below half a turn
SERIES_REACH = 1.2  # of drag t; beyond it, within LONGEST, the motion is overdamped
TERMS = 24
MOST_TRIES = 100


@compiled
def response(drag, t):
    """s', s, its integral and the integral of that after t, where s'' + drag s' + s = 0, s(0) = 0, s'(0) = 1."""
    if abs(drag) * t > SERIES_REACH:
        half = 0.5 * drag
        root = (half * half - 1.0) ** 0.5
        fast = half + root if half > 0.0 else half - root  # the rate further from zero; the other is its inverse
        slow = 1.0 / fast
        gap, slow_decay, fast_decay = fast - slow, exp(-slow * t), exp(-fast * t)
        once = (expm1(-fast * t) / fast - expm1(-slow * t) / slow) / gap
        twice = t * t * (second_phi(-slow * t) - second_phi(-fast * t)) / gap
        return (fast * fast_decay - slow * slow_decay) / gap, (slow_decay - fast_decay) / gap, once, twice
    before, term = 0.0, 1.0  # of the series of s, over t
    speed, way, once, twice = 0.0, 0.0, 0.0, 0.0
    for n in range(1, TERMS):
        speed += n * term
        way += term
        once += term / (n + 1)
        twice += term / ((n + 1) * (n + 2))
        before, term = term, -t * (drag * term + before * t / n) / (n + 1)
    return speed, t * way, t * t * once, t * t * t * twice


@compiled
def second_phi(x):
    """(e^x - 1 - x)/x^2."""
    if abs(x) > SERIES_REACH:
        return (expm1(x) - x) / (x * x)
    total = 1.0
    for n in range(TERMS, 2, -1):
        total = 1.0 + total * x / n
    return 0.5 * total


@compiled
def motion(w, v, push, alpha, drag, t):
    """w, w', w'' and w''' after t, from w, w' = v and push = B - w at the start."""
    ds, s, once, twice = response(drag, t)
    dw = v * ds + push * s + alpha * once
    jerk = push * ds - v * (drag * ds + s) + alpha * s
    return w + v * s + push * once + alpha * twice, dw, jerk, alpha - dw - drag * jerk


@compiled
def zero(order, w, v, push, alpha, drag, high):
    """When the derivative of w of this order (0, 1, 2), monotone up to `high`, passes zero. By safeguarded Newton."""
    low, t, rises = 0.0, high, motion(w, v, push, alpha, drag, high)[order] > 0.0
    for _ in range(MOST_TRIES):
        there = motion(w, v, push, alpha, drag, t)
        if (there[order] > 0.0) == rises:
            high = t
        else:
            low = t
        new = t - there[order] / there[order + 1]
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - t) <= 1e-15 * t:
            break
        t = new
    return t


@compiled
def steepest(w, v, push, alpha, drag, h):
    """When w' is extremal within h; h if it is not."""
    after = motion(w, v, push, alpha, drag, h)[2]
    return zero(2, w, v, push, alpha, drag, h) if (push - drag * v) * after < 0.0 else h


@compiled
def end_on_line(w, v, push, alpha, drag, h):
    """What ends a fall (v <= 0) within h, and when: rest (LEVEL_REACHED), a trough of w (TURNED), or nothing."""
    end = h
    turned = motion(w, v, push, alpha, drag, h)[1] > 0.0
    if not turned and push - drag * v > 0.0:  # w' may have been positive in between
        end = steepest(w, v, push, alpha, drag, h)
        turned = motion(w, v, push, alpha, drag, end)[1] > 0.0
    end = zero(1, w, v, push, alpha, drag, end) if turned else h
    if motion(w, v, push, alpha, drag, end)[0] <= 0.0:
        return LEVEL_REACHED, zero(0, w, v, push, alpha, drag, end)
    return (TURNED if turned else NO_EVENT), end
