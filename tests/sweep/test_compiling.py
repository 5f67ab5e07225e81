"""Compiling by a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip
import stickslip_kernels

DIGEST = """
import hashlib
import numpy as np
import stickslip
k, v = np.meshgrid(np.logspace(-1, 2, 40), np.linspace(0.02, 1.0, 40))
pair = {"mass": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
ds = stickslip.evaluate(pair | {"stiffness": k.ravel(), "belt_speed": v.ravel()})
print(hashlib.sha256(b"".join(ds[name].values.tobytes() for name in ds)).hexdigest())
"""


@pytest.mark.slow
def test_the_first_run_on_a_machine_has_the_bits_of_all_others(tmp_path):
    """It has the kernels compiled; a process that computes with what it compiled itself differs in last digits."""
    roots = [str(Path(package.__file__).parents[1]) for package in (stickslip, stickslip_kernels)]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": os.pathsep.join(roots)}
    first, second = (
        subprocess.run([sys.executable, "-c", DIGEST], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    )
    assert first.stdout == second.stdout and len(first.stdout) == 65
