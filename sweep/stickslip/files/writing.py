"""Datasets on disk: netCDF, or Zarr where that optional package is installed.

Writing is all or nothing (`targets.py`; behind a URL only Zarr is written, and an older store goes first); netCDF4
opened for writing would truncate the target first. These files are results, not checkpoints.

The file and all it says of itself are made by xarray with netCDF4 or Zarr; what is in chunks is put in afterwards, so
that threads compress it. Every chunk carries a checksum, and a seal covers the rest (`chunks.py`). `reading.py` is the
other half. netCDF4 and h5py may each bring an HDF5 library of their own, or share one: so h5py, too, is used under
NETCDF_LOCK, and a file is open in one of them at a time. h5py has a lock of its own, which is always taken after this
one.

Labels of a dimension have its name, ``pad`` = felt, rubber, in files as in memory, so that plain xarray selects by it.
In netCDF they are rows of characters, ``pad(pad, pad_letters)``: CF wants a variable of one dimension and its name to
hold numbers.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Hashable, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import NetCDF4DataStore
from xarray.backends.common import ArrayWriter

from stickslip.errors import StoreError
from stickslip.files.chunks import (
    NETCDF_FILL,
    NOBODY_WROTE,
    ChunkFile,
    Filter,
    chunks_in,
    filtered,
    packing_of,
    sealed,
)
from stickslip.files.locations import ROOT, UNCACHED, Location, Url, explained, location
from stickslip.files.reading import NETCDF_LOCK, open, require_zarr
from stickslip.files.targets import replaced

__all__ = ["StoreError", "open", "write"]

_CHUNK_VALUES = 2**17  # 1 MiB of float64: large enough to compress well, small enough to read a corner of a map
_LARGER = 4  # times are chunks of Zarr, each of which is a file
_ZSTD_LEVEL = 3  # 5 takes nearly three times as long, for stores that are 7 % smaller
Fill = Callable[[Any], None]
Packed = Any  # bytes, or an array or view of them
Encoding = dict[str, dict[str, Any]]


def write(
    ds: xr.Dataset,
    path: str | os.PathLike[str],
    fill: Fill | None = None,
    chunks: tuple[int, ...] | None = None,
    threads: int | None = None,
) -> Location:
    """Write to a path or URL: Zarr if it ends in ``.zarr``, netCDF if in ``.nc``. Returns it.

    Replaces what is there only once the new file is whole and on the disk. Behind a URL it is removed before.
    fill : writes the values of the variables in chunks, whatever they are in the dataset; called with the file
        (`NetcdfChunks` or `ZarrChunks`), in which all else is written.
    chunks : of variables that have so many dimensions; by default such that a chunk takes 1 MiB.
    threads : that compress, all processors if None.
    """
    place = location(path)
    plain, names = sealed(_with_plain_texts(ds.drop_encoding())), [str(name) for name in ds.variables]
    if place.suffix == ".zarr":
        require_zarr(path)
    elif isinstance(place, Url):
        place.check_is_zarr()
    elif place.suffix != ".nc":
        raise StoreError(f"{place}: unknown kind of file, expected a name that ends in .nc or .zarr")
    if isinstance(place, Url):
        if fill is None:
            plain.load()  # its values may be read from the older store
        place.begin_store()
        with explained(place, "written", answers=()):
            _fill(plain, ZarrChunks(plain, chunks, place, threads), fill)
            _consolidate(place, names)
    elif place.suffix == ".zarr":
        with replaced(place, zarr=True) as temporary:
            _fill(plain, ZarrChunks(plain, chunks, temporary, threads), fill)
            _consolidate(temporary, names)
    else:
        with replaced(place) as temporary:
            _create_netcdf(plain, _netcdf_encoding(plain, chunks), temporary)
            _fill(plain, NetcdfChunks(temporary, threads), fill)
    return place


def _fill(ds: xr.Dataset, file: NetcdfChunks | ZarrChunks, fill: Fill | None) -> None:
    """Write what is in chunks into a new file: data variables by `fill`, if there is one."""
    with file:
        for name in _in_chunks(ds):
            if fill is None or name not in ds.data_vars:
                variable = ds.variables[name]
                for part in chunks_in(variable.shape, file.chunks(name)):
                    file.write(name, variable[part].values, [side.start for side in part])
        if fill:
            fill(file)


def _in_chunks(ds: xr.Dataset) -> list[str]:
    """The variables that are written by themselves: numbers, but single ones."""
    return [str(name) for name, variable in ds.variables.items() if variable.dtype.kind in "fiu" and variable.ndim]


def _create_netcdf(ds: xr.Dataset, encoding: Encoding, path: Path) -> None:
    """Do as `to_netcdf` does, which takes no lock, and leave out what is in chunks."""
    with NETCDF_LOCK:
        file = NetCDF4DataStore.open(path, mode="w", format="NETCDF4", lock=NETCDF_LOCK)  # type: ignore[no-untyped-call]
    try:
        with NETCDF_LOCK:
            ds.dump_to_store(file, writer=_Without(_in_chunks(ds)), encoding=encoding)
    finally:
        file.close()


class _Without(ArrayWriter):
    """Writes what xarray gives it, but for some variables."""

    def __init__(self, left_out: Collection[str]) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self._left_out = left_out

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Called by xarray with the values of a variable, and with what writes them into the file."""
        name = getattr(target, "variable_name", None) or target.basename  # netCDF4, Zarr
        if name not in self._left_out:
            super().add(source, target, region)  # type: ignore[no-untyped-call]


def _with_plain_texts(ds: xr.Dataset) -> xr.Dataset:
    """Text indices as stored in the file: text of any length, type object."""
    texts = {
        dim: xr.Variable(dim, ds[dim].values.astype(object), ds[dim].attrs) for dim in ds.dims if _is_text(ds, dim)
    }
    return ds.assign_coords(texts)


def _is_text(ds: xr.Dataset, dim: Hashable) -> bool:
    return dim in ds.coords and ds[dim].dtype.kind in "OTU"


# --- how values are laid out ------------------------------------------------------------------------------------------


def _fill_values(ds: xr.Dataset) -> Encoding:
    """Fill values: a NaN for float data, none for flags, counts and coordinates (CF forbids the last).

    The NaN has bits of its own (`seal.NOBODY_WROTE`), which tell values of a lost chunk from undefined ones.
    """
    return {
        str(name): {"_FillValue": NOBODY_WROTE if name in ds.data_vars and variable.dtype.kind == "f" else None}
        for name, variable in ds.variables.items()
        if variable.dtype.kind in "fiu"
    }


def _netcdf_encoding(ds: xr.Dataset, chunks: tuple[int, ...] | None) -> Encoding:
    """Fill values, compression and chunks; labels of a dimension as characters. Scalars are stored as they are."""
    encoding = _fill_values(ds)
    labels = {str(dim): {"dtype": "S1", "char_dim_name": f"{dim}_letters"} for dim in ds.dims if _is_text(ds, dim)}
    for name, options in encoding.items():
        if shape := ds[name].shape:
            options |= {"zlib": True, "complevel": 4, "shuffle": True}  # see `netcdf.py`
            options |= {"chunksizes": _chunks(shape, chunks), "fletcher32": True}  # HDF5 refuses damaged chunks
    return encoding | labels


def _zarr_encoding(ds: xr.Dataset, chunks: tuple[int, ...] | None) -> Encoding:
    """Fill values, chunks, and compression with a checksum over what it made."""
    encoding: Encoding = {str(name): {} for name in ds.variables} | _fill_values(ds)
    for name, options in encoding.items():
        variable = ds.variables[name]
        options |= {"compressors": _compressors(variable.dtype), "chunks": _chunks(variable.shape, chunks, _LARGER)}
        if variable.dtype.str[1:] in NETCDF_FILL:
            options["fill_value"] = NETCDF_FILL[variable.dtype.str[1:]]  # 0, Zarr's own, may be a value; so may NaN
    return encoding


def _chunks(shape: tuple[int, ...], given: tuple[int, ...] | None = None, larger: int = 1) -> tuple[int, ...]:
    """Chunk sizes: those given for so many dimensions, else of at most `_CHUNK_VALUES` values, or `larger` times that.

    These are whole along the last dimensions: maps are looked at in planes.
    """
    if given and len(given) == len(shape):
        return given
    chunks: list[int] = []
    for i, length in enumerate(shape):
        below = max(1, prod(shape[i + 1 :]))  # a dimension may be empty: borders of lines that have none
        chunks.append(max(1, min(length, larger * _CHUNK_VALUES // below)))
    return tuple(chunks)


# --- netCDF -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Layout:
    """A variable as the file declares it.

    fill : one value, for what lies outside of the array in its last chunks. packing : the name in `chunks.py` of what
    its filters make; None for what is not there.
    """

    variable: Any
    dtype: np.dtype[Any]
    chunks: tuple[int, ...]
    fill: NDArray[Any]
    pipeline: tuple[Filter, ...]
    packing: str | None

    def packed(self, values: NDArray[Any]) -> Packed:
        """The bytes of one chunk as they are in the file."""
        whole = np.ascontiguousarray(values, self.dtype)
        if values.shape != self.chunks:
            whole = np.full(self.chunks, self.fill, self.dtype)
            whole[tuple(map(slice, values.shape))] = values
        return filtered(whole.reshape(-1).view(np.uint8), self.pipeline)


class NetcdfChunks(ChunkFile):
    """The chunks of a netCDF file: packed by threads, stored by the thread that gives them."""

    def __init__(self, path: Path, threads: int | None = None) -> None:
        super().__init__(threads)
        self._layouts: dict[str, Layout] = {}
        import h5py  # which takes its time: for whoever writes a file

        with NETCDF_LOCK:
            self._file = h5py.File(path, "r+")

    def _close(self) -> None:
        self._layouts.clear()
        with NETCDF_LOCK:
            self._file.close()

    def layout(self, name: str) -> Layout:
        """The layout of a variable in the file."""
        if name not in self._layouts:
            with NETCDF_LOCK:
                variable = self._file[name]
                declared = variable.id.get_create_plist()
                fill = np.empty((), variable.dtype)
                declared.get_fill_value(fill)
                filters = [declared.get_filter(i) for i in range(declared.get_nfilters())]
                pipeline = tuple((number, parameters) for number, _, parameters, _ in filters)
                packing = packing_of(pipeline, variable.dtype)
                layout = Layout(variable, variable.dtype, variable.chunks, fill, pipeline, packing)
            self._layouts[name] = layout
        return self._layouts[name]

    def chunks(self, name: str) -> tuple[int, ...]:
        """The lengths of the chunks of a variable."""
        return self.layout(name).chunks

    def write(self, name: str, values: NDArray[Any], start: Sequence[int] | None = None) -> None:
        """Values of whole chunks, the first at index `start` of the variable."""
        layout = self.layout(name)

        def made(origin: tuple[int, ...], part: NDArray[Any]) -> tuple[str, tuple[int, ...], Packed]:
            return name, origin, layout.packed(part)

        for part in chunks_in(values.shape, layout.chunks):
            origin = tuple(side.start + first for side, first in zip(part, start or (0,) * values.ndim, strict=True))
            self._submit(made, origin, values[part])

    def put(self, name: str, origin: Sequence[int], data: Packed) -> None:
        """A chunk that is packed as the file has it."""
        self._submit(lambda: (name, tuple(origin), data))

    def _store(self, made: tuple[Any, ...]) -> None:
        name, origin, data = made
        with NETCDF_LOCK:
            self.layout(name).variable.id.write_direct_chunk(origin, data)


# --- Zarr -------------------------------------------------------------------------------------------------------------


class ZarrChunks(ChunkFile):
    """A new Zarr store in which all of a dataset but its chunks is written, open for these."""

    def __init__(self, ds: xr.Dataset, chunks: tuple[int, ...] | None, place: Location, threads: int | None) -> None:
        import zarr
        from xarray.backends import ZarrStore

        options = UNCACHED if isinstance(place, Url) else None
        # Zarr leaves out chunks that hold nothing but the fill value, which makes a lost chunk look like one of them.
        # Chunks of dask need not be those of the store: `_fill` cuts them.
        store = ZarrStore.open_group(
            str(place), mode="w", consolidated=False, zarr_format=3, write_empty=True, safe_chunks=False,
            storage_options=options,
        )  # fmt: skip
        ds.dump_to_store(store, writer=_Without(_in_chunks(ds)), encoding=_zarr_encoding(ds, chunks))
        store.close()
        with zarr.config.set({"array.write_empty_chunks": True}):
            group: Any = zarr.open_group(str(place), mode="r+", storage_options=options)
            self._arrays: dict[str, Any] = {str(name): group[str(name)] for name in ds.variables}
        super().__init__(threads)

    def chunks(self, name: str) -> tuple[int, ...]:
        """The lengths of the chunks of a variable."""
        lengths: tuple[int, ...] = self._arrays[name].chunks
        return lengths

    def write(self, name: str, values: NDArray[Any], start: Sequence[int] | None = None) -> None:
        """Values of whole chunks, the first at index `start` of the variable."""
        begin = start or (0,) * values.ndim
        part = tuple(slice(i, i + length) for i, length in zip(begin, values.shape, strict=True))
        self._submit(self._arrays[name].__setitem__, part, values)


def _consolidate(place: Location, names: Sequence[str]) -> None:
    """Have the root of a store say what its arrays say of themselves, as xarray looks for it first, and warns where it
    is not. Only then the root lists them: before that, nobody takes it for a store. names : in their order.

    By hand, because zarr warns in turn that its third format knows no such thing (`must_understand` says that), and
    lists arrays at random.
    """
    import fsspec

    files = fsspec.get_mapper(str(place), **(UNCACHED if isinstance(place, Url) else {}))
    root = json.loads(files[ROOT])
    arrays = {name: json.loads(files[f"{name}/{ROOT}"]) for name in names}
    root["consolidated_metadata"] = {"kind": "inline", "must_understand": False, "metadata": arrays}
    files[ROOT] = json.dumps(root, indent=2).encode()


def _compressors(dtype: np.dtype[Any]) -> tuple[Any, ...]:
    """The codecs of an array, with a checksum over what they made."""
    from zarr.codecs import BloscCodec, Crc32cCodec, ZstdCodec

    if dtype.kind not in "fiu":
        return ZstdCodec(), Crc32cCodec()
    shuffle: Any = "shuffle" if dtype.itemsize > 1 else "bitshuffle"
    return BloscCodec(cname="zstd", clevel=_ZSTD_LEVEL, typesize=dtype.itemsize, shuffle=shuffle), Crc32cCodec()
