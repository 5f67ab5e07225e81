"""The file of a finished block, which a reader accepts only after checking it.

    a line that names the format | length of the header, 4 bytes | header, JSON | columns | SHA-256 of all before

Everything is little-endian; a column holds raw values, or one value that all cells share (NaN, mostly). Nothing is
compressed: measured, zlib at its fastest with shuffled bytes took a quarter of the time of computing, to save three
fifths of a temporary folder.
"""

from __future__ import annotations

import hashlib
import json
import struct
from collections.abc import Mapping
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import DamagedBlockError

MAGIC = b"stickslip block 1\n"
_TYPES = ("|i1", "<i4", "<f8")  # of columns; nothing else is read
_LENGTH = struct.Struct("<I")
_DIGEST = 32
_LONGEST_HEADER = 2**20

Header = dict[str, Any]
Columns = dict[str, NDArray[Any]]


def encode(header: Mapping[str, Any], columns: Mapping[str, NDArray[Any]]) -> bytes:
    """The bytes of a block file: `header` as JSON, `columns` of one length each."""
    described, data = [], []
    for name, values in columns.items():
        plain = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
        shared = plain.size > 1 and _all_equal(plain)
        described.append({"name": name, "type": plain.dtype.str, "cells": plain.size, "shared": shared})
        data.append(plain[:1].tobytes() if shared else plain.tobytes())
    text = json.dumps({**header, "columns": described}).encode()
    whole = b"".join([MAGIC, _LENGTH.pack(len(text)), text, *data])
    return whole + hashlib.sha256(whole).digest()


def decode(data: bytes) -> tuple[Header, Columns]:
    """Header and columns of a block file. Raises DamagedBlockError."""
    body, digest = memoryview(data)[:-_DIGEST], data[-_DIGEST:]
    if not data.startswith(MAGIC):
        raise DamagedBlockError("it is not a block file")
    if hashlib.sha256(body).digest() != digest:
        raise DamagedBlockError("its checksum does not match")
    try:
        start = len(MAGIC) + _LENGTH.size
        (length,) = _LENGTH.unpack(body[len(MAGIC) : start])
        if length > _LONGEST_HEADER:
            raise ValueError("a header of that length")
        header = json.loads(bytes(body[start : start + length]))
        return header, _columns(header.pop("columns"), body[start + length :])
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError, struct.error) as error:
        raise DamagedBlockError(f"its header is invalid ({error})") from None


def _columns(described: list[Header], data: memoryview) -> Columns:
    columns, place = {}, 0
    for column in described:
        if column["type"] not in _TYPES:
            raise ValueError(f"a column of type {column['type']!r}")
        dtype, cells = np.dtype(column["type"]), int(column["cells"])
        stored = prod((1 if column["shared"] else cells, dtype.itemsize))
        values = np.frombuffer(data[place : place + stored], dtype)
        columns[str(column["name"])] = np.broadcast_to(values, cells) if column["shared"] else values
        place += stored
    if place != len(data):
        raise ValueError("more data than columns")
    return columns


def _all_equal(values: NDArray[Any]) -> bool:
    """Whether all values have the same bits; NaN may be shared."""
    bits = values.view(f"u{values.itemsize}")
    return bool(bits[0] == bits[-1] and (bits == bits[0]).all())
