"""The refined map of a configuration as a study: its items are tiles."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import prod
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.checks import refined_axes
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.studies import Refine
from stickslip.dataset.build import map_dataset
from stickslip.engine import Options, Results, StopFlag, blank_results, columns, compute_range
from stickslip.studies.refinement.boxes import Labels
from stickslip.studies.refinement.painting import Painter, Sketch, labels_of
from stickslip.studies.refinement.rounds import CONFIDENCE, Audit, Refined, density, refine
from stickslip.studies.refinement.tiles import Indices, Tiles
from stickslip.studies.study import Finished, Moved, Study, joined

_OF_TILE = ("computed_cells", "audit_tried", "audit_wrong", "audit_inferred")  # columns with one value for each tile
_PLACE = "place"  # column of where in the window of its tile a computed cell is


class RefinedMap(Study):
    """The map of a configuration, computed where its regimes meet and at few points elsewhere.

    The results of tiles hold the cells that were computed, tile after tile; `painter` makes full maps of them.
    """

    name, counted, ragged = "map", "tiles", True

    def __init__(self, config: Config, asked: Refine, options: Options) -> None:
        self.grid = build_grid(config)
        self.options, self._asked = options, asked
        dims = refined_axes(config.axes, asked.depth)
        self.tiles = Tiles(self.grid.shape, dims, asked.depth)
        self._density = density(asked.audit, asked.depth, len(dims)) if asked.depth else 0.0
        self.dims, self.shape = self.grid.dims, self.tiles.shape
        self.cells_each = self.weight = self._cells_per_tile()
        whole = dict.fromkeys((*_OF_TILE, _PLACE), np.dtype(np.int32))
        self.columns = {**whole, **columns(options)}
        self.map_columns = {**columns(options), "computed": np.dtype(np.int8)}

    def _cells_per_tile(self) -> int:
        """About how many cells of a tile are computed: corners, centres, audit, and what a straight border takes."""
        lengths = [min(self.tiles.length, self.grid.shape[i]) for i in self.tiles.refined]
        boxes = prod(-(-length // 2**self._asked.depth) + 1 for length in lengths)
        border = 4 * prod(lengths) // min(lengths)
        return int(min((2.0 + 2.0 * self._asked.audit) * boxes + border, prod(lengths)))

    def described(self) -> str:
        """`250,000 cells: stiffness (500) x belt_speed (500), refined in 1 tile`."""
        axes = " x ".join(f"{dim} ({n})" for dim, n in zip(self.dims, self.grid.shape, strict=True))
        return f"{self.grid.size:,} cells: {axes}, refined in {self.tiles.count:,} tile{'s' * (self.tiles.count != 1)}"

    def compute(self, items: range, stop: StopFlag, moved: Moved | None = None) -> Finished:
        """Tiles are refined side by side, so that there are many cells to compute together."""
        tiles, parts = [self.tiles.tile(number) for number in items], list[Results]()

        def look(cells: Indices) -> Labels | None:
            computed = compute_range(self.grid.pick(cells), 0, cells.size, self.options, stop, moved, often=True)
            parts.append(computed.results)
            return labels_of(computed.results["regime"]) if computed.complete else None

        refined = refine(tiles, self._asked.depth, self._density, look)
        if refined is None:
            return Finished(self.blank(items), False)
        return Finished(_columns(refined, joined(parts)))

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
            "refine_box": 2**self._asked.depth,
            "refine_cells_computed": int(counts[0]),
            "audit_points": audit.tried,
            "audit_wrong": audit.wrong,
            "audit_bound": wrong,
            "audit": _told(audit, wrong),
        }

    def painter(self, found: Callable[[int], tuple[Results, int]]) -> Painter:
        """Full maps, range by range. found : the results that hold a tile, and the number of the tile among theirs."""

        def sketch(number: int) -> Sketch | None:
            results, at = found(number)
            ends = np.cumsum(results["computed_cells"], dtype=np.int64)
            part = slice(int(ends[at] - results["computed_cells"][at]), int(ends[at]))
            if part.start == part.stop:
                return None
            cells = {name: results[name][part] for name in columns(self.options)}
            return Sketch(self.tiles.tile(number), self._asked.depth, results[_PLACE][part].astype(np.int64), cells)

        return Painter(self.tiles, sketch, self._blank_cells, self._asked.interpolate)

    def _blank_cells(self, count: int) -> Results:
        return blank_results(count, self.options) | {"computed": np.zeros(count, np.int8)}


def _told(audit: Audit, wrong: float) -> str:
    """The audit for people. wrong : bound of the share of all cells that are wrong."""
    if not audit.tried:
        return "nothing was inferred" if not audit.inferred else "no random points were tried; nothing is known"
    points = f"{audit.tried:,} random point{'s' * (audit.tried != 1)} among the inferred cells"
    bound = f"at most {100 * wrong:.3g} % of all cells ({100 * CONFIDENCE:g} %, Clopper-Pearson)"
    return f"{points}, {audit.wrong:,} of them wrong: {bound}"


def _columns(refined: Refined, computed: Results) -> Results:
    """The columns of a range of tiles: what was computed, tile by tile, and counts."""
    order = np.argsort(refined.tiles, kind="stable")
    audits = refined.audits
    cells = np.bincount(refined.tiles, minlength=len(audits))
    counts = (cells, [a.tried for a in audits], [a.wrong for a in audits], [a.inferred for a in audits])
    columns = {name: np.array(count, np.int32) for name, count in zip(_OF_TILE, counts, strict=True)}
    columns[_PLACE] = refined.places[order].astype(np.int32)
    return columns | {name: values[order] for name, values in computed.items()}
