"""SciPy's solve_ivp with a terminal event at the end of slip, sticking by hand; right-hand side in Python or Numba.

`cycle` is what a SciPy user writes for P2: stop after one closed cycle, or when the motion has settled to steady
sliding.
"""

from __future__ import annotations

from functools import partial
from math import exp, sqrt

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from peers import Peer
from problem import A2, A3, A4, MU_START, MU_STOP, V_MIN, Answer, Cells

METHODS = ("RK45", "DOP853", "LSODA", "Radau")


def motion(t, state, k, belt):
    """y = k x - mu_start and the slip speed w."""
    y, w = state
    return [k * (belt - w), y - A2 * w - A3 * (exp(-abs(w) / A4) - 1.0)]  # abs: trial stages overshoot w = 0


@njit
def compiled_motion(t, state, k, belt):
    return np.array([k * (belt - state[1]), state[1] * -A2 + state[0] - A3 * (np.exp(-abs(state[1]) / A4) - 1.0)])


def rest(t, state, k, belt):
    return state[1]


rest.terminal, rest.direction = True, -1


def after_release(k, belt):
    """Just after break-away, by the first terms of the series, as the event function is zero at break-away."""
    growth = A3 / A4 - A2
    dt = 1e-4 / max(growth, sqrt(k))
    w = k * belt * dt**2 * (1 / 2 + growth * dt / 6 + (growth**2 - k) * dt**2 / 24)
    return dt, [k * belt * dt * (1 - k * dt**2 / 6), w]


def trajectory(k, belt, horizon, rtol, method, rhs):
    t, x, first = 0.0, 0.0, (np.nan, np.nan)
    while True:
        release = t + (MU_START / k - x) / belt
        if release >= horizon:
            return *first, x + belt * (horizon - t), belt
        dt, state = after_release(k, belt)
        run = solve_ivp(
            rhs, (release + dt, horizon), state, method, events=rest, args=(k, belt), rtol=rtol, atol=1e-3 * rtol
        )
        t, x = run.t[-1], (run.y[0, -1] + MU_START) / k
        if run.status == 0:
            return *first, x, belt - run.y[1, -1]
        if np.isnan(first[0]):
            first = t, x


def solve(cells: Cells, horizon: float, rtol: float, method: str = "DOP853", rhs=motion) -> Answer:
    found = [
        trajectory(k, belt, horizon, rtol, method, rhs)
        for k, belt in zip(cells.k.tolist(), cells.belt.tolist(), strict=True)
    ]
    return Answer(*np.array(found).T)


# --- P2 ---------------------------------------------------------------------------------------------------------------


def cycle(k: float, belt: float, rtol: float = 1e-6, hysteresis: bool = False, horizon: float = 500.0) -> str:
    """Regime of one cell: from break-away until it sticks (one closed cycle), or is within 1e-4 of steady sliding.

    The hysteretic curve by phases: along the curve until the slip speed falls below v_min or turns below it, then
    along the line until standstill or a trough. After the trough it is back on the curve: the jump a user does not see.
    """

    def curve(w):
        return A2 * w + A3 * (exp(-abs(w) / A4) - 1.0)

    dt, state = after_release(k, belt)
    t, line, atol = dt, None, 1e-3 * rtol
    steady = curve(belt)

    def friction(w):
        return curve(w) if line is None else line[0] + line[1] * w

    def rhs(t, s):
        return [k * (belt - s[1]), s[0] - friction(s[1])]

    def stop(t, s):
        return s[1]

    def settled(t, s):
        return (s[0] - steady) ** 2 + k * (s[1] - belt) ** 2 - 1e-8

    def leave_curve(t, s):
        """Falls through v_min, or turns below it; positive while neither has happened."""
        return max(s[1] - V_MIN, rhs(t, s)[1])

    def trough(t, s):
        return rhs(t, s)[1]

    stop.terminal, stop.direction = True, -1
    settled.terminal, settled.direction = True, -1
    leave_curve.terminal, leave_curve.direction = True, -1
    trough.terminal, trough.direction = True, 1
    for _ in range(200):
        events = [stop, settled]
        if hysteresis:
            events.append(leave_curve if line is None else trough)
        run = solve_ivp(rhs, (t, horizon), state, "DOP853", events=events, rtol=rtol, atol=atol)
        if run.status == 0:
            return "unresolved"
        if run.t_events[0].size:
            return "stick_slip"
        if run.t_events[1].size:
            return "sliding"
        t, state = run.t[-1], run.y[:, -1]
        if line is None:
            w, mu = state[1], curve(state[1])
            line = (MU_STOP - MU_START, (mu - (MU_STOP - MU_START)) / w)
        else:
            line = None
    return "unresolved"


# --- the list ---------------------------------------------------------------------------------------------------------


def peer(method: str, rhs, name: str) -> Peer:
    sample = {1e-6: 12, 1e-9: 8} if method != "Radau" else {1e-6: 2}
    run = partial(solve, method=method, rhs=rhs)
    return Peer(f"SciPy {method}, {name} RHS", "events", run, sample, repeats=2)


PEERS = [peer(method, motion, "Python") for method in METHODS]
PEERS += [peer(method, compiled_motion, "Numba") for method in ("DOP853", "LSODA")]
