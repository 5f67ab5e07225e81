"""What threads of ours compress is what the HDF5 library would have: its own readers find every bit, and any damage."""

import zlib

import h5py
import netCDF4
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from helpers.maps import plane
from stickslip.files import chunks, reading, writing
from stickslip.files.chunks import NOBODY_WROTE
from stickslip.files.reading import NETCDF_LOCK
from stickslip.files.writing import NetcdfChunks

TYPES = ("i1", "i4", "f8")


def values_of(kind, shape, seed=0):
    """Values of any bits, NaN of every kind among them, and a stretch where nothing changes."""
    raw = np.random.default_rng(seed).bytes(int(np.prod(shape)) * np.dtype(kind).itemsize)
    values = np.frombuffer(raw, kind).copy()
    values[values.size // 3 : values.size // 2] = 1
    return values.reshape(shape)


def create(path, kind, shape, pieces, values=None):
    """A variable `v` as `writing.py` declares it, by netCDF4; with values, netCDF4 writes them by itself."""
    with netCDF4.Dataset(path, "w") as file:
        dims = [file.createDimension(f"d{i}", length).name for i, length in enumerate(shape)]
        fill = {"fill_value": NOBODY_WROTE} if kind == "f8" else {}
        variable = file.createVariable(
            "v", kind, dims, zlib=True, complevel=4, shuffle=True, fletcher32=True, chunksizes=pieces, **fill
        )
        variable.set_auto_maskandscale(False)
        if values is not None:
            variable[...] = values
    return path


def read(path):
    with netCDF4.Dataset(path) as file:
        file["v"].set_auto_maskandscale(False)
        return file["v"][...]


def raw_chunks(path):
    """Which filters were left out, and the bytes as they are in the file, of all chunks by where they begin."""
    with h5py.File(path) as file:
        found = file["v"].id
        infos = [found.get_chunk_info(i) for i in range(found.get_num_chunks())]
        return {info.chunk_offset: found.read_direct_chunk(info.chunk_offset) for info in infos}


def same_bits(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


# --- as HDF5 does it --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize(
    ("shape", "pieces"), [((7,), (7,)), ((1,), (1,)), ((1001,), (300,)), ((50, 70), (20, 70)), ((3, 41, 5), (1, 10, 5))]
)
def test_chunks_are_those_that_the_library_makes_but_for_deflate(kind, shape, pieces, tmp_path):
    values = values_of(kind, shape)
    theirs = create(tmp_path / "theirs.nc", kind, shape, pieces, values)
    with NetcdfChunks(create(tmp_path / "ours.nc", kind, shape, pieces)) as file:
        file.write("v", values)
    assert same_bits(read(tmp_path / "ours.nc"), values)
    ours, theirs = raw_chunks(tmp_path / "ours.nc"), raw_chunks(theirs)
    assert ours.keys() == theirs.keys()
    for place, (mask, data) in theirs.items():
        assert ours[place][0] == 0, "no filter was left out"
        if mask == 0:
            assert zlib.decompress(ours[place][1]) == zlib.decompress(data)


@given(st.binary(max_size=3000))
def test_a_checksum_is_that_of_the_plain_sums(data):
    simple = double = 0
    for high, low in zip(data[::2], data[1::2] + b"\0", strict=False):
        simple = _folded(simple + (high << 8 | low))
        double = _folded(double + simple)
    assert chunks.fletcher32(np.frombuffer(data, np.uint8)) == double << 16 | simple


def _folded(total):
    return (total & 0xFFFF) + (total >> 16)


@pytest.mark.parametrize("engine", ["netcdf4", "h5netcdf"])
def test_any_netcdf_reader_finds_every_value(engine, tmp_path, monkeypatch):
    pytest.importorskip(engine if engine == "h5netcdf" else "netCDF4")
    monkeypatch.setattr(writing, "_CHUNK_VALUES", 100)
    ds = plane(30, 40)
    with xr.open_dataset(writing.write(ds, tmp_path / "map.nc"), engine=engine, decode_timedelta=False) as back:
        for name in ds.data_vars:
            assert same_bits(back[name].values, ds[name].values)


# --- damage -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", TYPES)
def test_a_flipped_bit_anywhere_in_a_chunk_is_refused_by_the_library(kind, tmp_path):
    values = values_of(kind, (400,))
    path = create(tmp_path / "v.nc", kind, (400,), (400,))
    with NetcdfChunks(path) as file:
        file.write("v", values)
    with h5py.File(path) as file:
        info = file["v"].id.get_chunk_info(0)
    good = path.read_bytes()
    refused = 0
    for place in range(info.byte_offset, info.byte_offset + info.size, 7):
        path.write_bytes(good[:place] + bytes([good[place] ^ 1 << place % 8]) + good[place + 1 :])
        try:
            found = read(path)
        except RuntimeError:
            refused += 1
        else:
            assert same_bits(found, values), "a bit that says nothing, in the head of the deflated data"
    assert refused > info.size // 7 - 3


# --- threads ----------------------------------------------------------------------------------------------------------


def test_a_file_does_not_depend_on_the_number_of_threads(tmp_path):
    values = values_of("f8", (1000, 60))
    for threads in (1, 2, 5):
        with NetcdfChunks(create(tmp_path / f"{threads}.nc", "f8", (1000, 60), (30, 60)), threads) as file:
            file.write("v", values[:600])
            file.write("v", values[600:], (600, 0))
    files = {(tmp_path / f"{threads}.nc").read_bytes() for threads in (1, 2, 5)}
    assert len(files) == 1 and same_bits(read(tmp_path / "1.nc"), values)


@pytest.mark.parametrize("suffix", [".nc", ".zarr"])
def test_lazy_values_in_other_chunks_than_the_file_are_written_as_they_are(tmp_path, monkeypatch, suffix):
    monkeypatch.setattr(writing, "_CHUNK_VALUES", 100)
    ds = plane(30, 40)
    pieces = ds.chunk(stiffness=7, belt_speed=11)
    with reading.open(writing.write(pieces, tmp_path / f"map{suffix}")) as back:
        xr.testing.assert_identical(back.load(), ds)


def test_what_goes_wrong_in_a_thread_is_raised_and_the_file_is_closed(tmp_path, monkeypatch):
    def full(values, pipeline):
        raise MemoryError("no room")

    path = create(tmp_path / "v.nc", "i4", (900,), (10,))
    monkeypatch.setattr(writing, "filtered", full)
    with pytest.raises(MemoryError, match="no room"), NetcdfChunks(path) as file:
        file.write("v", np.arange(900, dtype="i4"))
    assert not NETCDF_LOCK.locked()
    monkeypatch.undo()
    with NetcdfChunks(path) as file:  # HDF5 would refuse a file that is open for writing
        file.write("v", np.arange(900, dtype="i4"))
    assert same_bits(read(path), np.arange(900, dtype="i4"))
