"""Damaged results: an error for people, or what was meant; see `fuzz_files.py`."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from helpers.fuzzing import EXAMPLES

TESTS = Path(__file__).parents[1]
SEED = os.environ.get("STICKSLIP_SEED", "1")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="every file is read in a forked process")
@pytest.mark.parametrize(("kind", "count"), [("nc", 6), ("zarr", 5)])
def test_damaged_results_are_refused_or_read_as_they_were_written(kind, count):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])}
    command = [sys.executable, str(TESTS / "fuzz_files.py"), kind, str(min(EXAMPLES, 5000) or count), SEED]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
