"""Compiled code is kept between runs and never outlives an edit of a law."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip_kernels

KERNELS = Path(stickslip_kernels.__file__).parent
PRINT_FRICTION = """
from stickslip_kernels.contacts.stribeck.laws import stribeck
print(2.0 * stribeck.shape(0.0, 1.0), sum(stribeck.shape.stats.cache_hits.values()))
"""


@pytest.fixture
def edited(tmp_path):
    """A copy of the kernels to edit; runs a script on it with a cache of its own."""
    package = tmp_path / "root" / "stickslip_kernels"
    shutil.copytree(KERNELS, package, ignore=shutil.ignore_patterns("__pycache__"))
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(package.parent)}

    def run(script):
        command = [sys.executable, "-B", "-c", script]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split()

    return package, run


@pytest.mark.slow
def test_an_edit_in_another_file_gives_new_numbers(edited):
    """Numba's own check sees only the file of the function."""
    package, run = edited
    assert run(PRINT_FRICTION)[0] == "2.0"
    below = package / "exponential.py"
    text = below.read_text()
    assert "low = (1.0 + r)" in text
    below.write_text(text.replace("low = (1.0 + r)", "low = (2.0 + r)"))
    assert run(PRINT_FRICTION) == ["4.0", "0"]


def test_importing_the_kernels_leaves_the_settings_of_numba_alone():
    script = (
        "import numba; a = numba.config.CACHE_DIR; import stickslip_kernels.block; print(a == numba.config.CACHE_DIR)"
    )
    environment = os.environ | {"PYTHONPATH": str(KERNELS.parent)}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True"
