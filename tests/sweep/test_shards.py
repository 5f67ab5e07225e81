"""Zarr stores in shards: few files whatever the map, and a write that goes on where it was interrupted."""

import os
import signal
import subprocess
import sys
import time
from itertools import product

import numpy as np
import pytest
import xarray as xr

import stickslip
from stickslip.config.reader import load_config
from stickslip.errors import StoreError
from stickslip.files import targets, writing
from stickslip.files.zarr_chunks import Shards
from stickslip.runs.estimate import estimate

zarr = pytest.importorskip("zarr")
SHAPE, CHUNKS = (23, 5, 7), (2, 2, 7)  # 36 chunks, the last ones cut off along two dimensions
FILES = 4


class Killed(BaseException):
    """In place of SIGKILL."""


@pytest.fixture(autouse=True)
def small_shards(monkeypatch):
    monkeypatch.setattr(writing, "_MOST_FILES", FILES)
    monkeypatch.setattr(writing, "_chunks", lambda shape, given=None: CHUNKS if shape == SHAPE else shape)


def dataset(title="a map"):
    random = np.random.default_rng(8)
    coords = {name: np.arange(float(n)) for name, n in zip("xyz", SHAPE, strict=True)}
    data = {name: (tuple("xyz"), random.normal(size=SHAPE)) for name in ("period", "restick_time")}
    data["regime"] = (tuple("xyz"), random.integers(1, 5, SHAPE).astype(np.int8))
    return xr.Dataset(data, coords, {"source": "stickslip 0", "configuration": title})


def write(place, ds, calls=None, identity="a run", **options):
    """As a run does it: chunk after chunk, all variables of each that are not there."""

    def fill(file):
        with writing.open_chunks(file, 2) as target:
            for place in product(*(range(0, length, step) for length, step in zip(SHAPE, CHUNKS, strict=True))):
                part = tuple(slice(first, first + step) for first, step in zip(place, CHUNKS, strict=True))
                for name in ds.data_vars:
                    if not target.holds(name, place):
                        if calls is not None:
                            calls.append((name, place))
                        target.write(name, ds[name].values[part], place)

    return writing.write(ds, place, fill, identity=identity, **options)


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_store_in_shards_is_read_by_zarr_by_xarray_and_by_us(tmp_path):
    ds, place = dataset(), tmp_path / "map.zarr"
    write(place, ds)
    for name in ds.data_vars:
        assert sum(path.is_file() for path in (place / name / "c").rglob("*")) == FILES
        np.testing.assert_array_equal(zarr.open_group(place, mode="r")[name][...], ds[name])
    with xr.open_zarr(place) as plain, stickslip.open(place) as ours:
        for name in ds.data_vars:
            np.testing.assert_array_equal(plain[name], ds[name])
            np.testing.assert_array_equal(ours[name], ds[name])
            assert ours[name].data.chunksize == CHUNKS  # shards are read in parts
    assert not [*tmp_path.glob(".*")]
    assert not (place / targets.JOURNAL).exists()


def test_the_bytes_are_the_same_however_often_it_was_interrupted(tmp_path, monkeypatch):
    ds, whole, place = dataset(), tmp_path / "whole.zarr", tmp_path / "map.zarr"
    write(whole, ds)
    calls, append, stored = [], Shards.append, []
    for last in (0, 1, 5, 17, 40, 30):
        left = iter(range(last + 1))

        def some(self, of, number, data, content, left=left):
            if next(left, None) is None:
                self._write(of.key(number), 10**4, b"the beginning of a chunk")  # not noted
                raise Killed
            stored.append((of.name, number))
            return append(self, of, number, data, content)

        monkeypatch.setattr(Shards, "append", some)
        with pytest.raises(Killed):
            write(place, ds, calls)
        assert not place.exists()
    monkeypatch.setattr(Shards, "append", append)
    calls.clear()
    write(place, ds, calls)
    assert len(set(stored)) == len(stored)  # none twice
    assert len(calls) == 3 * 36 - len(stored)
    assert contents(place) == contents(whole)
    assert not [*tmp_path.glob(".*")]


@pytest.mark.parametrize("damage", ["shard", "journal", "zeros", "text", "lost"])
def test_what_was_damaged_meanwhile_is_written_again(tmp_path, monkeypatch, damage):
    ds, whole, place = dataset(), tmp_path / "whole.zarr", tmp_path / "map.zarr"
    write(whole, ds)
    interrupt(place, ds, monkeypatch, 60)
    (folder,) = tmp_path.glob(".map.zarr.*.part")
    shard = folder / "period" / "c" / "0" / "0" / "0"
    if damage == "shard":
        shard.write_bytes(bytes([shard.read_bytes()[0] ^ 1]) + shard.read_bytes()[1:])
    elif damage == "lost":
        shard.unlink()
    elif damage == "journal":
        journal = folder / targets.JOURNAL
        journal.write_bytes(journal.read_bytes()[:-7])
    else:
        journal = folder / targets.JOURNAL
        spoiled = b"\0" * 80 + b"\n" if damage == "zeros" else b"\xff[1, 2]\n"
        journal.write_bytes(b"".join([*journal.read_bytes().splitlines(keepends=True)[:20], spoiled, b"[]\n"]))
    write(place, ds)
    assert contents(place) == contents(whole)


def interrupt(place, ds, monkeypatch, after):
    left, append = iter(range(after)), Shards.append

    def some(*args):
        if next(left, None) is None:
            raise Killed
        return append(*args)

    with monkeypatch.context() as patch, pytest.raises(Killed):
        patch.setattr(Shards, "append", some)
        write(place, ds)


@pytest.mark.parametrize("what", ["map", "run by other kernels"])
def test_another_map_or_run_does_not_go_on_with_it(tmp_path, monkeypatch, what):
    place, calls = tmp_path / "map.zarr", []
    interrupt(place, dataset(), monkeypatch, 60)
    (tmp_path / ".map.zarr.of-an-other.zarr.0-0-0.part").mkdir()  # of a target with such a name
    write(place, dataset("another") if what == "map" else dataset(), calls, what)
    assert len(calls) == 3 * 36
    assert [path.name for path in tmp_path.glob(".*")] == [".map.zarr.of-an-other.zarr.0-0-0.part"]


@pytest.mark.parametrize(("age", "goes_on"), [(10.0, False), (200.0, True)])
def test_a_writer_on_another_machine_is_gone_once_it_is_silent(tmp_path, monkeypatch, age, goes_on):
    place, calls = tmp_path / "map.zarr", []
    with monkeypatch.context() as patch:
        patch.setattr(targets, "host", lambda: "another machine")
        interrupt(place, dataset(), patch, 60)
    (folder,) = tmp_path.glob(".map.zarr.*.part")
    moment = time.time() - age
    os.utime(folder / targets.JOURNAL, (moment, moment))
    write(place, dataset(), calls)
    assert len(calls) == 3 * 36 - (60 if goes_on else 0)
    assert folder.exists() is not goes_on


def test_a_lost_shard_is_found_when_the_store_is_opened(tmp_path):
    place = tmp_path / "map.zarr"
    write(place, dataset())
    next(path for path in (place / "period" / "c").rglob("*") if path.is_file()).unlink()
    with pytest.raises(StoreError, match="damaged, period has 3 shards of 4"):
        stickslip.open(place)


CONFIG = """
system: {mass: 1 kg, normal_load: 5 N}
friction: {a1: 0.2, a2: 0 s/m, a3: 0.1, a4: 20 mm/s}
axes:
  stiffness: {start: 0.1 N/mm, stop: 100 N/mm, num: 60, spacing: log}
  belt_speed: {start: 1 mm/s, stop: 300 mm/s, num: 50}
"""
RUN = """
import os, sys, stickslip
from stickslip.files import writing
from stickslip.files.zarr_chunks import Shards
from stickslip.runs.estimate import estimate
writing._MOST_FILES, writing._CHUNK_VALUES = 4, 100
append, count = Shards.append, 0
def some(*args):
    global count
    count += 1
    if count > int(sys.argv[1]):
        os.kill(os.getpid(), 9)
    append(*args)
Shards.append = some
stickslip.run("map.yaml", "map.zarr")
print(count)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_run_killed_in_its_last_write_goes_on_there(tmp_path):
    (tmp_path / "map.yaml").write_text(CONFIG)

    def run(most):
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
        return subprocess.run(
            [sys.executable, "-c", RUN, str(most)], cwd=tmp_path, env=environment, capture_output=True
        )

    assert run(300).returncode == run(200).returncode == -signal.SIGKILL
    done = run(10**9)
    assert done.returncode == 0, done.stderr
    with stickslip.open(tmp_path / "map.zarr") as ds:
        in_chunks = sum(ds[name].ndim == 2 for name in ds.data_vars)
        assert int(done.stdout) == 30 * in_chunks - 500
        whole = stickslip.run(tmp_path / "map.yaml")
        for name in ds.data_vars:
            np.testing.assert_array_equal(ds[name], whole[name])
    assert not [*tmp_path.glob(".map.zarr*")]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["zarr", "nc"])
def test_the_plan_says_how_large_the_file_will_be(tmp_path, monkeypatch, kind):
    monkeypatch.undo()
    monkeypatch.setattr(writing, "_MOST_FILES", FILES)
    monkeypatch.setattr(writing, "_CHUNK_VALUES", 10_000)
    config = tmp_path / "map.yaml"
    config.write_text(CONFIG.replace("60", "600").replace("50", "500") + f"output: {{file: map.{kind}}}\n")
    last = estimate(load_config(config)).last_write
    place = tmp_path / f"map.{kind}"
    stickslip.run(config, place).close()
    files = [path for path in place.rglob("*") if path.is_file()] if kind == "zarr" else [place]
    assert sum(path.stat().st_size for path in files) == pytest.approx(last.size, rel=0.25)
    assert len(files) == last.files
    assert last.seconds > 0.0


@pytest.mark.parametrize("more", ["", "  pad: {labels: [a, b], zip: {mass: [1, 2]}}\n", "refine: {depth: 3}\n"])
@pytest.mark.parametrize("kept", ["", "variables: [regime, period], "])
def test_the_plan_counts_the_files_that_are_written(tmp_path, more, kept):
    """Those that describe variables, fixed parameters and the table of marks among them."""
    config, place = tmp_path / "map.yaml", tmp_path / "map.zarr"
    text = CONFIG.replace("mass: 1 kg, ", "") if "mass" in more else CONFIG
    config.write_text(f"{text}{more}output: {{{kept}file: {place}}}\n")
    planned = estimate(load_config(config)).last_write.files
    stickslip.run(config, place).close()
    assert planned == sum(path.is_file() for path in place.rglob("*"))
