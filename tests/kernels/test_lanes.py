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
from stickslip_kernels.blank import new_regimes
from stickslip_kernels.contact import Contact
from stickslip_kernels.drive import STEADY_BELT
from stickslip_kernels.jit import compiled
from stickslip_kernels.lanes import step_lanes
from stickslip_kernels.laws import LAWS, RECURRENCES
from stickslip_kernels.observers.regime import Regime

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
from stickslip_kernels import blank, contact, drive, laws, layout
from stickslip_kernels.observers import regime
import importlib
import numpy as np
from numba import njit
lanes = np.zeros(layout.LANE_NUMBERS)
machine = contact.Contact(
    laws.LAWS["stribeck"], drive.STEADY_BELT, regime.Regime(blank.new_regimes(0), True), lanes,
    np.zeros((layout.CELL_ROWS, 0)), 1e-6, 1e6,
)
loop = importlib.import_module("stickslip_kernels.{module}").{loop}
loop = loop if hasattr(loop, "inspect_asm") else njit(error_model="numpy", fastmath={{"contract"}})(loop)
loop({tag}*{arguments})
print(next(iter(loop.inspect_asm().values())))
"""


FOUND_BY_CROSSING = (at.CROSS_LEVEL, at.CROSS_TIME, at.CROSS_RISE, at.CROSS_FALLEN)
GUESSES = (at.GUESS, at.GUESS_W, at.GUESS_DW, at.GUESS_A, at.GUESS_B)


@compiled
def step(m):
    step_lanes(m)


def machine(law, s):
    return Contact(LAWS[law], STEADY_BELT, Regime(new_regimes(0), True), s, np.empty((at.CELL_ROWS, 0)), 1e-6, 1e6)


@pytest.mark.parametrize("law", LAWS)
def test_every_lane_takes_the_step_it_would_take_alone(law):
    """The step of a lane does not depend on what the others do, nor on which lane it is."""
    random = np.random.default_rng(1)
    together = random.uniform(0.1, 1.0, at.LANE_NUMBERS)
    together[at.TAU_END : at.TAU_END + at.WIDTH] = np.inf
    alone = [np.zeros(at.LANE_NUMBERS) for _ in range(at.WIDTH)]
    for i, s in enumerate(alone):
        place = (i * 7) % at.WIDTH
        s[place :: at.WIDTH] = together[i :: at.WIDTH]
    step(machine(law, together))
    for i, s in enumerate(alone):
        step(machine(law, s))
        place = (i * 7) % at.WIDTH
        np.testing.assert_array_equal(what_counts(s, place), what_counts(together, i))


def what_counts(s, i):
    """The numbers of lane i, but for those of searches that found nothing there: others may have asked for them."""
    numbers = s.copy()
    for found, rows in ((at.CROSSES, FOUND_BY_CROSSING), (at.SOUGHT, (at.TOP, at.TOP_TIME)), (None, GUESSES)):
        if found is None or s[found + i] == 0.0:
            numbers[[row + i for row in rows]] = 0.0
    return numbers[: at.GATHERED][i :: at.WIDTH]


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

    def of(module, loop, arguments, law):
        tag = f"laws.LAWS['{law}'], " if law else ""
        script = PRINT_ASSEMBLY.format(module=module, loop=loop, arguments=arguments, tag=tag)
        kernels = str(Path(at.__file__).parents[1])
        environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / f"{loop}-{law}"), "PYTHONPATH": kernels}
        return subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
        ).stdout

    return of


TAYLOR_LAWS = [name for name, tag in LAWS.items() if type(tag) in RECURRENCES]
BUFFER, BUFFER_AND_RTOL = "(lanes,)", "(lanes, 1e-6)"


@pytest.mark.parametrize(("module", "loop", "arguments", "law", "least"), [
    *(("taylor", "expand", BUFFER, law, 0.99) for law in TAYLOR_LAWS),
    ("taylor", "choose_step", BUFFER_AND_RTOL, None, 0.95),
    ("taylor", "sum_series", BUFFER, None, 0.99),
    ("dense", "subtract_damper_work", BUFFER, None, 0.99),
    *(("taylor", "judge_step", BUFFER, law, 0.95) for law in TAYLOR_LAWS),
    ("runge_kutta", "stages", BUFFER, "stribeck_delta", 0.99),
    ("runge_kutta", "control_step", BUFFER_AND_RTOL, "stribeck_delta", 0.99),
    ("observers.regime", "watch", "(machine,)", None, 0.9),
    *(("observers.tops", "find_tops", BUFFER, law, 0.99) for law in TAYLOR_LAWS),
    ("crossings", "find_crossings", BUFFER, None, 0.99),
    ("observers.margin", "grow_errors", BUFFER, None, 0.9),
    ("lanes", "watch_and_commit", BUFFER, None, 0.9),
])  # fmt: skip
def test_hot_loop_is_packed_arithmetic_of_the_widest_vectors(assembly, module, loop, arguments, law, least):
    found = widest()
    if found is None:
        pytest.skip("this processor names no vector extension LLVM reports")
    feature, packed = found
    text = assembly(module, loop, arguments, law)
    vector = len(re.findall(packed, text))
    scalar = len(re.findall(SCALAR.get(feature, SCALAR_X86), text))
    assert vector >= 10
    assert vector / (vector + scalar) >= least, f"{vector} packed, {scalar} scalar"
    assert not re.search(r"\bcall\w*\b.*\b(exp|pow|log)\b", text), "a call to libm keeps a loop scalar"
