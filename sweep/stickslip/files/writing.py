"""Datasets on disk: netCDF, or Zarr where that optional package is installed.

Writing is all or nothing (`targets.py`; behind a URL only Zarr is written, and an older store goes first); netCDF4
opened for writing would truncate the target first. These files are results, not checkpoints.

Labels of a dimension have its name, ``pad`` = felt, rubber, in files as in memory, so that plain xarray selects by it.
In netCDF they are rows of characters, ``pad(pad, pad_letters)``: CF wants a variable of one dimension and its name to
hold numbers.

Every chunk carries a checksum, and a seal covers the rest, and where chunks belong (`seal.py`). `reading.py` is the
other half.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from math import prod
from operator import mul
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import NetCDF4DataStore
from xarray.backends.common import ArrayWriter

from stickslip.errors import StoreError
from stickslip.files.chunks import Chunks, Packed
from stickslip.files.locations import Check, Location, Url, location
from stickslip.files.netcdf import NETCDF, NETCDF_LOCK, NetcdfChunks, packed
from stickslip.files.reading import open, require_zarr
from stickslip.files.seal import GROUP, NOBODY_WROTE, SEAL, TABLE, content_of, marks_of, sealed
from stickslip.files.targets import JOURNAL, begin_store, check_url, replaced

if TYPE_CHECKING:
    from stickslip.files.zarr_chunks import NewZarr

__all__ = ["StoreError", "open", "write"]

_CHUNK_VALUES = 2**17  # 1 MiB of float64: large enough to compress well, small enough to read a corner of a map
_MOST_FILES = 64  # of a variable in a folder: the rest of its chunks share them
_MARKS = "digests that bind each chunk to its place, variable and file"
Fill = Callable[[Any], None]
Encoding = dict[str, dict[str, Any]]


def write(
    ds: xr.Dataset,
    path: str | os.PathLike[str],
    fill: Fill | None = None,
    chunks: tuple[int, ...] | None = None,
    check: Check | None = None,
    identity: str | None = None,
) -> Location:
    """Write to a path or URL: Zarr if it ends in ``.zarr``, netCDF if in ``.nc``. Returns it.

    Replaces what is there only once the new file is whole and on the disk. Behind a URL it is removed before.
    fill : writes the values of the variables in chunks, whatever they are in the dataset; called with what
        `open_chunks` takes, in which all else is written.
    chunks : of variables that have so many dimensions; by default such that a chunk takes 1 MiB.
    check : called at last, before what is new takes the place of what is there; what it raises leaves that alone.
        Not called behind a URL.
    identity : of the values, beside all else that is written: a large Zarr store in a folder goes on where an earlier
        writer of the same was interrupted. None: nobody goes on with it.
    """
    place = location(path)
    plain = sealed(_with_plain_texts(ds.drop_encoding()))
    if place.suffix == ".zarr":
        require_zarr(path)
        if isinstance(place, Url) and fill is None:
            plain.load()  # its values may be read from the older store
        with _new_zarr(place, plain.attrs[SEAL], check, identity) as store:
            _create(plain, chunks, store, fill)
            store.finish(map(str, ds.variables))
        return place
    if isinstance(place, Url):
        check_url(place)
    if place.suffix != ".nc":
        raise StoreError(f"{place}: unknown kind of file, expected a name that ends in .nc or .zarr")
    with replaced(path, check=check) as temporary:
        _create(plain, chunks, temporary, fill)
    return Path(os.path.expanduser(path))


@contextmanager
def _new_zarr(place: Location, seal: str, check: Check | None, identity: str | None) -> Iterator[NewZarr]:
    """A new store that replaces that at `place` in the end.

    Replacing an older folder takes two renames. A crash between them leaves both, the old one named ``.NAME....old``.
    """
    from stickslip.files.zarr_chunks import NewZarr, Shards, is_begun

    if isinstance(place, Url):
        begin_store(place)
        yield NewZarr(lambda key, data: place.put(key, bytes(data)))
        return
    of = f"{seal} {identity}"
    begun = None if identity is None else partial(is_begun, of=of)
    with replaced(place, _replace_folder, check, zarr=True, begun=begun) as temporary:

        def write(key: str, data: Packed) -> None:
            file = temporary / key
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)

        yield NewZarr(write, shards=Shards(temporary, of))


def _create(plain: xr.Dataset, chunks: tuple[int, ...] | None, file: Path | NewZarr, fill: Fill | None) -> None:
    """Write a new file with all that the dataset holds; by `fill` what is in chunks."""
    later = _Later({str(name) for name, v in plain.variables.items() if v.dtype.kind in "fiu" and v.ndim})
    if isinstance(file, Path):
        _create_netcdf(plain, _netcdf_encoding(plain, chunks), later, file)
    else:
        _create_zarr(plain, _zarr_encoding(plain, chunks, file.shards is not None), later, file)
    later.write(file, {name for name in later.values if fill is None or name not in plain.data_vars})
    if fill:
        fill(file)


def _create_netcdf(ds: xr.Dataset, encoding: Encoding, later: _Later, path: Path) -> None:
    """Do as `to_netcdf` does, which takes no lock."""
    with NETCDF_LOCK:
        file = NetCDF4DataStore.open(path, mode="w", format="NETCDF4", lock=NETCDF_LOCK)  # type: ignore[no-untyped-call]
    try:
        with NETCDF_LOCK:
            ds.dump_to_store(file, writer=later, encoding=encoding)
            layouts = {name: (ds[name].shape, options["chunksizes"]) for name, options in encoding.items()
                       if "chunksizes" in options}  # fmt: skip
            group = file.ds.createGroup(GROUP)
            group.createDimension("chunk", marks_of("", layouts).table.size)
            group.createVariable(TABLE, "u8", ("chunk",)).long_name = _MARKS
    finally:
        file.close()


def _create_zarr(ds: xr.Dataset, encoding: Encoding, later: _Later, new: NewZarr) -> None:
    """Do as `to_zarr` does, which would write placeholders, too."""
    from xarray.backends import ZarrStore

    # Zarr leaves out chunks that hold nothing but the fill value, which makes a lost chunk look like one of them.
    # Chunks of dask need not be those of the store: `_Later` cuts them.
    store = ZarrStore.open_group(
        new.metadata, mode="w-", consolidated=False, zarr_format=3, write_empty=True, safe_chunks=False
    )
    ds.dump_to_store(store, writer=later, encoding=encoding)
    store.close()
    new.declared()


class _Later(ArrayWriter):
    """Writes what xarray gives it at once, but for variables in chunks, which it keeps for `chunks.py`."""

    def __init__(self, in_chunks: Collection[str]) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self._in_chunks = in_chunks
        self.values: dict[str, Any] = {}

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Called by xarray with the values of a variable, and with what writes them into the file."""
        name = getattr(target, "variable_name", None) or target.basename  # netCDF4, Zarr
        if name in self._in_chunks:
            self.values[name] = source
        else:
            super().add(source, target, region)  # type: ignore[no-untyped-call]

    def write(self, file: Path | NewZarr, names: Collection[str]) -> None:
        """Write some of what was kept. Without the lock: dask's threads may read netCDF, and take it for each chunk."""
        lazy = {name: self.values[name] for name in names if not isinstance(self.values[name], np.ndarray)}
        with open_chunks(file) as chunks:
            for name in self.values:
                if name in names and name not in lazy:
                    chunks.write(name, self.values[name])
            if lazy:
                from dask.array import store

                whole = [values.rechunk(chunks.layout(name).chunks) for name, values in lazy.items()]
                targets: Any = [chunks[name] for name in lazy]
                store(whole, targets, lock=False, scheduler="threads")


def _replace_folder(temporary: Path, target: Path) -> None:
    """Rename a folder over another one, which no system does in one go."""
    (temporary / JOURNAL).unlink(missing_ok=True)
    if not target.exists():
        return os.replace(temporary, target)
    old = temporary.with_suffix(".old")
    os.replace(target, old)
    try:
        os.replace(temporary, target)
    except OSError:
        os.replace(old, target)
        raise
    shutil.rmtree(old)


def _with_plain_texts(ds: xr.Dataset) -> xr.Dataset:
    """Text indices as stored in the file: text of any length, type object."""
    texts = {
        dim: xr.Variable(dim, ds[dim].values.astype(object), ds[dim].attrs) for dim in ds.dims if _is_text(ds, dim)
    }
    return ds.assign_coords(texts)


def _is_text(ds: xr.Dataset, dim: Hashable) -> bool:
    return dim in ds.coords and ds[dim].dtype.kind in "OTU"


def rehearse(columns: Mapping[str, NDArray[Any]], suffix: str) -> tuple[float, int]:
    """Pack some values as a file of this kind has them: seconds of a thread, none where they are packed, and bytes."""
    if suffix == ".nc":
        return 0.0, sum(packed(np.ascontiguousarray(values), NETCDF).size for values in columns.values())
    from stickslip.files.zarr_chunks import pack

    began = perf_counter()
    size = sum(len(pack(np.ascontiguousarray(values))) + len(content_of(values)) for values in columns.values())
    return perf_counter() - began, size


def count_files(ds: xr.Dataset, place: Location) -> int:
    """The number of files, or objects, in which a dataset is written."""
    if place.suffix == ".nc":
        return 1
    groups, count = 2, len(ds.variables) + 1  # each variable and the table of marks have a file that describes them
    for name, options in _zarr_encoding(ds, None, isinstance(place, Path)).items():
        parts = options["shards" if "shards" in options else "chunks"]
        count += prod(-(-length // of) for length, of in zip(ds[name].shape, parts, strict=True))
    return groups + count + 1


def open_chunks(file: Path | NewZarr, threads: int | None = None) -> Chunks:
    """The chunks of a netCDF file, or of a Zarr store, that has been written but for them."""
    if isinstance(file, Path):
        return NetcdfChunks(file, threads)
    from stickslip.files.zarr_chunks import ZarrChunks

    return ZarrChunks(file, threads)


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


def _zarr_encoding(ds: xr.Dataset, chunks: tuple[int, ...] | None, in_shards: bool) -> Encoding:
    """Fill values, chunks, shards, and compression with a checksum over what it made: of numbers that of
    `zarr_chunks.py`.
    """
    from zarr.codecs import BloscCodec, Crc32cCodec, ZstdCodec

    from stickslip.files.zarr_chunks import LEVEL

    encoding: Encoding = {str(name): {} for name in ds.variables} | _fill_values(ds)
    for name, options in encoding.items():
        variable = ds.variables[name]
        size, is_number = variable.dtype.itemsize, variable.dtype.kind in "fiu"
        shuffle: Any = "shuffle" if size > 1 else "bitshuffle"
        blosc = BloscCodec(cname="zstd", clevel=LEVEL, typesize=size, shuffle=shuffle)
        options |= {"compressors": (blosc if is_number else ZstdCodec(), Crc32cCodec())}
        options |= {"chunks": (lengths := _chunks(variable.shape, chunks))}
        if in_shards and is_number and (shard := _shard(variable.shape, lengths)):
            options |= {"shards": shard}
    return encoding


def _chunks(shape: tuple[int, ...], given: tuple[int, ...] | None = None) -> tuple[int, ...]:
    """Chunk sizes: those given for so many dimensions, else of at most `_CHUNK_VALUES` values.

    These are whole along the last dimensions: maps are looked at in planes.
    """
    if given and len(given) == len(shape):
        return given
    chunks: list[int] = []
    for i, length in enumerate(shape):
        below = max(1, prod(shape[i + 1 :]))  # a dimension may be empty: borders of lines that have none
        chunks.append(max(1, min(length, _CHUNK_VALUES // below)))
    return tuple(chunks)


def _shard(shape: tuple[int, ...], chunks: tuple[int, ...]) -> tuple[int, ...] | None:
    """Lengths of a shard, such that a variable has about `_MOST_FILES`; None where its chunks are no more."""
    counts = [-(-length // chunk) for length, chunk in zip(shape, chunks, strict=True)]
    together, left = list[int](), -(-prod(counts) // _MOST_FILES)
    for count in reversed(counts):
        together.insert(0, min(count, left))
        left = -(-left // together[0])
    return tuple(map(mul, together, chunks)) if max(together, default=1) > 1 else None
