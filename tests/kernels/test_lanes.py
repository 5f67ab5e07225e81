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
from stickslip_kernels.laws import LAWS
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
from stickslip_kernels import block, lanes, laws, layout
import numpy as np
lanes.{loop}({tag}*{arguments})
print(next(iter(lanes.{loop}.inspect_asm().values())))
"""


@pytest.mark.parametrize("law", LAWS)
def test_lanes_take_the_scalar_step(law):
    random = np.random.default_rng(1)
    s = random.uniform(0.1, 1.0, at.LANE_NUMBERS)
    s[at.TAU_END : at.TAU_END + at.WIDTH] = np.inf
    rows = (at.Y, at.W, at.B, at.G, at.OFFSET, at.SLOPE, at.DROP, at.RATE, at.EXPONENT)
    tag = LAWS[law]
    for i in range(at.WIDTH):
        y, w, b, gamma, offset, slope, drop, rate, exponent = (s[row + i] for row in rows)
        s[at.DW + i] = slip_acceleration(tag, y, w, gamma + slope, drop, rate, exponent)
    before = s.copy()
    try_step(tag, s)
    for i in range(at.WIDTH):
        y, w, b, gamma, offset, slope, drop, rate, exponent = (before[row + i] for row in rows)
        h, dw = before[at.STEP + i], before[at.DW + i]
        expected = rk_step(tag, h, y, w, dw, b, gamma, offset, slope, drop, rate, exponent)
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

    def of(loop, arguments, law):
        tag = f"laws.LAWS['{law}'], " if law else ""
        script = PRINT_ASSEMBLY.format(loop=loop, arguments=arguments, tag=tag)
        kernels = str(Path(at.__file__).parents[1])
        environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / f"{loop}-{law}"), "PYTHONPATH": kernels}
        return subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
        ).stdout

    return of


BUFFER = "(np.zeros(layout.LANE_NUMBERS),)"


@pytest.mark.parametrize(("loop", "arguments", "law", "least"), [
    *(("try_step", BUFFER, law, 0.99) for law in LAWS),
    ("control_step", "(np.zeros(layout.LANE_NUMBERS), 1e-6)", "stribeck", 0.99),
    ("watch_and_commit", "(np.zeros(layout.LANE_NUMBERS), 1e6)", None, 0.9),
])  # fmt: skip
def test_hot_loop_is_packed_arithmetic_of_the_widest_vectors(assembly, loop, arguments, law, least):
    found = widest()
    if found is None:
        pytest.skip("this processor names no vector extension LLVM reports")
    feature, packed = found
    text = assembly(loop, arguments, law)
    vector = len(re.findall(packed, text))
    scalar = len(re.findall(SCALAR.get(feature, SCALAR_X86), text))
    assert vector >= 10
    assert vector / (vector + scalar) >= least, f"{vector} packed, {scalar} scalar"
    assert not re.search(r"\bcall\w*\b.*\b(exp|pow|log)\b", text), "a call to libm keeps a loop scalar"
