"""Compiling by a process of its own, and running what it left."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stickslip
import stickslip_kernels
from stickslip.engine import compiled, compiling
from stickslip_kernels import objects

PAIR = {"mass": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
CELL = PAIR | {"stiffness": 1.0, "belt_speed": 0.1}
ROOTS = [str(Path(package.__file__).parents[1]) for package in (stickslip, stickslip_kernels)]

DIGEST = """
import hashlib
import sys
import numpy as np
import stickslip
k, v = np.meshgrid(np.logspace(-1, 2, 40), np.linspace(0.02, 1.0, 40))
pair = {"mass": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
ds = stickslip.evaluate(pair | {"stiffness": k.ravel(), "belt_speed": v.ravel()})
print(hashlib.sha256(b"".join(ds[name].values.tobytes() for name in ds)).hexdigest(), "numba" in sys.modules)
"""


def in_process(script, **environment):
    """What a fresh process prints, the kernels' warnings being errors."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(ROOTS)} | environment
    command = [sys.executable, "-W", "error::RuntimeWarning", "-c", script]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.fixture
def cached(kernels, tmp_path, monkeypatch):
    """A cache with the object of the article's law, copied from the real one; its file."""
    name = objects.name_of("stribeck", False)
    made = compiling.compile_apart("stribeck", False)
    folder = tmp_path / f"kernels-{objects.source_digest()}"
    folder.mkdir()
    objects.write(folder / name, *made)
    monkeypatch.setattr(objects, "CACHE_FOLDER", folder)
    return folder / name


def test_a_process_computes_from_the_cache_without_numba(cached):
    digest, numba = in_process(DIGEST, NUMBA_CACHE_DIR=str(cached.parents[1]))
    assert numba == "False" and len(digest) == 64


def test_processes_have_the_same_bits(cached):
    first, second = (in_process(DIGEST, NUMBA_CACHE_DIR=str(cached.parents[1])) for _ in range(2))
    assert first == second


def test_a_damaged_object_is_compiled_anew(cached, monkeypatch):
    good = cached.read_bytes()
    content = bytearray(good)
    content[len(content) // 2] ^= 4
    cached.write_bytes(content)
    made = stand_in_for_compiling(monkeypatch, good)
    assert compiling.compile_apart("stribeck", False) == objects.read(cached)
    assert made == [cached]


def test_an_object_for_something_else_is_not_looked_at(cached, monkeypatch):
    good = cached.read_bytes()
    cached.rename(cached.with_name(cached.name.replace("python", "anaconda")))
    made = stand_in_for_compiling(monkeypatch, good)
    compiling.compile_apart("stribeck", False)
    assert made == [cached]


def test_without_a_cache_the_object_passes_through_a_temporary_file(cached, monkeypatch):
    made = stand_in_for_compiling(monkeypatch, cached.read_bytes())
    monkeypatch.setattr(objects, "CACHE_FOLDER", None)
    assert compiled.machine.load(*compiling.compile_apart("stribeck", False), False)
    assert len(made) == 1 and not made[0].parent.exists()


def test_a_compiler_that_fails_says_why(tmp_path, monkeypatch):
    monkeypatch.setattr(objects, "CACHE_FOLDER", tmp_path)
    with pytest.raises(RuntimeError, match="(?s)no object .*KeyError: 'coulomb'"):
        compiling.compile_apart("coulomb", False)


def stand_in_for_compiling(monkeypatch, content):
    """Instead of compiling, write this; the files asked for."""
    paths = []

    def run(command, **options):
        path = Path(command[-1].split("main(")[1].rstrip(")").split(", ", 2)[2].strip("'"))
        paths.append(path)
        path.write_bytes(content)
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(compiling.subprocess, "run", run)
    return paths


def test_arrays_that_the_kernels_would_misread_are_refused(kernels):
    stop, results = np.zeros(1, np.int64), np.zeros((27, 4))
    for cells in (np.zeros((15, 4))[:, ::2], np.zeros((15, 4), np.float32), np.zeros((14, 4))):
        with pytest.raises(ValueError, match="expected a C-contiguous array of float64"):
            compiled.kernels("stribeck").run_regimes(cells, 1e-6, 100, stop, results[:, : cells.shape[1]], True)


# --- what takes a compilation -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_first_run_on_a_machine_has_the_bits_of_all_others(tmp_path):
    first, second = (in_process(DIGEST, NUMBA_CACHE_DIR=str(tmp_path)) for _ in range(2))
    assert first == second and first[1] == "False"


@pytest.mark.slow
def test_two_processes_that_start_at_once_both_compute(tmp_path):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(ROOTS), "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", DIGEST]
    both = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    said = [process.communicate()[0] for process in both]
    assert said[0] == said[1] != "" and [process.returncode for process in both] == [0, 0]
    assert len(list(tmp_path.glob("kernels-*/*.o"))) == 1 == len(list(tmp_path.glob("kernels-*/*")))


@pytest.mark.slow
def test_a_folder_that_cannot_be_written_costs_a_compilation_each_time(tmp_path):
    (tmp_path / "cache").write_text("a file where the folder should be")
    assert in_process(DIGEST, NUMBA_CACHE_DIR=str(tmp_path / "cache"))[1] == "False"


@pytest.mark.slow
def test_without_what_building_needs_of_numba_this_process_compiles(tmp_path):
    """With public calls of Numba only, and with a warning; the regimes are the same."""
    for package in ("sweep", "kernels"):
        shutil.copytree(Path(ROOTS[package == "kernels"]), tmp_path / package)
    building = tmp_path / "kernels" / "stickslip_kernels" / "building.py"
    building.write_text(building.read_text().replace("import codegen", "import of_another_version, codegen"))
    roots = os.pathsep.join(str(tmp_path / package) for package in ("sweep", "kernels"))
    script = f"import stickslip; print(int(stickslip.evaluate({CELL})['regime'][0]))"
    environment = os.environ | {"PYTHONPATH": roots, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert "of_another_version" in done.stderr and "RuntimeWarning" in done.stderr
    assert done.stdout.split() == [str(int(stickslip.evaluate(CELL)["regime"][0]))]
