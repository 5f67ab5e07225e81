"""The hot loop is one integrator with the scalar step, and really vector code."""

import os
import re
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

from stickslip_kernels import layout as at
from stickslip_kernels.lanes import try_step
from stickslip_kernels.rk import rk_step, slip_acceleration

# The widest vectors of the processor: the feature that brings them, and the packed multiply-adds on whole registers.
WIDEST = (
    ("avx512f", r"\bv(?:fn?m(?:add|sub)\d+|mul|add|sub)pd\b.*%zmm"),
    ("avx", r"\bv(?:fn?m(?:add|sub)\d+|mul|add|sub)pd\b.*%ymm"),
    ("sse2", r"\b(?:mul|add|sub)pd\b.*%xmm"),
    ("neon", r"\b(?:fmla|fmls|fmul|fadd|fsub)(?:\.2d|\s+v\d+\.2d)"),
)
SCALAR = {"neon": r"\b(?:fmadd|fmsub|fmul|fadd|fsub)\s+d\d+"}
SCALAR_X86 = r"\bv?(?:fn?m(?:add|sub)\d+|mul|add|sub)sd\b"

PRINT_ASSEMBLY = """
from stickslip_kernels import block, lanes, layout
import numpy as np
lanes.{loop}(*{arguments})
print(next(iter(lanes.{loop}.inspect_asm().values())))
"""


def test_lanes_take_the_scalar_step():
    random = np.random.default_rng(1)
    s = random.uniform(0.1, 1.0, at.LANE_NUMBERS)
    s[at.TAU_END : at.TAU_END + at.WIDTH] = np.inf
    rows = (at.Y, at.W, at.B, at.G, at.OFFSET, at.SLOPE, at.DROP, at.RATE)
    for i in range(at.WIDTH):
        y, w, b, gamma, offset, slope, drop, rate = (s[row + i] for row in rows)
        s[at.DW + i] = slip_acceleration(y, w, gamma + slope, drop, rate)
    before = s.copy()
    try_step(s)
    for i in range(at.WIDTH):
        y, w, b, gamma, offset, slope, drop, rate = (before[row + i] for row in rows)
        expected = rk_step(before[at.STEP + i], y, w, before[at.DW + i], b, gamma, offset, slope, drop, rate)
        found = [s[row + i] for row in (at.Y_NEW, at.W_NEW, at.DW_NEW, at.WORK)]
        assert found == pytest.approx(expected, rel=1e-14)


def widest():
    features = llvm.get_host_cpu_features() if llvm.get_default_triple() else {}
    for feature, packed in WIDEST:
        if features.get(feature):
            return feature, packed
    return None


@pytest.fixture(scope="module")
def assembly(tmp_path_factory):
    """Machine code of a loop, compiled afresh: Numba does not keep it for what comes from the cache."""
    folder = tmp_path_factory.mktemp("numba")

    def of(loop, arguments):
        script = PRINT_ASSEMBLY.format(loop=loop, arguments=arguments)
        kernels = str(Path(at.__file__).parents[1])
        environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / loop), "PYTHONPATH": kernels}
        return subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
        ).stdout

    return of


@pytest.mark.parametrize(("loop", "arguments", "least"), [
    ("try_step", "(np.zeros(layout.LANE_NUMBERS),)", 0.99),
    ("control_step", "(np.zeros(layout.LANE_NUMBERS), 1e-6)", 0.99),
    ("watch_and_commit", "(np.zeros(layout.LANE_NUMBERS), 1e6)", 0.9),
])  # fmt: skip
def test_hot_loop_is_packed_arithmetic_of_the_widest_vectors(assembly, loop, arguments, least):
    found = widest()
    if found is None:
        pytest.skip("this processor names no vector extension LLVM reports")
    feature, packed = found
    text = assembly(loop, arguments)
    vector = len(re.findall(packed, text))
    scalar = len(re.findall(SCALAR.get(feature, SCALAR_X86), text))
    assert vector >= 10
    assert vector / (vector + scalar) >= least, f"{vector} packed, {scalar} scalar"
    assert not re.search(r"\bcall\w*\b.*\b(exp|pow|log)\b", text), "a call to libm keeps a loop scalar"
