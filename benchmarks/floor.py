"""The floor: what a step must cost at least on this machine, from its operations and the measured FMA rate.

Operations of one Taylor step are counted from its order, an operation being an addition, a multiplication, a fused
multiply-add, a minimum or a maximum of doubles; the integer operations of the exponential run beside them on other
ports and are left out, and so are event guards, which are the product's, not the method's. The rate is that of packed
fused multiply-adds on numbers in the first cache, compiled here by Numba.
"""

from __future__ import annotations

from time import process_time

import numpy as np
from numba import njit

from stickslip_kernels.layout import ORDER

EXPONENTIAL = {"clamp": 2, "reduction": 4, "polynomial of degree 12": 12}
NUMBERS = 64  # in the first cache; eight operations between load and store, so that memory does not bound the rate


def operations() -> dict[str, int]:
    """Operations of a trial step by part."""
    parts = {
        # the coefficient of order n + 1 of the weakening is a sum of n + 1 products
        "products of series": sum(n + 1 for n in range(ORDER - 1)),
        # each order: that of y, y - drag w - x, over n + 1; minus rate, over n + 1
        "the rest of the coefficients": 6 * ORDER,
        "exponential": sum(EXPONENTIAL.values()),
        "four sums: w, w' and two integrals": 4 * ORDER,
        "state at the end, friction work": 14,
        "scale, logarithms, step size": 24,
        "defect, verdict": 8,
    }
    return parts | {"all": sum(parts.values())}


@njit(error_model="numpy", fastmath={"contract"})
def _multiply_add(state, factor, term, repeats):
    for _ in range(repeats):
        for i in range(NUMBERS):
            x = state[i]
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            x = x * factor + term
            state[i] = x * factor + term


def fma_rate(repeats: int = 5) -> float:
    """Packed double-precision fused multiply-adds per second on one core: the best of the repetitions."""
    state, turns = np.zeros(NUMBERS), 500_000
    _multiply_add(state, 0.999, 1e-3, 1)
    seconds = []
    for _ in range(repeats):
        began = process_time()
        _multiply_add(state, 0.999, 1e-3, turns)
        seconds.append(process_time() - began)
    return turns * NUMBERS * 8 / min(seconds)


if __name__ == "__main__":
    print(operations(), f"{fma_rate():.3g} FMA/s")
