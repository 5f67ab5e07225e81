"""Objects that a package brings: for kinds of processors, and loaded only where they belong."""

import json
import os
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stickslip
from stickslip_kernels import objects

KIND = "x86-64-v3"
on_linux = pytest.mark.skipif(sys.platform != "linux" or os.uname().machine != "x86_64", reason="kinds of x86-64")


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package with objects of these sources, which are no code."""
    monkeypatch.setattr(objects, "_HERE", tmp_path)
    monkeypatch.setattr(objects, "source_digest", lambda: "0" * 16)
    folder = objects.shipped_folder()
    folder.mkdir(mode=0o755)
    for kind in ("x86-64-v3", "x86-64-v4"):
        objects.write(folder / objects.shipped_file("stribeck", kind), objects.Object(["exp"], kind.encode()))
    monkeypatch.setattr(
        objects.llvm, "get_host_cpu_features", lambda: dict.fromkeys(objects.KINDS["x86_64"][KIND], True)
    )
    objects.shipped_kind.cache_clear()
    yield folder
    objects.shipped_kind.cache_clear()


@on_linux
def test_a_processor_gets_the_objects_of_the_most_able_kind_that_it_is(package, monkeypatch):
    assert objects.shipped("stribeck").code == b"x86-64-v3"
    able = dict.fromkeys(objects.KINDS["x86_64"]["x86-64-v4"], True)
    monkeypatch.setattr(objects.llvm, "get_host_cpu_features", lambda: able)
    objects.shipped_kind.cache_clear()
    assert objects.shipped("stribeck").code == b"x86-64-v4"
    assert objects.shipped("stribeck-maps") is None  # not among them


DOUBTS = {
    "features": lambda patch, path: patch.setattr(objects.llvm, "get_host_cpu_features", lambda: {"avx2": True}),
    "sources": lambda patch, path: patch.setattr(objects, "source_digest", lambda: "1" * 16),
    "settings": lambda patch, path: patch.setenv("NUMBA_CPU_NAME", "generic"),
    "renamed": lambda patch, path: shutil.copy(path.with_name(path.name.replace("v3", "v4")), path),
    "file": lambda patch, path: path.chmod(0o666),
    "folder": lambda patch, path: path.parent.chmod(0o777),
    "link": lambda patch, path: path.symlink_to(path.rename(path.with_name("elsewhere"))),
}


@on_linux
@pytest.mark.parametrize("doubt", DOUBTS)
def test_nothing_is_loaded_that_does_not_belong_here(package, monkeypatch, doubt):
    DOUBTS[doubt](monkeypatch, package / objects.shipped_file("stribeck", KIND))
    assert objects.shipped("stribeck") is None


@on_linux
@pytest.mark.slow
def test_a_package_with_objects_computes_without_compiling(tmp_path):
    """In a process without Numba, and without a cache."""
    root = Path(objects.__file__).parents[1]
    kernels = shutil.copytree(root, tmp_path / "kernels", ignore=shutil.ignore_patterns("__pycache__", "shipped-*"))
    folder = kernels / "stickslip_kernels" / objects.shipped_folder().name
    kind = objects.shipped_kind() or KIND
    ship = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "objects.py"))["ship"]
    assert [path.name for path in ship(folder, ["stribeck"], [kind])] == [
        objects.shipped_file(name, kind) for name in ("stribeck", "stribeck-maps", "stribeck-signals")
    ]
    cell = {"mass": 0.1, "stiffness": 5000.0, "normal_load": 10.0, "a1": 0.2, "a2": 0.0, "a3": 0.1, "a4": 0.02}
    script = (
        "import json, sys; sys.modules['numba'] = None\n"
        "import stickslip\n"
        f"cell = {cell}\n"
        "ds = stickslip.evaluate(cell | dict(belt_speed=[0.01, 0.1]))\n"
        "stickslip.simulate(duration=0.1, belt_speed=0.01, **cell)\n"
        "print(json.dumps([ds['regime'].values.tolist(), ds['period'].values.tolist()]))\n"
    )
    path = os.pathsep.join([str(kernels), *sys.path])
    environment = os.environ | {"PYTHONPATH": path, "XDG_CACHE_HOME": str(tmp_path / "cache"), "NUMBA_CACHE_DIR": ""}
    done = json.loads(subprocess.check_output([sys.executable, "-c", script], env=environment, text=True))
    here = stickslip.evaluate(cell | {"belt_speed": [0.01, 0.1]})
    assert done[0] == here["regime"].values.tolist()
    np.testing.assert_allclose(done[1], here["period"], rtol=1e-9)
    assert not list((tmp_path / "cache").rglob("*.o"))
