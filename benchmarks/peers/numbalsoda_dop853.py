"""numbalsoda's DOP853 called from a compiled loop. It has no events, so the end of slip is found by hand.

Slip is integrated half a period at a time on a few output points; the first interval in which the slip speed changes
sign is integrated again to a Newton root. Friction is continued to negative slip speeds as an even function, so that
the overshoot is benign.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from peers import Peer, needs
from problem import A2, A3, A4, MU_START, Answer, Cells

POINTS = 9


@cache
def compiled():
    import numba
    from numba import njit
    from numbalsoda import dop853, lsoda_sig

    @numba.cfunc(lsoda_sig)
    def motion(t, u, du, p):
        du[0] = p[0] * (p[1] - u[1])
        du[1] = u[0] - A2 * u[1] - A3 * (np.exp(-abs(u[1]) / A4) - 1.0)

    address = motion.address

    @njit(error_model="numpy")
    def all_trajectories(address, k_all, belt_all, horizon, rtol, out):
        data, state = np.empty(2), np.empty(2)
        atol, growth = 1e-3 * rtol, A3 / A4 - A2
        grid, pair = np.empty(POINTS), np.zeros(2)
        for i in range(k_all.size):
            k, belt = k_all[i], belt_all[i]
            data[0], data[1] = k, belt
            t, x, running = 0.0, 0.0, True
            while running:
                release = t + (MU_START / k - x) / belt
                if release >= horizon:
                    out[i, 2], out[i, 3] = x + belt * (horizon - t), belt
                    break
                dt = 1e-4 / max(growth, np.sqrt(k))
                state[0] = k * belt * dt * (1 - k * dt**2 / 6)
                state[1] = k * belt * dt**2 * (1 / 2 + growth * dt / 6 + (growth**2 - k) * dt**2 / 24)
                t = release + dt
                while True:
                    if t >= horizon:
                        out[i, 2], out[i, 3] = (state[0] + MU_START) / k, belt - state[1]
                        running = False
                        break
                    length = min(np.pi / np.sqrt(k), horizon - t)
                    for j in range(POINTS):
                        grid[j] = length * j / (POINTS - 1)
                    found, _ = dop853(address, state, grid, data, rtol, atol, 100000)
                    last = 1
                    while last < POINTS and found[last, 1] > 0.0:
                        last += 1
                    if last == POINTS:
                        state[:] = found[-1]
                        t += length
                        continue
                    state[:] = found[last - 1]
                    w0, w1 = found[last - 1, 1], found[last, 1]
                    part = (grid[last] - grid[last - 1]) * w0 / (w0 - w1)
                    for _ in range(8):
                        pair[1] = part
                        there, _ = dop853(address, state, pair, data, rtol, atol, 100000)
                        y, w = there[1, 0], there[1, 1]
                        change = -w / (y - A2 * w - A3 * (np.exp(-abs(w) / A4) - 1.0))
                        part = max(part + change, 1e-9 * length)
                        if abs(change) < 0.03 * rtol**0.5 * length:
                            break
                    t += grid[last - 1] + part
                    x = (y + change * k * belt + MU_START) / k
                    if np.isnan(out[i, 0]):
                        out[i, 0], out[i, 1] = t, x
                    break

    return motion, address, all_trajectories


def solve(cells: Cells, horizon: float, rtol: float) -> Answer:
    _, address, run = compiled()
    out = np.full((len(cells), 4), np.nan)
    run(address, cells.k, cells.belt, horizon, rtol, out)
    return Answer(*out.T)


PEERS = [
    Peer("numbalsoda DOP853 in a Numba loop", "by hand", solve, {1e-6: 1000, 1e-9: 1000}, needs("numbalsoda", "numba"))
]
