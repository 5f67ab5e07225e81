"""Linear motion q'' + d q' + q = 0, in closed form: of q = w - B on a line of friction, or near steady sliding."""

from math import atan2, atanh, cos, exp, expm1, inf, pi, sin, sqrt

from .jit import compiled


@compiled
def linear(q, v, d, t):
    """(q, q') after t."""
    half = 0.5 * d
    x = half * half - 1.0
    if x < 1e-4:
        if x < -1e-4:
            omega = sqrt(-x)
            co, si = cos(omega * t), sin(omega * t) / omega
        else:  # near the double rate: series of cosh and sinh
            y = x * t * t
            if abs(y) > 1.0:
                root = sqrt(abs(x))
                co = (cos(root * t)) if x < 0.0 else 0.5 * (exp(root * t) + exp(-root * t))
                si = (sin(root * t) / root) if x < 0.0 else 0.5 * (exp(root * t) - exp(-root * t)) / root
            else:
                co, si, term = 1.0, t, 1.0
                for n in range(1, 14):
                    term *= y / (2 * n * (2 * n - 1))
                    co += term
                    si += term * t / (2 * n + 1)
        e = exp(-half * t)
        return e * ((co + half * si) * q + si * v), e * ((co - half * si) * v - si * q)
    root = sqrt(x)
    fast = half + root if half > 0.0 else half - root
    slow = 1.0 / fast
    es, ef = exp(-slow * t), exp(-fast * t)
    gap = fast - slow
    s = es * -expm1(-gap * t) / gap if gap > 0.0 else ef * expm1(gap * t) / gap
    return (fast * es - slow * ef) / gap * q + s * v, (fast * ef - slow * es) / gap * v - s * q


@compiled
def turn_of_linear(q, v, d):
    """The first time > 0 at which q' = 0; inf if there is none."""
    half = 0.5 * d
    x = half * half - 1.0
    if x < 0.0:
        omega = sqrt(-x)
        angle = atan2(omega * v, half * v + q)
        return (angle if angle > 0.0 else angle + pi) / omega
    bottom = half * v + q
    root = sqrt(x)
    if x == 0.0:
        t = v / bottom if bottom != 0.0 else inf
        return t if t > 0.0 else inf
    tangent = root * v / bottom if bottom != 0.0 else inf
    return atanh(tangent) / root if 0.0 < tangent < 1.0 else inf


@compiled
def time_of_level(q, v, d, level, latest):
    """When q, falling all the while, reaches the level, by bisection."""
    early, late = 0.0, latest
    for _ in range(1100):
        t = 0.5 * (early + late)
        if not early < t < late:
            break
        if linear(q, v, d, t)[0] > level:
            early = t
        else:
            late = t
    return late


@compiled
def square_of_linear(q, v, d, t):
    """Integral of q^2 over the next t."""
    if abs(d) > 0.1:
        q1, v1 = linear(q, v, d, t)
        return -(q1 * q1 + v1 * v1 - q * q - v * v) / (2.0 * d) - (q1 * v1 - q * v) - 0.5 * d * (q1 * q1 - q * q)
    n = 4 + int(8 * t)
    total, h = 0.0, t / n
    for i in range(n):  # Gauss-Legendre of order 10 on each piece
        for x, weight in (
            (-0.906179845938664, 0.23692688505618908), (-0.5384693101056831, 0.47862867049936647),
            (0.0, 0.5688888888888889), (0.5384693101056831, 0.47862867049936647),
            (0.906179845938664, 0.23692688505618908),
        ):  # fmt: skip
            total += 0.5 * h * weight * linear(q, v, d, (i + 0.5 + 0.5 * x) * h)[0] ** 2
    return total
