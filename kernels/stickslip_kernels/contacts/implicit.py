"""Linearly implicit steps, for contacts with an inner state that follows the slip at rates far above those of the mass.

Such a contact moves in y, v and z, v being the slip speed w or a function of it, and only v' is one of all of them:
y' = B - w and z' are of v and z. What `rates` and `slopes` say of a contact is all that a step needs; y, w and z are in
rows Y, W and WEAK. `kind` is the pair of tags of the contact and of its law.

The method is that of Rosenbrock: Runge-Kutta, linearly implicit, for rates that differ by dozens of decades.
A step of size h solves, one stage after the other and with one matrix, for z' = f(t, z) with the Jacobian J,

    (1/(gamma h) - J) k_i = f(t + c_i h, z + sum_j a_ij k_j) + sum_j c_ij k_j/h + d_i h f_t

(E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.7, Eq. 7.25). The last stage is the error.
"""

from math import inf, pi
from typing import NamedTuple

import numpy as np

from .. import layout as at
from ..arithmetic import in_turn, rough_exp2, rough_log2, select, widest_vectors
from ..jit import by_type, compiled


class Rosenbrock(NamedTuple):
    """A stiffly accurate method. matrix, coupling : rows of a_ij and of c_ij."""

    gamma: float
    matrix: tuple[tuple[float, ...], ...]
    coupling: tuple[tuple[float, ...], ...]
    order: int

    def nodes_and_time_weights(self):
        """c_i and d_i, which follow: with G = (1/gamma - (c_ij))^-1, row sums of (a_ij) G and of G."""
        n = len(self.matrix)
        a, c = (np.array([[*row, *[0.0] * (n - len(row))] for row in rows]) for rows in (self.matrix, self.coupling))
        g = np.linalg.inv(np.eye(n) / self.gamma - c)
        return tuple(map(float, (a @ g).sum(axis=1))), tuple(map(float, g.sum(axis=1)))


_LAST = (-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946)
# G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia Differential
# Equations package, BIT Numerical Mathematics 63 (2023) 27.
RODAS_5P = Rosenbrock(
    gamma=0.21193756319429014,
    matrix=(
        (),
        (3.0,),
        (2.849394379747939, 0.45842242204463923),
        (-6.954028509809101, 2.489845061869568, -10.358996098473584),
        (2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641),
        _LAST,
        (*_LAST, 1.0),
        (*_LAST, 1.0, 1.0),
    ),
    coupling=(
        (),
        (-14.155112264123755,),
        (-17.97296035885952, -2.859693295451294),
        (147.12150275711716, -1.41221402718213, 71.68940251302358),
        (165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306),
        (24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471),
        (
            30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
            -28.087943162872662,
        ),
        (
            37.80277123390563, -3.2571969029072296, 112.26918849496327, 66.9347231244047, -40.06618937091002,
            -54.66780262877968, -9.48861652309627,
        ),
    ),
    order=5,
)  # fmt: skip


# --- of any contact ---------------------------------------------------------------------------------------------------


STAGES, STATES = len(RODAS_5P.matrix), 3
_ROOM = at.Rows(at.SERIES_DW, at.SLOW)  # of series that no implicit step needs
K = _ROOM.take(STATES * STAGES)[0]  # first of the rows of k, stage after stage
V_START, PER_H, DIAGONAL, W_01, W_02, L_10, U_11, W_12, L_21, U_22 = _ROOM.take(10)
NODES, TIME_WEIGHTS = RODAS_5P.nodes_and_time_weights()
MATRIX, COUPLING = (
    tuple((*row, *[0.0] * (STAGES - len(row))) for row in rows) for rows in (RODAS_5P.matrix, RODAS_5P.coupling)
)
EXPONENT = 0.5 / RODAS_5P.order
LOG2_SAFETY, SHRINK_MOST, GROW_MOST = -0.152003093445, 0.2, 6.0
TINIEST_ERROR2 = 1e-16
LOOP, NEAR = 2.0 * pi, 0.1
MOST_OF_GROWTH, TRIES = 0.5, 100  # radians, or e-folds, of a motion that grows, in a step near steady sliding

_contact = by_type(lambda kind, *_: kind.types[0], inline=True)


LAST = STAGES - 1
WEIGHTS = (*RODAS_5P.matrix[LAST], 1.0)


@compiled(inline=True)
def k_of(s, i, n):
    """k of y, v and z of stage n."""
    row = K + n * (STATES * at.WIDTH) + i
    return s[row], s[row + at.WIDTH], s[row + 2 * at.WIDTH]


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


@compiled(inline=True)
def find_stage(kind, s, n):
    """k of stage n: straight-line code, n being a constant where this is merged (`stages`)."""
    widest_vectors()
    for i in range(at.WIDTH):
        h, y, v, z = s[at.TAKEN + i], s[at.Y + i], s[V_START + i], s[at.WEAK + i]
        r_0, r_1, r_2 = 0.0, 0.0, 0.0
        if n > 0:
            for j in range(n):
                k_0, k_1, k_2 = k_of(s, i, j)
                a, c = MATRIX[n][j], COUPLING[n][j]
                y, v, z = y + a * k_0, v + a * k_1, z + a * k_2
                r_0, r_1, r_2 = r_0 + c * k_0, r_1 + c * k_1, r_2 + c * k_2
        w, of_v, of_z = rates(kind, s, i, y, v, z)
        per_h, moved = s[PER_H + i], s[at.ALPHA + i] * h
        b_0 = s[at.B + i] + NODES[n] * moved - w + r_0 * per_h + TIME_WEIGHTS[n] * moved
        b_1 = of_v + r_1 * per_h - s[L_10 + i] * b_0
        b_2 = of_z + r_2 * per_h - s[L_21 + i] * b_1
        k_2 = b_2 * s[U_22 + i]
        k_1 = (b_1 - s[W_12 + i] * k_2) * s[U_11 + i]
        k_0 = (b_0 - s[W_01 + i] * k_1 - coupled(kind, s, i, k_2)) * s[DIAGONAL + i]
        row = K + n * (STATES * at.WIDTH) + i
        s[row], s[row + at.WIDTH], s[row + 2 * at.WIDTH] = k_0, k_1, k_2


@compiled
def stages(kind, s):
    """All of them."""
    in_turn(find_stage, kind, s, 0, STAGES)


@compiled(inline=True)
def end_of_step(s, i):
    """y, v and z at the end of the step."""
    y, v, z = s[at.Y + i], s[V_START + i], s[at.WEAK + i]
    for j in range(STAGES):
        k_0, k_1, k_2 = k_of(s, i, j)
        y, v, z = y + WEIGHTS[j] * k_0, v + WEIGHTS[j] * k_1, z + WEIGHTS[j] * k_2
    return y, v, z


@compiled(inline=True)
def errors(s, i):
    """Errors of y, v and z in the step."""
    return k_of(s, i, LAST)


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
