import shlex

import numpy as np
import pytest
from click.testing import CliRunner

import stickslip
from helpers.configs import cell_at
from stickslip.cli import main
from stickslip.config.grid import build_grid
from stickslip.config.reader import parse_config
from stickslip.config.select import recipe_of
from stickslip.dataset.build import map_dataset
from stickslip.dataset.provenance import provenance
from stickslip.dataset.summary import remark, summary, survey
from stickslip.errors import ConfigError
from stickslip.files import writing
from stickslip.vocabulary.flags import REGIMES, STATUSES

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


def survey_of(ds, **options):
    return survey(ds, recipe_of(ds, "map.nc"), **options)


# --- counts -----------------------------------------------------------------------------------------------------------


def test_cells_are_counted_by_regime_and_status():
    ds, _, grid = made_up(MAP, failed=[3, 50], unresolved=[7])
    found = survey_of(ds)
    expected = {("damped", "settled"): grid.size - 3, ("failed", "not_finite"): 2, ("unresolved", "step_limit"): 1}
    assert found.counts == expected
    assert found.wanted == 3 and [cell.number for cell in found.cells] == [3, 7, 50]


def test_the_first_cells_are_listed_up_to_a_limit_and_counted_all_the_same():
    ds, _, grid = made_up(MAP, failed=np.arange(5, 90))
    found = survey_of(ds, limit=4)
    assert found.wanted == 85 and [cell.number for cell in found.cells] == [5, 6, 7, 8]
    assert survey_of(ds, limit=0).cells == ()


@pytest.mark.parametrize(
    ("options", "numbers"),
    [
        ({"regimes": ["failed"]}, [3]),
        ({"regimes": ["failed", "unresolved"]}, [3, 7]),
        ({"statuses": ["step_limit"]}, [7]),
        ({"regimes": ["failed"], "statuses": ["step_limit"]}, []),
        ({"regimes": ["damped"], "limit": 2}, [0, 1]),
    ],
)
def test_any_regime_or_status_can_be_listed(options, numbers):
    ds, _, _ = made_up(MAP, failed=[3], unresolved=[7])
    assert [cell.number for cell in survey_of(ds, **options).cells] == numbers


def test_a_misspelt_regime_is_refused_with_those_that_exist():
    ds, _, _ = made_up(MAP)
    with pytest.raises(
        ConfigError, match="--regime: got 'stickslip', expected not_computed, .*\n.*did you mean stick_s"
    ):
        survey_of(ds, regimes=["stickslip"])


def test_a_report_says_how_many_cells_are_bad_and_how_to_see_them():
    ds, _, _ = made_up(MAP, failed=[3, 50], unresolved=[7])
    assert remark(summary(ds), "my map.nc") == "1 unresolved and 2 failed cells: stickslip inspect 'my map.nc'"
    assert remark(summary(made_up(MAP)[0])) is None
    assert remark(summary(made_up(MAP, failed=[1])[0])) == "1 failed cell"


# --- the same cell again ----------------------------------------------------------------------------------------------


def pasted(command: str):
    """The file and the settings of a line for the shell."""
    words = shlex.split(command)
    assert words[:2] == ["stickslip", "simulate"]
    return words[2], [words[i + 1] for i, word in enumerate(words) if word == "--at"]


def test_the_line_gives_the_same_cell_bit_for_bit(tmp_path):
    everywhere = slice(None, None, 11)
    ds, config, grid = made_up(MAP, failed=everywhere)
    with stickslip.open(writing.write(ds, tmp_path / "a map.nc")) as ds:
        recipe = recipe_of(ds, "a map.nc")
        cells = survey(ds, recipe, limit=10**6).cells
    assert len(cells) == len(range(grid.size)[everywhere])
    whole = grid[:]
    for cell in cells:
        file, settings = pasted(cell.command("a map.nc"))
        assert file == "a map.nc"
        expected = {name: values[cell.number] for name, values in whole.items()}
        found = cell_at(recipe, settings)
        np.testing.assert_array_equal(list(found.values()), list(expected.values()))
        assert cell_at(config, settings).keys() == found.keys()


def test_cells_of_a_list_are_spelt_out(tmp_path):
    chance = np.random.default_rng(1)
    given = {name: chance.random(6) + 0.1 for name in ("mass", "stiffness", "normal_load", "a1", "a2", "a3", "a4")}
    given["mu_stop"] = np.array([np.nan, 0.01, np.nan, 0.02, 0.03, np.nan])
    ds = stickslip.evaluate(given | {"belt_speed": 0.3}, law="rational")
    with stickslip.open(writing.write(ds, tmp_path / "cells.nc")) as ds:
        recipe = recipe_of(ds, "cells.nc")
        for cell in survey(ds, recipe, regimes=REGIMES).cells:
            found = cell_at(recipe, pasted(cell.command("cells.nc"))[1])
            expected = [float(ds[name][cell.number]) for name in found]
            np.testing.assert_array_equal(list(found.values()), expected)


def test_part_of_a_map_is_spelt_out_too(tmp_path):
    text = MAP.replace("mu_start: 1.3, v_reversal: 340 mm/s, a4: 0.1", "a1: 1, a2: 0.1, a3: 0.3, a4: 0.1")
    text = text.replace("  mu_reversal: [1.0440, 1.1, 1.2]\n", "")
    ds, _, grid = made_up(text, failed=slice(None))
    part = ds.isel(stiffness=[5], belt_speed=slice(3, 6))
    whole = grid[:]
    numbers = np.arange(grid.size).reshape(grid.shape)[5:6, ..., 3:6].ravel()
    for cell in survey_of(part).cells:
        found = cell_at(recipe_of(part, "part.nc"), cell.settings)
        expected = [whole[name][numbers[cell.number]] for name in found]
        np.testing.assert_array_equal(list(found.values()), expected)


# --- the commands -----------------------------------------------------------------------------------------------------

SMALL = """
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes: {stiffness: {start: 1, stop: 10, num: 3, spacing: log}, belt_speed: [0.1, 0.2, 0.9]}
solver: {max_steps: 6}
output: {file: small.nc}
"""


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


def test_run_reports_bad_cells_inspect_lists_them_and_simulate_shows_them(here):
    (here / "small.yaml").write_text(SMALL)
    done = call("run", "small.yaml")
    assert done.exit_code == 0 and "unresolved cells: stickslip inspect small.nc" in done.stdout
    listed = call("inspect", "small.nc")
    assert listed.exit_code == 0, listed.output
    lines = [line for line in listed.stdout.splitlines() if line.startswith("stickslip simulate")]
    ds = stickslip.open("small.nc")
    assert len(lines) == summary(ds)["unresolved"].cells
    assert "unresolved, step_limit: the step budget ran out" in listed.stdout
    arguments = shlex.split(lines[0])[1:]
    arguments[arguments.index("-t") + 1] = "1 s"  # as far as the step budget of this map goes
    shown = call(*arguments, "-o", "trace.nc")
    assert shown.exit_code == 0, shown.output
    assert float(stickslip.open("trace.nc")["mass"]) == 1.0


def test_the_table_of_a_map_is_not_cut_in_a_pipe(here, monkeypatch):
    monkeypatch.setenv("COLUMNS", "12")
    writing.write(made_up(MAP)[0], "map.nc")
    assert call("inspect", "map.nc").stdout.splitlines()[0].split() == ["regime", "status", "cells", "share"]


def test_inspecting_a_good_map_says_so(here):
    writing.write(made_up(MAP)[0], "map.nc")
    done = call("inspect", "map.nc")
    assert done.exit_code == 0
    assert "0 cells failed, are unresolved or were not computed" in done.stdout


def test_a_map_without_status_gives_a_reason_only_where_there_is_one(here):
    ds = made_up(MAP)[0].drop_vars("status")
    names = ["not_computed", "stick_slip", "unresolved"]
    ds["regime"].values.flat[: len(names)] = [REGIMES.index(name) for name in names]
    writing.write(ds, "map.nc")
    told = call("inspect", "map.nc", *(word for name in names for word in ("--regime", name))).stdout.splitlines()
    assert "not_computed: no run has computed these cells" in told and "stick_slip" in told
    assert [line for line in told if "a reason that is in status" in line][0].startswith("unresolved, ")
    assert sum("a reason" in line for line in told) == 1


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
