"""Linearly implicit steps, for contacts with an inner state that follows the slip at rates far above those of the mass.

Such a contact moves in y, v and z, v being the slip speed w or a function of it, and only v' is one of all of them:
y' = B - w and z' are of v and z. What `rates` and `slopes` say of a contact is all that a step needs; y, w and z are in
rows Y, W and WEAK. `kind` is the pair of tags of the contact and of its law.
"""

from math import inf, pi

from .. import layout as at
from ..exponential import rough_exp2, rough_log2
from ..intrinsics import select, widest_vectors
from ..jit import by_type, compiled, in_turn
from ..rosenbrock import RODAS_5P

STAGES, STATES = len(RODAS_5P.matrix), 3
(V_START, PER_H, DIAGONAL, W_01, W_02, L_10, U_11, W_12, L_21, U_22) = range(
    at.SERIES_DW + STAGES * STATES * at.WIDTH, at.SERIES_DW + (STAGES * STATES + 10) * at.WIDTH, at.WIDTH
)
NODES, TIME_WEIGHTS = RODAS_5P.nodes_and_time_weights()
EXPONENT = 0.5 / RODAS_5P.order
LOG2_SAFETY, SHRINK_MOST, GROW_MOST = -0.152003093445, 0.2, 6.0
TINIEST_ERROR2 = 1e-16
LOOP, NEAR = 2.0 * pi, 0.1
MOST_OF_GROWTH, TRIES = 0.5, 100  # radians, or e-folds, of a motion that grows, in a step near steady sliding

_contact = by_type(lambda kind, *_: kind.types[0], inline=True)


def stage_row(n, state):
    """Row of k of stage n."""
    return at.SERIES_DW + (STATES * n + state) * at.WIDTH


ROWS = tuple(tuple(stage_row(n, state) for state in range(STATES)) for n in range(STAGES))
LAST = STAGES - 1
WEIGHTS = (*RODAS_5P.matrix[LAST], 1.0)


@_contact
def variable(kind, s, i):
    """v at the start of the step."""
    return s[at.W + i]


@_contact
def rates(kind, s, i, y, v, z):
    """w, v' and z'."""
    raise NotImplementedError


@_contact
def slopes(kind, s, i, y, v, z):
    """Derivatives of w by v; of v' by y, v and z; of z' by v and z."""
    raise NotImplementedError


@_contact
def couple(kind, s, i, l_10, v_z):
    """Entry (1, 2) of the triangular factors; row W_02 has the derivative of w by z of contacts where w is one of z."""
    return -v_z


@_contact
def coupled(kind, s, i, k_2):
    """What k of z adds to that of w, in such contacts."""
    return 0.0


@compiled
def factorise(kind, s):
    """The time of the step, and 1/(gamma h) - J in triangular factors."""
    widest_vectors()
    for i in range(at.WIDTH):
        near = abs(s[at.W + i] - s[at.B + i]) < NEAR * abs(s[at.B + i])
        s[at.STEP + i] = min(s[at.STEP + i], select(near, s[at.LONGEST + i], inf))
        h = min(s[at.STEP + i], s[at.TAU_END + i] - s[at.TAU + i])
        v = variable(kind, s, i)
        w_v, v_y, v_v, v_z, z_v, z_z = slopes(kind, s, i, s[at.Y + i], v, s[at.WEAK + i])
        diagonal = 1.0 / (RODAS_5P.gamma * h)
        per_d = 1.0 / diagonal
        l_10 = -v_y * per_d
        per_u11 = 1.0 / (diagonal - v_v - l_10 * w_v)
        l_21, w_12 = -z_v * per_u11, couple(kind, s, i, l_10, v_z)
        s[at.TAKEN + i], s[V_START + i], s[PER_H + i] = h, v, 1.0 / h
        s[DIAGONAL + i], s[W_01 + i], s[L_10 + i], s[U_11 + i], s[W_12 + i], s[L_21 + i] = (
            per_d, w_v, l_10, per_u11, w_12, l_21
        )  # fmt: skip
        s[U_22 + i] = 1.0 / (diagonal - z_z - l_21 * w_12)


def stage_loop(n):
    """The loop of stage n: straight-line code, since its rows and weights are constants."""
    a, coupling, node, time_weight = RODAS_5P.matrix[n], RODAS_5P.coupling[n], NODES[n], TIME_WEIGHTS[n]
    own, first = ROWS[n], n == 0

    @compiled
    def loop(kind, s):
        widest_vectors()
        for i in range(at.WIDTH):
            h, y, v, z = s[at.TAKEN + i], s[at.Y + i], s[V_START + i], s[at.WEAK + i]
            r_0, r_1, r_2 = 0.0, 0.0, 0.0
            if not first:
                for j in range(n):
                    k_0, k_1, k_2 = s[ROWS[j][0] + i], s[ROWS[j][1] + i], s[ROWS[j][2] + i]
                    y, v, z = y + a[j] * k_0, v + a[j] * k_1, z + a[j] * k_2
                    r_0, r_1, r_2 = r_0 + coupling[j] * k_0, r_1 + coupling[j] * k_1, r_2 + coupling[j] * k_2
            w, of_v, of_z = rates(kind, s, i, y, v, z)
            per_h, moved = s[PER_H + i], s[at.ALPHA + i] * h
            b_0 = s[at.B + i] + node * moved - w + r_0 * per_h + time_weight * moved
            b_1 = of_v + r_1 * per_h - s[L_10 + i] * b_0
            b_2 = of_z + r_2 * per_h - s[L_21 + i] * b_1
            k_2 = b_2 * s[U_22 + i]
            k_1 = (b_1 - s[W_12 + i] * k_2) * s[U_11 + i]
            k_0 = (b_0 - s[W_01 + i] * k_1 - coupled(kind, s, i, k_2)) * s[DIAGONAL + i]
            s[own[0] + i], s[own[1] + i], s[own[2] + i] = k_0, k_1, k_2

    return loop


stages = in_turn(stage_loop, 0, STAGES)


@compiled(inline=True)
def end_of_step(s, i):
    """y, v and z at the end of the step."""
    y, v, z = s[at.Y + i], s[V_START + i], s[at.WEAK + i]
    for j in range(STAGES):
        y, v, z = (
            y + WEIGHTS[j] * s[ROWS[j][0] + i],
            v + WEIGHTS[j] * s[ROWS[j][1] + i],
            z + WEIGHTS[j] * s[ROWS[j][2] + i],
        )
    return y, v, z


@compiled(inline=True)
def errors(s, i):
    """Errors of y, v and z in the step."""
    return s[ROWS[LAST][0] + i], s[ROWS[LAST][1] + i], s[ROWS[LAST][2] + i]


@compiled(inline=True)
def step_factor(error2):
    """By how much the next step may be longer; error2 : squared error over its tolerance."""
    factor = rough_exp2(LOG2_SAFETY - EXPONENT * rough_log2(max(error2, TINIEST_ERROR2)))
    factor = min(max(factor, SHRINK_MOST), GROW_MOST)
    factor = select(error2 <= 1.0, factor, min(factor, 0.9))
    return select(error2 < 1e300, factor, SHRINK_MOST)


@compiled
def judge_steady_sliding(s, i, at_once, steady, rate):
    """Rows ATTRACTS, FIRMNESS and LONGEST.

    With the slopes E of friction at once and S of steady friction, gamma in both, and the rate r at which the state
    follows: x^3 + (r + E) x^2 + (1 + r S) x + r has roots with negative real parts only (Routh, Hurwitz).

    J. R. Rice, A. L. Ruina, J. Appl. Mech. 50 (1983) 343. A method that damps what is fast damps what grows as well.
    """
    square, linear = rate + at_once, 1.0 + rate * steady
    excess = square * linear - rate
    s[at.ATTRACTS + i] = 1.0 if square > 0.0 and excess > 0.0 else 0.0
    turns, size = abs(linear) ** 0.5, (abs(linear) + square * square) ** 0.5
    moved = 0.5 * abs(excess) / (turns * size)  # of x = i linear^(1/2), to first order: is that enough?
    is_near = linear > 0.0 and moved * (3.0 * turns + abs(square)) < NEAR * turns * size
    s[at.FIRMNESS + i] = min(LOOP * moved / size, 1.0) if is_near else 1.0
    if s[at.ATTRACTS + i] == 0.0:
        x = -1.0 - abs(square) - abs(linear) - rate  # below the root that is negative
        for _ in range(TRIES):
            x -= (((x + square) * x + linear) * x + rate) / ((3.0 * x + 2.0 * square) * x + linear)
        s[at.LONGEST + i] = MOST_OF_GROWTH / max((-rate / x) ** 0.5, -square - x)
