"""Several threads at once; in processes of their own, since what goes wrong there is a crash or a deadlock."""

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
from stickslip.files import writing
from stickslip.files.reading import NETCDF_LOCK

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


def test_threads_that_read_and_copy_one_lazy_dataset_do_not_deadlock(tmp_path):
    path = writing.write(plane(20, 20), tmp_path / "map.nc")
    with stickslip.open(path) as ds:
        loads = [lambda: ds.compute().identical(plane(20, 20)) for _ in range(2)]
        writes = [lambda n=n: writing.write(ds, tmp_path / f"copy{n}.nc") for n in range(2)]
        outcomes = at_once(*loads, *writes)
    assert not [outcome for outcome in outcomes if isinstance(outcome, Exception)]


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


def test_an_open_dataset_goes_to_other_processes(tmp_path):
    path = writing.write(plane(), tmp_path / "map.nc")
    assert pickle.loads(pickle.dumps(NETCDF_LOCK)) is NETCDF_LOCK
    with stickslip.open(path) as ds, pickle.loads(pickle.dumps(ds)) as copy:
        xr.testing.assert_equal(copy.load(), plane())


# --- runs -------------------------------------------------------------------------------------------------------------


@posix
@pytest.mark.parametrize("kind", ["nc", pytest.param("zarr", marks=pytest.mark.slow)])
def test_a_process_forked_after_a_run_reads_and_runs(kernels, kind, tmp_path):
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


# --- compiling --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_threads_that_ask_at_once_for_kernels_nobody_compiled_get_them(tmp_path):
    roots = [str(Path(package.__file__).parents[1]) for package in (stickslip, stickslip_kernels)]
    in_process("-c", COMPILE, patience=600, NUMBA_CACHE_DIR=str(tmp_path), PYTHONPATH=os.pathsep.join(roots))
    assert len(list(tmp_path.glob("kernels-*/*.o"))) == 2  # law and machine


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
