"""The working store of a run: a manifest and a file per finished block, `FILE.parts` beside the result; in the folder
where the program runs if the result is behind a URL.

A block exists once its file does; it is accepted once its checksum, its run and its cells agree. No state
is kept anywhere else, so there is nothing to repair after a crash but to compute what is missing.
"""

import json
import re
import shlex
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stickslip import engine, errors
from stickslip._version import __version__
from stickslip.config.model import Config
from stickslip.config.reader import parse_config
from stickslip.files.chunks import PLAIN
from stickslip.files.locations import Location
from stickslip.files.targets import TEMPORARY, Folder
from stickslip.runs import formats
from stickslip.runs.formats import Manifest, Notice, StoredColumn, is_lock
from stickslip.runs.work import Block, Work, described, differences, fingerprint

SUFFIX = ".parts"
START_OVER = "{fresh} starts over and replaces it; {output} names another file"
SAME_SETTINGS = "give the same settings (--set) as the run that began it: {keys}"
_BLOCK, _FAILED = re.compile(r"block-(\d{8,})"), re.compile(r"failed-(\d{8,})\.json")


def beside(output: Location) -> Path:
    """Place of the working store of a result, unless another one is named."""
    name = output.name + SUFFIX
    return output.with_name(name) if isinstance(output, Path) else Path(name)


@dataclass(frozen=True)
class Failure:
    """A block that could not be computed."""

    block: int
    message: str
    traceback: str


class BlockStore:
    """An open working store. packing : how its blocks are packed from now on."""

    def __init__(self, folder: Folder, manifest: Manifest, packing: str = PLAIN) -> None:
        self.folder, self.manifest, self.blocks, self.packing = folder, manifest, manifest.blocks, packing

    @property
    def where(self) -> str:
        """The place, for people."""
        return self.folder.where

    def finished(self) -> set[int]:
        """Numbers of the blocks that are there."""
        return self._numbers(_BLOCK)

    def failed(self) -> set[int]:
        """Numbers of the blocks that failed, and have not been computed since."""
        return self._numbers(_FAILED) - self.finished()

    def cells(self, numbers: Iterable[int]) -> int:
        """The number of cells that these blocks have."""
        return sum(len(self.blocks.cells(number)) for number in numbers)

    def save(self, number: int, block: Block) -> None:
        """Put a computed block on the disk."""
        self.put(number, self.packed(number, block))

    def packed(self, number: int, block: Block) -> bytes:
        """The bytes of the file of a computed block."""
        by = {"reused": block.reused, "stickslip": __version__, "kernels": self.manifest.kernels[-1]}
        return formats.block_bytes(self._identity(number) | by, block.results, self.packing, self.blocks.length)

    def put(self, number: int, data: bytes, work: Work | None = None) -> None:
        """Put a `packed` block on the disk. work : of one from elsewhere; raises DamagedBlockError for another."""
        if work is not None:
            self.stored(number, work, data)
        self.folder.write(_block_name(number), data)

    def stored(self, number: int, work: Work, data: bytes | None = None) -> dict[str, StoredColumn]:
        """The columns of a block, of the file or of its bytes. Raises FileNotFoundError, or DamagedBlockError for what
        must not be used.
        """
        header, columns = formats.opened_block(self.folder.read(_block_name(number)) if data is None else data)
        expected = self._identity(number)
        if wrong := [name for name, value in expected.items() if header.get(name) != value]:
            raise errors.DamagedBlockError(f"it belongs elsewhere (its {wrong[0]} is {header.get(wrong[0])!r})")
        types = {name: column.dtype for name, column in columns.items()}
        if not work.fits(number, types, [column.cells for column in columns.values()]):
            raise errors.DamagedBlockError("its columns are not those of this run")
        return columns

    def drop(self, number: int) -> None:
        """Remove a block, finished or failed, so that it counts as missing."""
        self.folder.remove(_block_name(number))
        self.clear_failure(number)

    def note_failure(self, number: int, error: Exception) -> None:
        """Record why a block could not be computed, here or elsewhere."""
        failure = error if isinstance(error, errors.UncomputedError) else errors.UncomputedError.of(error)
        record = {
            "run": self.manifest.fingerprint, "block": number, "message": failure.message,
            "traceback": failure.trace, "stickslip": __version__,
        }  # fmt: skip
        self.folder.write(_failed_name(number), json.dumps(record, ensure_ascii=False).encode())

    def failure(self, number: int) -> Failure:
        """Why a block could not be computed."""
        try:
            record = json.loads(self.folder.read(_failed_name(number)))
            return Failure(number, str(record["message"]), str(record["traceback"]))
        except (FileNotFoundError, ValueError, TypeError, KeyError):
            return Failure(number, "the record of what happened is damaged", "")

    def clear_failure(self, number: int) -> None:
        """Forget that a block failed."""
        self.folder.remove(_failed_name(number))

    def is_complete(self) -> bool:
        """Tell whether no block is missing."""
        return len(self.finished()) == self.blocks.count

    def no_longer_fresh(self) -> None:
        """Note that a fresh run is finished: another one begins again."""
        if self.manifest.fresh:
            self.manifest = replace(self.manifest, fresh=False)
            self.write_manifest()

    def write_manifest(self) -> None:
        """Put the manifest on the disk."""
        self.folder.write(formats.MANIFEST, self.manifest.encoded())

    def config(self) -> Config:
        """The configuration the store was made from. Raises StoreError."""
        try:
            text, source = self.manifest.configuration, f"{self.where}/{formats.MANIFEST}"
            return parse_config(text, source).shown_in(self.manifest.written_in)
        except errors.ConfigError as error:
            message = f"{self.where}: made from a configuration that this version does not read\n{error}"
            raise errors.StoreError(message) from None

    def _identity(self, number: int) -> dict[str, Any]:
        """What a block says of itself."""
        cells = self.blocks.cells(number)
        return {"run": self.manifest.fingerprint, "block": number, "start": cells.start, "stop": cells.stop}

    def _numbers(self, pattern: re.Pattern[str]) -> set[int]:
        numbers = {int(match[1]) for name in self.folder.names() if (match := pattern.fullmatch(name))}
        return {number for number in numbers if number < self.blocks.count}


def _block_name(number: int) -> str:
    return f"block-{number:08d}"


def _failed_name(number: int) -> str:
    return f"failed-{number:08d}.json"


def remove_temporary(folder: Folder) -> None:
    """Remove the temporary files of runs that were killed. Only for who holds the store alone."""
    for name in filter(_is_temporary, folder.names()):
        folder.remove(name)


def clear(folder: Folder) -> None:
    """Remove blocks, records of failures and left-over temporary files."""
    for name in folder.names():
        if _BLOCK.fullmatch(name) or _FAILED.fullmatch(name) or _is_temporary(name):
            folder.remove(name)


def delete(folder: Folder) -> None:
    """Remove everything that is ours except the locks."""
    clear(folder)
    folder.remove(formats.MANIFEST)


def _is_temporary(name: str) -> bool:
    return name.startswith(".") and name.endswith(TEMPORARY)


# --- opening ----------------------------------------------------------------------------------------------------------


def check_ours(folder: Folder) -> None:
    """Raise StoreError for a folder that holds other things and no manifest: it is not touched."""
    names = folder.names()
    ours = (formats.MANIFEST in names, *(bool(_BLOCK.fullmatch(n) or is_lock(n)) for n in names))
    if names and not any(ours) and not all(map(_is_temporary, names)):
        raise errors.StoreError(
            f"{folder.where}: holds other things ({names[0]}, ...) and no working store, so it is left alone",
            hint="name another place with {store}",
        )


def is_empty(folder: Folder) -> bool:
    """Tell whether a folder holds nothing but what a run leaves that is killed while it removes its store."""
    return all(is_lock(name) or _is_temporary(name) for name in folder.names())


def find(folder: Folder) -> BlockStore:
    """The store in a folder, whatever it computes. Raises StoreError."""
    store = found_at(folder)
    if store is None:
        check_ours(folder)
        raise errors.StoreError(f"{folder.where}: no working store there")
    return store


def prepare(
    folder: Folder, work: Work, fresh: bool, notice: Notice, packing: str = PLAIN, shards: int = 0
) -> BlockStore:
    """The store of this work in a folder that is locked: created, resumed, or begun again if `fresh`.

    A fresh run marks its store, and goes on with one that is marked so; with other kernels it begins again. packing :
    of the blocks that are computed now; those of a store that is resumed are cut as it says. shards : into how many
    they are dealt. Raises StoreError for a store of another configuration, or of another major version.
    """
    try:
        before = found_at(folder)
    except errors.StoreError:
        if not fresh:
            raise
        before = None
    digest = engine.kernels_digest()
    if fresh and before is not None:
        there, same = before.manifest, (fingerprint(work.config), work.size, digest)
        goes_on = there.fresh and same == (there.fingerprint, there.blocks.size, there.kernels[-1])
        before = before if goes_on else None
    if before is None:
        manifest = Manifest.of(work, fresh)
        if fresh:
            clear(folder)
    else:
        check_same(before, work)
        manifest = before.manifest
        if digest != manifest.kernels[-1]:
            if before.finished():
                notice("the kernels were changed since this run began; blocks of both will make up the map")
            manifest = replace(manifest, kernels=(*manifest.kernels, digest))
    store = BlockStore(folder, replace(manifest, shards=shards), packing)
    if before is None or store.manifest != before.manifest:
        store.write_manifest()
    return store


def check_same(store: BlockStore, work: Work, no_fresh: bool = False) -> None:
    """Raise StoreError unless a store holds blocks of this work.

    no_fresh : for who shares or only reads it, and cannot begin it again.
    """
    there = store.manifest
    if there.fingerprint != fingerprint(work.config) or there.blocks.size != work.size:
        place = shlex.quote(store.where).replace("{", "{{").replace("}", "}}")  # the hint is a template
        remedy = f"{SAME_SETTINGS}, or name the store: stickslip collect {place}"
        refuse(store.where, store.config(), work.config, remedy if no_fresh else START_OVER)


def refuse(where: str, there: Config, here: Config, remedy: str = START_OVER) -> None:
    """Raise StoreError: `where` was made from another configuration. remedy : with {keys} for those that differ."""
    differing = differences(there, here)
    keys = described(differing) or "  the number of its cells"
    hint = remedy.replace("{keys}", ", ".join(differing))
    raise errors.StoreError(f"{where}: made from another configuration, which differs in\n{keys}", hint=hint)


def same_major(version: str) -> bool:
    """Tell whether a version resumes what this one began: the same major version."""
    return version.partition(".")[0] == __version__.partition(".")[0]


def found_at(folder: Folder) -> BlockStore | None:
    """The store in a folder, None if there is none. Raises StoreError for one that is damaged, or too old or new."""
    try:
        manifest = formats.decoded(folder.read(formats.MANIFEST))
    except FileNotFoundError:
        return None
    except errors.DamagedManifestError as damaged:
        message = f"{folder.where}/{formats.MANIFEST}: damaged, {damaged}"
        raise errors.StoreError(message, hint="{run} with {fresh} starts over") from None
    if manifest.format != formats.FORMAT or not same_major(manifest.stickslip):
        raise errors.StoreError(
            f"{folder.where}: made by stickslip {manifest.stickslip}, and this is {__version__}",
            hint="resume with that version, or start over: {run} with {fresh}",
        )
    return BlockStore(folder, manifest)
