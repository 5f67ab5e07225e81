"""What tests by day may compile: nothing."""

import pytest

from helpers import day_kernels
from stickslip.engine import compiling
from stickslip_kernels import objects


def test_a_test_that_has_other_kernels_compiled_fails_and_is_told_of_the_marker(tmp_path, monkeypatch):
    monkeypatch.setattr(objects, "CACHE_FOLDER", tmp_path)
    monkeypatch.setattr(compiling, "_python", lambda *_: None)
    day_kernels.Guard()  # instead of that one, until the test is over
    with pytest.raises(pytest.fail.Exception, match="^the kernels of rational .* @pytest.mark.slow"):
        compiling.compile_apart("rational")
    assert compiling._python("print()") is None


def test_objects_that_other_processes_compiled_are_named_and_removed(tmp_path, monkeypatch):
    monkeypatch.setattr(objects, "CACHE_FOLDER", tmp_path)
    for law in ("rational", "stribeck"):
        (tmp_path / objects.file_of(law)).write_bytes(b"")
    assert day_kernels._removed_others() == ["rational"] and day_kernels._removed_others() == []
    assert [path.name for path in tmp_path.iterdir()] == [objects.file_of("stribeck")]
