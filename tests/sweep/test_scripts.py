"""The command as scripts and schedulers use it: settings, threads, silence, JSON, progress in a log, many nodes."""

import io
import json
import os
import re
import shlex
import warnings
from pathlib import Path

import click
import numpy as np
import pytest
from rich.console import Console

import stickslip
from helpers.commands import call, commands_of
from helpers.configs import write_config
from helpers.installed import is_command
from stickslip import progress
from stickslip.config.reader import parse_config
from stickslip.errors import UnitWarning

RIG = """\
system: {mass: 100 g, stiffness: 5 N/mm, damping: 2 N s/m, normal_load: 10 N, belt_speed: 10 mm/s}
friction: {mu_start: 0.4, mu_reversal: 0.3, v_reversal: 100 mm/s, a4: 20 mm/s}
drive: {stroke: 6 mm}
"""


# --- --set -------------------------------------------------------------------------------------------------

NEEDED = {
    "explore": ["--static", "page.html"],
    "border": ["--along", "stiffness"],
    "ramp": ["--along", "belt_speed"],
    "simulate": ["-t", "1"],
}


def params(command):
    return command.get_params(click.Context(command))  # of a study, made when first asked for


def commands_with(option):
    return [name for name, command in commands_of().items() if any(option in p.opts for p in params(command))]


def test_every_command_that_takes_a_configuration_takes_settings():
    names = ("config", "configs", "config_or_store")
    takers = {name for name, command in commands_of().items()
              if any(p.name in names and (isinstance(p, click.Argument) or p.required)
                     for p in params(command))}  # fmt: skip
    assert takers == set(commands_with("--set"))
    some = ("run", "plan", "validate", "simulate", "border", "status", "rig run", "explore")
    assert takers >= {name for name in some if is_command(name.split()[0])}


@pytest.mark.parametrize("name", commands_with("--set"))
def test_no_command_leaves_a_setting_out(here, name):
    """A setting that is wrong is refused, which it would not be if it were ignored."""
    write_config(here, more="output: {file: map.nc}\n")
    (here / "rig.yaml").write_text(RIG)
    config = "rig.yaml" if name.startswith("rig ") else "small.yaml"
    done = call(*name.split(), config, *NEEDED.get(name, ()), "--set", "system.nonsense=1")
    assert done.exit_code == 2
    assert f"{config}: --set system.nonsense=1: system.nonsense: unknown key" in done.stderr


def test_a_map_is_that_of_the_changed_file_and_says_so(here):
    config = write_config(here)
    settings = ["axes.belt_speed.num=5", "system.mass=200 g", "solver.rtol=1e-9"]
    options = [word for setting in settings for word in ("--set", setting)]
    assert call("run", config, "-o", "map.nc", *options).exit_code == 0
    text = config.read_text().replace("stop: 1, num: 12", "stop: 1, num: 5").replace("mass: 1,", "mass: 200 g,")
    found = stickslip.open("map.nc")
    expected = stickslip.run(parse_config(text + "solver: {rtol: 1e-9}\n"))
    assert found.sizes == {"stiffness": 12, "belt_speed": 5}
    np.testing.assert_array_equal(found["period"].values, expected["period"].values)
    assert "rtol: 1e-09" in found.attrs["configuration"]
    assert call("run", config, "-o", "map.nc", *options).exit_code == 0
    refused = call("run", config, "-o", "map.nc", *options[:-1], "solver.rtol=1e-8")
    assert refused.exit_code == 2 and "solver.rtol: 1e-09 there, 1e-08 here" in refused.stderr


def test_shards_with_other_settings_are_refused(here):
    config = write_config(here, num=100, more="output: {file: map.nc}\n")
    assert call("run", config, "--shard", "1/2", "--set", "system.mass=2").exit_code == 0
    refused = call("run", config, "--shard", "2/2", "--set", "system.mass=3")
    assert refused.exit_code == 2 and "system.mass: 2.0 there, 3.0 here" in refused.stderr
    refused = call("collect", "map.nc.parts", "--set", "system.mass=3")
    assert refused.exit_code == 2 and "system.mass: 2.0 there, 3.0 here" in refused.stderr
    stale = Path("map.nc.parts/lock-2-of-2.json")
    stale.write_text(
        json.dumps({**dict.fromkeys(("token", "host", "space", "user"), "x"), "pid": 1, "since": 0, "seen": 0})
    )
    found = call("status", config).stdout
    assert "shard     2/2: 1 of 1 blocks missing; no process works on it: submit it again" in found
    assert json.loads(call("status", config, "--json").stdout)["shards"][0]["shard"] == "2/2"
    for refused in (call("run", config, "--shard", "2/2"), call("collect", config)):
        assert refused.exit_code == 2 and "--fresh" not in refused.stderr
        assert "(--set) as the run that began it: system.mass" in refused.stderr
        assert "stickslip collect map.nc.parts" in refused.stderr
        assert stale.exists() and "took over" not in refused.stderr
    assert (
        call("run", config, "--shard", "2/2", "--set", "system.mass=2", "--set", "execution.threads=1").exit_code == 0
    )
    assert call("collect", "map.nc.parts", "--json").exit_code == 0
    refused = call("collect", config)
    assert refused.exit_code == 2 and ": system.mass" in refused.stderr and "--fresh" not in refused.stderr


def test_collecting_a_part_is_not_done_and_collecting_again_is(here):
    config = write_config(here, num=100, more="output: {file: map.nc}\n")
    half = json.loads(call("run", config, "--shard", "1/2", "--json").stdout)["computed"]
    part = call("collect", config)
    assert part.exit_code == 1
    assert f"{10_000 - half:,} of 10,000 cells are not computed" in part.stderr
    assert int((stickslip.open("map.nc")["regime"] != 0).sum()) == half
    assert call("collect", config, "-o", "so far.nc").exit_code == 2
    part = call("collect", "map.nc.parts", "--json", "-o", "table.csv")
    assert part.exit_code == 1 and json.loads(part.stdout)["items_missing"] == 10_000 - half
    assert len(Path("table.csv").read_text().splitlines()) > 10_000
    call("run", config, "--shard", "2/2")
    whole = json.loads(call("collect", config, "--json").stdout)
    assert whole["items_missing"] == 0 and not whole["up_to_date"] and whole["store"] is None
    again = call("collect", config)
    assert again.exit_code == 0 and "map.nc is complete already" in again.stdout


def test_a_result_is_simulated_with_what_is_set(here):
    call("run", write_config(here), "-o", "map.nc")
    at = ["--at", "stiffness=1", "--at", "belt_speed=0.2", "-t", "5", "-o"]
    for output, rtol in (("a.nc", "1e-3"), ("b.nc", "1e-9")):
        assert call("simulate", "map.nc", *at, output, "--set", f"solver.rtol={rtol}").exit_code == 0
    assert json.loads(stickslip.open("b.nc").attrs["configuration"])["solver"]["rtol"] == 1e-9


def test_threads_win_over_the_file_and_change_no_number(here):
    config = write_config(here, num=60, more="output: {file: map.nc}\n")
    text = config.read_text().replace("block: 4096", "block: 4096, threads: 2")
    config.write_text(text)
    one = json.loads(call("plan", config, "--set", "execution.threads=1", "--json").stdout)
    assert one["threads"] == 1 and json.loads(call("plan", config, "--json").stdout)["threads"] == 2
    done = call("run", config, "--set", "execution.threads=1")
    assert "cells/s on 1 thread\n" in done.stdout
    np.testing.assert_array_equal(stickslip.open("map.nc")["regime"].values, stickslip.run(config)["regime"].values)
    assert call("run", config, "--set", "execution.threads=0").exit_code == 2


# --- --quiet, --json --------------------------------------------------------------------------------------------------


def test_a_quiet_run_says_nothing_but_its_exit_code_and_warnings(here):
    config = write_config(here, num=60, more="output: {file: map.nc}\n")
    done = call("run", config, "--quiet")
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "") and (here / "map.nc").exists()
    assert call("run", config, "-q").output == ""
    refused = call("run", config, "-q", "--set", "system.mass=2")
    assert refused.exit_code == 2 and refused.stdout == "" and "system.mass: 1.0 there, 2.0 here" in refused.stderr
    with warnings.catch_warnings():
        warnings.simplefilter("always", UnitWarning)
        warned = call("run", config, "-q", "-o", "w.nc", "--set", "friction.a4=100")
    assert warned.exit_code == 0 and warned.stdout == ""
    assert "--set friction.a4=100: friction.a4: got 100 m/s" in warned.stderr


def test_standard_output_of_json_is_json_and_keys_are_the_documented_ones(here):
    config = write_config(here, num=100, more="output: {file: map.nc}\n")
    told = {}
    for name, arguments in {
        "plan": ["plan", config, "--nodes", "2"],
        "run --shard": ["run", config, "--shard", "1/2"],
        "status": ["status", config],
        "run": ["run", config],
        "collect": ["collect", config],
        "again": ["run", config],
        "status, finished": ["status", config],
        "inspect": ["inspect", "map.nc", "--regime", "damped", "--limit", "2"],
        "in memory": ["run", write_config(here, name="none.yaml")],
    }.items():
        done = call(*arguments, "--json")
        assert done.exit_code == 0, done.output
        told[name] = json.loads(done.stdout)
    page = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "runs.md")
    with open(page, encoding="utf-8") as file:
        documented = dict(re.findall(r"^\| `(\w+) --json` \| (.*) \|$", file.read(), re.MULTILINE))
    for name, answer in told.items():
        command = (
            name if name in documented else {"in memory": "run", "again": "run"}.get(name, name.split()[0].strip(","))
        )
        assert set(answer) == set(re.findall(r"`(\w+)`", documented[command])), name
    assert told["plan"]["nodes"]["submit"].startswith("sbatch --array=1-2 ")
    assert told["run --shard"]["shard"] == "1/2" and told["run --shard"]["output"] is None
    half = told["run --shard"]["computed"]
    assert told["status"]["items_finished"] == half and not told["status"]["finished"]
    assert (told["run"]["found"], told["run"]["computed"]) == (half, 10_000 - half)
    ds = stickslip.open("map.nc")
    assert told["run"]["regimes"] == {"stick_slip": int((ds["regime"] == 1).sum()),
                                      "damped": int((ds["regime"] == 2).sum()),
                                      "creep": int((ds["regime"] == 3).sum())}  # fmt: skip
    assert told["again"]["up_to_date"] and told["again"]["regimes"] == told["run"]["regimes"]
    assert told["status, finished"]["finished"] and told["status, finished"]["output"] == "map.nc"
    assert told["status, finished"]["items"] == told["status, finished"]["items_finished"] == 10_000
    assert told["inspect"]["wanted"] == told["run"]["regimes"]["damped"] and len(told["inspect"]["listed"]) == 2
    assert told["inspect"]["cells"] == 10_000
    assert told["in memory"]["output"] is None and told["in memory"]["items"] == 144


def test_what_goes_wrong_leaves_standard_output_empty(here):
    for arguments in (["run", "none.yaml"], ["status", "none.yaml"], ["inspect", "none.nc"], ["plan", "none.yaml"]):
        done = call(*arguments, "--json")
        assert done.exit_code == 2 and done.stdout == "" and done.stderr


# --- progress in a log ------------------------------------------------------------------------------------------------


def lines(moves, doing=""):
    """What is told of moves (time, done) of 6,000 cells."""
    clock = [0.0]
    console = Console(file=io.StringIO(), get_time=lambda: clock[0])
    shown = progress.Bar(console, "cells", doing)
    for clock[0], done in moves:
        shown.move(done, 6000)
    shown.end()
    return console.file.getvalue().splitlines()


def test_a_log_gets_a_line_at_the_start_every_minute_and_at_the_end():
    found = lines([(t, 600 + 10 * t) for t in range(1, 541)])
    assert found[0] == " 10.2 %  610 of 6,000 cells"
    assert found[1] == " 20.2 %  1,210 of 6,000 cells, 10/s, about 8 min left"
    assert found[-1] == "100.0 %  6,000 of 6,000 cells, 10/s, after 9 min"
    assert len(found) == 1 + 8 + 1


# --- many nodes -------------------------------------------------------------------------------------------------------


def test_the_lines_of_a_plan_are_commands_that_compute_the_map(here):
    config = write_config(here, num=100)
    told = call("plan", config.name, "--nodes", "2", "--set", "system.mass=200 g", "--set", "execution.threads=1")
    assert told.exit_code == 0, told.output
    rows = {line.split()[0]: line.split(maxsplit=1)[1] for line in told.stdout.splitlines() if line[:1].isalpha()}
    sbatch = shlex.split(rows["submit"])
    assert sbatch[:3] == ["sbatch", "--array=1-2", "--cpus-per-task=1"]
    assert sbatch[3].startswith("--mem=") and sbatch[4] == "--time=11"
    run = sbatch[5].removeprefix("--wrap=")
    for task in ("1", "2"):
        words = shlex.split(run.replace("$SLURM_ARRAY_TASK_ID", task))
        assert call(*words[1:]).exit_code == 0, words
    found = call(*shlex.split(rows["status"])[1:]).stdout
    assert "10,000 of 10,000 cells" in found and "by no process: stickslip collect writes the result" in found
    assert call(*shlex.split(rows["collect"], comments=True)[1:]).exit_code == 0
    assert int((stickslip.open("small.nc")["regime"] == 0).sum()) == 0


def test_a_plan_says_when_nodes_or_threads_have_nothing_to_do(here):
    config = write_config(here, num=100)
    told = call("plan", config, "--nodes", "40").stdout
    assert "further nodes have nothing to compute" in told and "--array=1-3 " in told and "ID/3" in told
    assert sum(line.startswith("time ") for line in told.splitlines()) == 1
    assert (
        "fewer blocks than a node has threads"
        in call("plan", config, "--nodes", "2", "--set", "execution.threads=9").stdout
    )
