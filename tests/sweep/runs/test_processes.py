"""Runs in parts in processes of their own: killed, out of space, two at once, without permission."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip
from helpers.configs import write_config
from helpers.nightly import few
from helpers.runs import called, environment, started, until

ROOT = Path(__file__).parents[3]
SEED = os.environ.get("STICKSLIP_SEED", "5")
pytestmark = pytest.mark.usefixtures("kernels")  # what is watched should not compile
posix = pytest.mark.skipif(os.name == "nt", reason="POSIX signals, limits and users")


def same_bits(path, expected):
    with stickslip.open(path) as found:
        for name, values in expected.variables.items():
            assert found[name].dtype == values.dtype
            assert found[name].values.tobytes() == values.values.tobytes(), name


def slow_config(folder, num=300):
    """Some seconds of computing: every cell to a horizon."""
    return write_config(folder, num=num, more="solver: {horizon: 3000, early_stop: false}\n")


@posix
@pytest.mark.slow
@pytest.mark.parametrize("kept", ["", "output: {variables: [regime, period]}\n"], ids=["all", "few"])
def test_killed_at_twenty_moments_a_run_ends_with_the_same_bits_and_computes_nothing_twice(tmp_path, kept):
    config = write_config(tmp_path, num=250, more=f"solver: {{rtol: 0.01}}\n{kept}")  # 62,500 cells in 16 blocks
    output = tmp_path / "a map µ.nc"
    command = [sys.executable, Path(__file__).with_name("kills.py"), config, output, "20", SEED]
    done = subprocess.run(command, env=environment(), text=True, capture_output=True, timeout=600)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["killed"] == 20 and told["codes"] == [] and told["again"] == 0
    assert told["written"] >= 16, "blocks were seen between the kills"
    whole = stickslip.run(config)
    maps = [path for path in tmp_path.iterdir() if path != config]
    assert len(maps) == told["maps"] + 1, "nothing is left but maps"
    for path in maps:
        same_bits(path, whole)
    assert ("period" in whole, "status" in whole) == (True, not kept)


@posix
def test_a_second_run_is_refused_while_the_first_computes_and_ctrl_c_leaves_it_resumable(tmp_path):
    config, output = slow_config(tmp_path), tmp_path / "map.nc"
    folder = tmp_path / "map.nc.parts"
    first = started("run", config, "-o", output)
    until(lambda: list(folder.glob("block-*")))
    code, _, errors = called("run", config, "-o", output)
    assert code == 2
    assert re.search(rf"another run works there: \S+ on \S+, process {first.pid}, since 20", errors)
    assert [holder.pid for holder in stickslip.status(folder).holders] == [first.pid]
    first.send_signal(signal.SIGTERM)
    _, errors = first.communicate(timeout=60)
    assert first.returncode == 1 and "are safe in" in errors
    assert not (folder / "lock.json").exists() and list(folder.glob("block-*"))


@posix
@pytest.mark.parametrize("limit", few([150_000, 1_200_000], 1), ids=["of blocks", "of the map"])
def test_a_full_disk_is_told_and_the_run_goes_on_once_there_is_room(tmp_path, monkeypatch, limit):
    """No file may grow beyond the limit: too small for a block, or for the map alone."""
    import resource

    monkeypatch.delenv("COVERAGE_PROCESS_CONFIG", raising=False)  # it would have no room either, and say so
    config, output = write_config(tmp_path, num=200), tmp_path / "map.nc"
    code, _, errors = called(
        "run", config, "-o", output, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    )
    assert code == 1
    assert "cannot be written" in errors and "are safe in" in errors
    assert not output.exists() and not list(tmp_path.glob(".*"))
    stickslip.run(config, output).close()
    same_bits(output, stickslip.run(config))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="others count peak memory in other units, or not at all")
def test_memory_does_not_grow_with_the_map(tmp_path):
    """Four times the cells, the same peak, within a few megabytes of noise: no array is as long as the map."""
    code = (
        "import resource, sys; from stickslip.cli import main\n"
        "main(['run', sys.argv[1], '-o', sys.argv[2]], standalone_mode=False)\n"
        "print('PEAK', resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    peaks = []
    for num in (400, 700):
        config = write_config(tmp_path, num=num, more="solver: {rtol: 0.01}\n", name=f"{num}.yaml")
        command = [sys.executable, "-c", code, config, tmp_path / f"{num}.nc"]
        done = subprocess.run(command, env=environment(), text=True, capture_output=True, timeout=300, check=True)
        peaks.append(int(done.stdout.split("PEAK")[1]) / 1e3)
    assert peaks[1] - peaks[0] < 0.5 * 134e-6 * (700**2 - 400**2), "half of what the results of the new cells take"
