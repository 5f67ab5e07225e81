"""The unstable cycle a second time: SciPy backwards in time, and the polygon of its samples clipped to a box.

Kernel units with m = k = N = 1: x'' + c x' + x = mu(v - x'), t -> -t as it stands, without any change of variables.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from helpers.plain_slip import PlainSlip

TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15, "max_step": 0.05}


def slip_of(belt, curve, damping, way=1.0):
    return PlainSlip({"belt_speed": belt, "damping": damping, **{f"a{i + 1}": a for i, a in enumerate(curve)}}, way=way)


class Cycle:
    """The unstable cycle of a cell: reach (the largest displacement, from steady sliding), period, states over it.

    guess : of the reach; a root of the return map is looked for between half of it and 1 % more.
    """

    def __init__(self, belt, curve, damping, guess):
        self.slip = slip_of(belt, curve, damping, way=-1.0)
        self.steady = self.slip.steady

        def change(reach):
            self.period, states = self.slip.loop(self.steady + reach)
            return states[0, -1] - self.steady - reach

        self.reach = brentq(change, 0.5 * guess, 1.01 * guess, xtol=1e-14)
        change(self.reach)

    def states(self, count=400_000):
        """Displacements and velocities over one period."""
        times, start = np.linspace(0.0, self.period, count, endpoint=False), [self.steady + self.reach, 0.0, 0.0]
        return solve_ivp(self.slip.rates(1.0), (0.0, self.period), start, t_eval=times, **TIGHT).y[:2]

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
    slip = slip_of(belt, curve, damping)

    def motion(_, state):
        x, w = state
        return [belt - w, x + damping * (belt - w) - slip.friction(max(w, 0.0))]

    def turns(t, state):
        return motion(t, state)[1]

    turns.terminal, turns.direction = True, 1.0
    away = solve_ivp(motion, (0.0, 0.1), [slip.static - damping * belt, 0.0], **TIGHT)  # past the minimum at the start
    return solve_ivp(motion, (0.0, 100.0), away.y[:, -1], events=turns, **TIGHT).y_events[0][0][1]
