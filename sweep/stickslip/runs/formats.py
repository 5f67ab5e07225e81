"""The files of a working store: its manifest, and the blocks, which a reader accepts only after checking them.

The manifest says what is computed, cut how, by what. It is JSON with a checksum of its own, written before the first
block and changed only when other kernels resume the run. All in it but the versions follows from the configuration.

The identity of a run is its settings: the keys of a configuration that decide its results. The title, the execution
section, and of the output section all but `variables` do not; nor does the file a curve was fitted to, since the fitted
coefficients do. A result without some variables is another one: of it they can neither be taken, nor may they be lost
where it replaces one that holds them.

A block is

    a line that names the format | header, a line of JSON | columns | SHA-256 of all before

Everything is little-endian; a column is one value that all cells share (NaN, mostly), or packed as the header says: as
a chunk of the file that is to be written, so that it goes there as it is (`files/chunks.py`).
"""

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, astuple, dataclass, fields
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip._version import __version__
from stickslip.config.grid import options_of
from stickslip.config.model import Config
from stickslip.dataset.build import software
from stickslip.engine import columns, kernels_digest
from stickslip.errors import DamagedBlockError, DamagedManifestError
from stickslip.files.chunks import PLAIN, packed, unpacked
from stickslip.runs.work import Blocks, Work

MANIFEST = "manifest.json"
FORMAT = 2
_LONGEST = 60  # characters of a value that is shown
_VARIABLES = "output.variables"
_MAGIC = b"stickslip block 2\n"
_TYPES = ("|i1", "<i4", "<f8")  # of columns; nothing else is read
_DIGEST = 32
_ONE = "one value"
Header = dict[str, Any]


# --- the manifest -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Manifest:
    """The manifest of a store.

    fingerprint : of everything that the numbers depend on. configuration : resolved, as YAML text. cut : into blocks,
    as arguments of `Blocks`. kernels : digests of those that computed blocks, in the order they came.
    written_in : units of the configuration. fresh : begun to replace whatever result there is, and not finished.
    shards : into how many the blocks are dealt, by the last who worked on them; 0 for a whole run.
    """

    fingerprint: str
    configuration: str
    cut: tuple[int, int, int]
    kernels: tuple[str, ...]
    stickslip: str
    software: str
    created: str
    written_in: Mapping[str, str]
    fresh: bool = False
    shards: int = 0
    format: int = FORMAT

    @classmethod
    def of(cls, work: Work, fresh: bool = False) -> "Manifest":
        """That of a store which this process begins."""
        config, created = work.config, datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        return cls(
            fingerprint(config), config.to_yaml(), astuple(work.blocks), (kernels_digest(),), __version__, software(),
            created, config.written_in, fresh,
        )  # fmt: skip

    @property
    def blocks(self) -> Blocks:
        """The cells, cut into blocks."""
        return Blocks(*self.cut)

    def encoded(self) -> bytes:
        """Its bytes."""
        plain = asdict(self)
        return json.dumps({**plain, "checksum": _checksum(plain)}, indent=1, ensure_ascii=False).encode()


def decoded(data: bytes) -> Manifest:
    """The manifest these bytes are. Raises DamagedManifestError; other formats are read as far as they say so."""
    try:
        plain = json.loads(data.decode())
        is_whole = plain.pop("checksum") == _checksum(plain)
        known = {field.name: plain[field.name] for field in fields(Manifest) if field.name in plain}
        manifest = Manifest(**known | {name: tuple(known[name]) for name in ("cut", "kernels")})
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise DamagedManifestError("it is not whole") from None
    if not is_whole:
        raise DamagedManifestError("its checksum does not match")
    return manifest


def _checksum(plain: Mapping[str, Any]) -> str:
    text = json.dumps(plain, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


# --- the identity of a run --------------------------------------------------------------------------------------------


def settings(config: Config) -> dict[str, Any]:
    """The settings that numbers depend on, as plain data; axes as a list, since their order is that of the cells."""
    plain = {key: value for key, value in config.resolved().items() if key not in ("title", "output", "execution")}
    plain["friction"] = {key: value for key, value in plain["friction"].items() if key != "fit"}
    variables = config.output.variables  # None for all there are, whether they are named or not
    if variables is not None and config.is_map and set(variables) != set(columns(options_of(config))):
        plain["output"] = {"variables": list(variables)}
    return {**plain, "axes": [[name, axis] for name, axis in plain["axes"].items()]}


def fingerprint(config: Config) -> str:
    """Equal for configurations of equal results, and only for those."""
    return hashlib.sha256(json.dumps(settings(config), sort_keys=True).encode()).hexdigest()[:32]


def differences(there: Config, here: Config) -> dict[str, tuple[str, str]]:
    """The keys in which two configurations differ, with both values as text, first that of `there`."""
    old, new = (dict(_flat(settings(config))) for config in (there, here))
    absent = {name: "all" if name == _VARIABLES else "nothing" for name in old | new}
    pairs = {name: (old.get(name, nothing), new.get(name, nothing)) for name, nothing in absent.items()}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def described(differing: Mapping[str, tuple[str, str]]) -> str:
    """Differences for people, one a line."""
    short = {name: [text[:_LONGEST] + "..." * (len(text) > _LONGEST) for text in differing[name]] for name in differing}
    return "\n".join(f"  {name}: {there} there, {here} here" for name, (there, here) in short.items())


def _flat(plain: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, str]]:
    """`solver.rtol`, `1e-06` and so on for nested mappings."""
    for key, value in plain.items():
        if not path and key == "axes":
            yield "order of axes", ", ".join(name for name, _ in value)
            value = dict(value)
        if isinstance(value, dict):
            yield from _flat(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", json.dumps(value, ensure_ascii=False)


# --- blocks -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class StoredColumn:
    """A column as it is stored. packing : of `data`, which may hold more than the values of its `cells`."""

    dtype: np.dtype[Any]
    cells: int
    packing: str
    data: memoryview

    def is_one_value(self) -> bool:
        """Tell whether all cells share one value, and `data` is that."""
        return self.packing == _ONE

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
    bits = plain.view(f"u{plain.itemsize}")  # NaN may be shared
    if plain.size > 1 and bits[0] == bits[-1] and (bits == bits[0]).all():
        return StoredColumn(plain.dtype, plain.size, _ONE, memoryview(plain[:1].tobytes()))
    whole = plain
    if packing != PLAIN and plain.size < length:
        whole = np.concatenate([plain, np.zeros(length - plain.size, plain.dtype)])
    return StoredColumn(plain.dtype, plain.size, packing, memoryview(packed(whole, packing)))  # type: ignore[arg-type]


def block_bytes(
    header: Mapping[str, Any], results: Mapping[str, NDArray[Any]], packing: str = PLAIN, length: int = 0
) -> bytes:
    """The bytes of a block file: `header` as JSON, columns of results, packed as chunks of `length` cells."""
    stored = {name: column(values, packing, length) for name, values in results.items()}
    about = [
        {"name": name, "type": c.dtype.str, "cells": c.cells, "packing": c.packing, "bytes": c.data.nbytes}
        for name, c in stored.items()
    ]
    text = json.dumps({**header, "columns": about}).encode()
    whole = b"".join([_MAGIC, text, b"\n", *(c.data for c in stored.values())])
    return whole + hashlib.sha256(whole).digest()


def opened_block(data: bytes) -> tuple[Header, dict[str, StoredColumn]]:
    """Header and columns of a block file, checked. Raises DamagedBlockError."""
    if not data.startswith(_MAGIC):
        raise DamagedBlockError("it is not a block file")
    body = memoryview(data)[:-_DIGEST]
    if hashlib.sha256(body).digest() != data[-_DIGEST:]:
        raise DamagedBlockError("its checksum does not match")
    try:
        begin = data.index(b"\n", len(_MAGIC)) + 1
        header = json.loads(data[len(_MAGIC) : begin])
        return header, _columns(header.pop("columns"), body[begin:])
    except (ValueError, KeyError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        raise DamagedBlockError(f"its header is invalid ({error})") from None


def _columns(described: list[Header], data: memoryview) -> dict[str, StoredColumn]:
    stored, place = {}, 0
    for about in described:
        if about["type"] not in _TYPES:
            raise ValueError(f"a column of type {about['type']!r}")
        dtype, end = np.dtype(about["type"]), place + int(about["bytes"])
        if not place <= end <= len(data):
            raise ValueError("more columns than data")
        packing, cells = str(about["packing"]), int(about["cells"])
        stored[str(about["name"])] = StoredColumn(dtype, cells, packing, data[place:end])
        place = end
    if place != len(data):
        raise ValueError("more data than columns")
    return stored
