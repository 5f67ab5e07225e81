"""Slip on the plain curve by SciPy: loops from rest to rest, backwards in time as well, and the first re-stick.

Units in which m = k = N = 1, belts that run forwards. The state is displacement, velocity and friction work.
"""

import numpy as np
from scipy.integrate import solve_ivp

from helpers.scipy_oscillator import SHAPES

LEAVES = 1e-4  # time in which a motion leaves the place where it began
METHOD = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-15}


class PlainSlip:
    """The motion of one cell; `way` is -1.0 backwards in time."""

    def __init__(self, cell, law="stribeck", way=1.0):
        self.belt, self.damping, self.way = cell["belt_speed"], cell.get("damping", 0.0), way
        self.a1, self.a2, self.a3, self.a4 = (cell[f"a{i}"] for i in range(1, 5))
        self.shape, self.delta = SHAPES[law], cell.get("delta", 1.0)
        self.steady, self.static = self.friction(self.belt), self.friction(0.0)

    def friction(self, w):
        return self.a1 + self.a2 * w + self.a3 * self.shape(w / self.a4, self.delta)

    def rates(self, side):
        """Of the state, where slip has this sign."""

        def motion(_, state):
            w = side * (self.belt - state[1])
            friction = self.friction(w)
            return self.way * np.array([state[1], side * friction - self.damping * state[1] - state[0], friction * w])

        return motion

    def slip(self, state, side, longest_step=0.1):
        """Slip of one sign up to w = 0 or to rest at the largest displacement: duration, states, and which it was."""

        def stops(_, state):
            return side * (self.belt - state[1])

        def rests(_, state):
            return self.way * state[1]

        def turns(_, state):  # at the smallest displacement
            return self.way * state[1]

        stops.terminal, stops.direction, rests.terminal, rests.direction = True, -1.0, True, -1.0
        turns.direction = 1.0
        rates = self.rates(side)
        away = solve_ivp(rates, (0.0, LEAVES), state, **METHOD)
        events = (stops, rests, turns)
        rest = solve_ivp(rates, (LEAVES, 1e5), away.y[:, -1], events=events, max_step=longest_step, **METHOD)
        states = np.concatenate([away.y, rest.y_events[2].reshape(-1, 3).T, rest.y], axis=1)
        return rest.t[-1], states, "stops" if rest.t_events[0].size else "rests"

    def loop(self, top):
        """From rest at the largest displacement to the next such rest: duration, states; None if it sticks before."""
        time, state, side, parts = 0.0, np.array([top, 0.0, 0.0]), 1.0, []
        while True:
            duration, states, end = self.slip(state, side)
            time, state = time + duration, states[:, -1]
            parts.append(states)
            if end == "rests":
                return time, np.concatenate(parts, axis=1)
            load = state[0] + self.damping * self.belt
            if abs(load) <= self.static:
                return None
            side = np.sign(load)

    def restick(self, displacement):
        """Where a motion from rest there comes to w = 0 first, and in how many loops."""
        state, loops = np.array([displacement, 0.0, 0.0]), 0
        while True:
            _, states, end = self.slip(state, 1.0, 1.0)
            if end == "stops":
                return states[0, -1], loops
            state, loops = states[:, -1], loops + 1
