"""The area inside a cycle of the plane (displacement, velocity), clipped to boxes, its extent, and where it crosses an
axis: plain formulas of samples.

A cycle turns clockwise, since the velocity is the derivative of the displacement. It crosses velocity zero twice only,
so that its area in a box [x1, x2] x [v1, v2] is the integral of clip(v, v1, v2) over clip(x, x1, x2).

x, v, a : displacements from steady sliding, velocities, accelerations (n, samples), evenly over a period, both ends
included.
"""

import numpy as np
import scipy  # type: ignore[import-untyped]
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_TRAPEZIA = 2**13


def area_in_box(
    x: Floats, v: Floats, a: Floats, period: Floats, left: Floats, right: Floats, low: Floats, high: Floats
) -> Floats:
    """The area inside each cycle and its box, all of shape (n,): trapezia below cubics through the samples."""
    left, right, low, high, period = (np.asarray(values)[:, np.newaxis] for values in (left, right, low, high, period))
    samples, fine = np.linspace(0.0, 1.0, x.shape[1]), np.linspace(0.0, 1.0, _TRAPEZIA + 1)
    spline = scipy.interpolate.CubicHermiteSpline
    x, v = (spline(samples, values, slopes * period, axis=1)(fine) for values, slopes in ((x, v), (v, a)))
    x, v = np.clip(x, left, right), np.clip(v, low, high)
    trapezia = np.ascontiguousarray(
        (v[:, 1:] + v[:, :-1]) * np.diff(x)
    )  # else sums depend on how many cycles there are
    return np.asarray(0.5 * np.sum(trapezia, axis=1))


def largest(values: Floats) -> Floats:
    """The maximum of each row, a period of samples both ends included: of the parabola about the largest."""
    rows, at, samples = np.arange(len(values)), np.argmax(values, axis=1), values.shape[1] - 1
    before, top, after = (values[rows, (at + step) % samples] for step in (-1, 0, 1))
    bend = 2.0 * top - before - after
    return np.asarray(top + np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros_like(top), where=bend > 0))


def velocities_at_rest_point(x: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """The velocities above and below zero at which each cycle passes the displacement of steady sliding.

    Between two samples v is the cubic over x through their values and slopes, a/v. NaN where there are more passes.
    """
    upward = (x[:, 1:] > 0) & (x[:, :-1] <= 0)
    downward = (x[:, 1:] <= 0) & (x[:, :-1] > 0)
    velocities = []
    for passes in (upward, downward):
        rows, at = np.arange(len(passes)), np.argmax(passes, axis=1)
        (x0, x1), (v0, v1), (a0, a1) = ((values[rows, at], values[rows, at + 1]) for values in (x, v, a))
        with np.errstate(divide="ignore", invalid="ignore"):
            step, s = x1 - x0, x0 / (x0 - x1)
            ends = (1 - s) ** 2 * (1 + 2 * s) * v0 + s**2 * (3 - 2 * s) * v1
            velocity = ends + s * (1 - s) * step * ((1 - s) * a0 / v0 - s * a1 / v1)
        velocities.append(np.where(passes.sum(axis=1) == 1, velocity, np.nan))
    return velocities[0], velocities[1]
