"""Collocation at the five nodes of Radau IIA, order 9, by full Newton with dense elimination; three states.

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8. All coefficients follow from the nodes.
"""

import numpy as np
from numpy.polynomial import legendre

from .jit import compiled
from .memory_motion import jacobian, rates

STAGES, STATES = 5, 3
SIZE = STAGES * STATES


def _coefficients():
    nodes = 0.5 * (np.sort(legendre.legroots([0.0, 0.0, 0.0, 0.0, -1.0, 1.0])) + 1.0)
    nodes[-1] = 1.0
    orders = np.arange(1, STAGES + 1)
    powers = nodes[:, None] ** (orders - 1)
    matrix = (nodes[:, None] ** orders / orders) @ np.linalg.inv(powers)
    eigenvalues = np.linalg.eigvals(np.linalg.inv(matrix))
    gamma = 1.0 / eigenvalues[np.argmin(np.abs(eigenvalues.imag))].real
    of_start = np.where(orders == 1, gamma, 0.0)
    lower = np.linalg.solve(powers.T, 1.0 / orders - of_start)  # weights of order 5, with f at the start
    error = (lower - matrix[-1]) @ np.linalg.inv(matrix)
    polynomial = np.linalg.inv(np.concatenate([[0.0], nodes])[:, None] ** np.arange(STAGES + 1))
    return nodes, matrix, gamma, error, polynomial


NODES, MATRIX, GAMMA, ERROR, POLYNOMIAL = _coefficients()


@compiled
def solve(a, b, n):
    """a x = b by elimination with pivots, in place; False if a is singular or not finite."""
    for column in range(n):
        pivot = column
        for row in range(column + 1, n):
            if abs(a[row, column]) > abs(a[pivot, column]):
                pivot = row
        if not 0.0 < abs(a[pivot, column]) < np.inf:
            return False
        if pivot != column:
            for j in range(column, n):
                a[column, j], a[pivot, j] = a[pivot, j], a[column, j]
            b[column], b[pivot] = b[pivot], b[column]
        for row in range(column + 1, n):
            factor = a[row, column] / a[column, column]
            if factor != 0.0:
                for j in range(column + 1, n):
                    a[row, j] -= factor * a[column, j]
                b[row] -= factor * b[column]
    for row in range(n - 1, -1, -1):
        for j in range(row + 1, n):
            b[row] -= a[row, j] * b[j]
        b[row] /= a[row, row]
    return True


@compiled
def step(p, y, h, sizes, z, work):
    """A step from y: z (STAGES, STATES), stage values less y. False where Newton's method does not converge.

    sizes : of the states, what counts as 1. work : (a, b, rates of all stages, a Jacobian).
    """
    a, b, f, j = work
    z[:] = 0.0
    before = np.inf
    for _ in range(25):
        a[:] = 0.0
        for n in range(STAGES):
            rates(p, y + z[n], f[n])
            jacobian(p, y + z[n], j)
            for m in range(STAGES):
                for row in range(STATES):
                    for column in range(STATES):
                        a[STATES * m + row, STATES * n + column] = -h * MATRIX[m, n] * j[row, column]
        for m in range(STAGES):
            for row in range(STATES):
                a[STATES * m + row, STATES * m + row] += 1.0
                total = -z[m, row]
                for n in range(STAGES):
                    total += h * MATRIX[m, n] * f[n, row]
                b[STATES * m + row] = total
        if not solve(a, b, SIZE):
            return False
        change = 0.0
        for m in range(STAGES):
            for row in range(STATES):
                z[m, row] += b[STATES * m + row]
                change = max(change, abs(b[STATES * m + row]) / sizes[row])
        if not change < 1e3:
            return False
        if change < 1e-13 or (change < 1e-9 and change > 0.3 * before):
            return True
        before = change
    return False


@compiled
def error_of(p, y, h, sizes, z, work):
    """The embedded estimate, of order 5, over the sizes of the states."""
    a, b, f, j = work
    rates(p, y, f[0])
    jacobian(p, y, j)
    for row in range(STATES):
        total = h * GAMMA * f[0, row]
        for n in range(STAGES):
            total += ERROR[n] * z[n, row]
        b[row] = total
        for column in range(STATES):
            a[row, column] = (1.0 if row == column else 0.0) - h * GAMMA * j[row, column]
    if not solve(a, b, STATES):
        return np.inf
    error = 0.0
    for row in range(STATES):
        error = max(error, abs(b[row]) / sizes[row])
    return error


@compiled
def polynomial_of(y, z, c):
    """Coefficients c (STAGES + 1, STATES) of the collocation polynomial, in powers of the share of the step."""
    for power in range(STAGES + 1):
        for row in range(STATES):
            total = POLYNOMIAL[power, 0] * y[row]
            for n in range(STAGES):
                total += POLYNOMIAL[power, n + 1] * (y[row] + z[n, row])
            c[power, row] = total


@compiled
def at_share(c, row, x):
    """A state, and its derivative by the share, at the share x of a step."""
    value, slope = 0.0, 0.0
    for power in range(STAGES, -1, -1):
        slope = slope * x + value
        value = value * x + c[power, row]
    return value, slope
