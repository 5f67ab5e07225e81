"""Runs in parts, in one process: resumed, refused, mended."""

import os
import pickle
import re
import sys

import numpy as np
import pytest

import stickslip
from helpers.configs import write_config
from helpers.nightly import few
from helpers.runs import block_files, same, stop_early
from stickslip.errors import StoreError
from stickslip.runs import block_store

SIDE = 30  # cells along an axis; two rows are a block

# --- what is asked ----------------------------------------------------------------------------------------------------


def test_an_address_that_is_none_is_refused_before_anything_is_made(config, output):
    with pytest.raises(ValueError, match="dask: got 'head:8786', expected an address such as"):
        stickslip.run(config, output, dask="head:8786")
    assert not output.with_name("map.nc.parts").exists()


def test_a_store_without_an_output_is_refused(config, tmp_path):
    with pytest.raises(ValueError, match="store: needs an output"):
        stickslip.run(config, store=tmp_path / "store")


# --- the result -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("values", [100, 2**17])
def test_a_run_in_parts_gives_the_dataset_of_a_run_in_memory(config, whole, tmp_path, monkeypatch, suffix, values):
    monkeypatch.setattr("stickslip.files.writing._CHUNK_VALUES", values)
    target = tmp_path / f"map{suffix}"
    same(stickslip.run(config, target), whole)
    assert {p.name for p in tmp_path.iterdir()} == {config.name, target.name}


def test_blocks_for_another_kind_of_file_are_packed_anew(config, whole, tmp_path):
    store = tmp_path / "store"
    stickslip.run_shard(config, "1/2", store)
    same(stickslip.run(config, tmp_path / "map.zarr", store=store, keep_parts=True), whole)
    same(stickslip.run(config, tmp_path / "map.nc", store=store), whole)


def test_a_cluster_needs_a_place_for_blocks_and_its_package(config, output, monkeypatch):
    with pytest.raises(stickslip.ClusterError, match="name an output, or a store"):
        stickslip.run(config, dask="local")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(stickslip.ClusterError, match=r"pip install 'stickslip\[dask\]'"):
        stickslip.run(config, output, dask="local")
    assert not output.with_name("map.nc.parts").exists()
    stickslip.run(config, output, dask="none").close()


def test_nothing_is_recomputed_once_a_result_is_finished(config, output, computed):
    stickslip.run(config, output).close()
    before = output.read_bytes()
    del computed[:]
    stickslip.run(config, output).close()
    assert computed == [] and output.read_bytes() == before


@pytest.mark.slow
def test_another_title_is_written_without_computing(config, output, computed, whole):
    stickslip.run(config, output).close()
    config.write_text(config.read_text().replace("A small map", "Another title"))
    del computed[:]
    with stickslip.run(config, output) as ds:
        assert ds.attrs["title"] == "Another title"
        np.testing.assert_array_equal(ds["period"], whole["period"])
    assert sum(computed) == 0


# --- resuming ---------------------------------------------------------------------------------------------------------


def test_the_same_call_goes_on_where_ctrl_c_stopped_it(config, output, whole, computed):
    stopped = stop_early(config, output)
    folder = f"{output}.parts"
    assert stopped.kept == folder and not output.exists()
    safe = len(block_files(folder)) * 2 * SIDE
    assert 0 < stopped.done <= safe and stopped.cells == 900
    del computed[:]
    said = []
    same(stickslip.run(config, output, notice=said.append), whole)
    assert sum(computed) == 900 - stopped.done
    assert said == [f"{stopped.done} of 900 cells were found finished in {folder}"]
    assert not os.path.exists(folder)


def test_fresh_computes_everything(config, output, computed):
    stop_early(config, output)
    del computed[:]
    stickslip.run(config, output, fresh=True).close()
    assert sum(computed) == 900
    del computed[:]
    stickslip.run(config, output, fresh=True).close()
    assert sum(computed) == 900


def test_parts_left_by_a_run_that_died_after_writing_are_removed(config, output):
    stickslip.run(config, output, keep_parts=True).close()
    assert os.path.isdir(f"{output}.parts")
    stickslip.run(config, output).close()
    assert not os.path.exists(f"{output}.parts")


# --- refused ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("finished", [True, False])
def test_another_configuration_is_refused_with_the_keys_that_differ(config, output, finished):
    if finished:
        stickslip.run(config, output).close()
    else:
        stop_early(config, output)
    config.write_text(config.read_text().replace("mass: 1", "mass: 2") + "solver: {rtol: 1e-7}\n")
    with pytest.raises(StoreError) as caught:
        stickslip.run(config, output)
    assert re.search(r"system.mass: 1.0 there, 2.0 here\n.*solver.rtol: 1e-06 there, 1e-07 here", str(caught.value))
    assert "hint: fresh=True starts over" in str(caught.value) and "--" not in str(caught.value)
    assert "hint: --fresh starts over" in pickle.loads(pickle.dumps(caught.value)).on_command_line
    stickslip.run(config, output, fresh=True).close()


def test_values_that_differ_by_rounding_are_those_of_the_file(tmp_path, computed):
    asked = {
        "system": {"mass": 1, "normal_load": 1, "stiffness": 1}, "friction": {"a1": 1, "a2": 0.1, "a3": 0.3, "a4": 0.1},
        "output": tmp_path / "map.nc",
    }  # fmt: skip
    mine, theirs = np.linspace(5, 1200, 40) * 1e-3, np.linspace(0.005, 1.2, 40)
    assert not np.array_equal(mine, theirs)
    first = stickslip.sweep(**asked, axes={"belt_speed": theirs}).load()
    del computed[:]
    again = stickslip.sweep(**asked, axes={"belt_speed": mine})
    np.testing.assert_array_equal(again["belt_speed"], theirs)
    np.testing.assert_array_equal(again["period"], first["period"])
    assert not sum(computed)
    with pytest.raises(StoreError, match="would be lost"):
        stickslip.sweep(**asked, axes={"belt_speed": theirs[:-1]})


def test_another_major_version_is_refused(config, output, monkeypatch):
    stop_early(config, output)
    monkeypatch.setattr(block_store, "__version__", "9.0.0")
    with pytest.raises(StoreError, match=r"made by stickslip 0\.\S+, and this is 9.0.0"):
        stickslip.run(config, output)


def test_other_kernels_go_on_and_are_named_in_the_history(config, output, monkeypatch):
    stop_early(config, output)
    monkeypatch.setattr(block_store.engine, "kernels_digest", lambda: "feedc0de")
    said = []
    with stickslip.run(config, output, notice=said.append) as ds:
        assert ds.attrs["history"].endswith(" and feedc0de")
    assert any("kernels were changed" in text for text in said)


def test_a_foreign_folder_is_left_alone(config, output):
    folder = output.with_name("map.nc.parts")
    folder.mkdir()
    (folder / "thesis.tex").write_text("years of work")
    for fresh in (False, True):
        with pytest.raises(StoreError, match="holds other things .thesis.tex"):
            stickslip.run(config, output, fresh=fresh)
    assert (folder / "thesis.tex").read_text() == "years of work" and not output.exists()


# --- damaged ----------------------------------------------------------------------------------------------------------


def broken(data, how):
    return {"flipped": data[:500] + bytes([data[500] ^ 1]) + data[501:], "cut": data[:-40], "empty": b"",
            "foreign": b"\x89PNG" + data}[how]  # fmt: skip


@pytest.mark.parametrize("how", few(["flipped", "cut", "empty", "foreign"], 1))
def test_a_damaged_block_is_said_and_computed_again(config, output, whole, computed, how):
    stickslip.run(config, output, keep_parts=True).close()
    output.unlink()
    block = output.with_name("map.nc.parts") / "block-00000003"
    block.write_bytes(broken(block.read_bytes(), how))
    del computed[:]
    said = []
    same(stickslip.run(config, output, notice=said.append), whole)
    assert sum(computed) == 2 * SIDE
    assert len(said) == 1 and "block 3 of" in said[0] and "damaged" in said[0]


def test_a_block_of_another_run_or_place_is_not_used(config, output, whole, tmp_path):
    other = write_config(tmp_path, num=30, more="solver: {rtol: 1e-5}\n", name="other.yaml")
    for path, target in ((config, output), (other, tmp_path / "other.nc")):
        stickslip.run(path, target, keep_parts=True).close()
    output.unlink()
    folder = output.with_name("map.nc.parts")
    (folder / "block-00000001").write_bytes((tmp_path / "other.nc.parts" / "block-00000001").read_bytes())
    (folder / "block-00000002").write_bytes((folder / "block-00000004").read_bytes())
    said = []
    same(stickslip.run(config, output, notice=said.append), whole)
    assert "its run is" in said[0] and "its block is 4" in said[1]


def test_collecting_leaves_a_damaged_block_out_and_a_run_computes_it(config, output, whole, computed):
    stickslip.run(config, output, keep_parts=True).close()
    output.unlink()
    block = output.with_name("map.nc.parts") / "block-00000003"
    block.write_bytes(b"")
    said = []
    part = stickslip.collect(config, output, notice=said.append)
    assert int((part["regime"] == 0).sum()) == 2 * SIDE and "left out" in said[0]
    part.close()
    del computed[:]
    same(stickslip.run(config, output), whole)
    assert sum(computed) == 2 * SIDE


# --- a fresh run ------------------------------------------------------------------------------------------------------


@pytest.fixture
def older(output, tmp_path, small_blocks):
    """A map of another configuration where the run will write."""
    other = write_config(tmp_path, num=5, name="other.yaml")
    stickslip.run(other, output).close()
    return other


def test_a_fresh_run_that_was_interrupted_goes_on_by_the_same_command(config, output, older, whole, computed):
    stopped = stop_early(config, output, fresh=True)
    with pytest.raises(StoreError, match="would be lost"):
        stickslip.run(config, output)
    assert len(block_files(f"{output}.parts")) * 60 == stopped.done > 0
    del computed[:]
    same(stickslip.run(config, output, fresh=True), whole)
    assert sum(computed) == 900 - stopped.done


# --- what is damaged or must not be touched ---------------------------------------------------------------------------


@pytest.mark.parametrize("kept", [0, 100, -30])
def test_a_damaged_manifest_is_said_and_a_fresh_run_begins_again(config, output, whole, kept):
    stop_early(config, output)
    manifest = output.with_name("map.nc.parts") / "manifest.json"
    manifest.write_bytes(manifest.read_bytes()[:kept])
    for call, place in ((stickslip.status, f"{output}.parts"), (stickslip.collect, f"{output}.parts"),
                        (stickslip.run, config)):  # fmt: skip
        with pytest.raises(StoreError, match="manifest.json: damaged"):
            call(place) if place != config else call(config, output)
    same(stickslip.run(config, output, fresh=True), whole)
