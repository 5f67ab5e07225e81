"""Blocks computed by a real Dask scheduler and real workers, which are killed."""

import os
import re
import signal
import subprocess
import sys
import threading
from dataclasses import replace

import pytest

import stickslip
from helpers.cluster import BLOCK, CLI, Cluster, environment
from helpers.commands import call
from helpers.configs import write_config
from helpers.runs import block_files, opened, same, until
from stickslip.runs import cluster as clusters
from stickslip.runs import work

distributed = pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(os.name == "nt", reason="POSIX signals"),
    pytest.mark.filterwarnings("default"),  # Dask's own
]
SIDE, COUNT = 60, 60  # 3,600 cells in blocks of a row


@pytest.fixture(scope="module")
def shared(kernels, tmp_path_factory):
    cluster = Cluster(tmp_path_factory.mktemp("cluster"), 3)
    yield cluster
    cluster.close()


@pytest.fixture
def cluster(shared):
    shared.forget()
    with distributed.Client(shared.address, set_as_default=False) as client:
        client.wait_for_workers(3, timeout=60)
    return shared


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(work, "_FEWEST", BLOCK)
    monkeypatch.setattr(work, "_BLOCKS", 10**9)


@pytest.fixture
def config(tmp_path, small_blocks):
    return write_config(tmp_path, num=SIDE)


@pytest.fixture
def output(tmp_path):
    return tmp_path / "map µ.nc"


@pytest.fixture
def whole(config):
    return stickslip.run(config)


def started(folder, *arguments):
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment(folder)}
    return subprocess.Popen([sys.executable, "-c", CLI, *map(str, arguments)], start_new_session=True, **pipes)


def ended(process):
    out, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors + out and "distributed." not in errors + out, errors
    return process.returncode, out, errors.replace("\n", " ")


def worker_pids(cluster):
    with distributed.Client(cluster.address, set_as_default=False) as client:
        return list(client.run(os.getpid).values())


def test_a_worker_killed_in_mid_run_changes_no_bit(cluster, config, output, whole):
    cluster.say("slow", "0.05")
    pids = worker_pids(cluster)

    def kill():
        until(lambda: len(cluster.computed()) > 10)
        os.kill(pids[0], signal.SIGKILL)

    killer = threading.Thread(target=kill)
    killer.start()
    stickslip.run(config, output, dask=cluster.address).close()
    killer.join()
    assert pids[0] not in worker_pids(cluster)
    same(opened(output), whole)
    assert set(cluster.computed()) == set(range(COUNT))
    assert not output.with_name("map µ.nc.parts").exists()


def test_a_store_that_workers_do_not_see_is_written_by_the_client(cluster, config, output, whole, monkeypatch):
    """They look into another folder of that name, as on another machine."""
    job = clusters.Job
    monkeypatch.setattr(clusters, "Job", lambda *of: replace(job(*of), place=f"{of[2]} of another machine"))
    stickslip.run(config, output, dask=cluster.address).close()
    same(opened(output), whole)


def test_a_block_that_kills_every_worker_is_recorded_and_the_others_finish(cluster, config, output, whole):
    cluster.say("deadly-20")
    with pytest.raises(stickslip.IncompleteError, match=r"blocks? \(\d+ cells\) failed, .* with KilledWorker: "):
        stickslip.run(config, output, dask=cluster.address)
    store = f"{output}.parts"
    failed = [failure.block for failure in stickslip.status(store).failures]  # and what ran beside it each time
    assert 20 in failed and len(failed) < 8 and len(block_files(store)) == COUNT - len(failed)
    cluster.forget()
    stickslip.retry_failed(store, dask=cluster.address)
    assert sorted(cluster.computed()) == failed
    same(opened(output), whole)


def test_what_a_block_raises_is_recorded_with_its_traceback_after_retries(cluster, config, output):
    cluster.say("broken-3")
    with pytest.raises(stickslip.IncompleteError, match="ArithmeticError: broken on purpose"):
        stickslip.run(config, output, dask=cluster.address)
    (failure,) = stickslip.status(f"{output}.parts").failures
    assert failure.block == 3 and "worker_preload.py" in failure.traceback


def test_workers_of_another_version_are_refused_by_name(cluster, config, output, monkeypatch):
    there = clusters.versions()
    monkeypatch.setattr(clusters, "version", lambda name: "0.1")
    with pytest.raises(stickslip.ClusterError) as caught:
        stickslip.run(config, output, dask=cluster.address)
    assert re.search(rf"3 of 3 workers .*\n  tcp://\S+: numba {there['numba']} \(here 0.1\)", str(caught.value))
    assert not output.with_name("map µ.nc.parts").exists()


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "tcp://nowhere", "gone.json"])
def test_a_scheduler_that_is_not_there_is_told_before_anything_is_changed(config, output, monkeypatch, address):
    monkeypatch.setattr(clusters, "PATIENCE", 0.5)
    monkeypatch.chdir(output.parent)
    done = call("run", config, "-o", output, "--set", f"execution.dask={address}")
    assert done.exit_code == 2, done.output
    assert address in done.stderr and "Traceback" not in done.stderr
    assert not output.with_name("map µ.nc.parts").exists()


def test_ctrl_c_and_a_killed_scheduler_leave_a_run_that_goes_on(shared, config, output, whole):
    """Last, since it ends the scheduler. What is finished is not computed again."""
    shared.forget()
    shared.say("slow", "0.1")
    store = output.with_name("map µ.nc.parts")
    for hit in (lambda run: os.killpg(run.pid, signal.SIGINT), lambda run: shared.scheduler.kill()):
        count = len(finished(store))
        run = started(shared.folder, "run", config, "-o", output, "--set", f"execution.dask={shared.address}")
        until(lambda: len(finished(store)) > count + 4)  # noqa: B023
        hit(run)
        code, _, errors = ended(run)
        assert code == 1, errors
        assert re.search(rf"[\d,]+ of 3,600 cells are safe in {store}; the same command resumes from there", errors)
    assert f"{shared.address}: lost the connection to the Dask scheduler" in errors
    shared.forget()
    there = finished(store)
    assert 8 < len(there) < COUNT
    code, out, errors = ended(started(shared.folder, "run", config, "-o", output, "--set", "execution.dask=local"))
    assert code == 0, errors
    assert "cells were found finished" in errors and re.search(r"on \d Dask workers? \(this machine\)", out)
    assert sorted(shared.computed()) == sorted(set(range(COUNT)) - there)
    same(opened(output).assign_attrs(configuration=whole.attrs["configuration"]), whole)


def finished(store):
    return {int(path.name.removeprefix("block-")) for path in store.glob("block-*")}
