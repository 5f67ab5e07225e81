"""Runs in parts in processes of their own: killed, out of space, two at once, without permission."""

import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

import stickslip
from helpers.configs import write_config
from helpers.nightly import few
from helpers.runs import until

ROOT = Path(__file__).parents[3]
SEED = os.environ.get("STICKSLIP_SEED", "5")
COMMAND = (sys.executable, "-m", "stickslip")
pytestmark = pytest.mark.usefixtures("kernels")  # what is watched should not compile
posix = pytest.mark.skipif(os.name == "nt", reason="POSIX signals, limits and users")


def environment():
    return os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "PYTHONWARNINGS": "ignore"}


def started(*arguments, **options):
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment()}
    return subprocess.Popen([*COMMAND, *map(str, arguments)], **pipes, **options)


def called(*arguments, **options):
    process = started(*arguments, **options)
    out, errors = process.communicate(timeout=120)
    assert "Traceback" not in errors, errors
    return process.returncode, out, errors


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
@pytest.mark.slow
def test_disks_that_are_full_at_any_moment_leave_a_store_that_is_resumed(tmp_path, monkeypatch):
    """Limits at random, between no room for the first lock and room for all."""
    import resource

    monkeypatch.delenv("COVERAGE_PROCESS_CONFIG", raising=False)  # it would have no room either, and say so
    chance, config = random.Random(SEED), write_config(tmp_path, num=200)
    whole = stickslip.run(config)
    for suffix in ("nc", "zarr"):
        for number in range(6):
            output, limit = tmp_path / f"{number}.{suffix}", int(10 ** chance.uniform(1.5, 6.2))
            code, _, errors = called("run", config, "-o", output, "--no-plot", preexec_fn=lambda limit=limit:
                                     resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))  # fmt: skip
            assert code in (0, 1, 2), limit
            assert (code == 0) == output.exists() and (code == 0 or "cannot be written" in errors), (limit, errors)
            stickslip.run(config, output).close()
            same_bits(output, whole)


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
@posix
def test_shards_at_once_are_merged_to_the_bits_of_one_run(tmp_path):
    config, output = write_config(tmp_path, num=200), tmp_path / "map.nc"
    running = [started("run", config, "-o", output, "--shard", f"{i}/3") for i in (1, 2, 3)]
    for process in running:
        process.communicate(timeout=120)
    assert [process.returncode for process in running] == [0, 0, 0]
    stickslip.collect(f"{output}.parts").close()
    same_bits(output, stickslip.run(config))


@posix
@pytest.mark.parametrize("where", ["no permission", "below a file", "proc"])
def test_folders_that_cannot_be_written_are_told_before_computing(tmp_path, where):
    """Root may write everywhere, so it becomes nobody for a moment."""
    from click.testing import CliRunner

    from stickslip.cli import main

    folder = Path(tempfile.mkdtemp(prefix="read only µ "))  # outside tmp_path, whose parents are private
    config = write_config(folder)
    output = {"no permission": folder / "map.nc", "below a file": config / "map.nc", "proc": Path("/proc/x/map.nc")}
    user = os.geteuid()
    try:
        folder.chmod(0o555)
        if user == 0:
            os.seteuid(65534)
        done = CliRunner().invoke(main, ["run", str(config), "-o", str(output[where])])
    finally:
        if user == 0:
            os.seteuid(0)
        folder.chmod(0o755)
    shutil.rmtree(folder)
    assert done.exit_code == 2, done.output
    assert f"{output[where]}: cannot be written" in done.stderr.replace(str(output[where].parent.resolve()), str(
        output[where].parent))  # fmt: skip
    assert "Traceback" not in done.output


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="others count peak memory in other units, or not at all")
def test_memory_does_not_grow_with_the_map(tmp_path):
    """Four times the cells, the same peak, within a few megabytes of noise: no array is as long as the map."""
    code = (
        "import resource, sys; from stickslip.cli import main\n"
        "main(['run', sys.argv[1], '-o', sys.argv[2], '--no-plot'], standalone_mode=False)\n"
        "print('PEAK', resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    peaks = []
    for num in (400, 700):
        config = write_config(tmp_path, num=num, more="solver: {rtol: 0.01}\n", name=f"{num}.yaml")
        command = [sys.executable, "-c", code, config, tmp_path / f"{num}.nc"]
        done = subprocess.run(command, env=environment(), text=True, capture_output=True, timeout=300, check=True)
        peaks.append(int(done.stdout.split("PEAK")[1]) / 1e3)
    assert peaks[1] - peaks[0] < 0.5 * 134e-6 * (700**2 - 400**2), "half of what the results of the new cells take"
