"""The baseline: one trajectory after another, event-driven, in Numba, `prange` over the cells.

What a good programmer writes without thinking of vector registers: Tsit5 (first same as last, proportional step
control, libm's exp), sticking in closed form, the re-stick located by the root of a cubic Hermite polynomial and,
since that alone spoils the step, by repeating the step to the root. Unknowns are the spring force above break-away y
= k x - mu_start and the slip speed w, in which nothing cancels at break-away. `scalar.cpp` is the same in C++.
"""

from __future__ import annotations

import os

import numba
import numpy as np
from numba import njit, prange

from peers import Peer
from problem import A2, A3, A4, MU_START, Answer, Cells

A21 = 0.161
A31, A32 = -0.008480655492356989, 0.335480655492357
A41, A42, A43 = 2.8971530571054935, -6.359448489975075, 4.3622954328695815
A51, A52, A53, A54 = 5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525
A61, A62, A63 = 5.86145544294642, -12.92096931784711, 8.159367898576159
A64, A65 = -0.071584973281401, -0.028269050394068383
A71, A72, A73 = 0.09646076681806523, 0.01, 0.4798896504144996
A74, A75, A76 = 1.379008574103742, -3.290069515436081, 2.324710524099774
E1, E2, E3 = -0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995
E4, E5, E6, E7 = -0.1447110071732629, 0.5823571654525552, -0.45808210592918697, 0.015151515151515152

ATOL = 1e-3  # over rtol: at break-away the slip speed grows from zero, and its relative error delays the slip


@njit(error_model="numpy", inline="always")
def slip(y, w):
    return y - A2 * w - A3 * (np.exp(-w / A4) - 1.0)


@njit(error_model="numpy")
def step(k, belt, h, y, w, k1):
    """One step of Tsit5: y, w, w' at the end, and the two errors."""
    d1 = k * (belt - w)
    w2 = w + h * (A21 * k1)
    y2 = y + h * (A21 * d1)
    d2, k2 = k * (belt - w2), slip(y2, w2)
    w3 = w + h * (A31 * k1 + A32 * k2)
    y3 = y + h * (A31 * d1 + A32 * d2)
    d3, k3 = k * (belt - w3), slip(y3, w3)
    w4 = w + h * (A41 * k1 + A42 * k2 + A43 * k3)
    y4 = y + h * (A41 * d1 + A42 * d2 + A43 * d3)
    d4, k4 = k * (belt - w4), slip(y4, w4)
    w5 = w + h * (A51 * k1 + A52 * k2 + A53 * k3 + A54 * k4)
    y5 = y + h * (A51 * d1 + A52 * d2 + A53 * d3 + A54 * d4)
    d5, k5 = k * (belt - w5), slip(y5, w5)
    w6 = w + h * (A61 * k1 + A62 * k2 + A63 * k3 + A64 * k4 + A65 * k5)
    y6 = y + h * (A61 * d1 + A62 * d2 + A63 * d3 + A64 * d4 + A65 * d5)
    d6, k6 = k * (belt - w6), slip(y6, w6)
    w7 = w + h * (A71 * k1 + A72 * k2 + A73 * k3 + A74 * k4 + A75 * k5 + A76 * k6)
    y7 = y + h * (A71 * d1 + A72 * d2 + A73 * d3 + A74 * d4 + A75 * d5 + A76 * d6)
    d7, k7 = k * (belt - w7), slip(y7, w7)
    error_w = h * (E1 * k1 + E2 * k2 + E3 * k3 + E4 * k4 + E5 * k5 + E6 * k6 + E7 * k7)
    error_y = h * (E1 * d1 + E2 * d2 + E3 * d3 + E4 * d4 + E5 * d5 + E6 * d6 + E7 * d7)
    return y7, w7, k7, error_y, error_w


@njit(error_model="numpy")
def locate(k, belt, h, y, w, k1, w_end, k_end):
    """Where in a step w falls to zero: time from its start, and y there."""
    low, high = 0.0, 1.0  # bisection on the cubic first: cheap, and cannot fail
    for _ in range(20):
        s = 0.5 * (low + high)
        r = 1.0 - s
        value = (
            (1.0 + 2.0 * s) * r * r * w + s * r * r * h * k1 + s * s * (3.0 - 2.0 * s) * w_end - s * s * r * h * k_end
        )
        if value > 0.0:
            low = s
        else:
            high = s
    part = 0.5 * (low + high) * h
    y_part = y
    for _ in range(8):
        y_part, w_part, k_part, _, _ = step(k, belt, part, y, w, k1)
        change = -w_part / k_part
        if abs(change) < 1e-12 * (1.0 + part):
            y_part += change * k * belt
            part += change
            break
        part = min(max(part + change, 0.0), h)
    return part, y_part


@njit(error_model="numpy")
def trajectory(k, belt, horizon, rtol, out):
    """Sticking from x = 0 to the horizon; out: first re-stick time and x, final x and v."""
    atol = ATOL * rtol
    t, x = 0.0, 0.0
    stiffness_time = 1.0 / np.sqrt(k)
    while True:
        release = t + (MU_START / k - x) / belt
        if release >= horizon:
            out[2], out[3] = x + belt * (horizon - t), belt
            return
        t, y, w, k1 = release, 0.0, 0.0, 0.0
        h = 1e-3 * stiffness_time
        while True:
            h = min(h, horizon - t)
            y_end, w_end, k_end, error_y, error_w = step(k, belt, h, y, w, k1)
            scale_y = atol + rtol * max(abs(y), abs(y_end))
            scale_w = atol + rtol * max(abs(w), abs(w_end))
            error = np.sqrt(0.5 * ((error_y / scale_y) ** 2 + (error_w / scale_w) ** 2))
            factor = min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** -0.2))
            if error > 1.0:
                h *= min(factor, 0.9)
                continue
            if w_end <= 0.0:
                part, y_part = locate(k, belt, h, y, w, k1, w_end, k_end)
                t += part
                x = (y_part + MU_START) / k
                if np.isnan(out[0]):
                    out[0], out[1] = t, x
                break  # |k x| <= mu_start in every cell of P1: the mass sticks
            t, y, w, k1 = t + h, y_end, w_end, k_end
            if t >= horizon:
                out[2], out[3] = (y + MU_START) / k, belt - w
                return
            h *= factor


@njit(parallel=True, error_model="numpy")
def all_trajectories(k, belt, horizon, rtol, out):
    for i in prange(k.size):
        trajectory(k[i], belt[i], horizon, rtol, out[i])


def solve_threads(cells: Cells, horizon: float, rtol: float, threads: int) -> Answer:
    out = np.full((len(cells), 4), np.nan)
    before = numba.get_num_threads()
    numba.set_num_threads(threads)
    try:
        # Cells come in random order (`problem.spread`), so prange's static chunks are even.
        all_trajectories(cells.k, cells.belt, horizon, rtol, out)
    finally:
        numba.set_num_threads(before)
    return Answer(*out.T)


def solve(cells: Cells, horizon: float, rtol: float) -> Answer:
    return solve_threads(cells, horizon, rtol, 1)


PEERS = [
    Peer(
        "Numba scalar, prange (the baseline)",
        "by hand, step repeated to the root",
        solve,
        {1e-6: 4000, 1e-9: 2000},
        solve_threads=solve_threads if (os.cpu_count() or 1) > 1 else None,
        repeats=5,
    )
]
