"""A chunk that is whole, and is not where it belongs, is never read as right."""

import shutil

import h5py
import numpy as np
import pytest

import stickslip
from helpers.maps import plane
from stickslip.errors import StoreError
from stickslip.files import chunks, reading, writing

KINDS = ["nc", "zarr"]


@pytest.fixture(params=KINDS)
def pair(request, tmp_path, monkeypatch):
    """Two maps of one shape, in chunks of two rows, of which only the normal load differs; what copies chunks."""
    monkeypatch.setattr(writing, "_CHUNK_VALUES", 64)
    monkeypatch.setattr(writing, "_LARGER", 1)
    one, other = plane(20, 30), plane(20, 30)
    one["period"][:], other["period"][:] = np.random.default_rng(1).random((2, 20, 30))
    one["steps"][:], other["steps"][:] = np.random.default_rng(1).integers(1, 9, (2, 20, 30))
    other.attrs["configuration"] += "# another\n"
    other["stiffness"] = other["stiffness"] * 1.01
    return [writing.write(ds, tmp_path / f"{name}.{request.param}") for name, ds in (("one", one), ("other", other))]


def copy_chunk(there, name, number, here, to_name, to_number):
    """The bytes of a chunk in place of those of another."""
    if here.is_dir():
        shutil.copy(there.joinpath(name, "c", *map(str, number)), here.joinpath(to_name, "c", *map(str, to_number)))
        return
    with h5py.File(there) as file:
        dataset = file[name]
        origin = tuple(i * n for i, n in zip(number, dataset.chunks, strict=True))
        data = dataset.id.read_direct_chunk(origin)[1]
    with h5py.File(here, "r+") as file:
        dataset = file[to_name]
        dataset.id.write_direct_chunk(tuple(i * n for i, n in zip(to_number, dataset.chunks, strict=True)), data)


def chunks_of(path, name):
    with stickslip.open(path) as ds:
        return [(i, 0) for i in range(len(ds[name].chunks[0]))] if ds[name].ndim == 2 else [(0,)]


def refused(path, name):
    """Whether a variable is refused, by name, however it is read; others must be read."""
    with pytest.raises(StoreError, match=rf"damaged, {name}\[.*\] is not what was written there"), stickslip.open(
        path) as ds:  # fmt: skip
        ds.drop_vars(name).load()
        ds[name].load()
    with pytest.raises(StoreError, match="is not what was written there"), reading.look_into(path) as ds:
        ds[name].values  # noqa: B018, reads


@pytest.mark.parametrize("name", ["period", "steps"])
def test_two_chunks_of_a_variable_that_were_swapped_are_refused(pair, name, tmp_path):
    kept = shutil.copytree(pair[0], tmp_path / "kept") if pair[0].is_dir() else shutil.copy(pair[0], tmp_path / "kept")
    copy_chunk(kept, name, (3, 0), pair[0], name, (4, 0))
    copy_chunk(kept, name, (4, 0), pair[0], name, (3, 0))
    refused(pair[0], name)


def test_a_chunk_of_another_variable_is_refused(pair):
    copy_chunk(pair[0], "period", (2, 0), pair[0], "spring_force_max", (2, 0))
    refused(pair[0], "spring_force_max")


def test_a_whole_variable_of_another_map_with_its_marks_is_refused(pair):
    """The marks of another file are of its seal."""
    ours, theirs = pair
    for number in chunks_of(ours, "period"):
        copy_chunk(theirs, "period", number, ours, "period", number)
    if ours.is_dir():
        shutil.copytree(theirs / chunks.GROUP, ours / chunks.GROUP, dirs_exist_ok=True)
        with pytest.raises(StoreError, match="is not what was written there"):
            stickslip.open(ours)
        return
    with h5py.File(theirs) as a, h5py.File(ours, "r+") as b:
        b[chunks.GROUP][chunks.TABLE][...] = a[chunks.GROUP][chunks.TABLE][...]
    with pytest.raises(StoreError, match="is not what was written there"):
        stickslip.open(ours)


def test_an_axis_of_another_map_is_refused_when_the_file_is_opened(pair):
    copy_chunk(pair[1], "stiffness", (0,), pair[0], "stiffness", (0,))
    with pytest.raises(StoreError, match="damaged, stiffness is not what was written there"):
        stickslip.open(pair[0])


def test_a_file_whose_marks_are_gone_is_refused(pair):
    if pair[0].is_dir():
        shutil.rmtree(pair[0] / chunks.GROUP)
    else:
        with h5py.File(pair[0], "r+") as file:
            del file[chunks.GROUP]
    with pytest.raises(StoreError, match=f"{chunks.MARKED} is not there\nhint: .*{chunks.SEAL}"):
        stickslip.open(pair[0])


@pytest.mark.parametrize("key", [
    {"stiffness": 7}, {"belt_speed": slice(3, 20, 4)}, {"stiffness": slice(15, 2, -3), "belt_speed": slice(1, 2)},
    {"stiffness": slice(4, 4)}, {"stiffness": -1, "belt_speed": -1},
])  # fmt: skip
def test_parts_across_chunks_are_those_of_the_whole(pair, key):
    with stickslip.open(pair[0]) as lazy, reading.look_into(pair[0]) as plain:
        whole = lazy["period"].load().isel(key)
        np.testing.assert_array_equal(plain["period"].isel(key).values, whole.values)
