"""Runs in parts, in one process: resumed, refused, mended."""

import os
import pickle
import re
import shutil
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import stickslip
from helpers.configs import write_config
from helpers.nightly import few
from helpers.runs import block_files, same, stop_early
from stickslip.cli import main
from stickslip.errors import StoreError
from stickslip.files import netcdf, writing
from stickslip.runs import work
from stickslip.runs.workdir import block_store

SIDE = 30  # cells along an axis; two rows are a block

# --- what is asked ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("asked", "message"), [
    ({"on_error": "ignore"}, "on_error: got 'ignore', expected 'continue' or 'stop'"),
    ({"dask": "head:8786"}, "dask: got 'head:8786', expected an address such as"),
])  # fmt: skip
def test_arguments_that_will_not_do_are_refused_before_anything_is_made(config, output, asked, message):
    with pytest.raises(ValueError, match=message):
        stickslip.run(config, output, **asked)
    assert not output.with_name("map.nc.parts").exists()


def test_a_store_without_an_output_is_refused(config, tmp_path):
    with pytest.raises(ValueError, match="store: needs an output"):
        stickslip.run(config, store=tmp_path / "store")


# --- the result -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
@pytest.mark.parametrize("values", [100, 2**17])
def test_a_run_in_parts_gives_the_dataset_of_a_run_in_memory(config, whole, tmp_path, monkeypatch, suffix, values):
    if suffix == ".zarr":
        pytest.importorskip("zarr")
    monkeypatch.setattr("stickslip.files.writing._CHUNK_VALUES", values)
    target = tmp_path / f"map{suffix}"
    same(stickslip.run(config, target), whole)
    assert {p.name for p in tmp_path.iterdir()} == {config.name, target.name}


def test_the_chunks_of_a_map_are_its_blocks_and_all_else_is_as_written_at_once(config, whole, tmp_path):
    import netCDF4

    stickslip.run(config, tmp_path / "in_parts.nc", keep_parts=True).close()
    writing.write(whole, tmp_path / "at_once.nc")
    with netCDF4.Dataset(tmp_path / "at_once.nc") as a, netCDF4.Dataset(tmp_path / "in_parts.nc") as b:
        assert list(a.variables) == list(b.variables)
        for name in a.variables:
            assert a[name].filters() == b[name].filters() and a[name].dtype == b[name].dtype
            assert a[name].ncattrs() == b[name].ncattrs()
        assert b["regime"].chunking() == b["period"].chunking() == [2, SIDE]
    assert len(block_files(tmp_path / "in_parts.nc.parts")) == SIDE / 2


def test_a_packed_chunk_goes_into_the_file_as_the_thread_made_it(config, tmp_path, monkeypatch):
    """Nothing is compressed once more but what is one value in all cells of a chunk, and axes."""
    compressed = []
    pack = netcdf._packed
    monkeypatch.setattr(netcdf, "_packed", lambda filters, data: compressed.append(data) or pack(filters, data))
    stickslip.run(config, tmp_path / "map.nc", keep_parts=True).close()
    assert all(
        np.unique(data.reshape(-1).view(np.uint8).reshape(-1, 8), axis=0).shape[0] == 1
        for data in compressed
        if data.nbytes == 16 * SIDE
    )
    blocks = block_files(tmp_path / "map.nc.parts")
    in_store = b"".join((tmp_path / "map.nc.parts" / name).read_bytes() for name in blocks)
    assert sum(chunk in in_store for chunk in chunks_of(tmp_path / "map.nc", "breakaway_time")) == SIDE / 2


def chunks_of(path, name):
    """The bytes of all chunks of a variable."""
    with h5py.File(path) as file:
        found = file[name].id
        places = [found.get_chunk_info(i).chunk_offset for i in range(found.get_num_chunks())]
        return [found.read_direct_chunk(place)[1] for place in places]


def test_blocks_for_another_kind_of_file_are_packed_anew(config, whole, tmp_path):
    pytest.importorskip("zarr")
    store = tmp_path / "store"
    stickslip.run_shard(config, "1/2", store)
    same(stickslip.run(config, tmp_path / "map.zarr", store=store, keep_parts=True), whole)
    same(stickslip.run(config, tmp_path / "map.nc", store=store), whole)


def test_labels_and_words_survive_streaming(tmp_path, small_blocks, monkeypatch):
    config = tmp_path / "pads.yaml"
    config.write_text(
        "system: {mass: 1, stiffness: 1}\nfriction: {a2: 0.1, a3: 0.3, a4: 0.1}\naxes:\n"
        "  pad: {zip: {normal_load: [1, 2], a1: [0.9, 1]}, labels: [felt, µ-foam]}\n"
        "  mu_stop: [none, 0.9]\n  belt_speed: {start: 0.05, stop: 1, num: 50}\n"
    )
    same(stickslip.run(config, tmp_path / "map.nc"), stickslip.run(config))


def test_a_map_of_one_cell_is_a_run_too(tmp_path):
    config = tmp_path / "one.yaml"
    config.write_text(
        "system: {mass: 1, stiffness: 1, normal_load: 1, belt_speed: 0.1}\nfriction: {a1: 1, a2: 0, a3: 0.3, a4: 0.1}\n"
    )
    same(stickslip.run(config, tmp_path / "one.nc"), stickslip.run(config))


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


def test_threads_and_names_of_files_are_no_other_configuration(config, output, computed):
    stickslip.run(config, output).close()
    config.write_text(config.read_text().replace("block: 4096", "block: 100, threads: 1") + "output: {plot: a.png}\n")
    del computed[:]
    stickslip.run(config, output).close()
    assert computed == []


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


def test_kept_parts_make_the_result_again(config, output, whole, computed):
    stickslip.run(config, output, keep_parts=True).close()
    output.unlink()
    del computed[:]
    same(stickslip.run(config, output), whole)
    assert computed == []


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


def test_a_result_of_another_major_version_is_refused(config, output, monkeypatch):
    stickslip.run(config, output).close()
    monkeypatch.setattr(block_store, "__version__", "9.0.0")
    with pytest.raises(StoreError, match=r"map.nc: made by stickslip 0\.\S+, and this is"):
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


def test_a_file_that_is_no_result_is_left_alone(config, output):
    output.write_text("not a map")
    with pytest.raises(StoreError, match="map.nc: cannot be read as netCDF"):
        stickslip.run(config, output)
    assert output.read_text() == "not a map"


def test_a_trajectory_is_not_taken_for_a_map(config, output):
    writing.write(stickslip.simulate(duration=1.0, mass=1, stiffness=1, normal_load=1, belt_speed=0.1,
                                             a1=1, a2=0, a3=0.1, a4=0.1), output)  # fmt: skip
    with pytest.raises(StoreError, match="exists and is not a map"):
        stickslip.run(config, output)


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


@pytest.mark.parametrize("kept", few([100, 0, -30], 1))
def test_a_truncated_manifest_is_written_again(config, output, whole, computed, kept):
    stopped = stop_early(config, output)
    manifest = output.with_name("map.nc.parts") / "manifest.json"
    manifest.write_bytes(manifest.read_bytes()[:kept])
    for call in (stickslip.status, stickslip.collect):
        with pytest.raises(StoreError, match="manifest.json: damaged.*\n.*stickslip.run"):
            call(f"{output}.parts")
    del computed[:]
    said = []
    same(stickslip.run(config, output, notice=said.append), whole)
    assert "manifest.json was damaged" in said[0] and sum(computed) == 900 - stopped.done


def test_a_truncated_manifest_does_not_let_another_configuration_in(config, output):
    stop_early(config, output)
    manifest = output.with_name("map.nc.parts") / "manifest.json"
    manifest.write_bytes(manifest.read_bytes()[:100])
    config.write_text(config.read_text().replace("mass: 1", "mass: 2"))
    with pytest.raises(StoreError, match="damaged.*not one of this configuration"):
        stickslip.run(config, output)


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


def test_a_fresh_run_that_is_finished_begins_again(config, output, whole, computed):
    for _ in range(2):
        same(stickslip.run(config, output, fresh=True, keep_parts=True), whole)
    assert sum(computed) == 1800


def test_a_fresh_run_of_another_configuration_begins_again(config, output, older, computed):
    stop_early(config, output, fresh=True)
    del computed[:]
    stickslip.run(older, output, fresh=True).close()
    assert sum(computed) == 25


def test_a_fresh_run_by_other_kernels_begins_again(config, output, older, computed, monkeypatch):
    stop_early(config, output, fresh=True)
    monkeypatch.setattr("stickslip.engine.kernels_digest", lambda: "others")
    del computed[:]
    stickslip.run(config, output, fresh=True).close()
    assert sum(computed) == 900


def test_a_whole_map_beside_a_fresh_run_leaves_its_blocks(config, output, whole):
    stickslip.run(config, output).close()
    stop_early(config, output, fresh=True)
    blocks, said = block_files(f"{output}.parts"), []
    same(stickslip.run(config, output, notice=said.append), whole)
    assert block_files(f"{output}.parts") == blocks != [] and "fresh run that was interrupted" in said[0]


def test_blocks_of_a_fresh_run_that_failed_are_retried_and_its_map_replaces_the_older(
    config, output, older, whole, monkeypatch
):
    compute, bad = work.Work.compute, [2]

    def failing(self, number, *rest):
        if number in bad:
            raise ZeroDivisionError
        return compute(self, number, *rest)

    monkeypatch.setattr(work.Work, "compute", failing)
    with pytest.raises(stickslip.IncompleteError, match="ZeroDivisionError"):
        stickslip.run(config, output, fresh=True)
    del bad[:]
    stickslip.retry_failed(f"{output}.parts")
    same(stickslip.open(output), whole)


# --- what is damaged or must not be touched ---------------------------------------------------------------------------


def test_a_damaged_manifest_beside_a_damaged_block_is_mended(config, output, whole, computed):
    stop_early(config, output, cells=600)
    folder = output.with_name("map.nc.parts")
    (folder / "manifest.json").write_bytes(b"{")
    first = folder / block_files(folder)[0]
    first.write_bytes(first.read_bytes()[:-40])
    said = []
    del computed[:]
    finished = 60 * (len(block_files(folder)) - 1)
    same(stickslip.run(config, output, notice=said.append), whole)
    assert sum(computed) == 900 - finished
    assert "manifest.json was damaged" in said[0] and any("is damaged" in line for line in said[1:])


@pytest.mark.skipif(os.name == "nt", reason="POSIX users")
def test_a_finished_map_in_a_folder_that_is_read_only_is_finished(config):
    """Root may write everywhere, so it becomes nobody for a moment."""
    folder = Path(tempfile.mkdtemp(prefix="read only "))  # outside tmp_path, whose parents are private
    text, user = config.read_text(), os.geteuid()
    config = folder / "a.yaml"
    config.write_text(text)
    command = ["run", str(config), "-o", str(folder / "map.nc"), "--no-plot"]
    try:
        for _ in range(2):  # all modules are imported by who may read them
            assert CliRunner().invoke(main, command).exit_code == 0
        folder.chmod(0o555)
        if user == 0:
            os.seteuid(65534)
        done = CliRunner().invoke(main, command)
    finally:
        if user == 0:
            os.seteuid(0)
        folder.chmod(0o755)
        shutil.rmtree(folder)
    assert done.exit_code == 0, done.output
    assert "is complete already" in done.output
