"""Friction laws, chosen by the type of a tag, so that the choice costs nothing in the hot loop.

Every law is a *shape* that weakening friction follows over the slip speed w, from shape(0) = 1 on:

    mu(w) = a1 + a2 w + a3 shape(w/a4, delta)

The kernels get the tag of a law as first argument. Its type decides which shape they are compiled with; there is no
branch at run time. A law is a tag in LAWS and versions of the functions below, of z = w/a4: the first three, the others
where they differ from the defaults. `shape`, `weakening_slope`, `steps_over` and `bends` enter the hot loop and are
straight-line code. Laws in RECURRENCES are stepped by the Taylor series of the motion, others by Runge-Kutta.

The law of a table, whose shape is numbers of a run, is in `friction.py`.
"""

from math import inf
from math import log as log_of
from typing import NamedTuple

from ...arithmetic import exp, log
from ...jit import compiled
from ...linking import by_law
from .recurrences import CUBIC, EXPONENTIAL, GAUSSIAN, QUOTIENT

NEGLIGIBLE = 37.0  # e^-37 beside 1
SEEN = 1.4  # up to here either way, e^-z^2 is at least a seventh of what it is at most
FLATTEST = 1e-290  # slopes nearer to zero are below the smallest value of the exponential
MOST_TRIES = 60


@by_law("ff:f", inline=True)
def shape(law, z, delta):
    """Shape of the law at z = w/a4."""
    raise NotImplementedError


@by_law("ffff:f", inline=True)
def weakening_slope(law, z, x, drop, delta):
    """drop shape'(z), given x = drop shape(z)."""
    raise NotImplementedError


@by_law()
def speed_of_shape_slope(law, slope, delta):
    """The largest z with shape'(z) = slope; 0 if it is nowhere that steep, inf if it is steeper everywhere."""
    raise NotImplementedError


@by_law()
def inflection(law, delta):
    """From this z on, the slope only grows: everywhere, where the curve is convex."""
    return 0.0


@by_law()
def relaxation(law, delta):
    """From this z on, the slope is concave: nowhere, where a law does not say so."""
    return inf


@by_law("f:f")
def last_weakening(law, delta):
    """From this z on, the shape is constant to rounding."""
    return inf


@by_law("f:f")
def hidden_depth(law, delta):
    """By how much z may dip inside a step below both ends of it: no limit, where any point tells all of a curve."""
    return inf


@by_law(inline=True)
def steps_over(law, z, z_end, rise, rise_end):
    """Return whether a Taylor step from z to z_end, over which z changes at these rates, has passed over friction that
    neither end shows: never, where the shape only grows below z = 0.
    """
    return False


@by_law(inline=True)
def bends(law):
    """Return whether it bends so much that w'' may vanish twice within a Taylor step; a constant."""
    return False


@by_law(inline=True)
def passes_unseen(law, z, z_end, rise, rise_end):
    """The same as `steps_over` of a Runge-Kutta step: never, where hidden_depth and last_weakening tell it."""
    return False


@by_law("ff:f", inline=True)
def next_station(law, z, way):
    """The next place after z, upwards (way 1) or downwards (-1), that no panel of a quadrature over the slope should
    pass: infinitely far, as of an analytic shape.
    """
    return way * inf


@by_law(":b", inline=True)
def has_kinks(law):
    """Return whether the slope may have kinks: never, where the shape is analytic."""
    return False


# --- e^-z: Eq. (2) of the article in its standard form (Bo & Pavelescu 1982; Tustin 1947) ---------------------------


class Stribeck(NamedTuple):
    """Tag of exponential weakening."""

    code: int


shape.of(Stribeck)(lambda law, z, delta: exp(-z))
weakening_slope.of(Stribeck)(lambda law, z, x, drop, delta: -x)  # no second exponential
last_weakening.of(Stribeck)(lambda law, delta: NEGLIGIBLE)
# The Taylor series resolves e^-z over more than two units; the defect at the end of a step shows the rest.
hidden_depth.of(Stribeck)(lambda law, delta: 2.0)


@speed_of_shape_slope.of(Stribeck)
def _speed_of_stribeck_slope(law, slope, delta):
    if slope >= 0.0:
        return inf
    return -log_of(-slope) if slope > -1.0 else 0.0


# --- 1/(1 + z) ------------------------------------------------------------------------------------------------------
# R. I. Leine, D. H. van Campen, A. de Kraker, L. van den Steen, Stick-slip vibrations induced by alternate friction
# models, Nonlinear Dynamics 16 (1998) 41-54, use mu = F/(1 + delta |v|): a1 = a2 = 0, a3 = F, a4 = 1/delta.


class Rational(NamedTuple):
    """Tag of rational weakening."""

    code: int


shape.of(Rational)(lambda law, z, delta: 1.0 / (1.0 + z))
weakening_slope.of(Rational)(lambda law, z, x, drop, delta: -x / (1.0 + z))
relaxation.of(Stribeck, Rational)(lambda law, delta: 0.0)  # everywhere: these shapes are completely monotone
hidden_depth.of(Rational)(lambda law, delta: 0.5)  # half the speed over which friction halves first
steps_over.of(Rational)(lambda law, z, z_end, rise, rise_end: z_end <= -1.0)  # beyond the pole


@speed_of_shape_slope.of(Rational)
def _speed_of_rational_slope(law, slope, delta):
    if slope >= 0.0:
        return inf
    return (-slope) ** -0.5 - 1.0 if slope > -1.0 else 0.0


# --- 1 - 3/2 z + 1/2 z^3: weakening and strengthening along a cubic; its minimum, 0, lies at w = a4 -------------------
# J. J. Thomsen, A. Fidlin, Analytical approximations for stick-slip vibration amplitudes, International Journal of
# Non-Linear Mechanics 38 (2003) 389-403: mu_s - 3/2 (mu_s - mu_m) (w/v_m - (w/v_m)^3/3), so a1 = mu_m, a2 = 0,
# a3 = mu_s - mu_m, a4 = v_m.


class Cubic(NamedTuple):
    """Tag of the cubic."""

    code: int


shape.of(Cubic)(lambda law, z, delta: 1.0 + z * (0.5 * z * z - 1.5))
weakening_slope.of(Cubic)(lambda law, z, x, drop, delta: drop * (1.5 * z * z - 1.5))
speed_of_shape_slope.of(Cubic)(lambda law, slope, delta: (1.0 + slope / 1.5) ** 0.5 if slope > -1.5 else 0.0)


# --- e^-z^delta, with an exponent >= 1 --------------------------------------------------------------------------------
# B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis tools and compensation methods for
# the control of machines with friction, Automatica 30 (1994) 1083-1138, Eq. (3). With an exponent below 1 the curve
# falls vertically at w = 0, and no method that needs a slope can leave it. The motion has no Taylor series at w = 0
# where it is no whole number. At 1 the law `stribeck` is the same curve, and faster; at 2 `gaussian`, which has a
# recurrence, and is no law of its own for people: the engine sends cells of that exponent there.


class StribeckDelta(NamedTuple):
    """Tag of exponential weakening with an exponent."""

    code: int


class Gaussian(NamedTuple):
    """Tag of the same at the exponent 2."""

    code: int


# Even, so that a trial stage just below w = 0 sees a smooth curve.
shape.of(StribeckDelta)(lambda law, z, delta: exp(-exp(delta * log(abs(z)))))


@weakening_slope.of(StribeckDelta)
def _slope_by_exponent(law, z, x, drop, delta):
    size = delta * exp((delta - 1.0) * log(abs(z))) * x
    return -size if z >= 0.0 else size


@speed_of_shape_slope.of(StribeckDelta)
@compiled
def _speed_by_exponent(law, slope, delta):
    """On the convex part, beyond the inflection: with p = z^delta, p - (1 - 1/delta) ln p = ln delta - ln(-slope).

    The left side is convex in p, so Newton's method falls onto the larger root from above, until it no longer moves.
    """
    if slope >= -FLATTEST:
        return inf
    bend, level = 1.0 - 1.0 / delta, log(delta) - log(-slope)
    if level <= (bend * (1.0 - log(bend)) if bend > 0.0 else 0.0):
        return 0.0
    p = 2.0 * level + 2.0
    for _ in range(MOST_TRIES):
        new = p - (p - bend * log(p) - level) / (1.0 - bend / p)
        if not bend < new < p:
            break
        p = new
    return exp(log(p) / delta)


# Where delta z^delta = delta - 1.
inflection.of(StribeckDelta)(lambda law, delta: exp(log((delta - 1.0) / delta) / delta) if delta > 1.0 else 0.0)


@relaxation.of(StribeckDelta)
def _relaxation_by_exponent(law, delta):
    """The larger p = z^delta with delta^2 p^2 - 3 delta (delta - 1) p + (delta - 1)(delta - 2) = 0."""
    p = (3.0 * (delta - 1.0) + ((delta - 1.0) * (5.0 * delta - 1.0)) ** 0.5) / (2.0 * delta)
    return exp(log(p) / delta) if p > 0.0 else 0.0


last_weakening.of(StribeckDelta)(lambda law, delta: exp(log(NEGLIGIBLE) / delta))
hidden_depth.of(StribeckDelta)(lambda law, delta: 0.5 / delta)  # half the width of the fall
shape.of(Gaussian)(lambda law, z, delta: exp(-z * z))
weakening_slope.of(Gaussian)(lambda law, z, x, drop, delta: -2.0 * z * x)
speed_of_shape_slope.of(Gaussian)(lambda law, slope, delta: _speed_by_exponent(law, slope, 2.0))
hidden_depth.of(Gaussian)(lambda law, delta: 0.25)
inflection.of(Gaussian)(lambda law, delta: 0.5**0.5)
relaxation.of(Gaussian)(lambda law, delta: 1.5**0.5)
last_weakening.of(Gaussian)(lambda law, delta: NEGLIGIBLE**0.5)
# The shape is even: beyond the zone on both sides nothing tells that it was crossed.
steps_over.of(Gaussian)(lambda law, z, z_end, rise, rise_end: (z > SEEN) & (z_end < -SEEN))
# At 2^(-1/2); of the cubic from far above a4, where it is steep, to a4: w'' = b - w - mu' w' changes its sign twice.
bends.of(Cubic, Gaussian)(lambda law: True)

LAWS = {
    "stribeck": Stribeck(0), "stribeck_delta": StribeckDelta(1), "rational": Rational(2), "cubic": Cubic(3),
    "gaussian": Gaussian(4),
}  # fmt: skip
RECURRENCES = {Stribeck: EXPONENTIAL, Rational: QUOTIENT, Cubic: CUBIC, Gaussian: GAUSSIAN}
