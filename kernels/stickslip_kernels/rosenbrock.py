"""A Rosenbrock method: linearly implicit Runge-Kutta, for motions with rates that differ by dozens of decades.

A step of size h solves, one stage after the other and with one matrix, for z' = f(t, z) with the Jacobian J,

    (1/(gamma h) - J) k_i = f(t + c_i h, z + sum_j a_ij k_j) + sum_j c_ij k_j/h + d_i h f_t

(E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.7, Eq. 7.25). The last stage is the error.
"""

from typing import NamedTuple

import numpy as np


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
