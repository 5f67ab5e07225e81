"""Datasets on disk: netCDF, or Zarr where that optional package is installed.

Writing is all or nothing: a temporary neighbour is written, flushed to the disk and renamed over the target, so that a
crash, a full disk or a lack of permission leaves the old file as it was. (netCDF4 opened for writing would truncate the
target first.) These files are results, not checkpoints.

CF wants text labels beside a dimension, not as its index, so the index ``pad`` = felt, rubber lies in the file as
``pad_label``; `open` makes it the index again. Everything else is in the file as it is in memory.
"""

from __future__ import annotations

import os
import shutil
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

_CHUNK_VALUES = 2**17  # 1 MiB of float64: large enough to compress well, small enough to read a corner of a map
_ZARR_MARKERS = ("zarr.json", ".zgroup")
_LABEL = "_label"


class StoreError(OSError):
    """A dataset could not be written or read; the message names the path, the reason and, if there is one, a remedy."""


def write(ds: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write to `path`: Zarr if it ends in ``.zarr``, netCDF if in ``.nc``. Returns the path."""
    return _writer(Path(path))(ds, path)


def write_netcdf(ds: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a compressed netCDF-4 file, replacing `path` only once the new file is whole and on the disk."""
    target = _target(path)
    with _temporary_neighbour(target) as temporary:
        plain = _labels_beside_dimensions(ds)
        plain.to_netcdf(temporary, engine="netcdf4", format="NETCDF4", encoding=_netcdf_encoding(plain))
        _flush(temporary)
        os.replace(temporary, target)
        _flush(target.parent)
    return Path(path)


def write_zarr(ds: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a Zarr store, a folder.

    Replacing an older one takes two renames. A crash between them leaves both, the old one named ``.NAME....old``.
    """
    _require_zarr(path)
    target = _target(path, zarr=True)
    plain = _labels_beside_dimensions(ds.drop_encoding())  # without chunks and filters of a file it was read from
    with _temporary_neighbour(target) as temporary:
        plain.to_zarr(temporary, mode="w-", consolidated=False, encoding=_fill_encoding(plain))
        if target.exists():
            old = temporary.with_suffix(".old")
            os.replace(target, old)
            try:
                os.replace(temporary, target)
            except OSError:
                os.replace(old, target)
                raise
            shutil.rmtree(old)
        else:
            os.replace(temporary, target)
        _flush(target.parent)
    return Path(path)


def check_writable(path: str | os.PathLike[str]) -> None:
    """Raise StoreError now if `write` would fail there later: worth knowing before an hour of computing."""
    is_zarr = _writer(Path(path)) is write_zarr
    if is_zarr:
        _require_zarr(path)
    with _temporary_neighbour(_target(path, zarr=is_zarr)) as temporary:
        temporary.touch()


def open(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a dataset that `write` wrote. Values are loaded when they are used."""
    source = Path(path)
    if not source.exists():
        raise StoreError(f"{path}: no such file")
    if source.is_dir():
        _require_zarr(path)
    options: dict[str, Any] = {"engine": "zarr", "consolidated": False} if source.is_dir() else {"engine": "netcdf4"}
    try:
        ds = xr.open_dataset(source, decode_times=False, decode_timedelta=False, chunks=None, **options)
    except (OSError, ValueError, RuntimeError) as error:
        kind = "Zarr" if source.is_dir() else "netCDF"
        raise StoreError(f"{path}: cannot be read as {kind} ({_reason(error)})") from error
    if not str(ds.attrs.get("source", "")).startswith("stickslip "):
        ds.close()
        raise StoreError(f"{path}: not written by stickslip (its attribute `source` does not say so)")
    return _labels_as_index(_with_plain_flags(ds))


def _labels_beside_dimensions(ds: xr.Dataset) -> xr.Dataset:
    """Text indices renamed, ``pad`` to ``pad_label``, as they lie in the file: text of any length, type object."""
    for dim in [str(dim) for dim in ds.dims]:
        if dim in ds.coords and ds[dim].dtype.kind in "OTU":
            text = xr.Variable(dim, ds[dim].values.astype(object), ds[dim].attrs)
            ds = ds.drop_vars(dim).assign_coords({dim + _LABEL: text})
    return ds


def _labels_as_index(ds: xr.Dataset) -> xr.Dataset:
    """The opposite of `_labels_beside_dimensions`."""
    for dim in [str(dim) for dim in ds.dims]:
        if (label := dim + _LABEL) in ds.coords and ds[label].dims == (dim,):
            text = xr.Variable(dim, np.array([str(name) for name in ds[label].values]), ds[label].attrs)
            ds = ds.drop_vars(label).assign_coords({dim: text})
    return ds


def _with_plain_flags(ds: xr.Dataset) -> xr.Dataset:
    """`flag_values` as an array of the flag's own type, as netCDF gives it; Zarr gives a list."""
    for variable in ds.variables.values():
        if "flag_values" in variable.attrs:
            variable.attrs["flag_values"] = np.atleast_1d(np.asarray(variable.attrs["flag_values"], variable.dtype))
    return ds


# --- how values are laid out ------------------------------------------------------------------------------------------


def _fill_encoding(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Fill values: NaN for float data, none for flags, counts and coordinates (CF forbids the last)."""
    return {
        str(name): {"_FillValue": np.nan if name in ds.data_vars and variable.dtype.kind == "f" else None}
        for name, variable in ds.variables.items()
        if variable.dtype.kind in "fiu"
    }


def _netcdf_encoding(ds: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Fill values, compression and chunks. Text and scalars are stored as they are."""
    encoding = _fill_encoding(ds)
    for name, options in encoding.items():
        if shape := ds[name].shape:
            options |= {"zlib": True, "complevel": 4, "shuffle": True, "chunksizes": _chunks(shape)}
    return encoding


def _chunks(shape: tuple[int, ...]) -> tuple[int, ...]:
    """Chunk sizes of at most `_CHUNK_VALUES` values, whole along the last dimensions: maps are looked at in planes."""
    chunks: list[int] = []
    for i, length in enumerate(shape):
        below = prod(shape[i + 1 :])
        chunks.append(min(length, max(1, _CHUNK_VALUES // below)))
    return tuple(chunks)


# --- files ------------------------------------------------------------------------------------------------------------


def _writer(path: Path) -> Callable[[xr.Dataset, str | os.PathLike[str]], Path]:
    """The function that writes this kind of file."""
    if path.suffix == ".zarr":
        return write_zarr
    if path.suffix == ".nc":
        return write_netcdf
    raise StoreError(f"{path}: unknown kind of file, expected a name that ends in .nc or .zarr")


def _target(path: str | os.PathLike[str], *, zarr: bool = False) -> Path:
    """The file or store behind `path`, links followed; refused if something else lies there (a device, a folder)."""
    target = Path(os.path.realpath(path))
    if not target.exists():
        return target
    if zarr and not any((target / marker).exists() for marker in _ZARR_MARKERS):
        raise StoreError(f"{path}: exists and is not a Zarr store, so it is left alone")
    if not zarr and not target.is_file():
        raise StoreError(f"{path}: exists and is not a regular file, so it is left alone")
    return target


@contextmanager
def _temporary_neighbour(target: Path) -> Iterator[Path]:
    """A free name in the folder of `target`, on the same disk so that a rename suffices; gone afterwards.

    The folder is created if need be. Whatever the operating system or the netCDF library complains about becomes a
    StoreError that names `target`.
    """
    temporary = target.with_name(f".{target.name}.{uuid.uuid4().hex}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
    except (OSError, RuntimeError) as error:  # netCDF4 reports a full disk as RuntimeError("NetCDF: HDF error")
        raise StoreError(f"{target}: cannot be written ({_reason(error)})") from error
    finally:
        if temporary.is_dir():
            shutil.rmtree(temporary, ignore_errors=True)
        with suppress(OSError):
            temporary.unlink()


def _reason(error: Exception) -> str:
    """What went wrong, without the path, which the message names already."""
    if isinstance(error, OSError) and error.strerror:
        return str(error.strerror)
    return str(error).splitlines()[0] if str(error) else type(error).__name__


def _flush(path: Path) -> None:
    """Have the operating system put a file, or the names in a folder, on the disk."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        if path.is_dir():  # Windows does not open folders
            return
        raise
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _require_zarr(path: str | os.PathLike[str]) -> None:
    """Zarr is an optional extra: say so before xarray says something longer."""
    try:
        import zarr  # noqa: F401
    except ModuleNotFoundError as error:
        raise StoreError(
            f"{path}: Zarr stores need the optional package zarr\n"
            "hint: pip install 'stickslip[zarr]', or give the file a name that ends in .nc"
        ) from error
