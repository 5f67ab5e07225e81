import numpy as np
import pytest

import stickslip
from helpers.commands import call
from helpers.data import cases
from stickslip.config.grid import build_grid
from stickslip.config.reader import parse_config
from stickslip.dataset.build import map_dataset, provenance
from stickslip.dataset.coarse import chunks, remark, summary, survey
from stickslip.errors import ConfigError
from stickslip.files import writing
from stickslip.vocabulary.quantities import REGIMES, STATUSES

MAP = """
title: a map
system: {mass: 0.1 kg, normal_load: 2}
friction: {mu_start: 1.3, v_reversal: 340 mm/s, a4: 0.1}
axes:
  stiffness: {start: 1, stop: 1000, num: 7, spacing: log}
  mu_reversal: [1.0440, 1.1, 1.2]
  pad: {zip: {damping: [0, 0.1], ageing_rate: [0.1, 0.3]}, labels: ["felt (old)", "it's silk"]}
  mu_stop: [none, 0.7]
  belt_speed: {start: 0.1, stop: 0.7, num: 13}
"""


def made_up(text: str, **changes):
    """A map without computing: everything damped, but for the cells given by flat number."""
    config = parse_config(text)
    grid = build_grid(config)
    regime, status = np.full(grid.size, REGIMES.index("damped")), np.full(grid.size, STATUSES.index("settled"))
    for name, cells in changes.items():
        regime[cells] = REGIMES.index(name)
        status[cells] = STATUSES.index("not_finite" if name == "failed" else "step_limit")
    period = np.full(grid.size, np.nan)
    results = {"regime": regime, "status": status, "period": period, "breakaway_time": np.full(grid.size, 0.5)}
    return map_dataset(grid, results, provenance(config.to_yaml(), title=config.title)), config, grid


# --- counts -----------------------------------------------------------------------------------------------------------


def test_cells_are_counted_by_regime_and_status():
    ds, _, grid = made_up(MAP, failed=[3, 50], unresolved=[7])
    found = survey(ds)
    expected = {("damped", "settled"): grid.size - 3, ("failed", "not_finite"): 2, ("unresolved", "step_limit"): 1}
    assert found.counts == expected
    assert found.wanted == 3 and [cell.number for cell in found.cells] == [3, 7, 50]


def test_the_first_cells_are_listed_up_to_a_limit_and_counted_all_the_same():
    ds, _, grid = made_up(MAP, failed=np.arange(5, 90))
    found = survey(ds, limit=4)
    assert found.wanted == 85 and [cell.number for cell in found.cells] == [5, 6, 7, 8]
    assert survey(ds, limit=0).cells == []


def test_the_position_of_a_cell_is_that_of_its_number_however_the_map_is_read(tmp_path, monkeypatch):
    ds, _, grid = made_up(MAP, failed=slice(None, None, 11), unresolved=[7])
    monkeypatch.setattr("stickslip.dataset.coarse.chunks", lambda flags: chunks(flags, 100))
    with stickslip.open(writing.write(ds, tmp_path / "map.nc")) as ds:
        cells = survey(ds, limit=10**6).cells
    assert [cell.number for cell in cells] == sorted([7, *range(0, grid.size, 11)])
    for cell in cells:
        assert [*cell.position.values()] == [*np.unravel_index(cell.number, grid.shape)]
        assert cell.regime == REGIMES[int(ds["regime"].isel(cell.position))]


@cases("sweep.yaml")
def test_any_regime_or_status_can_be_listed(options, numbers):
    ds, _, _ = made_up(MAP, failed=[3], unresolved=[7])
    assert [cell.number for cell in survey(ds, **options).cells] == numbers


def test_a_misspelt_regime_is_refused_with_those_that_exist():
    ds, _, _ = made_up(MAP)
    with pytest.raises(
        ConfigError, match="--regime: got 'stickslip', expected not_computed, .*\n.*did you mean stick_s"
    ):
        survey(ds, regimes=["stickslip"])


def test_a_report_says_how_many_cells_are_bad_and_how_to_see_them():
    ds, _, _ = made_up(MAP, failed=[3, 50], unresolved=[7])
    assert remark(summary(ds), "my map.nc") == "2 failed and 1 unresolved cells: stickslip inspect 'my map.nc'"
    assert remark(summary(made_up(MAP)[0]), "my map.nc") is None


# --- the commands -----------------------------------------------------------------------------------------------------

SMALL = """
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes: {stiffness: {start: 1, stop: 10, num: 3, spacing: log}, belt_speed: [0.1, 0.2, 0.9]}
solver: {max_steps: 6}
output: {file: small.nc}
"""


def test_run_reports_bad_cells_inspect_lists_them_and_simulate_shows_them(here):
    (here / "small.yaml").write_text(SMALL)
    done = call("run", "small.yaml")
    assert done.exit_code == 0 and "unresolved cells: stickslip inspect small.nc" in done.stdout
    listed = call("inspect", "small.nc")
    assert listed.exit_code == 0, listed.output
    lines = [line.split() for line in listed.stdout.splitlines() if line.endswith("step_limit")]
    ds = stickslip.open("small.nc")
    assert len(lines) == summary(ds)["unresolved"].cells
    assert "step_limit: the step budget ran out" in listed.stdout
    stiffness, belt_speed = " ".join(lines[0][1:3]), " ".join(lines[0][3:5])
    at = ("--at", f"stiffness={stiffness}", "--at", f"belt_speed={belt_speed}")
    shown = call(
        "simulate", "small.nc", *at, "-t", "1 s", "-o", "trace.nc"
    )  # as far as the step budget of this map goes
    assert shown.exit_code == 0, shown.output
    assert float(stickslip.open("trace.nc")["mass"]) == 1.0


def test_inspecting_what_is_no_map_says_so(here):
    cell = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "belt_speed": 0.1}
    curve = {"a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
    writing.write(stickslip.simulate(duration=1.0, **cell, **curve), "trace.nc")
    for command in (["inspect", "trace.nc"], ["simulate", "trace.nc", "-t", "1", "--plot", "x.png"]):
        done = call(*command)
        assert done.exit_code == 2 and "trace.nc: holds no regimes" in done.stderr
        assert "Traceback" not in done.output


def test_a_damaged_file_is_told_in_words(here):
    path = writing.write(made_up(MAP, failed=[1])[0], "map.nc")
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    for command in (["inspect", "map.nc"], ["plot", "map.nc"], ["simulate", "map.nc", "-t", "1", "-o", "x.nc"]):
        done = call(*command)
        assert done.exit_code == 2 and done.stderr.startswith("map.nc: cannot be read as netCDF")
        assert "Traceback" not in done.output
