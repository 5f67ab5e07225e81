"""What every test shares."""

import os

import pytest
from hypothesis import settings

from helpers import day_kernels

os.environ.setdefault("MPLBACKEND", "Agg")  # plots never open a window
# The first example of a kernel loads compiled code: no deadline. What a run finds, the next one finds too, unless fresh
# seeds are asked for, and twice as many examples (`make test-all`).
settings.register_profile("same", deadline=None, derandomize=True, max_examples=50)
settings.register_profile("fresh", deadline=None, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))


def pytest_configure(config):
    """Cells at random have any friction coefficient; tests of what asks about it see the question."""
    config.addinivalue_line("filterwarnings", "ignore:mu_start = .* is more than:stickslip.errors.UnitWarning")


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder in which the test runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.hookimpl(tryfirst=True)  # before xdist starts its workers
def pytest_sessionstart(session):
    """By day a few kernels are compiled before all tests, and no test may have others compiled."""
    config = session.config
    if "not slow" not in config.option.markexpr or config.option.collectonly:
        return
    if not hasattr(config, "workerinput"):
        folder = config.rootpath / "build" / "kernels-of-tests"
        day_kernels.prepare(folder, config.get_terminal_writer().line)
    config.pluginmanager.register(day_kernels.Guard())


@pytest.fixture(scope="session")
def kernels():
    """The article's kernels, in the cache: for tests of what should not compile while it is watched.

    By day they are there (`day_kernels`). Else they are compiled by who first computes, as in every run by another
    process (`warm_up`), since tests compare bits with those of processes.
    """
    from stickslip import engine

    engine.warm_up()
