"""Friction smoothed to tanh(u/eps) through one stiff solver, no events: the most common approach.

LSODA through SciPy, the right-hand side in Python. "Re-stick" is where the slip speed first falls below eps again; this
model has no such time, which is part of the error shown.
"""

from __future__ import annotations

from functools import partial
from math import exp, tanh

import numpy as np
from scipy.integrate import solve_ivp

from peers import Peer
from problem import A1, A2, A3, A4, Answer, Cells


def trajectory(k, belt, horizon, rtol, eps):
    def motion(t, state):
        x, v = state
        u = belt - v
        w = abs(u)
        return [v, tanh(u / eps) * (A1 + A2 * w + A3 * exp(-w / A4)) - k * x]

    run = solve_ivp(motion, (0.0, horizon), [0.0, belt], "LSODA", rtol=rtol, atol=1e-3 * rtol)
    u, first = belt - run.y[1], (np.nan, np.nan)
    slipping = u > 0.05 * belt + 3 * eps
    if slipping.any():
        started = int(np.argmax(slipping))
        stuck = np.flatnonzero(u[started:] < eps)
        if stuck.size:
            i = started + int(stuck[0])
            share = (u[i - 1] - eps) / (u[i - 1] - u[i])
            first = run.t[i - 1] + share * (run.t[i] - run.t[i - 1]), run.y[0, i]
    return *first, run.y[0, -1], run.y[1, -1]


def solve(cells: Cells, horizon: float, rtol: float, eps: float) -> Answer:
    found = [trajectory(*cell, horizon, rtol, eps) for cell in zip(cells.k.tolist(), cells.belt.tolist(), strict=True)]
    return Answer(*np.array(found).T)


PEERS = [
    Peer(f"tanh(u/{eps:g}), SciPy LSODA", "none: regularised", partial(solve, eps=eps), {1e-6: 12}, repeats=2)
    for eps in (1e-2, 1e-3, 1e-4)
]
