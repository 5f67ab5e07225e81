"""Compiling by a process of its own, and running what it left."""

import hashlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
import pytest

import stickslip
import stickslip_kernels
from helpers.runs import until
from stickslip.engine import compiling
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
    """A cache with the article's law and its machine, copied from the real one; the file of the law."""
    folder = tmp_path / f"kernels-{objects.source_digest()}"
    folder.mkdir()
    for name in ("stribeck-maps", "stribeck"):
        objects.write(folder / objects.file_of(name), compiling.compile_apart(name))
    monkeypatch.setattr(objects, "CACHE_FOLDER", folder)
    return folder / objects.file_of("stribeck")


def test_processes_compute_from_the_cache_without_numba_the_same_bits(cached):
    first, second = (in_process(DIGEST, NUMBA_CACHE_DIR=str(cached.parents[1])) for _ in range(2))
    assert first == second and first[1] == "False" and len(first[0]) == 64


def test_a_damaged_object_is_compiled_anew(cached, monkeypatch):
    good = cached.read_bytes()
    content = bytearray(good)
    content[len(content) // 2] ^= 4
    cached.write_bytes(content)
    made = stand_in_for_compiling(monkeypatch, good)
    with pytest.warns(RuntimeWarning, match="damaged; the kernels are compiled again"):
        assert compiling.compile_apart("stribeck") == objects.read(cached)
    assert len(made) == 1


def test_without_a_cache_nothing_is_kept_and_that_is_said(cached, monkeypatch):
    made = stand_in_for_compiling(monkeypatch, cached.read_bytes())
    monkeypatch.setattr(objects, "CACHE_FOLDER", None)
    monkeypatch.setattr(objects, "NO_CACHE", "/scratch: others may write there")
    with pytest.warns(RuntimeWarning, match="not kept.*/scratch: others may write there.*NUMBA_CACHE_DIR"):
        assert compiling.compile_apart("stribeck").code
    assert len(made) == 1 and not compiling.is_cached("stribeck")


@pytest.mark.skipif(os.name == "nt", reason="POSIX limits")
def test_a_full_disk_under_the_cache_costs_what_is_kept_and_nothing_else(cached, monkeypatch):
    good = cached.read_bytes()
    cached.unlink()
    stand_in_for_compiling(monkeypatch, good)

    def full(*args, **options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(objects.tempfile, "mkstemp", full)
    with pytest.warns(RuntimeWarning, match="not kept.*No space left on device"):
        assert compiling.compile_apart("stribeck") == objects.unpacked(cached.name, good)
    assert cached not in cached.parent.iterdir() and len(list(cached.parent.iterdir())) == 1  # the machine


# --- objects of others ------------------------------------------------------------------------------------------------

posix = pytest.mark.skipif(os.name == "nt", reason="owners and modes of POSIX")


@posix
@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() != 0, reason="only root gives files to others")
def test_an_object_of_another_user_is_not_loaded(cached, monkeypatch):
    good = cached.read_bytes()
    os.chown(cached, 65534, 65534)
    made = stand_in_for_compiling(monkeypatch, good)
    with pytest.warns(RuntimeWarning, match=r"owned by another user \(number 65534\)"):
        compiling.compile_apart("stribeck")
    assert len(made) == 1 and cached.stat().st_uid == os.geteuid() and cached.stat().st_mode & 0o777 == 0o600


@posix
@pytest.mark.parametrize("how", ["writable", "link"])
def test_an_object_that_others_may_write_and_a_link_are_not_loaded(cached, monkeypatch, how, tmp_path):
    good = cached.read_bytes()
    if how == "link":
        cached.rename(tmp_path / "elsewhere.o")
        cached.symlink_to(tmp_path / "elsewhere.o")
    else:
        cached.chmod(0o666)
    made = stand_in_for_compiling(monkeypatch, good)
    with pytest.warns(RuntimeWarning, match="others may write it|a link"):
        compiling.compile_apart("stribeck")
    assert len(made) == 1 and not cached.is_symlink() and objects.read(cached)


@pytest.mark.parametrize("head", [b"", b"nonsense\n", b'["exp"]\n', b'{"name": 1}\n', b"[" * 9999 + b"\n"])
def test_a_head_that_is_none_is_damage(cached, head):
    content = head + b"code"
    cached.write_bytes(hashlib.sha256(content).digest() + content)
    assert objects.read(cached) is None


def test_the_object_of_another_processor_under_our_name_is_not_loaded(cached):
    cached.write_bytes(objects.packed("stribeck-z80.o", objects.read(cached)))
    assert objects.read(cached) is None


FOLDER = "from stickslip_kernels import objects; print(objects.CACHE_FOLDER is not None, objects.NO_CACHE)"


@posix
def test_a_folder_is_made_for_its_user_alone(tmp_path):
    assert in_process(FOLDER, NUMBA_CACHE_DIR=str(tmp_path / "new"), XDG_CACHE_HOME="")[0] == "True"
    (inner,) = (tmp_path / "new").iterdir()
    assert inner.stat().st_mode & 0o777 == inner.parent.stat().st_mode & 0o777 == 0o700


@posix
@pytest.mark.parametrize("how", ["root writable", "writable", "link", "other user", "file"])
def test_a_folder_in_which_others_may_write_is_not_used(tmp_path, how):
    root = tmp_path / "cache"
    inner = root / f"kernels-{objects.source_digest()}"
    if how == "file":
        root.write_text("a file where the folder should be")
    else:
        inner.mkdir(mode=0o700, parents=True)
    if how == "root writable":
        root.chmod(0o777)
    elif how == "writable":
        inner.chmod(0o770)
    elif how == "link":
        inner.rename(tmp_path / "elsewhere")
        inner.symlink_to(tmp_path / "elsewhere")
    elif how == "other user":
        if os.geteuid() != 0:
            pytest.skip("only root gives folders to others")
        os.chown(inner, 65534, 65534)
    said = " ".join(in_process(FOLDER, NUMBA_CACHE_DIR=str(root)))
    why = {"root writable": "others may write there", "writable": "others may write it", "link": "a link",
           "other user": "owned by another user", "file": "Not a directory|exists"}[how]  # fmt: skip
    assert re.search(rf"^False {re.escape(str(root))}.*({why})", said)


@posix
def test_a_sticky_folder_of_all_users_holds_one_of_our_own(tmp_path):
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o1777)
    assert in_process(FOLDER, NUMBA_CACHE_DIR=str(tmp_path / "cache"))[0] == "True"


@posix
def test_without_a_home_nothing_is_made_in_the_folder_one_is_in(tmp_path, monkeypatch):
    """`~` of a user whom the system does not know stays `~`."""
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("os.path.expanduser", lambda path: path)
    monkeypatch.chdir(tmp_path)
    assert objects._usable_folder() == (None, "no home folder is known")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_compiler_that_fails_says_why(tmp_path, monkeypatch):
    monkeypatch.setattr(objects, "CACHE_FOLDER", tmp_path)
    with pytest.raises(RuntimeError, match="(?s)no object .*KeyError: 'coulomb'"):
        compiling.compile_apart("coulomb")


def stand_in_for_compiling(monkeypatch, content):
    """Instead of compiling, this comes of it; the scripts that were to be run."""
    scripts = []

    def compile(script, settings):
        scripts.append(script)
        return subprocess.CompletedProcess(script, 0, content, b"")

    monkeypatch.setattr(compiling, "_python", compile)
    return scripts


def test_arrays_that_the_kernels_would_misread_are_refused(kernels):
    stop, results = np.zeros(1, np.int64), np.zeros((27, 4))
    for cells in (np.zeros((15, 4))[:, ::2], np.zeros((15, 4), np.float32), np.zeros((14, 4))):
        with pytest.raises(ValueError, match="expected a C-contiguous array of float64"):
            compiling.kernels("stribeck").run_regimes(cells, 1e-6, 100, stop, results[:, : cells.shape[1]], True)


# --- what takes a compilation -----------------------------------------------------------------------------------------


@pytest.mark.slow
def test_two_processes_that_start_at_once_both_compute(tmp_path):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(ROOTS), "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", DIGEST]
    both = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    said = [process.communicate()[0] for process in both]
    assert said[0] == said[1] != "" and [process.returncode for process in both] == [0, 0]
    assert len(list(tmp_path.glob("kernels-*/*.o"))) == 2 == len(list(tmp_path.glob("kernels-*/*")))  # law, machine


@posix
@pytest.mark.slow
def test_processes_that_are_killed_while_they_compile_leave_nothing_that_is_loaded(tmp_path):
    """At random moments; the compiler ends with the process that waits for its object."""
    chance = random.Random(os.environ.get("STICKSLIP_SEED", "1"))
    for _ in range(4):
        with killed(tmp_path, DIGEST, lambda pid: [pid], chance) as process:
            assert process.wait(timeout=600) in (0, -signal.SIGKILL)
    assert in_process(DIGEST, NUMBA_CACHE_DIR=str(tmp_path / "cache")) == in_process(DIGEST)
    assert len(list(tmp_path.glob("cache/kernels-*/*.o"))) == 2


@posix
@pytest.mark.slow
def test_where_the_compiler_is_killed_this_process_compiles_and_says_so(tmp_path):
    """As by a system that is out of memory."""
    script = f"import stickslip; print(int(stickslip.evaluate({CELL})['regime'][0]))"
    chance = random.Random(os.environ.get("STICKSLIP_SEED", "1"))
    with killed(tmp_path, script, children, chance) as process:
        said, errors = process.communicate(timeout=900)
    assert process.returncode == 0 and "killed by signal 9" in errors
    assert said.split() == [str(int(stickslip.evaluate(CELL)["regime"][0]))]
    assert not list(tmp_path.glob("cache/kernels-*/*.o"))


@contextmanager
def killed(folder, script, whom, chance):
    """A process with a cache of its own, some of whose processes are killed at a random moment of compiling."""
    own = {"PYTHONPATH": os.pathsep.join(ROOTS), "NUMBA_CACHE_DIR": str(folder / "cache"), "TMPDIR": str(folder)}
    process = subprocess.Popen([sys.executable, "-c", script], env=os.environ | own, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)  # fmt: skip
    until(lambda: process.poll() is not None or children(process.pid))
    time.sleep(chance.uniform(0.0, 8.0))
    compilers = children(process.pid)
    for pid in whom(process.pid):
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    until(lambda: not any(Path(f"/proc/{pid}/exe").exists() for pid in compilers))
    yield process
    process.communicate(timeout=60)


def children(pid):
    """Processes that a process has started."""
    return [int(child) for task in Path(f"/proc/{pid}/task").glob("*/children") for child in task.read_text().split()]


@pytest.mark.slow
def test_without_what_building_needs_of_numba_this_process_compiles(tmp_path):
    """With public calls of Numba only, and with a warning; the regimes are the same."""
    for package in ("sweep", "kernels"):
        shutil.copytree(Path(ROOTS[package == "kernels"]), tmp_path / package)
    building = tmp_path / "kernels" / "stickslip_kernels" / "building.py"
    before, after = "from numba.core import base,", "from numba.core import of_another_version, base,"
    assert before in (text := building.read_text())
    building.write_text(text.replace(before, after))
    roots = os.pathsep.join(str(tmp_path / package) for package in ("sweep", "kernels"))
    script = f"import stickslip; print(int(stickslip.evaluate({CELL})['regime'][0]))"
    environment = os.environ | {"PYTHONPATH": roots, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    assert "of_another_version" in done.stderr and "RuntimeWarning" in done.stderr
    assert done.stdout.split() == [str(int(stickslip.evaluate(CELL)["regime"][0]))]
