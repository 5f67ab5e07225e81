"""The floor: what a step must cost at least on this machine, from its operations and the measured FMA rate.

Operations of one Tsitouras step are counted from the tableau the kernels use, an operation being an addition, a
multiplication, a fused multiply-add, a minimum or a maximum of doubles; the integer operations of the exponential run
beside them on other ports and are left out, and so are event guards, heat and extrema, which are the product's, not the
method's. The rate is that of packed fused multiply-adds on numbers in the first cache, compiled here by Numba.
"""

from __future__ import annotations

from time import process_time

import numpy as np
from numba import njit

from stickslip_kernels.tableau import TSITOURAS_54

EXPONENTIAL = {"clamp": 2, "reduction": 4, "polynomial of degree 12": 12}
NUMBERS = 64  # in the first cache; eight operations between load and store, so that memory does not bound the rate


def operations() -> dict[str, int]:
    """Operations of a trial step by part."""
    entries = [sum(a != 0.0 for a in row) for row in TSITOURAS_54.matrix[1:]]
    stages = len(entries)
    errors = sum(e != 0.0 for e in TSITOURAS_54.error_weights)
    parts = {
        # sum_j a_ij k_j takes as many operations as entries; times h and onto w, one more
        "stages of w": sum(entries) + stages,
        # the same, and the node times b, since y' = b - w is linear
        "stages of y": sum(entries) + 2 * stages,
        "right-hand side but for the exponential": 3 * stages,  # y - drag w; - drop shape; rate w
        "exponentials": sum(EXPONENTIAL.values()) * stages,
        "two error estimates": 2 * (errors + 1),
        "scales, norm, verdict": 12,
        "next step size": 12,  # a rough log2 and exp2, clamped
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
