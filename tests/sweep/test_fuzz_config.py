"""Any bytes as a configuration: a Config or a ConfigError, soon, and nothing else. And damaged results.

`STICKSLIP_FUZZ=50000 pytest tests/sweep/test_fuzz_config.py` tries that many; without it a few hundred are tried.
"""

import os
import subprocess
import sys
import warnings
from pathlib import Path
from time import thread_time

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings

from helpers.fuzzing import EXAMPLES, GOOD, TRIPWIRE, files
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.reader import load_config, parse_config
from stickslip.errors import ConfigError, FitWarning, UnitWarning
from stickslip.studies.draws import Inputs
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import PARAMETERS_OF

TESTS = Path(__file__).parents[1]
SEED = os.environ.get("STICKSLIP_SEED", "1")  # of damages of results
LONGEST = 5.0  # s of computing for one file; the usual is a hundredth
MOST_MEMORY = 600  # MB that a session of reading may grow by: a grid of 1e15 cells is refused, not allocated

fuzz = settings(
    max_examples=EXAMPLES or 60,
    deadline=None,
    database=None,
    suppress_health_check=list(HealthCheck),
    derandomize=not EXAMPLES,
)


def read(folder: Path, content: bytes) -> Config | None:
    """The configuration, or None after a ConfigError of which everything is as it should be."""
    path = folder / "fuzz.yaml"
    path.write_bytes(content)
    began = thread_time()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", FitWarning)
        warnings.simplefilter("ignore", UnitWarning)
        try:
            return load_config(path)
        except ConfigError as error:
            assert error.problems
            for line in (problem.text(error.source) for problem in error.problems):
                assert line.startswith((str(path), str(folder)))
                assert "\x00" not in line and "\x1b" not in line, "what a terminal would obey is not repeated"
            assert len(str(error)) < 200_000
            whole = {"the file is empty", "larger than 1 MB, expected a configuration in YAML"}
            placed = [problem.place is not None or problem.message in whole or problem.message.startswith("this is ")
                      for problem in error.problems]  # fmt: skip
            assert all(placed) or error.source != str(path)
            return None
        finally:
            assert thread_time() - began < LONGEST


def use(config: Config) -> None:
    """What comes after reading: the grid, a cell at either end, and the text that results keep."""
    grid = build_grid(config)
    for start in (0, grid.size - 1) if config.study is None or config.study.key != "explain" else ():
        if config.uncertain is None:
            cells = grid[start : start + 1]
        else:  # at the medians of what is uncertain
            cells, _ = Inputs(config).cells(np.array([start]), np.zeros((1, len(config.uncertain.names))))
        assert set(cells) == set(PARAMETERS_OF[model_of(config.friction.law)])
    assert parse_config(config.to_yaml()) == config


def peak_memory():
    """MB this process ever took; zero on Windows, where nobody says."""
    if sys.platform == "win32":
        return 0.0
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (2**20 if sys.platform == "darwin" else 2**10)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("fuzz")
    before = peak_memory()
    yield place
    assert peak_memory() - before < MOST_MEMORY
    assert not list(place.glob(f"**/{TRIPWIRE}")) and not Path(TRIPWIRE).exists()


def test_the_configurations_that_are_broken_are_good(folder):
    for text in GOOD:
        use(read(folder, text.encode()))


@fuzz
@given(content=files())
def test_any_file_is_a_configuration_or_a_config_error(content, folder):
    if config := read(folder, content):
        use(config)


ATTACKS = {
    "billion laughs": "a0: &a0 [x, x]\n" + "".join(f"a{i + 1}: &a{i + 1} [*a{i}, *a{i}]\n" for i in range(60)),
    "code": f'title: !!python/object/apply:os.system ["touch {TRIPWIRE}"]\n',
    "merge": "a: &a {b: 1}\nsystem: {<<: *a}\n",
    "deep lists": "system: " + "[" * 300_000,
    "deep mappings": "{a: " * 100_000,
    "deep blocks": "".join(" " * i + "a:\n" for i in range(1000)),
    "a long line": "title: " + "x" * 900_000,
    "a long key": "? " + "k" * 100_000 + "\n: 1",
    "many keys": "".join(f"key{i}: 1\n" for i in range(20_000)),
    "one key many times": "mass: 1\n" * 30_000,
    "digits": "system: {mass: " + "9" * 100_000 + "}",
    "a power of ten": "system: {mass: 1e999999999 kg, stiffness: 2**99999999 N/m}",
    "many dimensions": "axes: {" + ", ".join(f"g{i}: {{zip: {{mass: [1, 2]}}}}" for i in range(3000)) + "}",
    "documents": "---\n" * 100_000,
    "question marks": "? " * 50_000,
}
GRID = (
    "system: {{mass: 1, normal_load: 1}}\nfriction: {{a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}}\n"
    "axes: {{stiffness: {{start: 1, stop: 2, num: {num}}}, belt_speed: {{start: 1, stop: 2, num: {num}}}}}\n"
)


@pytest.mark.parametrize("text", ATTACKS.values(), ids=ATTACKS)
def test_attacks_are_refused_at_once(text, folder):
    assert read(folder, text.encode()) is None


@pytest.mark.parametrize("num", [10**6, 10**7, 10**12, "1e12", "9" * 400])
def test_grids_beyond_all_bounds_are_refused_without_allocating(num, folder):
    assert read(folder, GRID.format(num=num).encode()) is None


@pytest.mark.parametrize(
    "values",
    [
        ", ".join("1 kg" for _ in range(30_000)),
        ", ".join(f"1 u{i}" for i in range(30_000)),
        ", ".join(str(i + 1) for i in range(5_000)) + "".join(f", 1 q{i}" for i in range(20_000)),
    ],
    ids=["mistakes", "unknown units", "mistakes at the end"],
)
def test_long_lists_of_mistakes_are_explained_in_part(values, folder):
    text = GRID.format(num=3).replace("{start: 1, stop: 2, num: 3}", f"[{values}]", 1)
    assert read(folder, text.encode()) is None


@pytest.mark.skipif(not hasattr(os, "fork"), reason="every file is read in a forked process")
@pytest.mark.parametrize(("kind", "count"), [("nc", 6), ("zarr", 5)])
def test_damaged_results_are_refused_or_read_as_they_were_written(kind, count):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])}
    command = [sys.executable, str(TESTS / "fuzz_files.py"), kind, str(min(EXAMPLES, 5000) or count), SEED]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
