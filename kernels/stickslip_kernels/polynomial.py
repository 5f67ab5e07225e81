"""Quintic Hermite polynomials over one step, and their roots.

Slip knows value, first and second derivative of the slip speed (and of y) at both ends of a step, so extrema inside it
follow from a polynomial of degree five, without another evaluation of the friction law. theta = time / step runs from
0 to 1; a polynomial is the tuple of its six coefficients, lowest first.
"""

from .jit import compiled

RESOLVED = 1e-6  # of the step; what is left then is about its square, below the polynomial's own error


@compiled(inline=True)
def hermite(h, f0, d0, s0, f1, d1, s1):
    """Coefficients in theta of the quintic with values f, slopes d and second derivatives s (in time) at both ends."""
    c1 = h * d0
    c2 = 0.5 * h * h * s0
    rise = f1 - f0 - c1 - c2
    slope = h * d1 - c1 - 2.0 * c2
    bend = h * h * s1 - 2.0 * c2
    c3 = 10.0 * rise - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * rise + 7.0 * slope - bend
    c5 = 6.0 * rise - 3.0 * slope + 0.5 * bend
    return f0, c1, c2, c3, c4, c5


@compiled(inline=True)
def value(p, theta):
    """p(theta)."""
    return p[0] + theta * (p[1] + theta * (p[2] + theta * (p[3] + theta * (p[4] + theta * p[5]))))


@compiled(inline=True)
def derivative(p):
    """p', as six coefficients again."""
    return p[1], 2.0 * p[2], 3.0 * p[3], 4.0 * p[4], 5.0 * p[5], 0.0


@compiled(inline=True)
def minus(p, level):
    """p - level."""
    return p[0] - level, p[1], p[2], p[3], p[4], p[5]


@compiled(inline=True)
def scaled(p, factor):
    """factor * p."""
    return factor * p[0], factor * p[1], factor * p[2], factor * p[3], factor * p[4], factor * p[5]


@compiled
def deflated(p):
    """p without its roots at theta = 0 (at most two): the zero a phase starts on is not an event of it."""
    for _ in range(2):
        if p[0] == 0.0:
            p = (p[1], p[2], p[3], p[4], p[5], 0.0)
    return p


@compiled
def root(p, low, high):
    """Root of p in [low, high] by Newton's method inside a shrinking bracket; p changes sign there, or `high` returns.

    Without a change of sign there is nothing to find; the caller asks only when the numbers at the ends say otherwise,
    so this happens within rounding of the end.
    """
    slope = derivative(p)
    at_low, at_high = value(p, low), value(p, high)
    if at_low * at_high > 0.0:
        return high
    theta = low + (high - low) * at_low / (at_low - at_high) if at_low != at_high else low
    for _ in range(60):
        f = value(p, theta)
        if f * at_low > 0.0:
            low = theta
        else:
            high = theta
        step = f / value(slope, theta)
        new = theta - step
        if not (low <= new <= high):  # also where the slope vanishes: NaN fails the comparison
            new = 0.5 * (low + high)
        if abs(new - theta) < RESOLVED:
            return new
        theta = new
    return theta
