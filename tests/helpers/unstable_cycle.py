"""The unstable cycle a second time: SciPy backwards in time, and the polygon of its samples clipped to a box.

Kernel units with m = k = N = 1: x'' + c x' + x = mu(v - x'), t -> -t as it stands, without any change of variables.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 0.05}


class Cycle:
    """The unstable cycle of a cell: reach (the largest displacement, from steady sliding), period, states over it.

    guess : of the reach; a root of the return map is looked for between half of it and 1 % more.
    """

    def __init__(self, belt, curve, damping, guess):
        a1, a2, a3, a4 = curve
        self.steady = a1 + a2 * belt + a3 * np.exp(-belt / a4)

        def backwards(_, state):
            x, v = state
            w = belt - v
            return [-v, -(a1 + a2 * w + a3 * np.exp(-w / a4) - damping * v - x)]

        def at_rest(t, state):
            return state[1] if t > 1e-3 else 1.0

        at_rest.terminal, at_rest.direction = 2, 0.0

        def turn(reach):
            """Backwards from rest at the right: at rest at the left, and at the right again."""
            done = solve_ivp(
                backwards, (0.0, 100.0), [self.steady + reach, 0.0], events=at_rest, dense_output=True, **TIGHT
            )
            self.motion, self.period = done.sol, done.t_events[0][1]
            return done.y_events[0][1][0] - self.steady

        self.reach = brentq(lambda reach: turn(reach) - reach, 0.5 * guess, 1.01 * guess, xtol=1e-14)
        turn(self.reach)

    def states(self, count=400_000):
        """Displacements and velocities over one period."""
        return self.motion(np.linspace(0.0, self.period, count, endpoint=False))

    def share(self, displacement, velocity):
        """Share of the box inside the cycle."""
        points = self.states().T
        for column, (low, high) in enumerate((displacement, velocity)):
            points = _clipped(_clipped(points, column, low, 1.0), column, high, -1.0)
        x, v = points.T
        area = 0.5 * abs(np.dot(x, np.roll(v, -1)) - np.dot(v, np.roll(x, -1))) if len(points) else 0.0
        return area / np.ptp(displacement) / np.ptp(velocity)


def _clipped(points, column, level, sign):
    """The part of a polygon where sign (coordinate - level) >= 0 (Sutherland and Hodgman)."""
    following = np.roll(points, -1, axis=0)
    here, there = sign * (points[:, column] - level), sign * (following[:, column] - level)
    crossing = (here >= 0) != (there >= 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        cut = points + (following - points) * (here / (here - there))[:, np.newaxis]
    both = np.stack([points, cut], axis=1)
    return both.reshape(-1, 2)[np.stack([here >= 0, crossing], axis=1).ravel()]


def least_slip_speed(belt, curve, damping=0.0):
    """The least slip speed at the end of the slip that begins at w = w' = 0; below 0, with mu(0), where it would stick.

    Zero at the fold, where stick-slip and the unstable cycle graze each other.
    """
    a1, a2, a3, a4 = curve

    def motion(_, state):
        x, w = state
        speed = max(w, 0.0)
        return [belt - w, x + damping * (belt - w) - (a1 + a2 * speed + a3 * np.exp(-speed / a4))]

    def turns(t, state):
        return motion(t, state)[1]

    turns.terminal, turns.direction = True, 1.0
    away = solve_ivp(motion, (0.0, 0.1), [a1 + a3 - damping * belt, 0.0], **TIGHT)  # past the minimum at the start
    return solve_ivp(motion, (0.0, 100.0), away.y[:, -1], events=turns, **TIGHT).y_events[0][0][1]
