"""Compiled kernels in files: nothing damaged, and nothing made for something else, is ever run."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from stickslip.engine.compiling import compile_apart
from stickslip.vocabulary.models import LAWS
from stickslip_kernels import contacts, objects, runtime


def flipped(where):
    def damage(content):
        content[where] ^= 1

    return damage


def cut_to(left):
    def damage(content):
        del content[left:]

    return damage


@pytest.mark.parametrize("damage", [*map(flipped, (0, 31, 32, 40, -1)), *map(cut_to, (0, 10, 40))])
def test_what_is_written_is_read_and_what_is_damaged_is_not(tmp_path, damage):
    path, made = tmp_path / "kernels.o", objects.Object(["exp"], b"machine\ncode")
    objects.write(path, made)
    assert objects.read(path) == made and list(tmp_path.iterdir()) == [path]
    content = bytearray(path.read_bytes())
    damage(content)
    path.write_bytes(content)
    assert objects.read(path) is None


@pytest.mark.parametrize(("module", "function", "instead"), [
    (objects.llvm, "get_host_cpu_name", lambda: "z80"),
    (objects.llvm, "get_host_cpu_features", lambda: objects.llvm.FeatureMap(avx=False)),
    (objects, "version", lambda package: "0.1"),
])  # fmt: skip
def test_another_processor_or_compiler_has_objects_of_its_own(monkeypatch, module, function, instead):
    here = objects.file_of("stribeck")
    monkeypatch.setattr(module, function, instead)
    objects._host.cache_clear()
    try:
        assert objects.file_of("stribeck") != here
    finally:
        objects._host.cache_clear()


@pytest.mark.parametrize("name", ["of_another_world", "law.of_another_contact"])
def test_an_object_that_needs_what_this_process_or_its_law_lacks_is_not_loaded(kernels, name):
    law = compile_apart("stribeck")
    with pytest.raises(runtime.UnknownSymbolError, match=f"no function {name} in this process"):
        runtime.load(law, objects.Object(["exp", "law.shape", name], b""), False)


def test_a_law_is_linked_to_the_machine_of_its_contact():
    laws = {law: contact for contact, file in contacts.files().items() for law in file.LAWS}
    assert {law: objects.contact_of(law) for law in laws} == laws and set(LAWS) <= set(laws)


def test_importing_the_kernels_leaves_the_settings_of_numba_alone():
    code = (
        "import numba; a = numba.config.CACHE_DIR; import stickslip_kernels.lanes; assert a == numba.config.CACHE_DIR"
    )
    environment = os.environ | {"PYTHONPATH": str(Path(objects.__file__).parents[1])}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
