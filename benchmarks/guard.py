"""The speed guard of continuous integration: ours over the scalar Numba baseline, side by side in one process.

    python benchmarks/guard.py [least ratio at 1e-6] [least ratio at 1e-9]

Both solve the same cells of P1 on one thread, alternately; the ratio of their smallest CPU seconds does not depend
on how fast the machine is, and less than either on what else it does. Exit code 1 where a ratio is below its bound,
or an error above.
"""

from __future__ import annotations

import sys
from functools import partial

import problem
from measure import Job, interleave
from peers import numba_scalar
from problem import HORIZON

CELLS = 1500
REPEATS = 7
# rtol: (least ratio, largest median error of the first re-stick time). The ratios are half of what was measured when
# they were set, since a busy host slows vector code by up to 40 % and the baseline hardly: raise them with each gain.
BOUNDS = {1e-6: (7.0, 1e-6), 1e-9: (15.0, 5e-10)}


def main(least: list[float]) -> int:
    cells, exact, _ = problem.p1()
    part = cells.part(slice(0, CELLS))
    failed = False
    for (rtol, (bound, worst)), given in zip(BOUNDS.items(), least + [None, None], strict=False):
        bound = bound if given is None else given
        actions = [partial(solve, part, HORIZON, rtol) for solve in (problem.ours, numba_scalar.solve)]
        for action in actions:
            action()  # compiles
        ours, base = (Job(action, REPEATS) for action in actions)
        interleave([ours, base])
        ratio = min(base.timings.cpu) / min(ours.timings.cpu)
        error = problem.errors(ours.result, exact, cells).time
        good = ratio >= bound and error <= worst
        failed |= not good
        print(
            f"rtol {rtol:g}: {ratio:.2f} x the scalar baseline (at least {bound:g}), "
            f"error {error:.1e} (at most {worst:g}): {'good' if good else 'WORSE'}"
        )
    return int(failed)


if __name__ == "__main__":
    sys.exit(main([float(word) for word in sys.argv[1:]]))
