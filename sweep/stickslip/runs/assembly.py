"""Blocks put together into one dataset on disk, a chunk at a time: memory does not grow with the map."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip import engine
from stickslip.config.grid import Grid
from stickslip.dataset.build import map_template
from stickslip.dataset.provenance import INCOMPLETE, provenance
from stickslip.engine import Options, Progress, Results
from stickslip.errors import DamagedBlockError
from stickslip.files import writing
from stickslip.runs.maps import MapStudy
from stickslip.runs.regions import aligned, extent, regions
from stickslip.runs.work import Work
from stickslip.runs.workdir.lock import Notice
from stickslip.runs.workdir.parts import Parts

if TYPE_CHECKING:
    from stickslip.refinement import RefinedMap

IN_MEMORY = 2**20  # cells; smaller maps are written at once, which spares loading dask
_REMEMBERED = 2  # blocks; a chunk may begin in one and end in the next
_zarr_config = threading.Lock()  # settings of Zarr are those of all threads, and are read when a group is opened


@dataclass(frozen=True)
class Canvas:
    """A map to be written range by range. columns : names and types of its variables. cells : results of a range."""

    grid: Grid
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

    def __init__(self, parts: Parts, work: Work, repair: Callable[[int], Results] | None, notice: Notice) -> None:
        self._parts, self._work, self._repair, self._notice = parts, work, repair, notice
        self._remembered: OrderedDict[int, Results] = OrderedDict()
        self.missing: dict[int, int] = {}

    def item(self, number: int) -> tuple[Results, int]:
        """The block of an item, and the number of the item in it."""
        block, at = divmod(number, self._parts.blocks.length)
        return self._block(block), at

    def blocks(self) -> Sequence[Results]:
        """The results of all blocks, in order, each read when it is asked for."""
        return _Loaded(self._load, self._parts.blocks.count)

    def cells(self, cells: range) -> Results:
        """The results of a range of items that have one value each in every column."""
        length = self._parts.blocks.length
        found = []
        for number in range(cells.start // length, -(-cells.stop // length)):
            of_block = self._parts.blocks.cells(number)
            start, stop = max(cells.start, of_block.start), min(cells.stop, of_block.stop)
            part = slice(start - of_block.start, stop - of_block.start)
            found.append({name: values[part] for name, values in self._block(number).items()})
        if len(found) == 1:
            return found[0]
        return {name: np.concatenate([part[name] for part in found]) for name in found[0]}

    def _block(self, number: int) -> Results:
        if number not in self._remembered:
            self._remembered[number] = self._load(number)
            if len(self._remembered) > _REMEMBERED:
                self._remembered.popitem(last=False)
        return self._remembered[number]

    def _load(self, number: int) -> Results:
        try:
            return self._parts.load(number, self._work)
        except FileNotFoundError:
            pass
        except DamagedBlockError as damage:
            again = "computed again" if self._repair else "left out"
            self._notice(f"block {number} of {self._parts.where} is damaged: {damage}; {again}")
            self._parts.drop(number)
        if self._repair:
            return self._repair(number)
        results = self._work.known_only(number)
        of_map = self._work.known is not None
        items = len(self._parts.blocks.cells(number))
        self.missing[number] = int((results["regime"] == 0).sum()) if of_map else items
        return results


def assemble(gathered: Gathered, parts: Parts, work: Work, output: Path, progress: Progress | None) -> None:
    """Write the map of a store to `output`, all or nothing. Raises StoreError."""
    kernels = parts.manifest.kernels
    action = "run" if len(kernels) == 1 else f"run, by kernels {' and '.join(kernels)}"
    attributes = provenance(work.config.to_yaml(), title=work.config.title, action=action)
    canvas = _canvas(gathered, work)
    if canvas is None or canvas.grid.size <= IN_MEMORY:
        dataset = work.study.dataset(gathered.blocks(), attributes)
        dataset.attrs |= _lacking(gathered, work)
        writing.write(dataset, output)
        return
    if refined := _refined(work):
        attributes |= refined.findings(gathered.blocks())
    template = map_template(canvas.grid, canvas.columns, attributes | _lacking(gathered, work))
    fill = _fill_zarr if output.suffix == ".zarr" else _fill_netcdf
    writing.write(template, output, lambda file: fill(file, canvas, work.options, progress))


def _canvas(gathered: Gathered, work: Work) -> Canvas | None:
    """The map that a study makes, if it makes one."""
    study = work.study
    if isinstance(study, MapStudy):
        return Canvas(study.grid, study.columns, gathered.cells)
    if refined := _refined(work):
        return Canvas(refined.grid, refined.map_columns, refined.painter(gathered.item).cells)
    return None


def _refined(work: Work) -> RefinedMap | None:
    """The study, if it is a map of which few cells are computed."""
    if work.config.refine is None:
        return None
    from stickslip.refinement import RefinedMap

    assert isinstance(work.study, RefinedMap)
    return work.study


def _lacking(gathered: Gathered, work: Work) -> dict[str, str]:
    """What is to be said of missing items; the cells of a plain map say it themselves."""
    missing = sum(gathered.missing.values())
    if not missing or isinstance(work.study, MapStudy):
        return {}
    return {INCOMPLETE: f"{missing:,} of {work.size:,} {work.study.counted} are not computed"}


def _by_region(
    canvas: Canvas, chunks: tuple[int, ...], progress: Progress | None
) -> Iterator[tuple[tuple[slice, ...], str, np.ndarray[Any, Any]]]:
    """Regiones of the map with their values, variable by variable, chunk after chunk."""
    shape, size = canvas.grid.shape, canvas.grid.size
    for cells in aligned(shape, chunks):
        results = canvas.cells(cells)
        for region in regions(cells.start, cells.stop, shape):
            first = int(np.ravel_multi_index([side.start for side in region], shape)) - cells.start if shape else 0
            count = int(np.prod(extent(region)))
            for name, values in results.items():
                yield region, name, values[first : first + count].reshape(extent(region))
        if progress:
            progress(cells.stop, size)


def _fill_netcdf(file: Path, canvas: Canvas, options: Options, progress: Progress | None) -> None:
    from stickslip.files.chunks import ChunkFile  # here, since it loads h5py

    with ChunkFile(file, options.threads) as target:
        for region, name, values in _by_region(canvas, target.layout("regime").chunks, progress):
            target.write(name, values, [side.start for side in region])


def _fill_zarr(file: Path, canvas: Canvas, options: Options, progress: Progress | None) -> None:
    """Chunks are files of their own, so that threads compress several at a time."""
    import zarr

    with _zarr_config, zarr.config.set({"array.write_empty_chunks": True}):  # a chunk that is not there is a lost one
        target = zarr.open_group(file, mode="r+")
        arrays: dict[str, Any] = {name: target[name] for name in canvas.columns}
    threads = options.threads or engine.processors()
    chunks = tuple(arrays["regime"].chunks)
    with ThreadPoolExecutor(threads) as pool:
        pending = []
        for region, name, values in _by_region(canvas, chunks, progress):
            pending.append(pool.submit(arrays[name].__setitem__, region, values))
            if len(pending) > 2 * len(arrays) + threads:
                pending.pop(0).result()
        for future in pending:
            future.result()
