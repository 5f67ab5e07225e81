"""The command as a new user meets it: what it prints, writes and returns."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import stickslip
from helpers.commands import call, commands_of
from helpers.configs import write_config
from helpers.data import cases
from helpers.runs import until
from stickslip import extensions
from stickslip.runs.work import Work
from stickslip.vocabulary.quantities import STATUSES

ROOT = Path(__file__).parents[2]


# --- run --------------------------------------------------------------------------------------------------------------


def test_run_writes_map_and_plot_and_ends_with_a_summary(here):
    config = write_config(here, more="output: {file: map.nc, plot: map.png}\n")
    done = call("run", config)
    assert done.exit_code == 0, done.output
    assert "144 cells: stiffness (12) x belt_speed (12)" in done.stdout
    lines = {line.split()[0]: line.split() for line in done.stdout.splitlines() if line.strip()}
    ds = stickslip.open(here / "map.nc")
    sticks = int((ds["regime"] == 1).sum())
    assert lines["stick_slip"][1:] == [f"{sticks}", f"{sticks / 144:.1%}"]
    assert lines["map"][1] == "map.nc" and lines["plot"][1] == "map.png"
    assert "cells/s on" in done.stdout
    assert (here / "map.png").read_bytes().startswith(b"\x89PNG")


def test_options_go_before_the_output_section(here):
    config = write_config(here, more="output: {file: map.nc, plot: map.png}\n")
    assert call("run", config, "-o", "other.nc", "--set", "output.plot=").exit_code == 0
    assert {p.name for p in here.iterdir()} == {"small.yaml", "other.nc"}


def test_without_an_output_it_is_said_that_the_map_is_not_kept(here, kernels):
    write_config(here, name="a map.yaml")
    done = call("run", "a map.yaml", "--plot", "map.png")
    assert done.exit_code == 0 and "stick_slip" in done.stdout and "discarded; -o FILE.nc writes" in done.stderr
    assert {p.name for p in here.iterdir()} == {"a map.yaml", "map.png"}


@cases("sweep.yaml")
def test_a_target_that_will_not_do_is_told_before_computing(here, arguments, message):
    done = call("run", write_config(here), *arguments)
    assert done.exit_code == 2
    assert message in done.stderr
    assert done.stdout == ""


def test_a_wrong_configuration_shows_its_mistakes_and_no_traceback(here):
    config = write_config(here)
    config.write_text(config.read_text().replace("mass: 1", "mass: -1").replace("stop: 10", "stop: 10 kg"))
    done = call("run", config)
    assert done.exit_code == 2
    assert len([line for line in done.stderr.splitlines() if line.startswith(str(config))]) == 2
    assert "Traceback" not in done.output and done.stdout == ""


def command(*arguments, **options):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT / "sweep"), str(ROOT / "kernels")])}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "env": environment}
    return subprocess.Popen([sys.executable, "-m", "stickslip", *map(str, arguments)], **pipes, **options)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends Ctrl-C to whole groups of processes")
@pytest.mark.skipif(signal.getsignal(signal.SIGINT) is signal.SIG_IGN, reason="Ctrl-C is ignored, as by a shell's jobs")
def test_ctrl_c_stops_promptly_and_says_what_is_safe(here, kernels):
    """A map of minutes, interrupted once its first block is there."""
    more = "solver: {horizon: 20000, early_stop: false}\noutput: {file: map.nc}\n"
    config = write_config(here, num=700, more=more)
    with command("run", config, cwd=here) as process:
        try:
            until(lambda: list(here.glob("map.nc.parts/block-*")))
            process.send_signal(signal.SIGINT)
            began = time.perf_counter()
            _, errors = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 1
    assert "Traceback" not in errors
    assert time.perf_counter() - began < 20.0  # of minutes; a busy machine takes its time to end a process
    told = re.search(
        r"interrupted: ([\d,]+) of 490,000 cells are safe in map.nc.parts; the same command resumes", errors
    )
    safe = int(told[1].replace(",", ""))
    blocks = [name for name in os.listdir("map.nc.parts") if name.startswith("block-")]
    assert 0 < safe == 7000 * len(blocks) < 490_000  # ten rows a block
    assert not (here / "map.nc").exists()


def test_help_answers_without_loading_the_numerics():
    code = "import sys, stickslip.cli as c; c.main(['--help'], standalone_mode=False); print(sorted(sys.modules))"
    environment = os.environ | {"PYTHONPATH": str(ROOT / "sweep")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert "Exit codes" in done.stdout
    assert not any(f"'{name}'" in done.stdout for name in ("numba", "numpy", "xarray", "pydantic", "matplotlib"))


def test_a_map_and_its_plot_are_made_without_what_they_do_not_need(here):
    """SciPy and Dask take a second to load."""
    config = write_config(here, more="output: {file: map.nc, plot: map.png}\n")
    run = f"c.main(['run', {str(config)!r}], standalone_mode=False)"
    code = f"import sys, stickslip.cli as c; {run}; print([*sys.modules])"
    with_kernels = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT / "sweep"), str(ROOT / "kernels")])}
    done = subprocess.run([sys.executable, "-c", code], env=with_kernels, capture_output=True, text=True, check=True)
    assert (here / "map.png").exists()
    loaded = {name.strip(" '[]") for name in done.stdout.splitlines()[-1].split(",")}
    assert "matplotlib.figure" in loaded
    assert not loaded & {"scipy.special", "scipy.stats", "scipy.optimize", "dask", "numba"}
    assert not loaded & {"stickslip.api.studies", "stickslip.studies.attractors", "stickslip.dataset.export"}
    of_extensions = {name for name in loaded if re.match(r"stickslip_(?!kernels)\w+\.(?!extension$)", name)}
    assert of_extensions <= {place.partition(":")[0] for place in extensions.brought("quantities").values()}
    assert not loaded & {f"stickslip.cli.{other}" for other in ("cells", "stores", "studies")}


def test_every_command_has_help_that_fits_a_screen():
    for name in commands_of():
        done = call(*name.split(), "--help")
        assert done.exit_code == 0
        assert all(len(line) <= 100 for line in done.output.splitlines())
    whole = call("--help").stdout
    assert len(whole.splitlines()) <= 40 and "..." not in whole.partition("To begin:")[2]


# --- runs in parts ----------------------------------------------------------------------------------------------------


def test_blocks_that_failed_are_shown_with_what_happened_and_computed_once_more(here, monkeypatch):
    config = write_config(here, num=100, more="output: {file: map.nc}\n")
    compute, broken = Work.compute, [1]

    def failing(self, number, *rest):
        if number in broken:
            raise ZeroDivisionError(f"in block {number}")
        return compute(self, number, *rest)

    monkeypatch.setattr(Work, "compute", failing)
    assert call("run", config).exit_code == 1
    shown = call("status", config).stdout
    assert "1 failed, of 3" in shown and "failed    block 1: ZeroDivisionError: in block 1" in shown
    assert "What happened in block 1:\nTraceback" in shown and "in failing" in shown
    assert call("retry-failed", config).exit_code == 1
    broken.clear()
    done = call("retry-failed", config)
    assert done.exit_code == 0 and "3,400 cells in" in done.stdout and (here / "map.nc").is_file(), done.output


@cases("sweep.yaml")
def test_what_a_shard_names_next_works_when_it_is_pasted(here, section, options, map_file):
    config = write_config(here, num=100, more=section)
    done = call("run", config, "--shard", "1/2", *options)
    assert done.exit_code == 0, done.output
    status, collect = [shlex.split(line, comments=True) for line in done.stdout.splitlines()[-2:]]
    assert call(*status[status.index("stickslip") + 1 :]).stdout.count("6,600 of 10,000 cells") == 1
    assert call(*collect[1:]).exit_code == 1
    assert int((stickslip.open(map_file)["regime"] != 0).sum()) == 6600


@cases("sweep.yaml")
def test_stores_that_will_not_do_are_told(here, arguments, message):
    done = call("run", write_config(here), *arguments)
    assert done.exit_code == 2 and message in done.stderr, done.output
    assert "Traceback" not in done.output and not (here / "none").exists()


@pytest.mark.parametrize("name", ["collect", "status"])
def test_commands_for_stores_explain_what_they_miss(here, name):
    config = write_config(here)
    for place, message in ((config, "name an output"), ("memory://none", "on a file system"),
                           ("none.yaml", "none.yaml"), (".", "holds other things")):  # fmt: skip
        done = call(name, place)
        assert done.exit_code == 2 and "Traceback" not in done.output
        assert message in done.stderr or name == "collect" and "name it with --output" in done.stderr


# --- plan, validate ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", ["plan", "run"])
def test_plan_and_run_name_a_package_that_a_configured_file_needs(here, monkeypatch, command):
    monkeypatch.setattr("stickslip.files.targets.find_spec", lambda name: None)
    done = call(command, write_config(here, more="output: {file: a.zarr}\n"))
    assert done.exit_code == 2 and "need zarr\nhint: pip install" in done.stderr
    assert [p.name for p in here.iterdir()] == ["small.yaml"]


def test_a_run_counts_the_cells_that_run_out_of_steps(here):
    config = write_config(here, num=40, more="solver: {max_steps: 12}\noutput: {file: map.nc}\n")
    done = call("run", config)
    limited = int((stickslip.open("map.nc")["status"] == STATUSES.index("step_limit")).sum())
    assert 0 < limited < 1600
    assert f"{limited:,} unresolved cells: stickslip inspect map.nc" in done.stdout
    assert "unresolved" not in call("run", write_config(here, num=40, name="enough.yaml")).stdout


def test_validate_says_what_it_understood_in_si(here):
    (here / "my.yaml").write_text(
        "system: {mass: 100 g, stiffness: 5 N/mm, normal_load: 10 N}\n"
        "friction: {a1: 0.2, a2: 0, a3: 0.1, a4: 20 mm/s}\n"
        "axes:\n  belt_speed: {start: 1 mm/s, stop: 20 cm/s, num: 80, spacing: log}\n"
        "  lubricant: {zip: {mu_stop: [none, 0.25], damping: [0, 1 N s/m]}, labels: [dry, oil]}\n"
    )
    done = call("validate", "my.yaml")
    parts = [re.split("  +", line.strip()) for line in done.stdout.splitlines()[1:]]
    rows = {name: rest for name, *rest in parts}
    assert done.stdout.startswith("my.yaml: valid, 160 cells: belt_speed (80) x lubricant (2)\n")
    assert (
        rows["mass"] == ["0.1 kg", "(100 g)", "mass"]
        and rows["stiffness"][0] == "5000 N/m"
        and rows["a4"][0] == "0.02 m/s"
    )
    assert rows["natural frequency"][0] == "35.6 Hz"  # sqrt(50000)/6.283
    assert rows["static deflection"][:2] == ["0.0006 m", "(0.6 mm)"]  # 0.3 x 10/5000
    assert rows["velocity"] == ["sticking", "velocity at the start: that of the belt, sticking"]
    assert rows["axis belt_speed"] == ["0.001 to 0.2 m/s", "(1 to 200 mm/s)", "80 values, log spacing: belt speed"]
    assert rows["axis lubricant"] == ["2 points", "dry, oil"]
    assert rows["with mu_stop"][0] == "none, 0.25" and rows["with damping"][0] == "0, 1 N s/m"
    assert rows["solver"][0] == "rtol 1e-06, max_steps 100,000, horizon none"


def test_validate_lists_the_mistakes_of_every_file(here):
    good, bad, worse = (write_config(here, name=f"{name}.yaml") for name in ("good", "bad", "worse"))
    bad.write_text(bad.read_text().replace("a4: 0.1", "a5: 0.1"))
    worse.write_text(worse.read_text().replace("mass: 1", "mass: 1 m"))
    done = call("validate", good, bad, worse)
    assert done.exit_code == 2
    assert f"{good}: valid, 144 cells" in done.stdout
    assert f"{bad}:3:" in done.stderr and f"{worse}:2:" in done.stderr
    assert call("validate", good).exit_code == 0


# --- simulate, plot ---------------------------------------------------------------------------------------------------


def test_simulate_writes_one_cell_over_time(here):
    config = write_config(here)
    done = call("simulate", config, "--at", "stiffness=1", "--at", "belt_speed=10 cm/s", "-t", "30 s",
                "-o", "trace.nc", "--plot", "trace.png")  # fmt: skip
    assert done.exit_code == 0, done.output
    ds = stickslip.open(here / "trace.nc")
    cell = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": 0.1, "a1": 1.0, "a2": 0.1, "a3": 0.3}
    expected = stickslip.simulate(cell, duration=30.0, samples=ds.sizes["time"], a4=0.1)
    np.testing.assert_array_equal(ds["displacement"], expected["displacement"])
    assert (here / "trace.png").exists()


@cases("sweep.yaml")
def test_simulate_explains_what_is_missing(here, arguments, message):
    done = call("simulate", write_config(here), *arguments)
    assert done.exit_code == 2 and message in done.stderr
    assert "Traceback" not in done.output


# --- schema, init -----------------------------------------------------------------------------------------------------


def test_configurations_that_ship_are_listed_and_copied(here):
    listed = call("init", "--list").stdout
    assert "stickslip run quickstart " in listed and "stickslip run article/fig3 " in listed
    done = call("init", "my.yaml", "--from", "article/fig3")
    assert done.stdout == "wrote my.yaml; next: stickslip run my.yaml\n"
    assert (here / "my.yaml").read_bytes() == (ROOT / "configs" / "article" / "fig3.yaml").read_bytes()
    unknown = call("init", "other.yaml", "--from", "quickstrat")
    assert unknown.exit_code == 2 and "there are article/basins, " in unknown.stderr and not Path("other.yaml").exists()


@pytest.mark.parametrize("name", ["configs/article/fig3.yaml", "article/fig3"])
def test_configurations_that_ship_are_found_from_any_folder_and_it_is_said(here, name):
    done = call("run", name)
    assert done.exit_code == 0, done.output
    assert done.stderr.startswith(f"{name}: no such file here, taken from those that come with stickslip: ")
    assert [path.name for path in here.iterdir()] == ["fig3.nc"]


@pytest.mark.parametrize("command", ["run", "plan"])
def test_a_missing_file_with_the_name_of_one_that_ships_is_refused_and_that_one_named(here, command):
    """It may be somebody's copy, called from the wrong folder."""
    done = call(command, "quickstart.yaml")
    assert done.exit_code == 2 and "`stickslip init --list` names those" in done.stderr


def test_init_writes_a_configuration_that_runs_and_overwrites_nothing(here):
    done = call("init", "my.yaml")
    assert done.stdout == "wrote my.yaml; next: stickslip run my.yaml\n"
    assert call("run", "my.yaml").exit_code == 0
    again = call("init", "my.yaml")
    assert again.exit_code == 2 and "exists already" in again.stderr
    assert call("init", "no/folder.yaml").exit_code == 2
