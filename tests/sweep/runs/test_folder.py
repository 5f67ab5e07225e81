"""Folders of working stores: what a name holds is whole, and nobody takes a name that is taken."""

import errno
import os

import pytest

from stickslip.files.targets import Folder


@pytest.fixture(params=["links", "no links"])
def folder(request, tmp_path, monkeypatch):
    """A folder on a file system with links, and on one without."""
    if request.param == "no links":

        def refused(source, target):
            raise OSError(errno.EPERM, "Operation not permitted")

        monkeypatch.setattr(os, "link", refused)
    return Folder(tmp_path / "map.nc.parts")


def test_what_is_written_is_read_listed_and_removed(folder):
    assert folder.names() == [] and folder.size() == 0
    folder.write("block", b"first")
    folder.write("block", b"second")
    assert folder.names() == ["block"] and folder.read("block") == b"second" and folder.size() == 6
    folder.remove("block")
    folder.remove("block")
    assert folder.names() == []


def test_a_name_is_created_once(folder):
    folder.create("lock", b"mine")
    with pytest.raises(FileExistsError):
        folder.create("lock", b"yours")
    assert folder.read("lock") == b"mine" and folder.names() == ["lock"]
