"""What HDF5's filters make of the values of a chunk: shuffled, deflated, with a checksum.

The HDF5 library runs them one chunk at a time, and zlib's deflate takes ten times as long as that of ISA-L, which gives
ordinary deflated data. These here run in as many threads as one likes: none of them holds Python's global lock.

Specification: HDF5 File Format, Filter Pipeline Message; H5checksum.c and H5Zshuffle.c for what it leaves open.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from isal import isal_zlib
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Filter = tuple[int, tuple[int, ...]]  # number and parameters, as declared in the file

_LEVEL = 2  # of 0 to 3: as fast as 1, two percent smaller; 3 takes twice as long and gains nothing
_ROW = 512  # words; a chunk has about as many rows


def filtered(data: Bytes, pipeline: Sequence[Filter]) -> Bytes:
    """The bytes of a chunk after the filters that the file declares, in their order. KeyError: a filter we have not."""
    for number, parameters in pipeline:
        data = _FILTERS[number](data, parameters)
    return data


def unfiltered(data: Bytes, pipeline: Sequence[Filter]) -> Bytes:
    """What `filtered` was given. Raises ValueError for what it cannot have made."""
    for number, parameters in reversed(pipeline):
        data = _INVERSES[number](data, parameters)
    return data


def fletcher32(data: Bytes) -> int:
    """HDF5's checksum: Fletcher's over 16-bit big-endian words, modulo 65,535, an odd byte at the end padded with 0.

    Sums of rows and of columns give both sums. They are taken over little-endian words: modulo 65,535, swapping the
    bytes of the words swaps those of the sums.
    """
    words, whole = -(-data.size // 2), data.size // (2 * _ROW) * (2 * _ROW)
    table = data[:whole].view("<u2").reshape(-1, _ROW)
    last = np.zeros(2 * _ROW, np.uint8)
    last[: data.size - whole] = data[whole:]
    wide = np.uint32 if len(table) < 2**16 else np.uint64
    rows = np.append(table.sum(axis=1, dtype=wide), last.view("<u2").sum(dtype=wide))
    columns = table.sum(axis=0, dtype=wide) + last.view("<u2")
    simple = int(rows.sum(dtype=np.uint64))
    places = _ROW * _moment(rows) + _moment(columns)  # each word times how many are before it
    return _reduced(words * simple - places) << 16 | _reduced(simple)


def _moment(values: NDArray[Any]) -> int:
    return int(np.arange(values.size, dtype=np.uint64) @ values)


def _reduced(total: int) -> int:
    """A sum as it is stored: modulo 65,535, which stands for 0 unless all was 0; bytes swapped."""
    value = (total - 1) % 65535 + 1 if total else 0
    return (value & 0xFF) << 8 | value >> 8


def _with_checksum(data: Bytes, parameters: tuple[int, ...]) -> Bytes:
    checksum = fletcher32(data).to_bytes(4, "little")
    return np.concatenate([data, np.frombuffer(checksum, np.uint8)])


def _shuffled(data: Bytes, parameters: tuple[int, ...]) -> Bytes:
    """All first bytes of values, then all second ones, and so on; what is not a whole value stays at the end."""
    size = parameters[0]
    whole = data.size // size * size
    out = np.empty_like(data)
    out[:whole].reshape(size, -1)[...] = data[:whole].reshape(-1, size).T
    out[whole:] = data[whole:]
    return out


def _deflated(data: Bytes, parameters: tuple[int, ...]) -> Bytes:
    """The level that the file declares is zlib's, and says nothing to a reader."""
    return np.frombuffer(isal_zlib.compress(data, _LEVEL), np.uint8)


def _without_checksum(data: Bytes, parameters: tuple[int, ...]) -> Bytes:
    rest = data[:-4]
    if data.size < 4 or fletcher32(rest) != int.from_bytes(data[-4:].tobytes(), "little"):
        raise ValueError("a checksum that does not match")
    return rest


def _unshuffled(data: Bytes, parameters: tuple[int, ...]) -> Bytes:
    size = parameters[0]
    whole = data.size // size * size
    out = np.empty_like(data)
    out[:whole].reshape(-1, size)[...] = data[:whole].reshape(size, -1).T
    out[whole:] = data[whole:]
    return out


def _inflated(data: Bytes, parameters: tuple[int, ...]) -> Bytes:
    try:
        return np.frombuffer(isal_zlib.decompress(data), np.uint8)
    except isal_zlib.error as error:  # type: ignore[misc]
        raise ValueError(str(error)) from error


_FILTERS = {1: _deflated, 2: _shuffled, 3: _with_checksum}
_INVERSES = {1: _inflated, 2: _unshuffled, 3: _without_checksum}
