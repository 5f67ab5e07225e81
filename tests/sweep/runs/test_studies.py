"""What a run computes besides maps goes through the same store: it resumes, and blocks may be computed anywhere."""

import re

import pytest
import xarray as xr

import stickslip
from helpers.data import cases
from helpers.runs import block_files, opened, same, stop_early
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError, StoreError
from stickslip.runs import work

PAIR = """
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  stiffness: {start: 0.1, stop: 10, num: 30, spacing: log}
"""
SEARCH = "border: {along: belt_speed, between: [0.01, 5 m/s], tolerance: 1e-6, scan: 16}\n"


@pytest.fixture
def config(tmp_path, monkeypatch):
    monkeypatch.setattr(work, "_FEWEST", 8)  # lines a block: 4
    path = tmp_path / "border.yaml"
    path.write_text(PAIR.replace("mass: 1", "mass: 1, belt_speed: 1") + SEARCH)
    return path


def plain_border():
    config = parse_config(PAIR.replace("mass: 1", "mass: 1, belt_speed: 1"))
    return stickslip.border(config, "belt_speed", (0.01, 5.0), 1e-6, scan=16)


def test_a_section_asks_for_what_the_call_computes(config):
    ds, called = stickslip.run(config), plain_border()
    xr.testing.assert_equal(ds, called)
    assert parse_config(ds.attrs["configuration"]) == parse_config(called.attrs["configuration"])


def test_an_interrupted_search_resumes_and_gives_the_same_bits(config, tmp_path):
    output, whole = tmp_path / "borders.nc", stickslip.run(config)
    stopped = stop_early(config, output, cells=8)
    assert re.search(r"of 30 lines are safe in", str(stopped))
    assert 1 <= len(block_files(f"{output}.parts")) < 8  # lines in progress count for the call that stops it
    notices = []
    resumed = stickslip.run(config, output, notice=notices.append)
    assert any(re.search(r"of 30 lines were found finished", notice) for notice in notices)
    same(resumed, whole)
    assert stickslip.run(config, output).identical(opened(output))  # complete: nothing is computed again


def test_shards_are_collected_and_what_is_missing_is_said(config, tmp_path):
    store, output = tmp_path / "store", tmp_path / "borders.nc"
    stickslip.run_shard(config, "1/2", store)
    part = stickslip.collect(store, output)
    assert part.attrs["incomplete"] == "16 of 30 lines are not computed"
    assert (part["scan_undecided"] == 16).sum() == 16
    part.close()
    stickslip.run_shard(config, "2/2", store)
    whole = stickslip.collect(store, output)
    assert "incomplete" not in whole.attrs
    same(whole, stickslip.run(config))


def test_results_of_another_search_or_a_map_are_not_overwritten(config, tmp_path):
    output = tmp_path / "borders.nc"
    stickslip.run(config, output).close()
    config.write_text(config.read_text().replace("1e-6", "1e-7"))
    with pytest.raises(StoreError, match="border.tolerance: 1e-06 there, 1e-07 here"):
        stickslip.run(config, output)
    config.write_text(config.read_text().replace(SEARCH.replace("1e-6", "1e-7"), ""))
    with pytest.raises(StoreError, match="is not a map"):
        stickslip.run(config, output)


@cases("runs.yaml")
def test_bad_sections_are_refused_with_their_place(section, message):
    with pytest.raises(ConfigError) as caught:
        parse_config(PAIR.replace("mass: 1", "mass: 1, belt_speed: 1") + section, "my.yaml")
    assert message in str(caught.value) and "my.yaml:6" in str(caught.value)
