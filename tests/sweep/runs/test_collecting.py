"""Shards, maps of what there is, and blocks that fail."""

import json
import os
import re

import numpy as np
import pytest

import stickslip
from helpers.commands import call
from helpers.runs import FEW, block_files, interrupted_after, same, stop_early, with_axes
from stickslip.errors import StoreError
from stickslip.files.targets import folder_at
from stickslip.runs import work

# --- shards, collect, status ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", ["{}/the store", "file://{}/the%20store"])
def test_shards_are_merged_to_the_map_of_one_run(config, output, whole, tmp_path, computed, place):
    place = place.format(tmp_path)
    done = [stickslip.run_shard(config, f"{i}/3", place) for i in (2, 3, 1)]
    assert [outcome.computed for outcome in done] == [300, 300, 300] and sum(computed) == 900
    assert done[0].output is None
    same(stickslip.collect(place, output), whole)
    assert folder_at(place).names() == []


def test_status_names_the_shards_that_lack_blocks_whatever_became_of_them(config, output, whole, endless_block):
    """One is finished, one was stopped and took its lock away, one never began."""
    store = f"{output}.parts"
    stickslip.run_shard(config, "1/3", store)
    with endless_block(2), pytest.raises(stickslip.Interrupted):
        stickslip.run_shard(config, "2/3", store, progress=interrupted_after(1))
    done = call("status", store)
    assert "shard     1/3" not in done.output
    stopped, idle = (re.search(rf"shard +{i}/3: (\d+) of 5 blocks missing; no process works on it: submit it again",
                               done.output) for i in (2, 3))  # fmt: skip
    assert 0 < int(stopped[1]) < 5 and int(idle[1]) == 5
    answer = json.loads(call("status", store, "--json").stdout)["shards"]
    assert [(one["shard"], one["held"]) for one in answer] == [("2/3", False), ("3/3", False)]
    assert sum(len(one["missing"]) for one in answer) == int(stopped[1]) + 5
    stop_early(config, output)  # a whole run goes on, and has no shards
    assert "\nshard " not in call("status", store).output
    stickslip.run_shard(config, "4/4", store)
    assert "shard     4/4" not in call("status", store).output


def test_a_part_is_collected_and_its_other_cells_are_not_computed(config, output, whole):
    stickslip.run_shard(config, "1/3", f"{output}.parts")
    with stickslip.collect(config, output) as part:
        finished = part["regime"].values.ravel() != 0
        assert finished.sum() == 300
        for name in whole.data_vars:
            np.testing.assert_array_equal(part[name].values.ravel()[finished], whole[name].values.ravel()[finished])
        assert np.isnan(part["period"].values.ravel()[~finished]).all()
    assert len(block_files(f"{output}.parts")) == 5


def test_collecting_keeps_the_cells_of_a_map_that_is_being_extended(tmp_path, small_blocks):
    output, config = tmp_path / "map.nc", with_axes(tmp_path / "a.yaml", FEW, [0.1, 0.2])
    stickslip.run(config, output).close()
    with_axes(config, [float(k) for k in range(1, 200)], [0.1, 0.2])
    stickslip.run_shard(config, "2/7", f"{output}.parts")
    with stickslip.collect(config, output) as ds:
        assert int((ds["regime"] != 0).sum()) == 64
        assert (ds["regime"].sel(stiffness=FEW) != 0).all()


def test_collecting_does_not_replace_another_map(config, output):
    stickslip.run_shard(config, "1/3", f"{output}.parts")
    stickslip.run(with_axes(config.with_name("b.yaml"), FEW, [0.1, 0.2]), output.with_name("b.nc")).close()
    os.rename(output.with_name("b.nc"), output)
    with pytest.raises(StoreError, match="made from another configuration"):
        stickslip.collect(config, output)


@pytest.mark.parametrize("shard", ["0/3", "4/3", "1", "1/0", "a/b", "-1/3"])
def test_shards_that_make_no_sense_are_refused(config, tmp_path, shard):
    with pytest.raises(ValueError, match="expected a shard such as 1/8|shards are counted from 1: 1/3 to 3/3"):
        stickslip.run_shard(config, shard, tmp_path / "s")


def test_status_says_how_far_a_run_is(config, output):
    stopped = stop_early(config, output)
    for place in (config, f"{output}.parts"):
        if place == config:
            config.write_text(config.read_text() + f"output: {{file: {output}}}\n")
        found = stickslip.status(place)
        assert (found.cells, found.cells_finished, found.blocks) == (900, stopped.done, 15)
        assert found.holders == () and found.failures == () and found.title == "A small map"


# --- blocks that fail -------------------------------------------------------------------------------------------------


@pytest.fixture
def fragile(monkeypatch):
    """Blocks 2 and 5 fail until the list is emptied."""
    bad, compute = [2, 5], work.Work.compute

    def failing(self, number, *rest):
        if number in bad:
            raise ZeroDivisionError(f"in block {number}, µ")
        return compute(self, number, *rest)

    monkeypatch.setattr(work.Work, "compute", failing)
    return bad


def test_blocks_that_fail_are_recorded_and_the_others_computed(config, output, whole, computed, fragile):
    told = r"2 blocks \(120 cells\) failed.*ZeroDivisionError: in block 2, µ"
    with pytest.raises(stickslip.IncompleteError, match=told):
        stickslip.run(config, output)
    assert sum(computed) == 900 - 120
    found = stickslip.status(f"{output}.parts")
    assert [failure.block for failure in found.failures] == [2, 5]
    assert "in failing" in found.failures[0].traceback
    with pytest.raises(stickslip.IncompleteError, match="failed"):
        stickslip.run(config, output)
    assert sum(computed) == 900 - 120, "a failed block is left to retry_failed"
    with pytest.raises(stickslip.IncompleteError, match="failed"):
        stickslip.retry_failed(f"{output}.parts")
    del fragile[:]
    outcome = stickslip.retry_failed(f"{output}.parts")
    assert outcome.computed == 120 and outcome.output == output
    same(stickslip.open(output), whole)


def test_a_store_that_was_being_removed_hinders_nobody(config, output, whole):
    """Killed between removing the manifest and the lock."""
    stickslip.run(config, output).close()
    folder = output.with_name("map.nc.parts")
    lock = {"token": "x", "host": "elsewhere", "space": "", "pid": 1, "user": "Ada", "since": 1e9, "seen": 1e9}
    config.write_text(config.read_text() + f"output: {{file: {output}}}\n")
    for command in ("status", "collect", "run"):
        folder.mkdir(exist_ok=True)
        (folder / "lock.json").write_text(json.dumps(lock))
        done = call(command, config)
        assert done.exit_code == 0, done.output
    assert not folder.exists()
    same(stickslip.open(output), whole)
