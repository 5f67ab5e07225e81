"""Two runs on one store."""

import errno
import json
import os
import subprocess
import sys
import threading
import time

import pytest

import stickslip
from helpers.runs import block_files, same
from stickslip.errors import StoreError
from stickslip.files import targets
from stickslip.files.targets import Folder
from stickslip.runs import formats as lock


def holding(output, **changes):
    """A lock as another process writes it."""
    folder = output.with_name("map.nc.parts")
    folder.mkdir(exist_ok=True)
    plain = {"token": "x", "host": "elsewhere", "space": "", "pid": 1, "user": "Ada", "since": time.time() - 300,
             "seen": time.time()} | changes  # fmt: skip
    (folder / "lock.json").write_text(json.dumps(plain))


def test_a_second_run_is_refused_with_the_name_of_the_first(config, output):
    holding(output)
    with pytest.raises(StoreError, match="another run works there: Ada on elsewhere, process 1, since 20"):
        stickslip.run(config, output)
    with pytest.raises(StoreError, match="another run works there"):
        stickslip.run_shard(config, "1/2", f"{output}.parts")
    assert (output.with_name("map.nc.parts") / "lock.json").exists()


def test_a_stale_lock_is_taken_over(config, output, whole):

    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    for changes in ({"seen": time.time() - 1000}, {"host": targets.host(), "space": targets.space(), "pid": gone.pid}):
        holding(output, **changes)
        said = []
        same(stickslip.run(config, output, fresh=True, notice=said.append), whole)
        assert len(said) == 1 and "took over from a run that has died: Ada on" in said[0]


@pytest.mark.parametrize("changes", [
    {"seen": time.time() + 1e6}, {"seen": float("nan")}, {"since": 1e18}, {"since": -1e18}, {"seen": 1e300},
    {"host": targets.host(), "space": targets.space(), "pid": 2**70},
    {"host": targets.host(), "space": targets.space(), "pid": -1},
    {"host": targets.host(), "space": targets.space(), "pid": 0},
])  # fmt: skip
def test_a_lock_of_no_time_or_process_holds_nobody_up(config, output, whole, changes):
    holding(output, **changes)
    assert stickslip.run(config, output, notice=lambda text: None)["regime"].equals(whole["regime"])


def test_a_lock_that_is_not_whole_is_nobodys(config, output, whole):
    folder = output.with_name("map.nc.parts")
    folder.mkdir()
    (folder / "lock.json").write_text('{"pid": ')
    same(stickslip.run(config, output), whole)
    assert not folder.exists()


def test_a_run_whose_lock_was_taken_stops(config, output, monkeypatch):
    monkeypatch.setattr(lock, "REFRESH", 0.01)

    def rob(done, of):
        end = time.monotonic() + 20.0
        while done and any(thread.name == "lock" for thread in threading.enumerate()) and time.monotonic() < end:
            holding(output)  # again, since the heartbeat may have been about to write
            time.sleep(0.02)

    with pytest.raises(stickslip.IncompleteError, match="another run took over"):
        stickslip.run(config, output, progress=rob)
    assert not output.exists()


def test_shards_work_at_once_and_a_whole_run_waits_for_them(config, output):
    refused, merged = [], []

    def meanwhile(done, of):
        if done and not merged:
            merged.append(stickslip.run_shard(config, "2/2", f"{output}.parts"))
            try:
                stickslip.run(config, output)
            except StoreError as error:
                refused.append(str(error))

    stickslip.run_shard(config, "1/2", f"{output}.parts", progress=meanwhile)
    assert merged[0].computed == 7 * 60 and "another run works there" in refused[0]
    assert len(block_files(f"{output}.parts")) == 15


@pytest.mark.parametrize("links", [True, False])
def test_a_name_is_created_once_on_any_file_system(tmp_path, monkeypatch, links):
    def refused(source, target):
        raise OSError(errno.EPERM, "Operation not permitted")

    if not links:
        monkeypatch.setattr(os, "link", refused)
    folder = Folder(tmp_path / "map.nc.parts")
    folder.create("lock", b"mine")
    with pytest.raises(FileExistsError):
        folder.create("lock", b"yours")
    assert folder.read("lock") == b"mine" and folder.names() == ["lock"]
