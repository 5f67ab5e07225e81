"""Several threads at once; in processes of their own, since what goes wrong there is a crash or a deadlock."""

from __future__ import annotations

import gc
import os
import pickle
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import xarray as xr

import stickslip
import stickslip_kernels
from helpers.configs import write_config
from helpers.maps import plane
from stickslip.engine import compiled
from stickslip.errors import StoreError
from stickslip.files import writing
from stickslip.files.netcdf import NETCDF_LOCK
from stickslip.runs import work

TESTS = Path(__file__).parents[1]
posix = pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")


def in_process(*arguments, patience=120.0, **environment):
    """Run Python there; what it wrote."""
    everything = os.environ | {"PYTHONPATH": os.pathsep.join([str(TESTS), *sys.path])} | environment
    command = [sys.executable, "-X", "faulthandler", *map(str, arguments)]
    done = subprocess.run(command, env=everything, capture_output=True, text=True, timeout=patience)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def at_once(*tasks):
    """Call all in threads that begin together; what each returned or raised."""
    outcomes, begin = [None] * len(tasks), threading.Barrier(len(tasks))

    def call(i, task):
        begin.wait()
        try:
            outcomes[i] = task()
        except Exception as error:
            outcomes[i] = error

    threads = [threading.Thread(target=call, args=item, daemon=True) for item in enumerate(tasks)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
        assert not thread.is_alive(), "deadlock"
    return outcomes


# --- reading and writing ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [1, 60])
def test_threads_read_write_run_and_extend_at_once(kernels, seconds):
    in_process(TESTS / "thread_stress.py", seconds, patience=seconds + 200)


@pytest.mark.slow
def test_six_threads_open_load_and_close_one_file(tmp_path):
    path = writing.write(plane(100, 100), tmp_path / "map.nc")
    in_process("-c", OPEN_LOAD_CLOSE, path)


OPEN_LOAD_CLOSE = """
import sys, threading, stickslip

def work():
    for _ in range(5):
        ds = stickslip.open(sys.argv[1])
        ds.load()
        ds.close()

threads = [threading.Thread(target=work) for _ in range(6)]
for thread in threads: thread.start()
for thread in threads: thread.join()
"""


def test_threads_that_read_and_copy_one_lazy_dataset_do_not_deadlock(tmp_path):
    path = writing.write(plane(20, 20), tmp_path / "map.nc")
    with stickslip.open(path) as ds:
        loads = [lambda: ds.compute().identical(plane(20, 20)) for _ in range(2)]
        writes = [lambda n=n: writing.write(ds, tmp_path / f"copy{n}.nc") for n in range(2)]
        outcomes = at_once(*loads, *writes)
    assert not [outcome for outcome in outcomes if isinstance(outcome, Exception)]


@pytest.mark.slow
def test_a_file_that_nobody_closed_is_closed_by_the_garbage_collector(tmp_path):
    from xarray.backends.file_manager import FILE_CACHE

    path = writing.write(plane(), tmp_path / "map.nc")
    gc.collect()
    before = len(FILE_CACHE)
    ds = stickslip.open(path)
    assert len(FILE_CACHE) == before + 1
    del ds
    gc.collect()
    assert len(FILE_CACHE) == before and not NETCDF_LOCK.locked()


def test_plain_xarray_waits_for_us_and_we_for_it(tmp_path):
    path = writing.write(plane(), tmp_path / "map.nc")
    with xr.open_dataset(path, engine="netcdf4", cache=False) as plain:
        read = threading.Thread(target=lambda: plain["period"].values, daemon=True)
        with NETCDF_LOCK:
            read.start()
            read.join(0.3)
            assert read.is_alive()
        read.join(30)
        assert not read.is_alive()


def test_plain_xarray_given_our_lock_opens_safely_while_holding_it(tmp_path):
    path = writing.write(plane(), tmp_path / "map.nc")
    with NETCDF_LOCK, xr.open_dataset(path, engine="netcdf4", lock=NETCDF_LOCK) as ds:
        ds.load()
    assert not NETCDF_LOCK.locked()


def test_an_open_dataset_goes_to_other_processes(tmp_path):
    path = writing.write(plane(), tmp_path / "map.nc")
    assert pickle.loads(pickle.dumps(NETCDF_LOCK)) is NETCDF_LOCK
    with stickslip.open(path) as ds, pickle.loads(pickle.dumps(ds)) as copy:
        xr.testing.assert_equal(copy.load(), plane())


# --- runs -------------------------------------------------------------------------------------------------------------


def test_a_second_run_to_the_same_output_is_refused_in_another_thread(tmp_path, monkeypatch):
    config, output = write_config(tmp_path), tmp_path / "map.nc"
    computing, refused = threading.Event(), threading.Event()
    compute_range = work.compute_range

    def waiting(*arguments):
        computing.set()
        assert refused.wait(30)
        return compute_range(*arguments)

    monkeypatch.setattr(work, "compute_range", waiting)
    first = threading.Thread(target=lambda: stickslip.run(config, output).close(), daemon=True)
    first.start()
    assert computing.wait(30)
    with pytest.raises(StoreError, match="another run works there"):
        stickslip.run(config, output)
    refused.set()
    first.join(60)
    with stickslip.open(output) as ds:
        assert (ds["regime"] != 0).all()


def test_runs_to_one_output_that_begin_together_write_it_or_are_refused(tmp_path):
    config, output = write_config(tmp_path), tmp_path / "map.nc"
    for outcome in at_once(*[lambda: stickslip.run(config, output).load()] * 4):
        assert isinstance(outcome, (xr.Dataset, StoreError)), outcome
    with stickslip.open(output) as ds:
        xr.testing.assert_equal(ds.load(), stickslip.run(config))


@posix
@pytest.mark.parametrize("kind", ["nc", pytest.param("zarr", marks=pytest.mark.slow)])
def test_a_process_forked_after_a_run_reads_and_runs(kernels, kind, tmp_path):
    if kind == "zarr":
        pytest.importorskip("zarr")
    in_process("-W", "ignore", "-c", FORK, write_config(tmp_path), tmp_path, kind)


FORK = """
import os, signal, sys, stickslip
config, folder, kind = sys.argv[1:]
first, second = f"{folder}/first.{kind}", f"{folder}/second.{kind}"
opened = stickslip.run(config, first)
expected = opened.compute()
child = os.fork()
if child == 0:
    signal.alarm(60)
    same = opened.compute().identical(expected)
    with stickslip.open(first) as ds:
        same &= ds.load().identical(expected)
    with stickslip.run(config, second) as ds:
        same &= ds.load().equals(expected)
    os._exit(0 if same else 3)
sys.exit(os.waitpid(child, 0)[1])
"""


@pytest.mark.slow
@posix
def test_a_process_forked_while_a_thread_writes_writes_too(tmp_path):
    """The locks of h5py and ours are taken in one order by all, `os.fork` included."""
    in_process("-W", "ignore", "-c", FORK_WHILE_WRITING, tmp_path, patience=60)


FORK_WHILE_WRITING = """
import os, signal, sys, threading, time
import stickslip
from helpers.maps import plane
from stickslip.files import writing
from stickslip.files.netcdf import NETCDF_LOCK
folder, ds, locked = sys.argv[1], plane(20, 20), threading.Event()
writing.write(ds, f"{folder}/map.nc")
import h5py

def use_h5py_as_a_writer_does():
    with NETCDF_LOCK:
        locked.set()
        time.sleep(0.5)
        h5py.File("map.nc", "w", driver="core", backing_store=False).close()

thread = threading.Thread(target=use_h5py_as_a_writer_does, daemon=True)
thread.start()
locked.wait()
child = os.fork()
if child == 0:
    signal.alarm(30)
    with stickslip.open(writing.write(ds, f"{folder}/map.nc")) as back:
        os._exit(0 if back.load().identical(ds) else 3)
thread.join()
sys.exit(os.waitpid(child, 0)[1])
"""


# --- compiling --------------------------------------------------------------------------------------------------------


def test_threads_that_ask_for_the_kernels_at_once_compile_them_once(monkeypatch):
    calls, apart = [], compiled.compile_apart
    monkeypatch.setattr(compiled, "_machines", {})
    monkeypatch.setattr(compiled, "_loaded", {})
    monkeypatch.setattr(compiled, "compile_apart", lambda law, signals: calls.append(law) or apart(law, signals))
    assert at_once(*[compiled.warm_up] * 4) == [None] * 4
    assert len(calls) == 1


@pytest.mark.slow
def test_threads_that_ask_at_once_for_kernels_nobody_compiled_get_them(tmp_path):
    roots = [str(Path(package.__file__).parents[1]) for package in (stickslip, stickslip_kernels)]
    in_process("-c", COMPILE, patience=600, NUMBA_CACHE_DIR=str(tmp_path), PYTHONPATH=os.pathsep.join(roots))
    assert len(list(tmp_path.glob("kernels-*/stribeck-*.o"))) == 1


COMPILE = """
import threading
import stickslip
cell = dict(mass=1.0, stiffness=1.0, normal_load=1.0, belt_speed=0.1, a1=1.0, a2=0.1, a3=0.3, a4=0.1)
regimes = []

def work():
    regimes.append(int(stickslip.evaluate(cell)["regime"][0]))

threads = [threading.Thread(target=work) for _ in range(2)]
for thread in threads: thread.start()
for thread in threads: thread.join()
assert len(set(regimes)) == 1 and len(regimes) == 2, regimes
"""
