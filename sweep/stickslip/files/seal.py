"""A checksum over what the checksums of chunks do not cover.

Chunks carry a checksum each (Fletcher-32 in netCDF, CRC-32C in Zarr), but names, units, texts and single numbers are
stored without. The seal is a digest over those, kept in a global attribute: a flipped bit in the configuration or in
the mass of all cells is found when the file is opened. History, title and the like may be edited freely.

A checksum says that a chunk is whole, not that it is where it belongs. So a table of the file, in a group of its own,
holds a mark of every chunk: a digest of its values, of their variable and place, and of the seal, which covers the
configuration and the version that computed it.

What no checksum can detect is a chunk that is not there, because its place in the file's table of chunks was damaged:
it reads as fill values. So these differ from all values that are written.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.files.locations import SEAL as SEAL

MARKED = "chunk_marks"  # global attribute of files that have the table of marks, which says where it is
GROUP, TABLE = "seal", "chunk_marks"
NOBODY_WROTE = np.array(0x7FF8_0000_0571_C511, np.uint64).view(np.float64)[()]  # a NaN no computation ends with
_NETCDF_FILL = {"i1": -127, "i4": -2147483647, "f8": 9.969209968386869e36}  # where a variable has no fill value
_SEALED_ATTRIBUTES = ("units", "axis_spacing", "flag_values", "flag_meanings")
Layout = tuple[tuple[int, ...], tuple[int, ...]]  # of a variable: its shape, that of its chunks
Contents = dict[tuple[str, tuple[int, ...]], bytes]  # what identifies chunks (`content_of`), by variable and number


def sealed(ds: xr.Dataset) -> xr.Dataset:
    """The dataset as it goes into a file, with its seal."""
    marked = ds.assign_attrs({MARKED: f"{GROUP}/{TABLE}"})
    return marked.assign_attrs({SEAL: digest(marked)})


def digest(ds: xr.Dataset) -> str:
    """Digest of the configuration, of names, dimensions and units of all variables, and of values without chunks."""
    hasher = hashlib.sha256()
    hasher.update(_text(ds.attrs.get("configuration", "")))
    if MARKED in ds.attrs:
        hasher.update(_text(MARKED, ds.attrs[MARKED], ds.attrs.get("source", "")))
    for name in sorted(map(str, ds.variables)):
        variable = ds.variables[name]
        is_number = variable.dtype.kind in "fiu"  # texts of any length are one type, in any kind of file
        hasher.update(_text(name, *variable.dims, *variable.shape, variable.dtype.str if is_number else "text"))
        for attribute in _SEALED_ATTRIBUTES:
            if attribute in variable.attrs:
                hasher.update(_text(attribute, *np.atleast_1d(variable.attrs[attribute])))
        if has_bare_values(variable):
            values = np.ascontiguousarray(variable.values)
            hasher.update(values.tobytes() if is_number else _text(*values.ravel()))
    return hasher.hexdigest()


@dataclass(frozen=True)
class Marks:
    """The marks of all chunks of a file. seal : of the file. places : by variable, where in `table` those of its chunks
    are, an array with an element for each chunk.
    """

    seal: str
    places: Mapping[str, NDArray[np.intp]]
    table: NDArray[np.uint64]

    def noted(self, contents: Contents) -> NDArray[np.uint64]:
        """The table, with the marks of chunks put in."""
        for (name, number), content in contents.items():
            self.table[self.places[name][number]] = self._mark(name, number, content)
        return self.table

    def fit(self, name: str, number: tuple[int, ...], values: NDArray[Any]) -> bool:
        """Tell whether these values were written as this chunk of this file."""
        at = self.places[name][number]
        return bool(at < self.table.size and self.table[at] == self._mark(name, number, content_of(values)))

    def _mark(self, name: str, number: tuple[int, ...], content: bytes) -> np.uint64:
        digest = hashlib.sha256(_text(self.seal, name, *number) + content).digest()
        return np.uint64(int.from_bytes(digest[:8], "little"))


def marks_of(seal: str, layouts: Mapping[str, Layout], table: NDArray[np.uint64] | None = None) -> Marks:
    """The marks of the variables of these shapes and chunks; without a table, an empty one."""
    places, first = dict[str, NDArray[np.intp]](), 0
    for name in sorted(layouts):
        counts = [-(-length // chunk) for length, chunk in zip(*layouts[name], strict=True)]
        places[name] = np.arange(first, first + prod(counts)).reshape(counts)
        first += prod(counts)
    return Marks(seal, places, np.zeros(max(first, 1), np.uint64) if table is None else table)


def chunks_in(
    shape: tuple[int, ...], lengths: tuple[int, ...], whole: tuple[slice, ...] | None = None
) -> Iterator[tuple[tuple[int, ...], tuple[slice, ...]]]:
    """The chunks of an array that a part of it touches: their numbers along each dimension, and their slices."""
    sides = whole or tuple(slice(0, length) for length in shape)
    touched = (range(s.start // n, -(-s.stop // n)) for s, n in zip(sides, lengths, strict=True))
    for number in product(*touched):
        ends = zip(number, lengths, shape, strict=True)
        yield number, tuple(slice(i * n, min((i + 1) * n, end)) for i, n, end in ends)


def content_of(values: NDArray[Any]) -> bytes:
    """SHA-256 of the values of a chunk in C order, without those that fill it up at an edge."""
    return hashlib.sha256(np.ascontiguousarray(values, values.dtype.newbyteorder("<")).data).digest()


def has_bare_values(variable: xr.Variable) -> bool:
    """Tell whether the values are stored without checksum: single numbers, and text."""
    return variable.ndim == 0 or variable.dtype.kind not in "fiu"


def is_unwritten(values: NDArray[Any]) -> bool:
    """Tell whether some values are fill values, as they are where a chunk got lost."""
    fill = _NETCDF_FILL.get(values.dtype.str[1:])
    if fill is not None and bool((values == fill).any()):
        return True
    return values.dtype == np.float64 and bool((values.view(np.uint64) == NOBODY_WROTE.view(np.uint64)).any())


def _text(*parts: Any) -> bytes:
    """The parts as bytes, each with its length before it, so that no two lists of parts look alike."""
    encoded = [str(part).encode("utf-8", "surrogatepass") for part in parts]
    return b"".join(len(part).to_bytes(8, "little") + part for part in encoded)
