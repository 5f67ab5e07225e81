"""Results behind URLs: the map of a local run, all or nothing, though nothing can be renamed there."""

import fsspec
import pytest
import xarray as xr

import stickslip
from helpers.runs import FEW, opened, same, stop_early, with_axes
from stickslip.errors import StoreError
from stickslip.files import locations, targets, writing
from stickslip.files.locations import Url
from stickslip.runs.workdir.lock import hold_lock

pytest.importorskip("zarr")


@pytest.fixture
def url(tmp_path):
    return f"memory:/{tmp_path}/map.zarr"


def below(url):
    """The objects in the folder of a result, but for its own."""
    folder = locations.RemoteFolder(url.rpartition("/")[0])
    return [key for key in folder.keys() if not key.startswith("map.zarr/")]


class Killed(BaseException):
    """Nothing is cleaned up: the process is gone."""


@pytest.fixture
def killed(monkeypatch):
    """Kills writers at a copy: `killed(2)` at the second; `killed(None)` lets them live."""
    copy, clear, count = locations.RemoteFolder.copy, targets._clear, [0]

    def kill(at):
        count[0] = 0

        def dying(self, keys, to):
            count[0] += 1
            if count[0] == at:
                raise Killed
            copy(self, keys, to)

        monkeypatch.setattr(locations.RemoteFolder, "copy", dying)
        monkeypatch.setattr(targets, "_clear", clear if at is None else lambda folder: None)

    return kill


def test_a_map_is_written_behind_a_url_and_nothing_is_left_beside_it(config, whole, url):
    same(stickslip.run(config, url), whole)
    assert below(url) == []
    with xr.open_dataset(url, engine="zarr", consolidated=False, chunks=None) as plain:
        assert (plain["regime"].values == whole["regime"].values).all()


def test_a_run_that_was_stopped_resumes_from_the_blocks_beside_the_url(config, whole, url, computed):
    stopped = stop_early(config, url)
    assert all(key.startswith("map.zarr.parts/") for key in below(url)) and f"{url}.parts" in str(stopped)
    assert not Url(url).exists()
    with pytest.raises(StoreError):
        stickslip.open(url)
    del computed[:]
    same(stickslip.run(config, url), whole)
    assert sum(computed) == 900 - stopped.done and below(url) == []


def test_a_map_that_is_complete_is_not_computed_again(config, url, computed):
    stickslip.run(config, url).close()
    del computed[:]
    stickslip.run(config, url).close()
    assert computed == []


def test_a_map_behind_a_url_is_extended(tmp_path, small_blocks, url, computed):
    config = with_axes(tmp_path / "a.yaml", FEW, [0.1, 0.2])
    stickslip.run(config, url).close()
    del computed[:]
    with_axes(config, [*FEW, 1000.0], [0.1, 0.2])
    same(stickslip.run(config, url), stickslip.run(config))
    assert sum(computed) == 2


def test_shards_are_collected_into_a_url(config, whole, url):
    for i in (1, 3):
        stickslip.run_shard(config, f"{i}/3", f"{url}.parts")
    with stickslip.collect(f"{url}.parts") as part:
        assert int((part["regime"] == 0).sum()) == 300
    stickslip.run_shard(config, "2/3", f"{url}.parts")
    same(stickslip.collect(f"{url}.parts"), whole)
    assert below(url) == []


def test_another_map_is_refused_and_stays(config, tmp_path, url):
    stickslip.run(config, url).close()
    before = opened(url)
    with pytest.raises(StoreError, match="made from another configuration"):
        stickslip.run(with_axes(tmp_path / "b.yaml", FEW, [0.1, 0.2]), url)
    same(stickslip.open(url), before)


def test_a_failing_write_leaves_the_older_map_and_nothing_else(config, whole, url, monkeypatch):
    stickslip.run(config, url).close()
    put = locations.RemoteFolder.write

    def failing(self, name, data):
        if name == "regime/zarr.json":
            raise StoreError("no space")
        put(self, name, data)

    monkeypatch.setattr(locations.RemoteFolder, "write", failing)
    with pytest.raises(stickslip.IncompleteError, match="no space"):
        stickslip.run(config, url, fresh=True)
    assert all(key.startswith("map.zarr.parts/") for key in below(url))
    same(stickslip.open(url), whole)


@pytest.mark.parametrize("at", [1, 2])
def test_a_writer_killed_while_it_replaces_leaves_no_half_map_and_the_next_one_finishes(config, whole, url, killed, at):
    """At the chunks, and at the root: an older map is there."""
    stickslip.run(config, url).close()
    killed(at)
    with pytest.raises(Killed):
        stickslip.run(config, url, fresh=True)
    assert not Url(url).exists()
    killed(None)
    same(stickslip.run(config, url), whole)
    assert below(url) == []


def test_a_dataset_is_written_where_a_writer_was_killed_while_it_replaced(config, whole, url, killed):
    killed(1)
    with pytest.raises(Killed):
        writing.write(whole, url)
    killed(None)
    same(stickslip.open(writing.write(whole, url)), whole)
    assert below(url) == []


def test_what_a_killed_writer_left_is_no_part_of_the_next_map(config, whole, url):
    folder = locations.RemoteFolder(url.replace("map.zarr", ".map.zarr.new"))
    folder.write("of_another_version/zarr.json", b"{}")
    same(stickslip.run(config, url), whole)
    assert below(url) == [] and not any("another" in key for key in Url(url).folder().keys())


def test_two_do_not_write_at_once(config, url):
    where = Url(url)
    with hold_lock(where.with_name(".map.zarr.lock").folder(), None, lambda: None, print):
        with pytest.raises(stickslip.IncompleteError, match="another run works there"):
            stickslip.run(config, url)
    stickslip.run(config, url).close()


def test_other_things_behind_the_url_are_left_alone(config, url, computed):
    Url(url).folder().write("thesis.pdf", b"")
    with pytest.raises(StoreError, match="exists and is not a Zarr store, so it is left alone"):
        stickslip.run(config, url)
    assert Url(url).folder().keys() == ["thesis.pdf"] and computed == []


def test_only_zarr_goes_behind_a_url(config, tmp_path, computed):
    with pytest.raises(StoreError, match=r"memory://b/map\.nc: behind a URL only Zarr .* ends in \.zarr\nhint: netCDF"):
        stickslip.run(config, "memory://b/map.nc")
    config.write_text(config.read_text() + "output: {file: memory://b/map.nc}\n")
    with pytest.raises(stickslip.ConfigError, match=r"output\.file: got 'memory://b/map\.nc', expected .*a URL that"):
        stickslip.run(config)
    assert computed == []


def test_a_file_url_is_a_file_of_this_machine(config, whole, tmp_path):
    same(stickslip.run(config, f"file://{tmp_path}/my%20map.nc"), whole)
    assert (tmp_path / "my map.nc").is_file()


def test_a_service_that_cannot_be_opened_is_said_before_computing(config, computed):
    with pytest.raises(StoreError, match="gopher://x/map.zarr.*cannot be opened"):
        stickslip.run(config, "gopher://x/map.zarr")
    assert computed == []


def test_urls_keep_their_slashes():
    url = Url("s3://bucket/a/map.zarr")
    assert (url.name, url.stem, url.suffix) == ("map.zarr", "map", ".zarr")
    assert str(url.with_suffix(".png")) == "s3://bucket/a/map.png" and str(url) == "s3://bucket/a/map.zarr"
    assert fsspec.core.url_to_fs("memory://x")[1] == "/x"
