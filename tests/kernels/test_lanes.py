"""The hot loop is really vector code."""

import re
import shutil
import subprocess
import tempfile

import llvmlite.binding as llvm
import pytest

from helpers.nightly import few
from stickslip.engine.compiling import compile_apart
from stickslip_kernels.contacts.stribeck.laws import LAWS

# The widest vectors of the processor: the feature that brings them, and the packed arithmetic on whole registers.
WIDEST = (
    ("avx512f", r"v(?:fn?m(?:add|sub)\d+|mul|add|sub)pd .*%zmm"),
    ("avx", r"v(?:fn?m(?:add|sub)\d+|mul|add|sub)pd .*%ymm"),
    ("sse2", r"(?:mul|add|sub)pd .*%xmm"),
    ("neon", r"(?:fmla|fmls|fmul|fadd|fsub) v\d+\.2d"),
)
SCALAR = r"v?(?:fn?m(?:add|sub)\d+|mul|add|sub)sd |(?:fmadd|fmsub|fmul|fadd|fsub) d\d+"
INSTRUCTION, JUMP = r"^\s+([0-9a-f]+):\s+(\S.*)$", r"(?:j\w+|b\.\w+|b|cbn?z|tbn?z) .*?([0-9a-f]+) <"
LOOPS = 16  # of the lanes in a step: series, error, events, extrema, commit


def widest():
    features = llvm.get_host_cpu_features() if llvm.get_default_triple() else {}
    for feature, packed in WIDEST:
        if features.get(feature):
            return feature, packed
    return None


def loops_of_lanes(law):
    """Instructions by address of the functions that step the lanes, in the objects of a law and of its machine."""
    of_law = compile_apart(law)
    yield from loops_in(of_law.code, r"law\.(try_step|step|step_regularised|confirm_slopes|expand_regularised)")
    yield from loops_in(compile_apart(of_law.machine(False)).code, r".*5block\d(run|run_lanes)B.*")


def loops_in(code, pattern):
    """The same of the functions of such names in an object."""
    with tempfile.NamedTemporaryFile(suffix=".o") as file:
        file.write(code)
        file.flush()
        disassemble = ["objdump", "--disassemble", "--no-show-raw-insn", file.name]
        text = subprocess.run(disassemble, capture_output=True, text=True, check=True).stdout
    functions = re.split(r"^[0-9a-f]+ <(.+)>:$", text, flags=re.MULTILINE)
    for name, body in zip(functions[1::2], functions[2::2], strict=True):
        if re.fullmatch(pattern, name):
            found = re.findall(INSTRUCTION, body, flags=re.MULTILINE)
            yield {int(place, 16): " ".join(instruction.split()) for place, instruction in found}


def straight_loops(instructions):
    """Bodies of the loops without a jump or a call inside."""
    places = list(instructions)
    for k, (place, instruction) in enumerate(instructions.items()):
        target = re.match(JUMP, instruction)
        start = int(target[1], 16) if target else place
        if start < place and start in instructions:
            body = [instructions[at] for at in places[places.index(start) : k]]
            if not any(re.match(r"j|b\.?\w* |cbn?z|tbn?z|call", one) for one in body):
                yield body


def operations(body, pattern):
    """How many instructions of a loop are such."""
    return sum(bool(re.match(pattern, one)) for one in body)


@pytest.mark.skipif(shutil.which("objdump") is None, reason="needs objdump, which comes with gcc")
@pytest.mark.parametrize("law", few(LAWS, 1))
def test_hot_loop_is_packed_arithmetic_of_the_widest_vectors(law):
    """In what is shipped. A loop that calls or branches is none of these, so that their number tells."""
    found = widest()
    if found is None:
        pytest.skip("this processor names no vector extension LLVM reports")
    feature, packed = found
    functions = list(loops_of_lanes(law))
    bodies = [body for instructions in functions for body in straight_loops(instructions)]
    counts = [(operations(body, packed), operations(body, SCALAR)) for body in bodies]
    assert not [count for count in counts if count[1] and sum(count) >= 4]
    if feature == "avx":  # wider ones may be unrolled to no loop at all
        assert sum(vector >= 10 for vector, _ in counts) >= LOOPS
    assert sum(operations(instructions.values(), packed) for instructions in functions) >= 30 * LOOPS
