"""Problem P1 beside SciPy: every cell to t = 100 without early stop, on the same machine in the same run.

    python benchmarks/fixed_horizon.py [SciPy cells]

m = N = 1, c = 0, the article's curve, stiffness logspace(-1, 2, 100) x belt speed linspace(0.02, 0.6, 100), sticking at
x = 0. SciPy: solve_ivp with LSODA and a terminal event at w = 0, the stick phases by hand, on a sample of the cells.
Errors of both are those of the final displacement against our answer at rtol 1e-10, in units of N/k; cells in which the
motion is undecided at that accuracy (a touch that just sticks or just does not) show as the largest ones.
"""

from __future__ import annotations

import sys
from time import perf_counter

import numpy as np
from scipy.integrate import solve_ivp

import stickslip
from quickstart import best
from stickslip import engine

A1, A2, A3, A4 = 1.0, 0.1, 0.3, 0.1
HORIZON = 100.0
MU_START = A1 + A3
STIFFNESS, BELT_SPEED = (
    axis.ravel() for axis in np.meshgrid(np.logspace(-1, 2, 100), np.linspace(0.02, 0.6, 100), indexing="ij")
)


def cells(part=slice(None)):
    return {"mass": 1.0, "normal_load": 1.0, "a1": A1, "a2": A2, "a3": A3, "a4": A4,
            "stiffness": STIFFNESS[part], "belt_speed": BELT_SPEED[part]}  # fmt: skip


def ours(rtol, threads=None, part=slice(None)):
    return stickslip.evaluate(cells(part), rtol=rtol, horizon=HORIZON, early_stop=False, threads=threads)


def scipy_displacement(k, belt, rtol):
    """Final displacement of one cell. Release: x = mu_start N/k, where speed and acceleration vanish together."""

    def motion(t, state):
        x, v = state
        w = belt - v
        return [v, np.sign(w) * (A1 + A2 * abs(w) + A3 * np.exp(-abs(w) / A4)) - k * x]

    def rest(t, state):
        return belt - state[1]

    rest.terminal, rest.direction = True, -1
    t, x = 0.0, 0.0
    while True:
        release = t + (MU_START / k - x) / belt
        if release >= HORIZON:
            return x + belt * (HORIZON - t)
        # The event is zero at release: leave it by the first term of w = belt k (t - release)^2 / 2 + ...
        dt = min(1e-4 / np.sqrt(k), HORIZON - release)
        w = belt * k * dt**2 / 2 * (1 + (A3 / A4 - A2) * dt / 3)
        state = [MU_START / k + belt * dt, belt - w]
        run = solve_ivp(motion, (release + dt, HORIZON), state, "LSODA", events=rest, rtol=rtol, atol=1e-3 * rtol)
        t, x = run.t[-1], run.y[0, -1]
        if run.status == 0:
            return x
        assert abs(k * x) <= MU_START, "the mass would slip backwards, which no cell of P1 does"


def report(name, seconds, count, found, exact, k):
    errors = np.abs(found - exact) * k
    rate = count / seconds
    median, worst, far = np.median(errors), np.quantile(errors, 0.99), int((errors > 1e-2).sum())
    print(f"{name:34}{rate:12,.0f} trajectories/s   error: median {median:.1e}, 99 % below {worst:.1e}, {far} apart")
    return rate


def main(sample: int = 60) -> None:
    engine.warm_up()
    exact = ours(1e-10)["displacement_end"].values
    for threads in sorted({1, engine.processors()}):
        for rtol in (1e-6, 1e-9):
            seconds = best(lambda rtol=rtol, threads=threads: ours(rtol, threads), 3)
            found = ours(rtol)["displacement_end"].values
            rate = report(f"kernels, rtol {rtol:g}, {threads} threads", seconds, exact.size, found, exact, STIFFNESS)
            if rtol == 1e-6 and threads == 1:
                one_thread = rate
    chosen = np.random.default_rng(1).choice(exact.size, sample, replace=False)
    began = perf_counter()
    found = np.array([scipy_displacement(STIFFNESS[i], BELT_SPEED[i], 1e-6) for i in chosen])
    seconds = perf_counter() - began
    rate = report(f"SciPy LSODA, rtol 1e-06, {sample} cells", seconds, sample, found, exact[chosen], STIFFNESS[chosen])
    print(f"ratio, one thread each: {one_thread / rate:,.0f}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
