"""The friction oscillator solved independently: the motion of one cell in kernel units, event by event.

No code in common with the kernels. Slip on the curve is stepped by SciPy's DOP853 pair, with steps that never carry
the slip speed over the steep part of the curve; events are located by stepping again from the start of the step. Stick,
the line of the hysteretic curve and hold are closed forms. The state is (p, w) in the frame of the present sliding
direction sigma, B = sigma b: w = |b - xi'|, and p = sigma xi + gamma B - mu(0) is the load beyond the friction at
w = 0, so that p' = B - w and w' = p - gamma w + mu(0) - mu(w), without cancellation where the contact breaks away.
"""

from math import inf, isnan, nan

import numpy as np

from .band import begin_band, steady
from .curve import speed_of_minimum
from .jit import compiled
from .layout import (
    A1, A3, AMPLITUDE, BELT, BOOK, CROSSED, DONE, ETA0, FALL, FIRST_SLIP, GAMMA, MEMORY, PROVEN, RATIO, REGIME,
    RELEASED_BOOK, RELEASE_LOAD, REST, REVERSAL, SETTLES, SIGMA, STATES, STATIC, STEPS, STOP, TO_FAST, TO_RISE,
    UNDECIDED, WHOLE, W_MIN, XI0, P, W,
)  # fmt: skip
from .phases import fall, rest, slip
from .settling import answer_point, forget, note, prove_settling
from .stepping import rate


@compiled
def begin(c, s, books):
    """The start: whether it sticks to the belt."""
    mu0 = c[A1] + c[A3]
    s[W_MIN] = 0.0 if isnan(c[STOP]) else speed_of_minimum(c)
    prove_settling(c, s)
    s[AMPLITUDE], s[RATIO], s[FIRST_SLIP], s[RELEASE_LOAD] = nan, nan, nan, c[STATIC]
    s[REVERSAL] = inf
    for book in range(3):
        forget(books[book])
    relative = 0.0 if isnan(c[ETA0]) else c[BELT] - c[ETA0]
    s[SIGMA] = -1.0 if relative < 0.0 else 1.0
    s[W], s[P] = abs(relative), s[SIGMA] * (c[XI0] + c[GAMMA] * c[BELT]) - mu0
    if relative != 0.0:
        begin_band(c, s)
    return relative == 0.0


@compiled
def judge_cell(c, out, rtol, share, most_steps):
    """Follow the motion of cell c (CELL_ROWS) until its regime is certain; the answers (ANSWERS) go to out.

    rtol : of a step. share : of a4, by which w may change in a step on the steep part.
    """
    s, books, k = np.zeros(STATES), np.empty((3, BOOK)), np.zeros((13, 3))
    memory = np.zeros((MEMORY, RELEASED_BOOK + BOOK))
    out[:] = nan
    out[REGIME], out[STEPS] = UNDECIDED, 0.0
    starting, fast = begin(c, s, books), False
    what = REST if starting else TO_RISE
    if not starting and s[W_MIN] > 0.0:
        dw = rate(c, s[P], s[W])
        fast = s[W] >= s[W_MIN]
        note(c, s, books, s[P], s[W], dw)
        if not fast and (dw < 0.0 or (dw == 0.0 and s[W] > s[SIGMA] * c[BELT])):
            what = FALL
    while what != DONE and out[STEPS] < most_steps:
        if what == REST:
            what, fast = rest(c, s, out, books, memory, starting), False
        elif what == FALL:
            what, fast = fall(c, s, out, books), False
        else:
            fast = fast or what == TO_FAST
            what = slip(c, s, out, books, k, fast, rtol, share, most_steps)
        starting = False
    if out[REGIME] == UNDECIDED and s[PROVEN] > 0.0 and s[CROSSED] >= 2.0:  # damped, if slowly
        answer_point(c, s, out, SETTLES, books[WHOLE], steady(c))


@compiled
def judge_cells(cells, out, rtol, share, most_steps):
    """`judge_cell` for every row of cells (n, CELL_ROWS)."""
    for i in range(cells.shape[0]):
        judge_cell(cells[i], out[i], rtol, share, most_steps)
