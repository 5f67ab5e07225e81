"""The seam to the kernels: SI outside, kernel units inside.

Only this package knows the kernels. `dispatch.py` converts, and has the kernels that suit a cell compute it, also over
time; `cells.py` has blocks of cells on a pool of threads; `compiling.py` knows what is in the cache, and fills it.
"""

from stickslip.engine.cells import (
    blank_results,
    blocks,
    bytes_per_cell,
    compute,
    compute_range,
    in_order,
    processors,
    solve,
    spread,
)
from stickslip.engine.compiling import is_cached, kernels_digest, processor, warm_up, will_compile
from stickslip.engine.dispatch import (
    RigRuns,
    Sampling,
    by_theory,
    compute_rigs,
    flows,
    friction_at_belt_speed,
    kernels_for,
    sampled,
    to_kernel,
    trajectory,
)
from stickslip.engine.options import (
    Computed,
    Options,
    Progress,
    Results,
    SolverKeywords,
    StopFlag,
    columns,
    joined,
    stop_flag,
)
from stickslip.vocabulary.models.model import Scales

__all__ = [
    "Computed", "Options", "Progress", "Results", "RigRuns", "Sampling", "Scales",
    "SolverKeywords", "StopFlag", "blank_results", "blocks", "by_theory", "bytes_per_cell", "columns", "compute",
    "compute_range", "compute_rigs", "flows", "friction_at_belt_speed", "in_order", "is_cached", "joined",
    "kernels_digest", "kernels_for", "processor", "processors", "sampled", "solve", "spread", "stop_flag", "to_kernel",
    "trajectory", "warm_up", "will_compile",
]  # fmt: skip
