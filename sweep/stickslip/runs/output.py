"""The result of a run: what is there already, and blocks put together into one dataset.

A result at the same place is finished, to be extended, or not to be touched; its cells are taken over where they are
those of the new map, or of one whose axes were extended since. Blocks are written a chunk at a time: memory does not
grow with the map. A block of a plain map is a chunk of the file, packed as the file wants it: it is checked, and put in
as it is.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from math import prod
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip._version import __version__
from stickslip.config.grid import build_grid, quantity_of
from stickslip.config.model import Config
from stickslip.config.reader import parse_config
from stickslip.dataset.build import INCOMPLETE, map_template, provenance
from stickslip.engine import Progress, Results, in_order
from stickslip.errors import ConfigError, DamagedBlockError, StoreError
from stickslip.files import reading, writing
from stickslip.files.locations import Location
from stickslip.runs.block_store import START_OVER, BlockStore, refuse, same_major
from stickslip.runs.formats import Notice, StoredColumn, column
from stickslip.runs.work import KnownCells, MapStudy, Work, blocks_of_chunks, chunks_of, differences, study_of
from stickslip.vocabulary.cells import Cells

if TYPE_CHECKING:
    from stickslip.studies.refine import RefinedMap

_ANEW = "{fresh} computes it anew and replaces it; "
_OTHER_FILE = "{output} names another file"
_ROUNDING = 1e-12  # relative: what a few operations on a number come to
_OF_STEP = 1e-10  # of an axis: what they come to where a value is much smaller than those they began with
_REMEMBERED = 2  # blocks; a chunk may begin in one and end in the next


# --- what is there ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ExistingOutput:
    """A result that this run resumes from.

    complete : there is nothing left to do. grid : of a map, with the values of the result where only rounding tells
    them apart.
    """

    cells: int
    complete: bool
    known: KnownCells | None
    grid: Cells | None = None


@contextmanager
def existing_output(
    output: Location | None, config: Config, fresh: bool, remedy: str = START_OVER
) -> Iterator[ExistingOutput | None]:
    """The result at `output`, open; None if there is none or it does not matter.

    remedy : as for `refuse`; other than the usual one from who cannot begin anew.

    Raises StoreError for what this run would destroy: results of another configuration or major version, results whose
    cells are not all part of the new map, and what stickslip has not written.
    """
    if output is None or fresh or not output.exists():
        yield None
        return
    hint = _ANEW * (remedy == START_OVER) + _OTHER_FILE
    try:
        dataset = reading.look_into(output)
    except StoreError as error:
        raise StoreError(str(error), hint=hint) from error
    with dataset:
        yield _compared(output, dataset, config, remedy, hint)


def _compared(output: Location, dataset: xr.Dataset, config: Config, remedy: str, hint: str) -> ExistingOutput:
    version = str(dataset.attrs["source"]).split()[1].rstrip(",")
    if not same_major(version):
        raise StoreError(f"{output}: made by stickslip {version}, and this is {__version__}", hint=hint)
    study = study_of(config)
    if isinstance(study, MapStudy) and "regime" not in dataset:
        raise StoreError(f"{output}: exists and is not a map", hint=hint)
    try:
        there = parse_config(str(dataset.attrs["configuration"]), str(output))
    except (ConfigError, KeyError):
        raise StoreError(f"{output}: exists, and its configuration cannot be read", hint=hint) from None
    differing = differences(there, config)
    if differing and not (isinstance(study, MapStudy) and all(name.startswith("axes.") for name in differing)):
        refuse(str(output), there, config, remedy)
    whole = not differing and there.title == config.title
    if not isinstance(study, MapStudy):
        return ExistingOutput(prod(study.shape), whole and INCOMPLETE not in dataset.attrs, None)
    old, new = build_grid(there), build_grid(config)
    axes, new_axes = ([(c.name, grid.dims.index(c.dim)) for c in grid.coords] for grid in (old, new))
    if axes != new_axes:
        refuse(str(output), there, config, remedy)
    before = {c.name: dataset[c.name].values for c in old.coords}
    old, new = as_before(old, before), as_before(new, before)
    points = points_of(old, new)
    if lost := old.size - prod(np.unique(place[place >= 0]).size for place in points):
        if lost == old.size:
            refuse(str(output), there, config, remedy)
        raise StoreError(
            f"{output}: holds {lost:,} cells that are not part of the new map and would be lost", hint=hint
        )
    whole = whole and not (dataset["regime"] == 0).any()
    return ExistingOutput(new.size, whole, None if whole else KnownCells(dataset, new.shape, points), new)


def points_of(old: Cells, new: Cells) -> tuple[NDArray[np.intp], ...]:
    """For each dimension of `new`, where its points lie in that dimension of `old`, -1 for new ones.

    Points are equal if all their quantities are, to the bit. Both grids have the same axes in the same order.
    """
    places = []
    for i in range(len(new.dims)):
        there, here = _bits(old, i), _bits(new, i)
        numbered = np.unique(np.concatenate([there, here]), axis=0, return_inverse=True)[1].reshape(-1)
        place = np.full(numbered.max() + 1, -1)
        place[numbered[: len(there)]] = np.arange(len(there))
        places.append(place[numbered[len(there) :]])
    return tuple(places)


def _bits(grid: Cells, dimension: int) -> NDArray[np.int64]:
    """The bits of all quantities along a dimension: shape (points, quantities)."""
    along = sorted((c for c in grid.coords if c.dim == grid.dims[dimension]), key=lambda c: c.name)
    return np.stack([np.ascontiguousarray(c.values, np.float64).view(np.int64) for c in along], axis=1)


def as_before(grid: Cells, values: Mapping[str, NDArray[np.float64]]) -> Cells:
    """`grid` with values of before, by coordinate, wherever only rounding tells its own from them."""
    coords = tuple(
        replace(c, values=_as_before(values[c.name], c.values)) if c.name in values else c for c in grid.coords
    )
    along = {quantity_of(c.name): (grid.dims.index(c.dim), c.values) for c in coords}
    return replace(grid, coords=coords, along=along)


def _as_before(before: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    known = np.unique(before[~np.isnan(before)])
    if not known.size:
        return values
    nearest = known[np.searchsorted((known[1:] + known[:-1]) / 2, values)]
    steps = np.concatenate([np.diff(known), np.diff(np.unique(values[~np.isnan(values)]))])
    step = float(steps.min(initial=np.inf))
    of_step = _OF_STEP * step if np.isfinite(step) else 0.0  # where a range passes through 0
    rounding = np.minimum(np.maximum(_ROUNDING * abs(values), of_step), step / 4)
    return np.where(abs(nearest - values) <= rounding, nearest, values)


# --- blocks put together ----------------------------------------------------------------------------------------------


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


def assemble(gathered: Gathered, store: BlockStore, work: Work, output: Location, progress: Progress | None) -> None:
    """Write the map of a store to `output`, all or nothing. Raises StoreError."""
    kernels = store.manifest.kernels
    action = "run" if len(kernels) == 1 else f"run, by kernels {' and '.join(kernels)}"
    attributes = provenance(work.config.to_yaml(), title=work.config.title, action=action)
    study, canvas = work.study, None
    is_refined = getattr(work.config.study, "is_map", False)  # few of its cells are computed
    refined = cast("RefinedMap", study) if is_refined else None
    if isinstance(study, MapStudy):
        canvas = Canvas(study.grid, study.columns, gathered.cells)
    elif refined:
        canvas = Canvas(refined.grid, refined.map_columns, refined.painter(gathered.item).cells)
    if canvas is None or not canvas.grid.shape:
        dataset = study.dataset(gathered.blocks(), attributes)
        dataset.attrs |= _lacking(gathered, work)
        writing.write(dataset, output)
        return
    if refined:
        attributes |= refined.findings(gathered.blocks())
    template = map_template(canvas.grid, canvas.columns, attributes | _lacking(gathered, work))
    chunks = chunks_of(store.blocks, canvas.grid.shape) if not refined and output.suffix == ".nc" else None
    threads = work.options.threads

    def fill(file: Any) -> None:
        pieces = _copied(gathered, store, file, threads) if chunks else _computed(canvas, file)
        for done in pieces:
            if progress:
                progress(done, canvas.grid.size)

    writing.write(template, output, fill, chunks, threads)


def _lacking(gathered: Gathered, work: Work) -> dict[str, str]:
    """The attribute about missing items; the cells of a plain map say it themselves."""
    missing = sum(gathered.missing.values())
    if not missing or isinstance(work.study, MapStudy):
        return {}
    return {INCOMPLETE: f"{missing:,} of {work.size:,} {work.study.counted} are not computed"}


def _computed(canvas: Canvas, target: Any) -> Iterator[int]:
    """The map chunk after chunk, all variables of each; yields cells done. target : as of `writing.write`."""
    shape = canvas.grid.shape
    chunks = blocks_of_chunks(target.chunks("regime"), shape)
    for number in range(chunks.count):
        cells = chunks.cells(number)
        origin, extent = part_of(cells, shape)
        for name, values in canvas.cells(cells).items():
            target.write(name, values.reshape(extent), origin)
        yield cells.stop


def _copied(gathered: Gathered, store: BlockStore, target: writing.NetcdfChunks, threads: int | None) -> Iterator[int]:
    """Blocks that are chunks, in their order, read and checked by threads; yields cells done."""
    blocks, shape = store.blocks, target.layout("regime").variable.shape

    @lru_cache(maxsize=64)  # NaN and the like: a chunk that is packed once
    def of_one_value(name: str, value: bytes) -> Any:
        layout = target.layout(name)
        return layout.packed(np.full(layout.chunks, np.frombuffer(value, layout.dtype)))

    for number, block in enumerate(in_order(gathered.read, range(blocks.count), threads)):
        cells = blocks.cells(number)
        origin, extent = part_of(cells, shape)
        for name, stored in gathered.columns(number, block).items():
            if stored.is_one_value():
                target.put(name, origin, of_one_value(name, bytes(stored.data)))
            elif stored.packing == target.layout(name).packing:
                target.put(name, origin, stored.data)
            else:
                target.write(name, stored.values().reshape(extent), origin)
        yield cells.stop


def part_of(cells: range, shape: tuple[int, ...]) -> tuple[list[int], list[int]]:
    """Where a chunk that holds these cells of an array begins, and its shape."""
    first, last = (np.unravel_index(number, shape) for number in (cells.start, cells.stop - 1))
    return [int(i) for i in first], [int(i - begin) + 1 for begin, i in zip(first, last, strict=True)]
