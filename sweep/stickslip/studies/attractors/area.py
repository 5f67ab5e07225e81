"""The area inside a cycle of the plane (displacement, velocity), clipped to boxes, and where it crosses an axis.

A cycle turns clockwise, since the velocity is the derivative of the displacement: velocities above zero go to the
right. It crosses velocity zero twice only, so that its inside lies between two curves v(x), and the area in a box
[x1, x2] x [v1, v2] is the integral of clip(v, v1, v2) v dt over the times with x1 < x < x2. Between samples v is the
cubic through values and slopes, and x its integral.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
_HALVINGS = 60
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)  # v^2 has degree 6


@dataclass(frozen=True)
class Orbits:
    """Some cycles, sampled evenly over their periods, both ends included.

    x, v, a : displacement from steady sliding, velocity, acceleration; (n, samples). period : (n,).
    """

    x: Floats
    v: Floats
    a: Floats
    period: Floats

    @property
    def step(self) -> Floats:
        """Time between samples, (n, 1)."""
        return np.asarray(self.period[:, np.newaxis] / (self.v.shape[1] - 1))

    def extremes(self, values: Floats, slopes: Floats) -> tuple[Floats, Floats]:
        """The largest and the least of x (or v), whose slopes are v (or a): of cubics through the samples."""
        h = self.step
        y0, y1, d0, d1 = values[:, :-1], values[:, 1:], h * slopes[:, :-1], h * slopes[:, 1:]
        turns = (d0 > 0) != (d1 > 0)
        b, c = 3.0 * (y1 - y0) - 2.0 * d0 - d1, 2.0 * (y0 - y1) + d0 + d1
        s = np.divide(d0, d0 - d1, out=np.zeros_like(d0), where=turns)  # of straight slopes; then Newton's method
        for _ in range(3):
            bend = 2.0 * b + 6.0 * c * s
            s = s - np.divide(d0 + s * (2.0 * b + 3.0 * c * s), bend, out=np.zeros_like(s), where=turns & (bend != 0))
        turned = np.where(turns, y0 + s * (d0 + s * (b + c * s)), y0)
        return turned.max(axis=1), turned.min(axis=1)


def area_in_box(orbits: Orbits, left: Floats, right: Floats, low: Floats, high: Floats) -> Floats:
    """The area inside each orbit and its box, all of shape (n,)."""
    left, right, low, high = (np.asarray(end)[:, np.newaxis] for end in (left, right, low, high))
    x, v = orbits.x, orbits.v
    cut = np.zeros(v[:, 1:].shape, np.bool_)
    for values, level in ((x, left), (x, right), (v, low), (v, high)):
        cut |= (values[:, 1:] > level) != (values[:, :-1] > level)
    total = np.where(cut, 0.0, _whole(orbits, left, right, low, high)).sum(axis=1)
    cell, piece = np.nonzero(cut)
    parts = _split(orbits, cell, piece, *(end[cell, 0] for end in (left, right, low, high)))
    np.add.at(total, cell, parts)
    return np.asarray(total)


def _whole(orbits: Orbits, left: Floats, right: Floats, low: Floats, high: Floats) -> Floats:
    """The integral over each piece between samples in which neither x nor v passes an end of the box."""
    h, v, a = orbits.step, orbits.v, orbits.a
    inside = (orbits.x[:, :-1] > left) & (orbits.x[:, :-1] <= right)
    middle = 0.5 * (v[:, 1:] + v[:, :-1])
    free = (middle > low) & (middle < high)
    held = np.where(middle > low, high, low)  # the velocity that stands for those outside the box
    # The trapezium rule corrected by the slopes at both ends, of v^2 and of v.
    squares = 0.5 * h * (v[:, 1:] ** 2 + v[:, :-1] ** 2)
    squares -= h**2 / 6.0 * (v[:, 1:] * a[:, 1:] - v[:, :-1] * a[:, :-1])
    return np.where(inside, np.where(free, squares, held * (orbits.x[:, 1:] - orbits.x[:, :-1])), 0.0)


def _split(
    orbits: Orbits, cell: NDArray[np.intp], piece: NDArray[np.intp], left: Floats, right: Floats, low: Floats,
    high: Floats,
) -> Floats:  # fmt: skip
    """The integral over each of these pieces, split where x or v passes an end of its box."""
    one = Piece.of(orbits, cell, piece)
    ends = [np.zeros(cell.size), np.ones(cell.size)]
    for which, level in ((0, left), (0, right), (1, low), (1, high)):
        ends.append(one.passes(which, level))
    times = np.sort(np.stack(ends), axis=0)
    total = np.zeros(cell.size)
    for start, end in zip(times[:-1], times[1:], strict=True):
        for node, weight in zip(_NODES, _WEIGHTS, strict=True):
            x, v = one.at(start + 0.5 * (end - start) * (1.0 + node))
            inside = (x > left) & (x <= right)
            total += np.where(inside, 0.5 * (end - start) * weight * np.clip(v, low, high) * v, 0.0)
    return total * one.h


def velocities_at_rest_point(orbits: Orbits) -> tuple[Floats, Floats]:
    """The velocities above and below zero at which each orbit passes the displacement of steady sliding."""
    upward = (orbits.x[:, 1:] > 0) & (orbits.x[:, :-1] <= 0)
    downward = (orbits.x[:, 1:] <= 0) & (orbits.x[:, :-1] > 0)
    found = []
    for passes in (upward, downward):
        cell = np.arange(passes.shape[0])
        one = Piece.of(orbits, cell, np.argmax(passes, axis=1))
        velocity = one.at(one.passes(0, np.zeros(cell.size)))[1]
        found.append(np.where(passes.sum(axis=1) == 1, velocity, np.nan))
    return found[0], found[1]


@dataclass(frozen=True)
class Piece:
    """Pieces of orbits between two samples, over s from 0 to 1: v as a cubic with coefficients `v`, x at its start."""

    h: Floats
    x: Floats
    v: tuple[Floats, Floats, Floats, Floats]

    @classmethod
    def of(cls, orbits: Orbits, cell: NDArray[np.intp], piece: NDArray[np.intp]) -> Piece:
        """The pieces with these numbers of these orbits."""
        h = orbits.step[cell, 0]
        v0, v1 = orbits.v[cell, piece], orbits.v[cell, piece + 1]
        begin, end = h * orbits.a[cell, piece], h * orbits.a[cell, piece + 1]
        return cls(h, orbits.x[cell, piece], (v0, begin, 3 * (v1 - v0) - 2 * begin - end, 2 * (v0 - v1) + begin + end))

    def at(self, s: Floats) -> tuple[Floats, Floats]:
        """x and v at s."""
        v0, v1, v2, v3 = self.v
        x = self.x + self.h * s * (v0 + s * (v1 / 2 + s * (v2 / 3 + s * v3 / 4)))
        return x, v0 + s * (v1 + s * (v2 + s * v3))

    def passes(self, which: int, level: Floats) -> Floats:
        """Return where x (0) or v (1) passes a level between the ends; 0 where it does not."""
        zero, one = np.zeros_like(self.h), np.ones_like(self.h)
        above = self.at(zero)[which] > level
        there = above != (self.at(one)[which] > level)
        low, high = zero, one
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            same = (self.at(middle)[which] > level) == above
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return np.where(there, low, 0.0)
