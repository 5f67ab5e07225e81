"""What a run computes besides maps goes through the same store: it resumes, and blocks may be computed anywhere."""

import re
import subprocess
import sys

import pytest
import xarray as xr
from click.testing import CliRunner

import stickslip
from helpers.runs import block_files, opened, same, stop_early
from stickslip.cli import main
from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError, IncompleteError, StoreError
from stickslip.runs import blocks

PAIR = """
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  stiffness: {start: 0.1, stop: 10, num: 30, spacing: log}
"""
SEARCH = "border: {along: belt_speed, between: [0.01, 5 m/s], tolerance: 1e-6, scan: 16}\n"


@pytest.fixture
def config(tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "_FEWEST", 8)  # lines a block: 4
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


def test_a_damaged_block_is_computed_again(config, tmp_path):
    output = tmp_path / "borders.nc"
    stop_early(config, output, cells=8)
    block = next((tmp_path / "borders.nc.parts").glob("block-*"))
    block.write_bytes(block.read_bytes()[:-1] + b"x")
    same(stickslip.run(config, output), stickslip.run(config))


def test_results_of_another_search_or_a_map_are_not_overwritten(config, tmp_path):
    output = tmp_path / "borders.nc"
    stickslip.run(config, output).close()
    config.write_text(config.read_text().replace("1e-6", "1e-7"))
    with pytest.raises(StoreError, match="border.tolerance: 1e-06 there, 1e-07 here"):
        stickslip.run(config, output)
    config.write_text(config.read_text().replace(SEARCH.replace("1e-6", "1e-7"), ""))
    with pytest.raises(StoreError, match="is not a map"):
        stickslip.run(config, output)


def test_a_block_that_fails_is_recorded_and_tried_again(config, tmp_path, monkeypatch):
    from stickslip.studies.borders.border import BorderStudy

    output, compute = tmp_path / "borders.nc", BorderStudy.compute

    def failing(self, items, *rest):
        if items.start == 4:
            raise RuntimeError("out of oil")
        return compute(self, items, *rest)

    monkeypatch.setattr(BorderStudy, "compute", failing)
    with pytest.raises(IncompleteError, match=r"1 block \(4 lines\) failed"):
        stickslip.run(config, output)
    monkeypatch.setattr(BorderStudy, "compute", compute)
    stickslip.retry_failed(config, output)
    same(opened(output), stickslip.run(config))


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("border: {between: [1, 2]}", "border.along: missing, expected parameter of a cell"),
        ("border: {along: belt_sped}", "belt_speed?"),
        ("border: {along: damping}", "border.between: missing; damping is no axis of the configuration"),
        (
            "border: {along: belt_speed, between: [2, 1]}",
            "got [2, 1], expected the lower end first",
        ),
        ("border: {along: belt_speed, between: [2 kg, 3]}", "border.between: got [2 kg, 3] (mass), expected a speed"),
        ("border: {along: mass, between: [0, 3]}", "expected a mass above 0 kg"),
        ("border: {along: mu_stop, between: [0.5, 2]}", "expected at most mu_start = a1 + a3 = 1.3"),
        ("border: {along: stiffness, scan: 1}", "border.scan: got 1, expected a whole number from 2"),
        ("border: {along: stiffness, tolerance: 0}", "border.tolerance: got 0"),
        ("border: {along: stiffness, between: [1, 2], widht: 3}", "unknown key"),
    ],
)
def test_bad_sections_are_refused_with_their_place(section, message):
    with pytest.raises(ConfigError) as caught:
        parse_config(PAIR.replace("mass: 1", "mass: 1, belt_speed: 1") + section, "my.yaml")
    assert message in str(caught.value) and "my.yaml:6" in str(caught.value)


def test_the_commands_name_what_is_counted(config, tmp_path):
    def told(*words):
        done = CliRunner().invoke(main, [str(word) for word in words])
        assert done.exit_code == 0, done.output
        return done.output

    assert "30 lines: stiffness (30)" in told("validate", config)
    assert "blocks   8 of up to 4 lines" in told("plan", config)
    told("run", config, "--shard", "1/2", "-o", tmp_path / "borders.nc")
    assert "14 of 30 lines (46.7%)" in told("status", tmp_path / "borders.nc.parts")
    said = told("run", config, "-o", tmp_path / "borders.nc")
    assert re.search(r"^borders  30 on 30 of 30 lines$", said, re.MULTILINE)
    assert re.search(r"^16 lines in .* lines/s on", said, re.MULTILINE)
    assert re.search(r"^written  .*borders.nc \(", said, re.MULTILINE)


def test_a_map_waits_for_no_room_that_it_has_no_use_for(tmp_path):
    path = tmp_path / "map.yaml"
    path.write_text(PAIR.replace("mass: 1", "mass: 1, belt_speed: 1"))
    program = (
        "import sys; from stickslip.config.reader import load_config; from stickslip.runs import session\n"
        f"from stickslip.runs.work import Work; Work(load_config({str(path)!r})).study\n"
        "rooms = [f'studies.{room}' for room in ('borders', 'margins', 'attractors', 'refinement', 'uncertainty')]\n"
        "print([name for name in [*(f'stickslip.{room}' for room in rooms), 'scipy.stats'] if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "[]", done.stdout + done.stderr
