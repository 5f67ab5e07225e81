"""The hot loop is really vector code."""

import re
import shutil
import subprocess

import llvmlite.binding as llvm
import pytest

from helpers.nightly import few
from stickslip.engine.compiling import compile_apart
from stickslip_kernels import objects
from stickslip_kernels.contacts.stribeck.laws import LAWS

# The widest vectors of the processor: the feature that brings them, and the packed arithmetic on whole registers.
WIDEST = {
    "avx512f": r"v(?:fn?m(?:add|sub)\d+|mul|add|sub)pd .*%zmm", "avx": r"v(?:fn?m(?:add|sub)\d+|mul|add|sub)pd .*%ymm",
    "sse2": r"(?:mul|add|sub)pd .*%xmm", "neon": r"(?:fmla|fmls|fmul|fadd|fsub) v\d+\.2d",
}  # fmt: skip
SCALAR = r"v?(?:fn?m(?:add|sub)\d+|mul|add|sub)sd |(?:fmadd|fmsub|fmul|fadd|fsub) d\d+"
STEPS, LANES = (
    r"law\.(try_step|step|step_regularised|confirm_slopes|expand_regularised)",
    r".*5lanes\d(run|run_lanes)B.*",
)


def arithmetic(code, functions, packed, folder):
    """How many operations on whole registers, and on numbers, the functions of such names in an object have."""
    (folder / "code.o").write_bytes(code)
    disassemble = ["objdump", "--disassemble", "--no-show-raw-insn", folder / "code.o"]
    text = subprocess.run(disassemble, capture_output=True, text=True, check=True).stdout
    parts = re.split(r"^[0-9a-f]+ <(.+)>:$", text, flags=re.MULTILINE)
    body = "".join(body for name, body in zip(parts[1::2], parts[2::2], strict=True) if re.fullmatch(functions, name))
    instructions = [" ".join(found.split()) for found in re.findall(r"^\s+[0-9a-f]+:\s+(\S.*)$", body, re.MULTILINE)]
    return (sum(bool(re.match(pattern, one)) for one in instructions) for pattern in (packed, SCALAR))


@pytest.mark.skipif(shutil.which("objdump") is None, reason="needs objdump, which comes with gcc")
@pytest.mark.parametrize("law", few(LAWS, 1))
def test_hot_loop_is_packed_arithmetic_of_the_widest_vectors(law, tmp_path):
    """In what is shipped: steps of a law have no other, and the machine around them has loops over the lanes."""
    features = llvm.get_host_cpu_features() if llvm.get_default_triple() else {}
    wide = [pattern for feature, pattern in WIDEST.items() if features.get(feature)]
    if not wide:
        pytest.skip("this processor names no vector extension LLVM reports")
    packed, scalar = arithmetic(compile_apart(law).code, STEPS, wide[0], tmp_path)
    assert packed > 150 and scalar <= 0.01 * packed
    packed, _ = arithmetic(
        compile_apart(objects.machine_of(objects.contact_of(law), False)).code, LANES, wide[0], tmp_path
    )
    assert packed > 400
