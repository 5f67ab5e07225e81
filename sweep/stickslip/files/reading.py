"""Result files into lazy datasets; damaged ones are refused.

Data variables come back as dask arrays with the chunks of the file; a chunk is read when it is used, and a corrupt one
is a StoreError that names file, variable and place. Chunks carry checksums and the rest of the file is sealed
(`chunks.py`), so a flipped bit or a missing piece is refused, not drawn.

netCDF and HDF5 are not safe for more than one thread. xarray locks reading and writing of values, but not what it asks
a file for when it opens, describes or closes it. So whatever of ours touches a netCDF file holds NETCDF_LOCK, and what
xarray does later with a file of ours (a lazy chunk, closing, the garbage collector) takes the same lock, because it was
given to it. Holding it includes holding xarray's own lock: plain xarray in another thread waits wherever it locks at
all. Never wait for other threads while holding it: dask's read our files. Zarr needs no lock.
"""

import os
import sys
import threading
from collections.abc import Callable, Hashable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.backends.netCDF4_ import NETCDF4_PYTHON_LOCK
from xarray.core.indexing import ExplicitIndexer, IndexingSupport, LazilyIndexedArray, explicit_indexing_adapter
from xarray.namedarray import pycompat, utils

from stickslip.errors import StoreError, reason
from stickslip.files.chunks import SEAL, digest, is_unwritten
from stickslip.files.locations import RESULTS, UNCACHED, Url, location, neighbours, wrong_file_type

_REMEDY = "hint: copy it again, or compute it again"
_UNSEAL = f"remove the global attribute {SEAL}"
Lazily = Callable[[xr.Variable, "_Guarded"], xr.Variable]


class _NetcdfLock:
    """A re-entrant lock with the interface xarray asks for; a pickled one is that of the process that unpickles it."""

    def __init__(self) -> None:
        self._ours, self._xarrays, self._depth = threading.RLock(), NETCDF4_PYTHON_LOCK, 0

    def acquire(self, blocking: bool = True) -> bool:
        """Tell whether this thread holds the lock now; the garbage collector asks without blocking."""
        if not self._ours.acquire(blocking):
            return False
        try:
            free = self._depth > 0 or bool(self._xarrays.acquire(blocking))
        except BaseException:  # Ctrl-C while waiting
            self._ours.release()
            raise
        if free:
            self._depth += 1
        else:
            self._ours.release()
        return free

    def release(self) -> None:
        """Give up what one `acquire` took."""
        self._depth -= 1
        if self._depth == 0:
            self._xarrays.release()
        self._ours.release()

    def locked(self) -> bool:
        """Tell whether any thread holds it."""
        return self._depth > 0

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *_: Any) -> None:
        self.release()

    def __reduce__(self) -> str:
        return "NETCDF_LOCK"


NETCDF_LOCK = _NetcdfLock()


# --- a file -----------------------------------------------------------------------------------------------------------


def open(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a dataset that `writing.write` wrote: netCDF or Zarr, in chunks, each when it is used.

    Coordinates are in memory, data variables are dask arrays. Raises StoreError; so does reading a corrupt chunk later.
    """
    return _open(path, _by_dask)


def look_into(path: str | os.PathLike[str]) -> xr.Dataset:
    """As `open`, without dask, whose import takes longer than a look: values are read each time."""
    return _open(path, _by_xarray)


def _open(path: str | os.PathLike[str], lazily: Lazily) -> xr.Dataset:
    source = _source(path)
    if source.is_dir() if isinstance(source, Path) else source.rstrip("/").endswith(".zarr"):
        require_zarr(path)
        return _checked(path, source, "zarr", lazily)
    with NETCDF_LOCK:
        return _checked(path, source, "netcdf4", lazily)


def _checked(path: str | os.PathLike[str], source: Path | str, engine: str, lazily: Lazily) -> xr.Dataset:
    """The dataset as people use it; a file that is refused is closed."""
    with ExitStack() as to_close:
        try:
            opened = _opened(source, engine, to_close)
            objection = _objection(opened)
            waiting = {str(name): array.variable for name, array in opened.data_vars.items() if array.ndim}
            ds = _as_in_memory(opened.assign({
                name: lazily(v, _Guarded(v, name, str(path))) for name, v in waiting.items()
            }))  # fmt: skip
        except Exception as error:  # a damaged file can make these libraries raise whatever there is
            kind = "Zarr" if engine == "zarr" else "netCDF"
            raise StoreError(f"{path}: cannot be read as {kind} ({reason(error)})") from error
        if objection:
            raise StoreError(f"{path}: {objection}")
        to_close.pop_all()
    ds.attrs = {name: value for name, value in opened.attrs.items() if name != SEAL}
    ds.set_close(opened.close)
    return ds


def _objection(ds: xr.Dataset) -> str | None:
    """The reason not to work with a file; None if there is none."""
    if not str(ds.attrs.get("source", "")).startswith("stickslip "):
        return "not written by stickslip (its attribute `source` does not say so)"
    for name, variable in ds.variables.items():
        if name in ds.coords and is_unwritten(variable.values):
            return f"damaged, {name} is not there, or not all of it\n{_REMEDY}"
    if SEAL not in ds.attrs:  # removed by somebody who worked on a result
        return None
    if ds.attrs[SEAL] != digest(ds):
        changed = "names, units, parameters or configuration are not those that were written"
        return f"damaged or changed, {changed}\nhint: if it was changed on purpose, {_UNSEAL}"
    return None


def _source(path: str | os.PathLike[str]) -> Path | str:
    """The path, or the address of a remote store; refused if there is nothing."""
    where = location(path)
    if isinstance(where, Url):
        if where.suffix == ".zarr" and not where.exists():
            again = "a run that was stopped while it wrote it writes it again"
            raise StoreError(f"{path}: no Zarr store there, or not all of it\nhint: {again}")
        return str(where)
    message, hint = f"{path}: no such file", None
    if not where.exists():
        hint = neighbours(where, RESULTS)
    elif kind := wrong_file_type(where, RESULTS):
        message, hint = f"{path}: this is {kind.name}, expected a result (.nc or .zarr)", kind.hint
    else:
        return where
    raise StoreError(f"{message}\nhint: {hint}" if hint else message)


def _opened(source: Path | str, engine: str, to_close: ExitStack) -> xr.Dataset:
    """The dataset as stored in the file, coordinates and single numbers loaded, the rest waiting."""
    ds = _as_stored(source, engine)
    to_close.callback(ds.close)
    loaded = dict[Hashable, xr.Variable]()
    for name, variable in ds.variables.items():
        if name in ds.coords or not variable.ndim:
            values = variable.values
            stored = {key: variable.encoding[key] for key in ("preferred_chunks",) if key in variable.encoding}
            native = values.astype(_native(values.dtype), copy=False)
            loaded[name] = xr.Variable(variable.dims, native, variable.attrs, stored)
    ds.update(loaded)  # all at once: each time it looks at all variables
    return ds


def _as_stored(source: Path | str, engine: str) -> xr.Dataset:
    options: dict[str, Any] = {"lock": NETCDF_LOCK}
    if engine == "zarr":
        import zarr

        remote = UNCACHED if isinstance(source, str) else None
        root = zarr.open_group(source, mode="r", storage_options=remote)
        listed = root.metadata.consolidated_metadata is not None  # the arrays, in their order
        options = {"consolidated": listed, "storage_options": remote}
    return xr.open_dataset(
        source, engine=engine, decode_times=False, decode_timedelta=False, chunks=None, cache=False, **options
    )


def _native(dtype: np.dtype[Any]) -> np.dtype[Any]:
    """The type in the byte order of this machine; Zarr gives one that says it is little-endian."""
    return dtype.newbyteorder("=") if dtype.kind in "fiu" else dtype


# --- chunks -----------------------------------------------------------------------------------------------------------


class _Guarded(BackendArray):
    """A variable of a file as dask and xarray read it: a part at a time, errors in the words of StoreError."""

    def __init__(self, variable: xr.Variable, name: str, path: str) -> None:
        self.shape, self.dtype = variable.shape, _native(variable.dtype)
        self._variable, self._name, self._path = variable, name, path

    def __getitem__(self, key: tuple[slice | int, ...] | ExplicitIndexer) -> NDArray[Any]:
        if isinstance(key, ExplicitIndexer):
            values: NDArray[Any] = explicit_indexing_adapter(key, self.shape, IndexingSupport.BASIC, self._read)
            return values
        return self._read(key)

    def _read(self, key: tuple[slice | int, ...]) -> NDArray[Any]:
        # Steps are taken in memory: the HDF5 library takes them one value at a time.
        whole, inside = zip(*(_hull(part, length) for part, length in zip(key, self.shape, strict=True)), strict=True)
        return self._values(whole)[inside].astype(self.dtype, copy=False)

    def _values(self, whole: tuple[slice, ...]) -> NDArray[Any]:
        try:
            values: NDArray[Any] = self._variable[whole].values
        except Exception as error:  # damage shows up in many guises: HDF5, zlib, codecs, JSON
            raise self._damaged(whole, f"cannot be read ({reason(error)})") from error
        if is_unwritten(values):
            raise self._damaged(whole, "is not there, or not all of it")
        return values

    def _damaged(self, whole: tuple[slice, ...], what: str) -> StoreError:
        place = ", ".join(f"{part.start}:{part.stop}" for part in whole)
        return StoreError(f"{self._path}: damaged, {self._name}[{place}] {what}\n{_REMEDY}")


def _hull(part: slice | int, length: int) -> tuple[slice, slice | int]:
    """The contiguous slice that holds `part`, and the place of `part` in it."""
    if not isinstance(part, slice):
        return slice(part % length, part % length + 1), 0
    chosen = range(length)[part]
    if not chosen:
        return slice(0, 0), slice(None)
    start, stop = sorted((chosen[0], chosen[-1]))
    return slice(start, stop + 1), slice(None, None, chosen.step)


def _by_dask(variable: xr.Variable, guarded: _Guarded) -> xr.Variable:
    from dask.array import from_array  # here, so that nobody pays for dask who opens no file

    blank, lengths = np.empty((0,) * variable.ndim, guarded.dtype), _chunk_lengths(variable)
    array = from_array(guarded, chunks=lengths, name=False, meta=blank, lock=False, fancy=False)
    return xr.Variable(variable.dims, array, variable.attrs)


def _by_xarray(variable: xr.Variable, guarded: _Guarded) -> xr.Variable:
    encoding = {"preferred_chunks": dict(zip(variable.dims, _chunk_lengths(variable), strict=True))}
    return xr.Variable(variable.dims, LazilyIndexedArray(guarded), variable.attrs, encoding)


def _without_threads() -> None:
    """Have dask start threads anew in a forked process: it would deadlock waiting for those of its parent."""
    threaded: Any = sys.modules.get("dask.threaded")
    if threaded:
        threaded.default_pool = None
        threaded.pools.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_without_threads)


def _chunk_lengths(variable: xr.Variable) -> tuple[int, ...]:
    """Chunks as stored in the file; one for all where the file has none."""
    preferred: Mapping[Any, int] = variable.encoding.get("preferred_chunks", {})
    return tuple(
        max(1, int(preferred.get(dim, length))) for dim, length in zip(variable.dims, variable.shape, strict=True)
    )


def _as_in_memory(ds: xr.Dataset) -> xr.Dataset:
    """Text indices as plain texts, and `flag_values`, of which Zarr gives a list, as an array of the flag's type."""
    for dim in [str(dim) for dim in ds.dims]:
        if dim in ds.coords and ds[dim].dtype.kind not in "fiu":
            text = xr.Variable(dim, np.array([str(name) for name in ds[dim].values]), ds[dim].attrs)
            ds = ds.assign_coords({dim: text})
    for variable in ds.variables.values():
        if "flag_values" in variable.attrs:
            variable.attrs["flag_values"] = np.atleast_1d(np.asarray(variable.attrs["flag_values"], variable.dtype))
    return ds


def require_zarr(path: str | os.PathLike[str]) -> None:
    """Zarr is an optional extra: say so before xarray says something longer."""
    try:
        import zarr  # noqa: F401
    except ModuleNotFoundError as error:
        raise StoreError(
            f"{path}: Zarr stores need the optional package zarr\n"
            "hint: pip install 'stickslip[zarr]', or give the file a name that ends in .nc"
        ) from error


# --- xarray without the libraries of arrays that nobody has imported --------------------------------------------------

_CLASSES = {"dask": ("dask.array", "Array"), "pint": ("pint", "Quantity")}


class _LazyModule:
    """A `pycompat.DuckArrayModule` of a library that may never be imported."""

    def __init__(self, name: str) -> None:
        self._name = name

    @property
    def type(self) -> tuple[type[Any], ...]:
        """The class of its arrays, in a tuple; an empty one before the library is imported."""
        module, name = _CLASSES[self._name]
        kind = getattr(sys.modules.get(module), name, None)
        return () if kind is None else (kind,)

    def __getattr__(self, name: str) -> Any:
        """Everything else as xarray has it, for which it imports the library."""
        return getattr(pycompat.DuckArrayModule(self._name), name)  # type: ignore[arg-type]


def _wait_for_imports() -> None:
    """Have xarray wait for others to import dask and pint; where it has become another one, it goes on as before.

    Of every variable it asks whether it holds an array of these, and imports both to know: 0.4 s of every command, as
    much as all the rest of `stickslip inspect` (measured). But no array is one of a library that nobody has imported.
    So what it keeps of each library (`xarray.namedarray.pycompat`, private; seen in 2026.9) says so, and so does its
    question for collections of dask.
    """
    known = getattr(pycompat, "_cached_duck_array_modules", None)
    if isinstance(known, dict) and hasattr(pycompat, "DuckArrayModule"):
        for name in _CLASSES:
            known.setdefault(name, _LazyModule(name))
    ask = getattr(utils, "is_dask_collection", None)
    if ask is None:
        return

    def is_dask_collection(x: object) -> Any:
        # Imported, and whole: another thread may be importing dask, which a second import would upset.
        spec = getattr(sys.modules.get("dask"), "__spec__", None)
        return spec is not None and not getattr(spec, "_initializing", False) and ask(x)

    utils.is_dask_collection = is_dask_collection  # type: ignore[assignment]


_wait_for_imports()
