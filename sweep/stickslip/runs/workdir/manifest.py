"""The manifest of a working store: what is computed there, cut how, by what.

It is JSON with a checksum of its own, written before the first block and changed only when other kernels resume the
run. Everything in it but the versions follows from the configuration.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from datetime import UTC, datetime
from typing import Any

from stickslip._version import __version__
from stickslip.config.model import Config
from stickslip.config.reader import parse_config
from stickslip.errors import DamagedManifestError
from stickslip.runs.blocks import EVERY_NTH, SPREAD, Blocks, Deal
from stickslip.runs.settings import fingerprint

NAME = "manifest.json"
FORMAT = 1
_ADDED = ("plane", "written_in", "deal", "fresh")  # what stores of earlier versions lack


@dataclass(frozen=True)
class Manifest:
    """What `encode` writes.

    fingerprint : of everything that the numbers depend on. configuration : resolved, as YAML text.
    kernels : digests of the kernels that computed blocks, in the order they came.
    """

    fingerprint: str
    configuration: str
    shape: tuple[int, ...]
    size: int
    block: int
    count: int
    kernels: tuple[str, ...]
    stickslip: str
    software: str
    created: str
    plane: int = 0  # of `Blocks`; 0 for all of them, which is what stores had before
    written_in: Mapping[str, str] = field(default_factory=dict)  # units of the configuration; stores had none before
    deal: Deal = EVERY_NTH  # how shards get their blocks
    fresh: bool = False  # begun to replace whatever result there is, and not finished
    format: int = FORMAT

    @property
    def blocks(self) -> Blocks:
        """Return how the cells are cut."""
        return Blocks(self.size, self.block, self.plane or self.size)

    def config(self, where: str) -> Config:
        """The configuration, read again; `where` names the store in messages. Raises ConfigError."""
        return parse_config(self.configuration, f"{where}/{NAME}").shown_in(self.written_in)


def make(
    config: Config, shape: tuple[int, ...], blocks: Blocks, kernels: str, software: str, fresh: bool = False
) -> Manifest:
    """The manifest of a new store."""
    created = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return Manifest(
        fingerprint(config), config.to_yaml(), shape, blocks.size, blocks.length, blocks.count, (kernels,),
        __version__, software, created, blocks.plane, config.written_in, SPREAD, fresh,
    )  # fmt: skip


def encode(manifest: Manifest) -> bytes:
    """The bytes of a manifest."""
    plain = asdict(manifest)
    return json.dumps({**plain, "checksum": _checksum(plain)}, indent=1, ensure_ascii=False).encode()


def decode(data: bytes) -> Manifest:
    """The manifest these bytes are. Raises DamagedManifestError; other formats are read as far as they say so."""
    try:
        plain = json.loads(data.decode())
        if plain.pop("checksum") != _checksum(plain):
            raise ValueError("its checksum does not match")
        known = {one.name: plain[one.name] for one in fields(Manifest) if one.name in plain or one.name not in _ADDED}
        known |= {name: tuple(known[name]) for name in ("shape", "kernels")}
        return Manifest(**known)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        reason = str(error) if "checksum does not" in str(error) else "it is not whole"
        raise DamagedManifestError(reason) from None


def _checksum(plain: Mapping[str, Any]) -> str:
    text = json.dumps(plain, sort_keys=True, ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()
