"""Dense output: the motion of one lane inside its step.

Rows SERIES hold the coefficients of w over the step: the Taylor series, exact as the step itself, or the Hermite
polynomial between its ends (`interpolate`). y and the friction work follow by integration.
"""

from numpy.polynomial.legendre import leggauss

from . import layout as at
from .arithmetic import widest_vectors
from .jit import compiled


def gauss(points):
    """Nodes and weights of the Gauss-Legendre rule on [0, 1], exact for polynomials of degree 2 points - 1."""
    nodes, weights = leggauss(points)
    return tuple((0.5 + 0.5 * nodes).tolist()), tuple((0.5 * weights).tolist())


NODES, WEIGHTS = gauss(5)


# --- the one reader of the series ------------------------------------------------------------------------------------


@compiled(inline=True)
def horner(s, i, t):
    """Coefficients 0 to 3 of the series of w about t after the start of the step, the integral and double integral of w
    from the start to t; at last coefficient 4.

    In one pass, so that each sum waits for itself only; what a reader leaves unread the compiler leaves out.
    """
    w, dw, half_jerk, sixth_snap, fourth = s[at.SERIES + at.ORDER * at.WIDTH + i], 0.0, 0.0, 0.0, 0.0
    once, twice = w, w
    for j in range(at.ORDER):
        n = at.ORDER - 1 - j
        c = s[at.SERIES + n * at.WIDTH + i]
        fourth = fourth * t + sixth_snap
        sixth_snap = sixth_snap * t + half_jerk
        half_jerk = half_jerk * t + dw
        dw = dw * t + w
        w = w * t + c
        # Each less its factors 1/(n + 1) and 1/((n + 1)(n + 2)), so that a sum waits for one operation a term.
        once = once * (t * ((n + 1) / (n + 2))) + c
        twice = twice * (t * ((n + 1) / (n + 3))) + c
    return w, dw, half_jerk, sixth_snap, t * once, 0.5 * t * t * twice, fourth


@compiled
def speed(s, i, t):
    """w, w', w'' and w''' of lane i at t after the start of its step."""
    w, dw, half_jerk, sixth_snap = horner(s, i, t)[:4]
    return w, dw, 2.0 * half_jerk, 6.0 * sixth_snap


@compiled(inline=True)
def load_and_speed(s, i, t):
    """y and w of lane i at t after the start of its step."""
    w, _, _, _, once, _, _ = horner(s, i, t)
    return s[at.Y + i] + t * (s[at.B + i] + 0.5 * t * s[at.ALPHA + i]) - once, w


# --- friction work --------------------------------------------------------------------------------------------------


@compiled(inline=True)
def conservative_work(s, i, h, rise, w, fallen):
    """Friction work over h without damper: y rises by `rise`, w ends at `w`, `fallen` is the double integral of w.

    For a belt at constant speed (`observers/signals.py` has the others).

    With mu = offset + y - gamma w - w' and w = b - y', mu w = b (offset + y) - ((offset + y)^2/2 + w^2/2)' - gamma w^2.
    """
    b, load = s[at.B + i], s[at.OFFSET + i] + s[at.Y + i]
    return (
        b * (h * (load + 0.5 * h * b) - fallen)
        - rise * (load + 0.5 * rise)
        - 0.5 * (w - s[at.W + i]) * (w + s[at.W + i])
    )


@compiled(inline=True)
def integral_by_ends(h, f, f_new, slope, slope_new, bend, bend_new):
    """Of f over h, from f, f' and f'' at both ends: of order 6 (Hermite)."""
    return h * (0.5 * (f + f_new) + h * (0.1 * (slope - slope_new) + h * (bend + bend_new) * (1.0 / 120.0)))


@compiled(inline=True)
def work_by_ends(s, i, h):
    """Friction work over a step from the motion at its ends, the damper counted; as `conservative_work`."""
    b, load, w, dw, jerk = s[at.B + i], s[at.OFFSET + i] + s[at.Y + i], s[at.W + i], s[at.DW + i], s[at.JERK + i]
    w_new, dw_new, rise = s[at.W_NEW + i], s[at.DW_NEW + i], s[at.Y_NEW + i] - s[at.Y + i]
    turn, turn_new = dw * dw + w * jerk, dw_new * dw_new + w_new * s[at.JERK_NEW + i]
    square = integral_by_ends(h, w * w, w_new * w_new, 2.0 * w * dw, 2.0 * w_new * dw_new, 2.0 * turn, 2.0 * turn_new)
    change = rise * (load + 0.5 * rise) + 0.5 * (w_new - w) * (w_new + w)
    return b * integral_by_ends(h, load, load + rise, b - w, b - w_new, -dw, -dw_new) - change - s[at.G + i] * square


@compiled(inline=True)
def square_integral(s, i, h):
    """Integral of w^2 over h."""
    total = 0.0
    for node in range(len(NODES)):
        w = horner(s, i, NODES[node] * h)[0]
        total += WEIGHTS[node] * w * w
    return h * total


@compiled
def subtract_damper_work(s):
    """Subtract the work of the damper, where any lane has one."""
    widest_vectors()
    damped = False
    for i in range(at.WIDTH):
        damped |= s[at.G + i] != 0.0
    if damped:
        for i in range(at.WIDTH):
            s[at.WORK + i] -= s[at.G + i] * square_integral(s, i, s[at.TAKEN + i])


# --- steps without a series of their own ------------------------------------------------------------------------------


@compiled
def interpolate(s):
    """The quintic Hermite polynomial over the step of every lane, as rows SERIES, and the friction work from it.

    It meets w, w' and w'' at both ends; inside, its error is a hundredth of what the step itself allows: h^6 w^(6)
    (theta (1 - theta))^3 / 6!.
    """
    widest_vectors()
    for i in range(at.WIDTH):
        h, w, dw, jerk = s[at.TAKEN + i], s[at.W + i], s[at.DW + i], s[at.JERK + i]
        rise = s[at.W_NEW + i] - w - h * (dw + 0.5 * h * jerk)
        slope = h * (s[at.DW_NEW + i] - dw - h * jerk)
        bend = h * h * (s[at.JERK_NEW + i] - jerk)
        third = 10.0 * rise - 4.0 * slope + 0.5 * bend
        fourth = -15.0 * rise + 7.0 * slope - bend
        fifth = 6.0 * rise - 3.0 * slope + 0.5 * bend
        s[at.SERIES + i], s[at.SERIES + at.WIDTH + i], s[at.SERIES + 2 * at.WIDTH + i] = w, dw, 0.5 * jerk
        per_h3 = 1.0 / (h * h * h)
        s[at.SERIES + 3 * at.WIDTH + i] = third * per_h3
        s[at.SERIES + 4 * at.WIDTH + i] = fourth * per_h3 / h
        s[at.SERIES + 5 * at.WIDTH + i] = fifth * per_h3 / (h * h)
        fallen = h * h * (0.5 * w + h * (dw / 6.0 + h * jerk / 24.0) + third / 20.0 + fourth / 30.0 + fifth / 42.0)
        s[at.WORK + i] = conservative_work(s, i, h, s[at.Y_NEW + i] - s[at.Y + i], s[at.W_NEW + i], fallen)
    subtract_damper_work(s)


# --- the motion -----------------------------------------------------------------------------------------------------


@compiled(inline=True)
def rise_and_work(s, i, t):
    """w, by how much y rises, and the friction work, until t after the start of the step of lane i."""
    w, _, _, _, once, twice, _ = horner(s, i, t)
    rise = t * (s[at.B + i] + 0.5 * t * s[at.ALPHA + i]) - once
    return w, rise, friction_work(s, i, t, rise, w, twice)


@compiled(inline=True)
def friction_work(s, i, t, rise, w, fallen):
    """Friction work until t after the start of the step, in the notation of `conservative_work`."""
    work = conservative_work(s, i, t, rise, w, fallen)
    if s[at.G + i] != 0.0:
        work -= s[at.G + i] * square_integral(s, i, t)
    return work
