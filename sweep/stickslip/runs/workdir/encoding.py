"""The file of a finished block, which a reader accepts only after checking it.

    a line that names the format | header, a line of JSON | columns | SHA-256 of all before

Everything is little-endian; a column is one value that all cells share (NaN, mostly), or packed as the header says: as
a chunk of the file that is to be written, so that it goes there as it is (`files/filters.py`).
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import DamagedBlockError
from stickslip.files.filters import PLAIN, packed, unpacked
from stickslip.files.seal import content_of

MAGIC = b"stickslip block 2\n"
_TYPES = ("|i1", "<i4", "<f8")  # of columns; nothing else is read
_DIGEST = 32
_ONE = "one value"

Header = dict[str, Any]


@dataclass(frozen=True)
class StoredColumn:
    """A column as it is stored. packing : of `data`, which may hold more than the values of its `cells`.

    sha256 : of the values, as `content` gives it; empty where it is not known yet.
    """

    dtype: np.dtype[Any]
    cells: int
    packing: str
    data: memoryview
    sha256: str = ""

    def is_one_value(self) -> bool:
        """Tell whether all cells share one value, and `data` is that."""
        return self.packing == _ONE

    def content(self) -> bytes:
        """The digest of the values (`files/seal.py`), without unpacking them if whoever packed them noted it."""
        return bytes.fromhex(self.sha256) if self.sha256 else content_of(self.values())

    def values(self) -> NDArray[Any]:
        """One value per cell. Raises ValueError for data that are not of that kind."""
        if self.is_one_value():
            return np.broadcast_to(np.frombuffer(self.data, self.dtype), self.cells)
        values = unpacked(self.data, self.packing, self.dtype)[: self.cells]
        if values.size < self.cells:
            raise ValueError("more cells than data")
        return values


def column(values: NDArray[Any], packing: str = PLAIN, length: int = 0) -> StoredColumn:
    """Values as they are stored; those of a chunk are filled up to `length`."""
    plain = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
    if plain.size > 1 and _all_equal(plain):
        return StoredColumn(plain.dtype, plain.size, _ONE, memoryview(plain[:1].tobytes()))
    whole = plain
    if packing != PLAIN and plain.size < length:
        whole = np.concatenate([plain, np.zeros(length - plain.size, plain.dtype)])
    return StoredColumn(plain.dtype, plain.size, packing, memoryview(packed(whole, packing)))  # type: ignore[arg-type]


def encode(
    header: Mapping[str, Any], columns: Mapping[str, NDArray[Any]], packing: str = PLAIN, length: int = 0
) -> bytes:
    """The bytes of a block file: `header` as JSON, `columns`, packed as chunks of `length` cells."""
    stored = {name: column(values, packing, length) for name, values in columns.items()}
    described = [
        {"name": name, "type": c.dtype.str, "cells": c.cells, "packing": c.packing, "bytes": c.data.nbytes,
         "sha256": content_of(columns[name]).hex()}
        for name, c in stored.items()
    ]  # fmt: skip
    text = json.dumps({**header, "columns": described}).encode()
    whole = b"".join([MAGIC, text, b"\n", *(c.data for c in stored.values())])
    return whole + hashlib.sha256(whole).digest()


def opened(data: bytes) -> tuple[Header, dict[str, StoredColumn]]:
    """Header and columns of a block file, checked. Raises DamagedBlockError."""
    if not data.startswith(MAGIC):
        raise DamagedBlockError("it is not a block file")
    body = memoryview(data)[:-_DIGEST]
    if hashlib.sha256(body).digest() != data[-_DIGEST:]:
        raise DamagedBlockError("its checksum does not match")
    try:
        begin = data.index(b"\n", len(MAGIC)) + 1
        header = json.loads(data[len(MAGIC) : begin])
        return header, _columns(header.pop("columns"), body[begin:])
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        raise DamagedBlockError(f"its header is invalid ({error})") from None


def _columns(described: list[Header], data: memoryview) -> dict[str, StoredColumn]:
    columns, place = {}, 0
    for about in described:
        if about["type"] not in _TYPES:
            raise ValueError(f"a column of type {about['type']!r}")
        dtype, end = np.dtype(about["type"]), place + int(about["bytes"])
        if not place <= end <= len(data):
            raise ValueError("more columns than data")
        packing, sha256 = str(about["packing"]), str(about["sha256"])
        columns[str(about["name"])] = StoredColumn(dtype, int(about["cells"]), packing, data[place:end], sha256)
        place = end
    if place != len(data):
        raise ValueError("more data than columns")
    return columns


def _all_equal(values: NDArray[Any]) -> bool:
    """Tell whether all values have the same bits; NaN may be shared."""
    bits = values.view(f"u{values.itemsize}")
    return bool(bits[0] == bits[-1] and (bits == bits[0]).all())
