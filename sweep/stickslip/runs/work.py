"""The source of blocks: a configuration and the number of a block in, arrays out, whoever calls; how cells are cut into
blocks, and dealt to shards; and the map as a study.

A block is one file, one thread, one unit of loss. That of a map is a chunk of its file too, so that what a thread has
compressed goes into the file as it is.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import gcd, prod
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid, map_options_of, options_of
from stickslip.config.model import Config
from stickslip.config.studies import Moved, Study, study_class
from stickslip.dataset.build import map_dataset
from stickslip.engine import Options, Results, StopFlag, columns, compute_range, joined, kernels_for, stop_flag
from stickslip.files.chunks import NETCDF, PLAIN
from stickslip.files.locations import Location
from stickslip.vocabulary.cells import Cells

_FEWEST, _MOST = 4096, 131_072  # cells; below, files cost more than cells; above, a thread takes memory and is missed
_GOLDEN = (1 + 5**0.5) / 2
_BLOCKS = 64  # aimed at, so that many threads and shards find work to the end; a large map has more
_LONGEST = 60  # characters of a value that is shown
_VARIABLES = "output.variables"


@dataclass(frozen=True)
class Blocks:
    """The items from 0 to `size`, plane after plane of `plane` items, each in blocks of `length`, the last one shorter.

    size : a multiple of `plane`.
    """

    size: int
    length: int
    plane: int

    @property
    def count(self) -> int:
        """Number of blocks."""
        return self.size // self.plane * self._in_plane

    def cells(self, number: int) -> range:
        """The items of a block."""
        plane, part = divmod(number, self._in_plane)
        start, end = plane * self.plane + part * self.length, (plane + 1) * self.plane
        return range(start, min(start + self.length, end))

    def at(self, item: int) -> int:
        """The block an item is in."""
        plane, place = divmod(item, self.plane)
        return plane * self._in_plane + place // self.length

    @property
    def _in_plane(self) -> int:
        return -(-self.plane // self.length)


def blocks_of(shape: tuple[int, ...], weight: int = 1) -> Blocks:
    """The blocks of an array of items of this shape, each of which takes about `weight` cells.

    A block is one long along some dimensions, cut along the next, whole along those after it. Nothing but the shape
    enters, so that every machine cuts alike.
    """
    size = prod(shape)
    fewest, most = max(_FEWEST // weight, 1), max(_MOST // weight, 1)
    aim, below = min(max(-(-size // _BLOCKS), fewest), most), 1
    for length in reversed(shape):
        if below * length > aim:
            parts = -(-length // (aim // below))
            return Blocks(size, -(-length // parts) * below, length * below)
        below *= length
    return Blocks(size, size, size)


def chunks_of(blocks: Blocks, shape: tuple[int, ...]) -> tuple[int, ...] | None:
    """The chunks of a file whose chunks are blocks of an array of this shape; None if blocks are not of that kind."""
    below, chunks = 1, list[int]()
    for length in reversed(shape):
        cut = blocks.length // below if below < blocks.length else 1
        chunks.insert(0, min(cut, length))
        below *= length
    return tuple(chunks) if blocks_of_chunks(tuple(chunks), shape) == blocks else None


def blocks_of_chunks(chunks: tuple[int, ...], shape: tuple[int, ...]) -> Blocks:
    """The blocks that are these chunks."""
    cuts = [i for i, (chunk, length) in enumerate(zip(chunks, shape, strict=True)) if chunk < length]
    size = prod(shape)
    return Blocks(size, prod(chunks), prod(shape[cuts[-1] :])) if cuts else Blocks(size, size, size)


# --- shards -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Shard:
    """Part `number` of `count` (from 1) of the blocks of a run."""

    number: int
    count: int

    def blocks(self, blocks: Blocks) -> list[int]:
        """Its blocks, in every process the same.

        Neighbours cost alike, and so do blocks at the same place of each row. Dealt is a row of all blocks in steps
        of about the golden section, of which any piece lies evenly over the map and over the places in its rows.
        """
        count, step = blocks.count, round(blocks.count / _GOLDEN)
        while gcd(step, count) != 1:
            step += 1
        each, more = divmod(count, self.count)  # the first `more` shards get one more
        begin, end = (number * each + min(number, more) for number in (self.number - 1, self.number))
        return [place * step % count for place in range(begin, end)]

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


def parse_shard(text: str) -> Shard:
    """The shard called `2/8`. Raises ValueError."""
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text.strip())
    if not match or not int(match[2]):
        raise ValueError(f"got {text!r}, expected a shard such as 1/8, 2/8 up to 8/8")
    number, count = int(match[1]), int(match[2])
    if not 1 <= number <= count:
        raise ValueError(
            f"got {text!r}, but shards are counted from 1: 1/{count} to {count}/{count}\n"
            f"hint: in a SLURM array: --array=1-{count} and --shard $SLURM_ARRAY_TASK_ID/{count}"
        )
    return Shard(number, count)


# --- what is computed -------------------------------------------------------------------------------------------------


def study_of(config: Config) -> Study:
    """What a configuration asks for: a map of every cell, unless it has the section of a study."""
    section = config.study or config.uncertain
    if section is None:
        return MapStudy(config, map_options_of(config))
    return study_class(section.key).of(config, section, options_of(config))


@dataclass(frozen=True)
class KnownCells:
    """The cells of `dataset`, found from those of a new grid.

    points : for each dimension, where the points of the new grid lie in the dataset; -1 for those it does not have.
    """

    dataset: xr.Dataset
    shape: tuple[int, ...]
    points: tuple[NDArray[np.intp], ...]

    def cells(self, cells: range) -> tuple[NDArray[np.bool_], dict[str, NDArray[Any]]] | None:
        """Flags of the known cells of a range of the new grid, and their results; None if none is known."""
        numbers = np.unravel_index(np.arange(cells.start, cells.stop), self.shape or (1,))
        places = [points[number] for points, number in zip(self.points, numbers, strict=False)]  # none of a single cell
        have = np.logical_and.reduce([place >= 0 for place in places] or [np.ones(len(cells), bool)])
        if not have.any():
            return None
        dims = self.dataset["regime"].dims
        indices = {dim: xr.DataArray(place[have], dims="cell") for dim, place in zip(dims, places, strict=True)}
        part = self.dataset.drop_vars(self.dataset.coords).isel(indices).load()
        computed = part["regime"].values.ravel() != 0
        have[have] = computed
        return have, {str(name): part[name].values.ravel()[computed] for name in part.data_vars}


@dataclass(frozen=True)
class Block:
    """The results of a block, and how many of its items were taken over from an older result."""

    results: Results
    reused: int


@dataclass(frozen=True)
class Work:
    """The blocks of a configuration.

    known : cells that an older map holds. cut : the blocks, where a store that was begun has others than a new one.
    grid : of a map whose older cells have values that differ by rounding from those of the configuration.
    """

    config: Config
    known: KnownCells | None = None
    cut: Blocks | None = None
    grid: Cells | None = None

    @cached_property
    def study(self) -> Study:
        """What is computed."""
        study = study_of(self.config)
        return study if self.grid is None else MapStudy(self.config, study.options, self.grid)

    @property
    def options(self) -> Options:
        """How cells are integrated."""
        return self.study.options

    @cached_property
    def size(self) -> int:
        """How many items there are."""
        return prod(self.study.shape)

    @cached_property
    def blocks(self) -> Blocks:
        """How they are cut."""
        study = self.study
        return self.cut or blocks_of(study.shape if study.is_array else (self.size,), study.weight)

    def packing(self, output: Location | None) -> str:
        """The packing of blocks: as chunks of the file, if they are to be these; of a netCDF file if none is named."""
        of_netcdf = output is None or output.suffix == ".nc"
        return NETCDF if self.study.is_array and of_netcdf else PLAIN

    def compute(self, number: int, stop: StopFlag | None = None, moved: Moved | None = None) -> Block:
        """A block by the calling thread: the numbers of an undivided run, bit for bit.

        stop, moved : as for `Study.compute`.
        """
        items, stop = self.blocks.cells(number), stop_flag() if stop is None else stop
        known = self.known_cells(number)
        if known is None:
            return Block(self.study.compute(items, stop, moved), 0)
        assert isinstance(self.study, MapStudy)
        have, values = known
        cells = self.study.grid.pick(items.start + np.flatnonzero(~have))
        computed = compute_range(cells, 0, cells.size, self.study.options, stop, moved)
        if moved:
            moved(int(have.sum()))
        results = self.study.blank(items)
        for name, column in results.items():
            column[have], column[~have] = values[name], computed[name]
        return Block(results, int(have.sum()))

    def known_cells(self, number: int) -> tuple[NDArray[np.bool_], Results] | None:
        """Which cells of a block an older map holds, and their results; None if it holds none."""
        return self.known.cells(self.blocks.cells(number)) if self.known else None

    def known_only(self, number: int) -> Results:
        """The results of a block as far as an older map holds them; other items are "not computed"."""
        results = self.study.blank(self.blocks.cells(number))
        if known := self.known_cells(number):
            have, values = known
            for name, column in results.items():
                column[have] = values[name]
        return results

    def fits(self, number: int, types: Mapping[str, np.dtype[Any]], sizes: Collection[int]) -> bool:
        """Tell whether columns of these types and sizes are those of a block of this study."""
        size = None if self.study.ragged else len(self.blocks.cells(number))
        wanted = {name: dtype.newbyteorder("<") for name, dtype in self.study.columns.items()}
        return types == wanted and all(size in (None, cells) for cells in sizes)


class MapStudy(Study):
    """Every cell of the grid of a configuration: the map as a study, whose items are the cells."""

    name, counted, is_array = "map", "cells", True

    def __init__(self, config: Config, options: Options, grid: Cells | None = None) -> None:
        self.grid = build_grid(config) if grid is None else grid
        self.dims, self.shape = self.grid.dims, self.grid.shape
        self.options, self.columns = options, columns(options)

    @property
    def kernels(self) -> tuple[str, ...]:
        """By the cells, of which some may have kernels of their own."""
        return kernels_for(self.grid, self.options)

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """The numbers of an undivided run, bit for bit."""
        return compute_range(self.grid, items.start, items.stop, self.options, stop, moved)

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The map, in memory."""
        return map_dataset(self.grid, joined(parts), attributes)


# --- the identity of a run --------------------------------------------------------------------------------------------

# The settings are the keys of a configuration that decide its results. The title, the execution section, and of the
# output section all but `variables` do not; nor does the file a curve was fitted to, since the fitted coefficients do.
# A result without some variables is another one: of it they can neither be taken, nor may they be lost where it
# replaces one that holds them.


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
