"""Results behind URLs: written from a working store on the disk, and not seen before they are whole."""

from pathlib import Path

import pytest
import xarray as xr

import stickslip
from helpers.commands import call
from helpers.runs import FEW, same, stop_early, with_axes
from stickslip.errors import StoreError
from stickslip.files import writing
from stickslip.files.locations import Url

ROOT = "zarr.json"


@pytest.fixture
def url(tmp_path, monkeypatch):
    """A URL of a service that keeps objects under any name; the program runs in a folder."""
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    return f"memory://{tmp_path}/there/map.zarr"


def nothing_is_left():
    return list(Path().iterdir()) == []


class Killed(BaseException):
    """Nothing is cleaned up: the process is gone."""


def killed(*_):
    raise Killed


def test_a_map_is_written_behind_a_url_and_nothing_else_is_left(config, whole, url):
    same(stickslip.run(config, url), whole)
    assert nothing_is_left() and not [key for key in Url(url).keys() if key.startswith(".")]
    with xr.open_dataset(url, engine="zarr", consolidated=False, chunks=None) as plain:
        assert (plain["regime"].values == whole["regime"].values).all()


def test_a_run_that_was_stopped_resumes_from_the_blocks_in_the_current_folder(config, whole, url, computed):
    notices = []
    stopped = stop_early(config, url, notice=notices.append)
    assert notices == ["finished blocks are kept in map.zarr.parts until the result is written"]
    assert "map.zarr.parts" in str(stopped) and (Path() / "map.zarr.parts" / "manifest.json").is_file()
    assert not Url(url).exists()
    with pytest.raises(StoreError, match="no Zarr store there, or not all of it"):
        stickslip.open(url)
    del computed[:]
    same(stickslip.run(config, url), whole)
    assert sum(computed) == 900 - stopped.done and nothing_is_left()


def test_a_map_behind_a_url_is_extended(tmp_path, small_blocks, url, computed):
    config = with_axes(tmp_path / "a.yaml", FEW, [0.1, 0.2])
    stickslip.run(config, url).close()
    del computed[:]
    with_axes(config, [*FEW, 1000.0], [0.1, 0.2])
    same(stickslip.run(config, url), stickslip.run(config))
    assert sum(computed) == 2


def test_a_map_is_collected_over_the_part_of_it_that_is_read_meanwhile(config, whole, url):
    """Of two stores, of which neither has all blocks: the cells of the first come from the map."""
    for i in (1, 2, 3):
        stickslip.run_shard(config, f"{i}/3", f"store {i}")
        with stickslip.collect(f"store {i}", url) as part:
            assert int((part["regime"] == 0).sum()) == 900 - 300 * i
    same(stickslip.open(url), whole)


@pytest.mark.parametrize("at, fresh", [("ZarrChunks.write", True), ("_consolidate", False)])
def test_a_writer_that_is_killed_leaves_no_half_map_and_the_next_one_writes_it_from_the_blocks(
    config, whole, url, monkeypatch, computed, at, fresh
):
    """With an older map there and without one, which is told of in place of what is not whole."""
    if fresh:
        stickslip.run(config, url).close()
    with pytest.raises(Killed), monkeypatch.context() as patch:
        patch.setattr(f"stickslip.files.writing.{at}", killed)
        stickslip.run(config, url, fresh=fresh)
    assert not Url(url).exists() and Url(url).keys()
    with pytest.raises(StoreError, match="no Zarr store there, or not all of it"):
        stickslip.open(url)
    del computed[:]
    same(stickslip.run(config, url), whole)
    assert computed == [] and nothing_is_left()


def test_a_dataset_is_written_over_the_map_that_its_values_are_read_from(config, whole, url):
    stickslip.run(config, url).close()
    with stickslip.open(url) as ds:
        writing.write(ds, url)
    same(stickslip.open(url), whole)


def test_what_an_older_store_holds_is_no_part_of_the_next_map(config, whole, url):
    Url(url).put("of_another_version/zarr.json", b"{}")
    Url(url).put(ROOT, b"{}")
    same(stickslip.run(config, url, fresh=True), whole)
    assert not any("another" in key for key in Url(url).keys())


@pytest.mark.parametrize("there", ["a store", "a thesis"])
def test_what_somebody_else_has_there_is_left_alone(config, url, computed, there):
    if there == "a store":
        xr.Dataset({"wind": ("x", [1.0])}).to_zarr(url, consolidated=False, zarr_format=3)
    else:
        Url(url).put("thesis.pdf", b"")
    before = set(Url(url).keys())
    with pytest.raises(
        StoreError, match="not written by stickslip|exists and is not a Zarr store, so it is left alone"
    ):
        stickslip.run(config, url)
    assert set(Url(url).keys()) == before and computed == []


@pytest.mark.parametrize("keep", [{"store": "s3://b/map.parts"}, {"store": "memory://map.parts"}])
def test_a_working_store_is_on_a_file_system(config, tmp_path, computed, keep):
    with pytest.raises(StoreError, match="a working store has to be on a file system\nhint: name a folder with store"):
        stickslip.run(config, tmp_path / "map.nc", **keep)
    said = call("status", keep["store"])
    assert said.exit_code == 2 and "on a file system\nhint: name a folder with --store" in said.stderr
    assert computed == []


def test_only_zarr_goes_behind_a_url(config, tmp_path, computed):
    with pytest.raises(StoreError, match=r"memory://b/map\.nc: behind a URL only Zarr .* ends in \.zarr\nhint: netCDF"):
        stickslip.run(config, "memory://b/map.nc")
    config.write_text(config.read_text() + "output: {file: memory://b/map.nc}\n")
    with pytest.raises(
        stickslip.ConfigError, match=r"output\.file: got 'memory://b/map\.nc', expected .*behind a URL ends in"
    ):
        stickslip.run(config)
    assert computed == []


def test_a_service_that_cannot_be_opened_is_said_before_computing(config, computed):
    with pytest.raises(StoreError, match="gopher://x/map.zarr.*cannot be opened"):
        stickslip.run(config, "gopher://x/map.zarr")
    assert computed == []
