"""Blocks put together into one dataset on disk, a chunk at a time: memory does not grow with the map.

A block of a plain map is a chunk of the file, packed as the file wants it: it is checked, and put in as it is.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from stickslip.dataset.build import map_template
from stickslip.dataset.provenance import INCOMPLETE, provenance
from stickslip.engine import Progress, Results, in_order
from stickslip.errors import DamagedBlockError
from stickslip.files import writing
from stickslip.files.locations import Check, Location
from stickslip.files.netcdf import NetcdfChunks
from stickslip.runs.blocks import Blocks, blocks_of_chunks, chunks_of, extent, regions
from stickslip.runs.work import MapStudy, Work
from stickslip.runs.workdir.block_store import BlockStore
from stickslip.runs.workdir.encoding import StoredColumn, column
from stickslip.runs.workdir.lock import Notice
from stickslip.vocabulary.cells import Cells

if TYPE_CHECKING:
    from stickslip.studies.refine import RefinedMap

_REMEMBERED = 2  # blocks; a chunk may begin in one and end in the next


class Canvas(NamedTuple):
    """A map to be written range by range. columns : names and types of its variables. cells : results of a range."""

    grid: Cells
    columns: Mapping[str, np.dtype[Any]]
    cells: Callable[[range], Results]


@dataclass(frozen=True)
class _Loaded(Sequence[Results]):
    """The results of blocks, none of which is held."""

    load: Callable[[int], Results]
    size: int

    def __len__(self) -> int:
        return self.size

    def __getitem__(self, number: Any) -> Any:
        return self.load(range(self.size)[number])


class Gathered:
    """The results of any range of items, from the blocks of a store.

    A damaged block is said and removed; it is never used. What is missing or was damaged is computed by `repair`;
    without it, cells that the work knows from an older map are taken from there, and others are "not computed".
    missing : how many are not computed, by block.
    """

    def __init__(self, store: BlockStore, work: Work, repair: Callable[[int], Results] | None, notice: Notice) -> None:
        self._store, self._work, self._repair, self._notice = store, work, repair, notice
        self._block = lru_cache(_REMEMBERED)(self._load)
        self.missing: dict[int, int] = {}

    def item(self, number: int) -> tuple[Results, int]:
        """The block of an item, and the number of the item in it."""
        block = self._store.blocks.at(number)
        return self._block(block), number - self._store.blocks.cells(block).start

    def blocks(self) -> Sequence[Results]:
        """The results of all blocks, in order, each read when it is asked for."""
        return _Loaded(self._load, self._store.blocks.count)

    def cells(self, cells: range) -> Results:
        """The results of a range of items that have one value each in every column."""
        pieces = []
        for number in range(self._store.blocks.at(cells.start), self._store.blocks.at(cells.stop - 1) + 1):
            of_block = self._store.blocks.cells(number)
            start, stop = max(cells.start, of_block.start), min(cells.stop, of_block.stop)
            part = slice(start - of_block.start, stop - of_block.start)
            pieces.append({name: values[part] for name, values in self._block(number).items()})
        if len(pieces) == 1:
            return pieces[0]
        return {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}

    def _load(self, number: int) -> Results:
        return {name: stored.values() for name, stored in self.columns(number, self.read(number)).items()}

    def read(self, number: int) -> Mapping[str, StoredColumn] | Exception:
        """The columns of a block as they are stored, or why it must not be used; by any thread."""
        try:
            return self._store.stored(number, self._work)
        except (FileNotFoundError, DamagedBlockError) as why:
            return why

    def columns(self, number: int, stored: Mapping[str, StoredColumn] | Exception) -> Mapping[str, StoredColumn]:
        """The columns that were `read`, or what stands for them."""
        if not isinstance(stored, Exception):
            return stored
        if isinstance(stored, DamagedBlockError):
            again = "computed again" if self._repair else "left out"
            self._notice(f"block {number} of {self._store.where} is damaged: {stored}; {again}")
            self._store.drop(number)
        if self._repair:
            results = self._repair(number)
        else:
            results = self._work.known_only(number)
            of_map, items = self._work.known is not None, len(self._store.blocks.cells(number))
            self.missing[number] = int((results["regime"] == 0).sum()) if of_map else items
        return {name: column(values) for name, values in results.items()}


def assemble(
    gathered: Gathered,
    store: BlockStore,
    work: Work,
    output: Location,
    progress: Progress | None,
    check: Check | None = None,
) -> None:
    """Write the map of a store to `output`, all or nothing. Raises StoreError, and what `check` raises at last."""
    kernels = store.manifest.kernels
    action = "run" if len(kernels) == 1 else f"run, by kernels {' and '.join(kernels)}"
    attributes = provenance(work.config.to_yaml(), title=work.config.title, action=action)
    study, canvas = work.study, None
    refined = (
        cast("RefinedMap", study) if getattr(work.config.study, "is_map", False) else None
    )  # few of its cells are computed
    if isinstance(study, MapStudy):
        canvas = Canvas(study.grid, study.columns, gathered.cells)
    elif refined:
        canvas = Canvas(refined.grid, refined.map_columns, refined.painter(gathered.item).cells)
    if canvas is None or not canvas.grid.shape:
        dataset = study.dataset(gathered.blocks(), attributes)
        dataset.attrs |= _lacking(gathered, work)
        writing.write(dataset, output, check=check)
        return
    if refined:
        attributes |= refined.findings(gathered.blocks())
    template = map_template(canvas.grid, canvas.columns, attributes | _lacking(gathered, work))
    copied = not refined and output.suffix == ".nc"
    chunks = chunks_of(store.blocks, canvas.grid.shape) if copied else None
    threads = work.options.threads

    def fill(file: Any) -> None:
        if chunks:
            _copy_blocks(gathered, store.blocks, canvas.grid, file, threads, progress)
        else:
            _write_by_region(canvas, file, progress)

    writing.write(template, output, fill, chunks, check, threads)


def _lacking(gathered: Gathered, work: Work) -> dict[str, str]:
    """The attribute about missing items; the cells of a plain map say it themselves."""
    missing = sum(gathered.missing.values())
    if not missing or isinstance(work.study, MapStudy):
        return {}
    return {INCOMPLETE: f"{missing:,} of {work.size:,} {work.study.counted} are not computed"}


def _write_by_region(canvas: Canvas, target: Any, progress: Progress | None) -> None:
    """The map chunk after chunk, all variables of each. target : a `NetcdfChunks` or `ZarrChunks`."""
    shape, size = canvas.grid.shape, canvas.grid.size
    chunks = blocks_of_chunks(target.chunks("regime"), shape)
    for number in range(chunks.count):
        cells = chunks.cells(number)
        (region,) = regions(cells.start, cells.stop, shape)
        for name, values in canvas.cells(cells).items():
            target.write(name, values.reshape(extent(region)), [side.start for side in region])
        if progress:
            progress(cells.stop, size)


def _copy_blocks(
    gathered: Gathered,
    blocks: Blocks,
    grid: Cells,
    target: NetcdfChunks,
    threads: int | None,
    progress: Progress | None,
) -> None:
    """Blocks that are chunks, in their order, read and checked by threads."""

    @lru_cache(maxsize=64)  # NaN and the like: a chunk that is packed once
    def of_one_value(name: str, value: bytes) -> Any:
        layout = target.layout(name)
        return layout.packed(np.full(layout.chunks, np.frombuffer(value, layout.dtype)))

    for number, block in enumerate(in_order(gathered.read, range(blocks.count), threads)):
        cells = blocks.cells(number)
        (region,) = regions(cells.start, cells.stop, grid.shape)
        origin = [side.start for side in region]
        for name, stored in gathered.columns(number, block).items():
            if stored.is_one_value():
                target.put(name, origin, of_one_value(name, bytes(stored.data)), stored.content())
            elif stored.packing == target.layout(name).packing:
                target.put(name, origin, stored.data, stored.content())
            else:
                target.write(name, stored.values().reshape(extent(region)), origin)
        if progress:
            progress(cells.stop, grid.size)
