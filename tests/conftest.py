"""What every test shares."""

import os

import pytest
from hypothesis import settings

from stickslip import engine
from stickslip.compiling import compile_apart
from stickslip.variables import LAWS

os.environ.setdefault("MPLBACKEND", "Agg")  # pictures never open a window
# The first example of a kernel loads compiled code: no deadline. What a run finds, the next one finds too, unless fresh
# seeds are asked for (`make nightly`).
settings.register_profile("same", deadline=None, derandomize=True)
settings.register_profile("fresh", deadline=None, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))


@pytest.fixture(scope="session", autouse=True)
def compiled():
    """As in every run, kernels are compiled by a process of their own: tests compare bits with those of processes."""
    for law in LAWS:
        compile_apart(f"load({law!r})", lambda law=law: engine.will_compile(law))
