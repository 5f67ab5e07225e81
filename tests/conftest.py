"""What every test shares."""

import os

import pytest
from hypothesis import settings

from stickslip import engine
from stickslip.compiling import compile_apart
from stickslip.variables import LAWS

os.environ.setdefault("MPLBACKEND", "Agg")  # pictures never open a window
settings.register_profile("here", deadline=None)  # the first example of a kernel loads compiled code
settings.load_profile("here")


@pytest.fixture(scope="session", autouse=True)
def compiled():
    """As in every run, kernels are compiled by a process of their own: tests compare bits with those of processes."""
    for law in LAWS:
        compile_apart(f"load({law!r})", lambda law=law: engine.will_compile(law))
