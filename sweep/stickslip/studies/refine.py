"""The refined map of a configuration as a study: its items are tiles, from which any range of the map is painted.

A grid is cut into tiles, which are refined one by one. Along axes without boxes (lists, groups, short ranges) every
point is a map of its own. The cut follows from the grid and the depth alone, so that the numbers do not depend on who
computes which tile. A tile looks at one box more on each side than it owns: a border near its edge is seen from both
sides.

The audit tries random points. They are drawn before anything is known of the map, anywhere with the same probability,
in numbers that are Poisson in every tile: so those that fall on inferred cells are a random sample of these. The number
of wrong ones among them is binomial, and Clopper and Pearson (Biometrika 26, 1934) bound its probability: the share of
inferred cells that were wrong then. What is mended afterwards only makes the map better than the bound says.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any, NamedTuple

import numpy as np
import scipy  # type: ignore[import-untyped]
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import build_grid, map_options_of
from stickslip.config.model import Axis, Config, Range
from stickslip.config.problems import ProblemCollector
from stickslip.config.sections import StudySection, of_row
from stickslip.config.studies import Moved, Study
from stickslip.dataset.build import map_dataset
from stickslip.engine import Options, Results, StopFlag, blank_results, columns, compute_range, joined
from stickslip.studies.lines import decided
from stickslip.studies.search import Boxes, Integers, Labels
from stickslip.vocabulary.parameter import Parameter, table
from stickslip.vocabulary.quantities import MAP_VARIABLES

CONFIDENCE = 0.95  # of the audit
_SEED = 20_150_417  # any number, the same in all runs
_TILE = 21  # a tile has about 2^21 cells: large enough to follow borders, small enough for memory and for many threads
_OF_TILE = ("computed_cells", "audit_tried", "audit_wrong", "audit_inferred")  # columns with one value for each tile
_MOST_IN_BOX = 18  # a box has at most about 2^18 cells: tiles of several boxes a side must fit into memory
COMPUTED = 1  # of the flag `computed`
_PLACE = "place"  # column of where in the window of its tile a computed cell is


@dataclass(frozen=True)
class Tile:
    """A part of the grid: the window of cells it looks at, from `starts` to `stops` along every dimension, and the
    cells it owns, along the refined dimensions and relative to the window."""

    number: int
    grid: tuple[int, ...]
    refined: tuple[int, ...]
    starts: tuple[int, ...]
    stops: tuple[int, ...]
    own: tuple[slice, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """Points of the window along the refined dimensions."""
        return tuple(self.stops[i] - self.starts[i] for i in self.refined)

    @property
    def size(self) -> int:
        """Number of cells owned."""
        return prod(side.stop - side.start for side in self.own)

    def cells(self, places: Integers) -> Integers:
        """The cells of the grid at places of the window."""
        points = [np.full(places.size, start, np.int64) for start in self.starts]
        for i, along in zip(self.refined, np.unravel_index(places, self.shape), strict=True):
            points[i] += along
        return np.ravel_multi_index(points, self.grid)

    def places(self, cells: Integers) -> Integers:
        """Return where cells of the grid are in the window that holds them."""
        points = np.unravel_index(cells, self.grid)
        return np.ravel_multi_index([points[i] - self.starts[i] for i in self.refined], self.shape)


@dataclass(frozen=True)
class Tiles:
    """All tiles of a grid. refined : the dimensions along which boxes extend, at least one."""

    grid: tuple[int, ...]
    refined: tuple[int, ...]
    depth: int

    @property
    def length(self) -> int:
        """Cells of a tile along a refined dimension; the last tile has up to one more."""
        return 1 << max(_TILE // len(self.refined), self.depth + 1)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of tiles along each dimension of the grid."""
        return tuple(max(1, -(-(n - 1) // self.length)) if i in self.refined else n for i, n in enumerate(self.grid))

    @property
    def count(self) -> int:
        """Number of tiles."""
        return prod(self.shape)

    def tile(self, number: int) -> Tile:
        """A tile by its number, the last dimension running fastest."""
        halo = (1 << self.depth) if self.depth else 0
        at = [int(i) for i in np.unravel_index(number, self.shape)]
        starts, stops, own = list(at), [i + 1 for i in at], []
        for i in self.refined:
            first = at[i] * self.length
            last = self.grid[i] if at[i] == self.shape[i] - 1 else first + self.length
            starts[i], stops[i] = max(0, first - halo), min(self.grid[i], last + halo + 1)
            own.append(slice(first - starts[i], last - starts[i]))
        return Tile(number, self.grid, self.refined, tuple(starts), tuple(stops), tuple(own))

    def owners(self, cells: Integers) -> Integers:
        """The numbers of the tiles that own these cells."""
        at = [
            np.minimum(along // self.length, self.shape[i] - 1) if i in self.refined else along
            for i, along in enumerate(np.unravel_index(cells, self.grid))
        ]
        return np.ravel_multi_index(at, self.shape)


class Audit(NamedTuple):
    """Outcome of an audit. inferred : cells not computed when the points were tried."""

    tried: int
    wrong: int
    inferred: int

    @property
    def bound(self) -> float:
        """Upper bound of the share of inferred cells that are wrong, at the level `CONFIDENCE`; 1 if none was tried."""
        if not self.inferred:
            return 0.0
        if self.wrong >= self.tried:
            return 1.0
        return float(scipy.stats.beta.ppf(CONFIDENCE, self.wrong + 1, self.tried - self.wrong))


def drawn(tile: Tile, density: float) -> Integers:
    """Random places of a tile, in its window; the same place may come twice."""
    draw = np.random.default_rng([_SEED, tile.number])
    count = int(draw.poisson(density * tile.size))
    points = tuple(draw.integers(side.start, side.stop, count) for side in tile.own)
    return np.ravel_multi_index(points, tile.shape).astype(np.int64)


class Refined(NamedTuple):
    """Computed cells of several tiles in their order: to which tile each belongs, and where it is in its window."""

    tiles: Integers
    places: Integers
    audits: list[Audit]


def refine(tiles: Sequence[Tile], depth: int, density: float, look: Callable[[Integers], Labels]) -> Refined:
    """Refine tiles side by side: what they need in a round is computed together, by `look`.

    Boxes are split until all are uniform; then the audit; then boxes in which it was wrong are split, until all are
    uniform again. Where windows overlap, the same cell may be computed more than once.
    """
    boxes = [Boxes(tile.shape, depth) for tile in tiles]
    rounds: list[tuple[int, Integers]] = []

    def learn(wanted: list[Integers]) -> list[Labels]:
        """The labels of places of each tile, once they are computed."""
        labels = look(np.concatenate([tile.cells(places) for tile, places in zip(tiles, wanted, strict=True)]))
        of_tiles = np.split(labels, np.cumsum([places.size for places in wanted])[:-1])
        for i, (places, of_tile) in enumerate(zip(wanted, of_tiles, strict=True)):
            boxes[i].learn(places, of_tile)
            rounds.append((i, places))
        return of_tiles

    def settle() -> None:
        while True:
            wanted = [of_tile.wanted() for of_tile in boxes]
            if not any(places.size for places in wanted):
                return
            learn(wanted)

    settle()
    audits, tried, inferred = [], [], [of_tile.inferred().ravel() for of_tile in boxes]
    for tile, of_tile in zip(tiles, boxes, strict=True):
        places = drawn(tile, density)
        tried.append(places[~of_tile.known.ravel()[places]])
        audits.append(Audit(tried[-1].size, 0, int((~of_tile.known[tile.own]).sum())))
    if any(places.size for places in tried):
        different, which = zip(*(np.unique(places, return_inverse=True) for places in tried), strict=True)
        for i, labels in enumerate(learn([*different])):
            wrong = labels[which[i]] != inferred[i][tried[i]]
            audits[i] = audits[i]._replace(wrong=int(wrong.sum()))
        settle()
    return Refined(
        np.repeat([i for i, _ in rounds], [places.size for _, places in rounds]),
        np.concatenate([places for _, places in rounds]),
        audits,
    )


class Refine(StudySection):
    """A map of which cells are computed only where regimes meet, and at few points elsewhere."""

    key, is_map = "refine", True
    rows = table(
        Parameter("depth", "1", "how often boxes may be halved: the largest have 2^depth + 1 cells a side", key,
                  default=5, at_least=0, at_most=_MOST_IN_BOX, whole=True),
        Parameter("audit", "1", "random points tried, over the corners and centres of the largest boxes", key,
                  default=1.0, at_least=0.0, at_most=1000.0),
    )  # fmt: skip
    depth: int = of_row(rows["depth"])
    audit: float = of_row(rows["audit"])

    def along(self, axes: Sequence[Axis]) -> tuple[int, ...]:
        """The positions of the axes along which boxes extend: ranges of at least the points that a box has a side."""
        return tuple(i for i, axis in enumerate(axes) if isinstance(axis, Range) and axis.size > 2**self.depth)


class RefinedMap(Study):
    """The map of a configuration, computed where its regimes meet and at few points elsewhere.

    The results of tiles hold the cells that were computed, tile after tile; `painter` makes full maps of them.
    """

    section, variables = Refine, MAP_VARIABLES
    name, counted, ragged = "map", "tiles", True

    def __init__(self, config: Config, section: Refine, options: Options) -> None:
        self.grid = build_grid(config)
        self.options, self._section = options, section
        dims = section.along(config.axes)
        self.tiles = Tiles(self.grid.shape, dims, section.depth)
        # Of corners and centres of boxes, which every map is computed at.
        self._density = 2.0 * section.audit / 2.0 ** (section.depth * len(dims)) if section.depth else 0.0
        self.dims, self.shape = self.grid.dims, self.tiles.shape
        self.cells_each = self.weight = self._cells_per_tile()
        whole = dict.fromkeys((*_OF_TILE, _PLACE), np.dtype(np.int32))
        self.columns = {**whole, **columns(options)}
        self.map_columns = {**columns(options), "computed": np.dtype(np.int8)}

    @classmethod
    def of(cls, given: Config, section: Refine, options: Options) -> RefinedMap:
        """The map of a configuration, of which some variables may be all that is kept."""
        return cls(given, section, map_options_of(given))

    @classmethod
    def check(cls, section: Refine, config: Config, problems: ProblemCollector) -> None:
        """Note boxes that do not fit into the axes."""
        dims = section.along(config.axes)
        ranges = {axis.name: axis.size for axis in config.axes if isinstance(axis, Range)}
        if not ranges:
            hint = "a list of values has nothing between them; leave refine out to compute every cell"
            message = "got no range among the axes, expected an axis with start, stop and num"
            problems.add((section.key,), message, hint, at_key=True)
        elif not dims:
            name = max(ranges, key=lambda name: ranges[name])
            hint = f"boxes have 2^depth + 1 points a side, and the longest range, {name}, has {ranges[name]}"
            problems.refuse((section.key, "depth"), f"at most {(ranges[name] - 1).bit_length() - 1}", hint)
        elif section.depth * len(dims) > _MOST_IN_BOX:
            hint = f"boxes would have 2^{section.depth * len(dims)} cells in {len(dims)} dimensions"
            problems.refuse((section.key, "depth"), f"at most {_MOST_IN_BOX // len(dims)}", hint)

    @classmethod
    def explain(cls, section: Refine, config: Config) -> Iterator[tuple[str, str, str]]:
        """The size of boxes, and where they extend."""
        names = [config.axes[i].name for i in section.along(config.axes)]
        meaning = f"audit {section.audit:g}; other metrics only where they were computed"
        yield "refine", f"boxes of 2^{section.depth} + 1 cells along {', '.join(names)}", meaning

    def _cells_per_tile(self) -> int:
        """About how many cells of a tile are computed: corners, centres, audit, and what a straight border takes."""
        lengths = [min(self.tiles.length, self.grid.shape[i]) for i in self.tiles.refined]
        boxes = prod(-(-length // 2**self._section.depth) + 1 for length in lengths)
        border = 4 * prod(lengths) // min(lengths)
        return int(min((2.0 + 2.0 * self._section.audit) * boxes + border, prod(lengths)))

    def described(self) -> str:
        """`250,000 cells: stiffness (500) x belt_speed (500), refined in 1 tile`."""
        axes = " x ".join(f"{dim} ({n})" for dim, n in zip(self.dims, self.grid.shape, strict=True))
        return f"{self.grid.size:,} cells: {axes}, refined in {self.tiles.count:,} tile{'s' * (self.tiles.count != 1)}"

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Results:
        """Tiles are refined side by side, so that there are many cells to compute together."""
        tiles, parts = [self.tiles.tile(number) for number in items], list[Results]()

        def look(cells: Integers) -> Labels:
            parts.append(compute_range(self.grid.pick(cells), 0, cells.size, self.options, stop, moved, often=True))
            return labels_of(parts[-1]["regime"])

        return _columns(refine(tiles, self._section.depth, self._density, look), joined(parts))

    def blank(self, items: range) -> Results:
        """Tiles of which nothing is computed."""
        nothing = {name: np.zeros(len(items), np.int32) for name in _OF_TILE} | {_PLACE: np.zeros(0, np.int32)}
        return nothing | blank_results(0, self.options)

    def dataset(self, parts: Sequence[Results], attributes: Mapping[str, Any]) -> xr.Dataset:
        """The full map, in memory."""
        whole = joined(parts)
        painter = self.painter(lambda number: (whole, number))
        return map_dataset(self.grid, painter.cells(range(self.grid.size)), {**attributes, **self.findings(parts)})

    def findings(self, parts: Iterable[Results]) -> dict[str, Any]:
        """Return what the results of all tiles say of the map, as attributes."""
        counts = np.array([[part[name].sum(dtype=np.int64) for name in _OF_TILE] for part in parts]).sum(axis=0)
        audit = Audit(*map(int, counts[1:]))
        wrong = audit.bound * audit.inferred / self.grid.size
        return {
            "refine_box": 2**self._section.depth,
            "refine_cells_computed": int(counts[0]),
            "audit_points": audit.tried,
            "audit_wrong": audit.wrong,
            "audit_bound": wrong,
        }

    def painter(self, held_by: Callable[[int], tuple[Results, int]]) -> Painter:
        """Full maps, range by range. held_by : the results that hold a tile, and its number among theirs."""

        def computed(number: int) -> tuple[Integers, Results]:
            results, at = held_by(number)
            ends = np.cumsum(results["computed_cells"], dtype=np.int64)
            part = slice(int(ends[at] - results["computed_cells"][at]), int(ends[at]))
            places = results[_PLACE][part].astype(np.int64)
            return places, {name: results[name][part] for name in columns(self.options)}

        def blank(count: int) -> Results:
            return blank_results(count, self.options) | {"computed": np.zeros(count, np.int8)}

        return Painter(self.tiles, computed, blank)


def _columns(refined: Refined, computed: Results) -> Results:
    """The columns of a range of tiles: what was computed, tile by tile, and counts."""
    order = np.argsort(refined.tiles, kind="stable")
    cells = np.bincount(refined.tiles, minlength=len(refined.audits))
    counts = zip(_OF_TILE, (cells, *zip(*refined.audits, strict=True)), strict=True)
    columns = {name: np.array(count, np.int32) for name, count in counts}
    columns[_PLACE] = refined.places[order].astype(np.int32)
    return columns | {name: values[order] for name, values in computed.items()}


def labels_of(regimes: Labels) -> Labels:
    """Regimes as `Boxes` takes them: below 0 where nothing is decided, so that nothing is inferred from such cells."""
    return np.where(decided(regimes), regimes, -1 - regimes).astype(np.int8)


class Painter:
    """Any range of the cells of a map.

    computed : gives places of the window of a tile, each once, and the results there. blank : results of so many cells
    that are not computed.
    """

    def __init__(
        self, tiles: Tiles, computed: Callable[[int], tuple[Integers, Results]], blank: Callable[[int], Results]
    ) -> None:
        self._tiles, self._computed, self._blank = tiles, computed, blank
        self._sketches: dict[int, _Sketch | None] = {}

    def cells(self, cells: range) -> Results:
        """The results of a range of cells."""
        flat = np.arange(cells.start, cells.stop, dtype=np.int64)
        owners, results = self._tiles.owners(flat), self._blank(len(cells))
        numbers = [int(number) for number in np.unique(owners)]
        # The next range mostly needs the same tiles.
        self._sketches = {n: self._sketches[n] if n in self._sketches else self._sketch(n) for n in numbers}
        for number, sketch in self._sketches.items():
            if sketch is not None:
                at = np.flatnonzero(owners == number)
                places = sketch.tile.places(flat[at])
                results["regime"][at], rows = sketch.regimes[places], sketch.rows[places]
                at, rows = at[rows >= 0], rows[rows >= 0]
                results["computed"][at] = COMPUTED
                for name, values in sketch.results.items():
                    results[name][at] = values[rows]
        return results

    def _sketch(self, number: int) -> _Sketch | None:
        (places, results), tile = self._computed(number), self._tiles.tile(number)
        if not places.size:
            return None
        boxes = Boxes(tile.shape, self._tiles.depth)
        boxes.learn(places, labels_of(results["regime"]))
        rows = np.full(boxes.known.size, -1, np.int32)
        rows[places] = np.arange(places.size, dtype=np.int32)
        return _Sketch(tile, boxes.inferred().ravel(), rows, results)


class _Sketch(NamedTuple):
    """What is known of a tile. regimes : of every place of its window, inferred ones among them. rows : where in the
    results each is, -1 for what was not computed. results : of computed cells, by column."""

    tile: Tile
    regimes: Labels
    rows: NDArray[np.int32]
    results: Results
