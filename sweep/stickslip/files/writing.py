"""Datasets on disk: netCDF, or Zarr where that optional package is installed.

Writing is all or nothing (`atomic.py`); netCDF4 opened for writing would truncate the target first. These files are
results, not checkpoints.

CF wants text labels beside a dimension, not as its index, so the index ``pad`` = felt, rubber is stored in the file as
``pad_label``; `open` makes it the index again. Everything else is in the file as it is in memory.

Every chunk carries a checksum, and a seal covers the rest (`seal.py`). `reading.py` is the other half.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Collection
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from xarray.backends import NetCDF4DataStore
from xarray.backends.common import ArrayWriter

from stickslip.errors import StoreError
from stickslip.files.atomic import neighbour, replaced
from stickslip.files.netcdf_lock import NETCDF_LOCK
from stickslip.files.reading import open, require_zarr
from stickslip.files.seal import NOBODY_WROTE, sealed

__all__ = ["StoreError", "check_writable", "open", "write", "write_netcdf", "write_zarr"]

_CHUNK_VALUES = 2**17  # 1 MiB of float64: large enough to compress well, small enough to read a corner of a map
_ZARR_MARKERS = ("zarr.json", ".zgroup")
_LABEL = "_label"
Fill = Callable[[Path], None]
# Zarr leaves out chunks that hold nothing but the fill value, which makes a lost chunk look like one of them.
_WHOLE: dict[str, Any] = {"zarr_format": 3, "write_empty_chunks": True}


def write(ds: xr.Dataset, path: str | os.PathLike[str], fill: Fill | None = None) -> Path:
    """Write to `path`: Zarr if it ends in ``.zarr``, netCDF if in ``.nc``. Returns the path.

    fill : writes the values of a dataset that is lazy and has none yet; called with the temporary file, in which all
        else is written.
    """
    return _writer(Path(path))(ds, path, fill)


def write_netcdf(ds: xr.Dataset, path: str | os.PathLike[str], fill: Fill | None = None) -> Path:
    """Write a compressed netCDF-4 file, replacing `path` only once the new file is whole and on the disk."""
    target = _target(path)
    with replaced(target) as temporary:
        _create_netcdf(sealed(_labels_beside_dimensions(ds.drop_encoding())), temporary, with_lazy=fill is None)
        if fill:
            fill(temporary)
    return Path(path)


def _create_netcdf(ds: xr.Dataset, path: Path, with_lazy: bool) -> None:
    """What `to_netcdf` does, which takes no lock. with_lazy : whether lazy values are computed and written as well."""
    encoding = _netcdf_encoding(ds)
    later = _Later([name for name, options in encoding.items() if "chunksizes" in options])
    with NETCDF_LOCK:
        file = NetCDF4DataStore.open(path, mode="w", format="NETCDF4", lock=NETCDF_LOCK)  # type: ignore[no-untyped-call]
    try:
        with NETCDF_LOCK:
            ds.dump_to_store(file, writer=later, encoding=encoding)
    finally:
        file.close()
    later.write(path, with_lazy)


class _Later(ArrayWriter):
    """Writes what xarray gives it at once, but for variables in chunks, which it keeps for `chunks.py`."""

    def __init__(self, in_chunks: Collection[str]) -> None:
        super().__init__()  # type: ignore[no-untyped-call]
        self._in_chunks = in_chunks
        self._kept: dict[str, Any] = {}

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Called by xarray with the values of a variable, and with what writes them into the file."""
        if target.variable_name in self._in_chunks:
            self._kept[target.variable_name] = source
        else:
            super().add(source, target, region)  # type: ignore[no-untyped-call]

    def write(self, path: Path, with_lazy: bool) -> None:
        """Write what was kept. Without the lock: dask's threads may read netCDF, and take it for each chunk."""
        from stickslip.files.chunks import ChunkFile  # here: not all that write know h5py, which takes its time

        lazy = {name: values for name, values in self._kept.items() if not isinstance(values, np.ndarray)}
        with ChunkFile(path) as file:
            for name, values in self._kept.items():
                if name not in lazy:
                    file.write(name, values)
            if lazy and with_lazy:
                from dask.array import store

                whole = [values.rechunk(file.layout(name).chunks) for name, values in lazy.items()]
                targets: Any = [file[name] for name in lazy]
                store(whole, targets, lock=False, scheduler="threads")


def write_zarr(ds: xr.Dataset, path: str | os.PathLike[str], fill: Fill | None = None) -> Path:
    """Write a Zarr store, a folder.

    Replacing an older one takes two renames. A crash between them leaves both, the old one named ``.NAME....old``.
    """
    require_zarr(path)
    target = _target(path, zarr=True)
    plain = sealed(_labels_beside_dimensions(ds.drop_encoding()))
    with replaced(target, _replace_folder) as temporary:
        options = {"mode": "w-", "consolidated": False, "encoding": _zarr_encoding(plain), **_WHOLE}
        plain.to_zarr(temporary, compute=fill is None, **options)  # type: ignore[call-overload]
        if fill:
            fill(temporary)
    return Path(path)


def _replace_folder(temporary: Path, target: Path) -> None:
    """Rename a folder over another one, which no system does in one go."""
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


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raise StoreError now if `write` would fail there later: worth knowing before an hour of computing."""
    is_zarr = _writer(Path(path)) is write_zarr
    if is_zarr:
        require_zarr(path)
    with neighbour(_target(path, zarr=is_zarr)) as temporary:
        temporary.touch()


def _labels_beside_dimensions(ds: xr.Dataset) -> xr.Dataset:
    """Text indices renamed, ``pad`` to ``pad_label``, as stored in the file: text of any length, type object."""
    for dim in [str(dim) for dim in ds.dims]:
        if dim in ds.coords and ds[dim].dtype.kind in "OTU":
            text = xr.Variable(dim, ds[dim].values.astype(object), ds[dim].attrs)
            ds = ds.drop_vars(dim).assign_coords({dim + _LABEL: text})
    return ds


# --- how values are laid out ------------------------------------------------------------------------------------------


def _fill_encoding(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Fill values: a NaN for float data, none for flags, counts and coordinates (CF forbids the last).

    The NaN has bits of its own (`seal.NOBODY_WROTE`), which tell values of a lost chunk from undefined ones.
    """
    return {
        str(name): {"_FillValue": NOBODY_WROTE if name in ds.data_vars and variable.dtype.kind == "f" else None}
        for name, variable in ds.variables.items()
        if variable.dtype.kind in "fiu"
    }


def _netcdf_encoding(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Fill values, compression and chunks. Text and scalars are stored as they are."""
    encoding = _fill_encoding(ds)
    for name, options in encoding.items():
        if shape := ds[name].shape:
            options |= {"zlib": True, "complevel": 4, "shuffle": True, "chunksizes": _chunks(shape)}  # see `filters.py`
            options["fletcher32"] = True  # HDF5 refuses to read a chunk that does not match
    return encoding


def _zarr_encoding(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Fill values, chunks, and compression with a checksum over what it made."""
    from zarr.codecs import BloscCodec, Crc32cCodec, ZstdCodec

    encoding: dict[str, dict[str, Any]] = {str(name): {} for name in ds.variables} | _fill_encoding(ds)
    for name, options in encoding.items():
        variable = ds.variables[name]
        is_number = variable.dtype.kind in "fiu"
        squeeze = BloscCodec(cname="zstd", clevel=5, typesize=variable.dtype.itemsize) if is_number else ZstdCodec()
        options |= {"compressors": (squeeze, Crc32cCodec()), "chunks": _chunks(variable.shape)}
    return encoding


def _chunks(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Chunk sizes of at most `_CHUNK_VALUES` values, whole along the last dimensions: maps are looked at in planes."""
    chunks: list[int] = []
    for i, length in enumerate(shape):
        below = max(1, prod(shape[i + 1 :]))  # a dimension may be empty: borders of lines that have none
        chunks.append(max(1, min(length, _CHUNK_VALUES // below)))
    return tuple(chunks)


# --- files ------------------------------------------------------------------------------------------------------------


def _writer(path: Path) -> Callable[[xr.Dataset, str | os.PathLike[str], Fill | None], Path]:
    """The function that writes this kind of file."""
    if path.suffix == ".zarr":
        return write_zarr
    if path.suffix == ".nc":
        return write_netcdf
    raise StoreError(f"{path}: unknown kind of file, expected a name that ends in .nc or .zarr")


def _target(path: str | os.PathLike[str], *, zarr: bool = False) -> Path:
    """The file or store behind `path`, links followed; refused if something else is there (a device, a folder)."""
    target = Path(os.path.realpath(path))
    if not target.exists():
        return target
    if zarr and not any((target / marker).exists() for marker in _ZARR_MARKERS):
        raise StoreError(f"{path}: exists and is not a Zarr store, so it is left alone")
    if not zarr and not target.is_file():
        raise StoreError(f"{path}: exists and is not a regular file, so it is left alone")
    return target
