"""Cycles of contacts with memory by SciPy: motions followed from one passage of the belt's speed to the next.

Kernel units, as in the docs: u is the spring force over the load, w the slip speed. A cycle is a fixed point of the
first return, found by Newton's method from where a motion has come to; its smallest recurrence is its period.
"""

from math import asinh, copysign, exp, inf, log

import numpy as np
from scipy.integrate import solve_ivp

LEAVES = 1e-3  # time in which a motion leaves the section
METHOD = {"method": "LSODA", "rtol": 1e-10}


class RateAndState:
    """The slip law with w = 2 v_0 sinh(chi) e^-c, c = (mu_0 + b ln(v_0 theta/D))/a; the state is (u, chi, psi)."""

    atol = 1e-12

    def __init__(self, cell):
        m, k, load = cell["mass"], cell["stiffness"], cell["normal_load"]
        self.time, self.load, self.speed = (m / k) ** 0.5, load, load / (k * m) ** 0.5
        self.belt, self.gamma = cell["belt_speed"] / self.speed, cell.get("damping", 0.0) / (k * m) ** 0.5
        self.a, self.b, self.mu_0 = cell["a"], cell["b"], cell["mu_0"]
        self.v_0, self.distance = cell["v_0"] / self.speed, cell["D_c"] * k / load
        w, contact = self.belt - cell["velocity"] / self.speed, cell["contact_time"] / self.time
        psi = log(contact * self.belt / self.distance)
        self.start = np.array([0.0, self.chi(w, psi), psi])

    def level(self, psi):
        return (self.mu_0 + self.b * (log(self.v_0 / self.belt) + psi)) / self.a

    def chi(self, w, psi):
        return copysign(asinh(abs(w) / (2.0 * self.v_0) * exp(self.level(psi))), w)

    def slip(self, y):
        return 2.0 * self.v_0 * np.sinh(y[1]) * np.exp(-self.level(y[2]))

    def at_section(self, u, psi):
        return np.array([u, self.chi(self.belt, psi), psi])

    def rates(self, _, y):
        c, (u, chi, psi) = self.level(y[2]), y
        there, back = self.v_0 * np.exp(np.clip([chi - c, -chi - c], -300.0, 300.0))  # beyond only in trial steps
        w = there - back
        by_state = -abs(w) / self.distance * (log(abs(w) / self.belt) + psi) if w else 0.0
        pull = u + self.gamma * (self.belt - w) - self.a * chi
        return self.belt - w, (pull + self.b / self.a * by_state * w) / (there + back), by_state


class Bristles:
    """LuGre bristles on a Stribeck curve; the state is (u, w, sigma_0 z)."""

    atol = 1e-13

    def __init__(self, cell):
        m, k, load = cell["mass"], cell["stiffness"], cell["normal_load"]
        self.time, self.load, self.speed = (m / k) ** 0.5, load, load / (k * m) ** 0.5
        self.belt, self.gamma = cell["belt_speed"] / self.speed, cell["damping"] / (k * m) ** 0.5
        self.a1, self.a2, self.a3, self.a4 = cell["a1"], cell["a2"] * self.speed, cell["a3"], cell["a4"] / self.speed
        self.stiff, self.damp = cell["contact_stiffness"] / k, cell["contact_damping"] / (k * m) ** 0.5
        self.start = np.zeros(3)

    def slip(self, y):
        return y[1]

    def at_section(self, u, z):
        return np.array([u, self.belt, z])

    def rates(self, _, y):
        u, w, z = y
        yields = w - abs(w) * z / (self.a1 + self.a3 * exp(-abs(w) / self.a4))
        friction = z + self.damp * yields + self.a2 * w
        return self.belt - w, u + self.gamma * (self.belt - w) - friction, self.stiff * yields


def loop(contact, y):
    """The motion from the section to its next passage: duration, state there, extremes of u and w.

    Raises ArithmeticError where it does not come back.
    """

    def passes(_, state):
        return contact.slip(state) / contact.belt - 1.0

    passes.direction, passes.terminal = 1.0, True
    options = METHOD | {"atol": contact.atol}
    away = solve_ivp(contact.rates, (0.0, LEAVES), y, **options)
    rest = solve_ivp(contact.rates, (LEAVES, 1e5), away.y[:, -1], events=passes, **options)
    if rest.status != 1:
        raise ArithmeticError("the motion does not come back")
    states = np.concatenate([away.y, rest.y, rest.y_events[0].T], axis=1)
    w = contact.slip(states)
    return rest.t_events[0][0], rest.y_events[0][0], states[0].max(), states[0].min(), w.max(), w.min()


def returned(contact, place, loops=1):
    """Where so many loops lead, in the section (u and the inner state); how long they take; extremes of u and w."""
    y, time, extremes = contact.at_section(*place), 0.0, np.array([-inf, inf, -inf, inf])
    for _ in range(loops):
        duration, y, *ends = loop(contact, y)
        time += duration
        extremes[::2] = np.maximum(extremes[::2], ends[::2])
        extremes[1::2] = np.minimum(extremes[1::2], ends[1::2])
    return y[[0, 2]], time, extremes


def cycle_near(contact, place, loops=1):
    """The cycle of so many loops near a place: period, extremes of u and w, multipliers; None where Newton fails."""
    place = np.asarray(place)
    for _ in range(15):
        there, time, extremes = returned(contact, place, loops)
        width = extremes[0] - extremes[1]
        shift = 1e-5 * width
        slopes = np.stack(
            [(returned(contact, place + d, loops)[0] - returned(contact, place - d, loops)[0]) / (2.0 * shift)
             for d in shift * np.eye(2)], axis=1,
        )  # fmt: skip
        if np.abs(there - place).max() < 1e-9 * width:
            return time, extremes, np.linalg.eigvals(slopes)
        move = np.linalg.solve(slopes - np.eye(2), place - there)
        place = place + move * min(1.0, 0.3 * width / np.abs(move).max())
    return None


def first_cycle(contact, loops, longest=4):
    """The cycle to which a motion tends, from where it is after so many loops: the one of fewest loops that attracts.

    Returns the loops of the cycle and what `cycle_near` does; None where none is found.
    """
    y = contact.start
    for _ in range(loops):
        _, y, *_ = loop(contact, y)
    for many in range(1, longest + 1):
        found = cycle_near(contact, y[[0, 2]], many)
        if found is not None and np.abs(found[2]).max() < 1.0:
            return many, *found
    return None
