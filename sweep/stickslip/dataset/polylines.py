"""Borders as polylines: the lines of contours, and crossings of lines side by side, joined.

A crossing goes on where the neighbouring line has one with the same regimes below and above, in the same order; where a
line has more of a kind than its neighbour, those are taken that lie nearest. Where nothing agrees there is a gap.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.dataset.display import MapAxis

CONTAINER = "geometry"  # variable that says which others hold the nodes of lines, in the manner of CF
Floats = NDArray[np.float64]
Kind = tuple[int, int]  # regimes below and above


@dataclass(frozen=True, eq=False)
class Polyline:
    """One line: its nodes (n,), and the flags of the regimes to its left and right as x and y grow to right and up."""

    x: Floats
    y: Floats
    left: int
    right: int
    closed: bool


def plane_names(ds: xr.Dataset) -> tuple[str, str]:
    """The two parameters of the plane of contours, x and y."""
    x, y = str(ds[CONTAINER].attrs["node_coordinates"]).split()
    return x, y


def polylines(ds: xr.Dataset, chosen: NDArray[np.bool_] | None = None) -> Iterator[Polyline]:
    """The lines of contours, or those of them that `chosen` (lines,) marks."""
    x, y = (ds[name].values for name in plane_names(ds))
    stops = np.cumsum(ds["node_count"].values)
    what = "regime" if "regime_left" in ds else "verdict"
    columns = [ds[name].values for name in ("node_count", f"{what}_left", f"{what}_right", "closed")]
    for i, (stop, count, left, right, closed) in enumerate(zip(stops, *columns, strict=True)):
        if chosen is None or chosen[i]:
            nodes = slice(int(stop) - int(count), int(stop))
            yield Polyline(x[nodes], y[nodes], int(left), int(right), bool(closed))


def border_lines(ds: xr.Dataset, x: MapAxis, y: MapAxis, at: Mapping[Hashable, object]) -> Iterator[Polyline]:
    """The borders of a dataset of borders or of contours in a map over `x` and `y`.

    at : values of the other dimensions of the map in the panel that is drawn. Nothing where the dataset says nothing of
    such a map.
    """
    if CONTAINER in ds.variables and "node_coordinates" in ds[CONTAINER].attrs:
        if {x.dim, y.dim} == set(plane_names(ds)):
            chosen = np.ones(ds.sizes["line"], np.bool_)
            for name, value in at.items():
                if name in ds.coords and ds[name].dims == ("line",):
                    chosen &= _equal(ds[name].values, value)
            for line in polylines(ds, chosen):
                if plane_names(ds)[0] == x.dim:
                    yield line
                else:  # what was to the left is to the right in a mirror
                    yield Polyline(line.y, line.x, line.right, line.left, line.closed)
        return
    along = str(ds.attrs.get("border_parameter", ""))
    across = next((axis for axis in (x, y) if axis.dim != along), x)
    if {x.dim, y.dim} != {along, across.dim} or across.dim not in ds["border"].dims or not across.is_numeric:
        return
    panel = _panel(ds, [dim for dim in ds["border"].dims if dim not in (across.dim, "crossing")], at)
    if panel is None:
        return
    panel = panel.transpose(across.dim, ...).sortby(across.dim)
    columns = (panel[name].values for name in (across.dim, "border", "regime_below", "regime_above"))
    for places, values, (below, above) in joined_crossings(*columns):
        # x grows to the right and y upwards: what is above a horizontal run of a line is to its left
        if across is x:
            yield Polyline(places, values, above, below, False)
        else:
            yield Polyline(values, places, below, above, False)


def joined_crossings(
    places: Floats, border: Floats, below: NDArray[np.int8], above: NDArray[np.int8]
) -> list[tuple[Floats, Floats, Kind]]:
    """Crossings (line, crossing) of neighbouring lines at `places` as polylines: places, borders, regimes.

    A crossing that goes on nowhere is a polyline of one point.
    """
    finished: list[tuple[Kind, list[tuple[float, float]]]] = []
    growing: list[tuple[Kind, list[tuple[float, float]]]] = []
    for place, row, low, high in zip(places, border, below, above, strict=True):
        new = [((int(b), int(a)), float(v)) for v, b, a in zip(row, low, high, strict=True) if not np.isnan(v)]
        before = _matched([kind for kind, _ in growing], [points[-1][1] for _, points in growing], new)
        finished += [line for i, line in enumerate(growing) if i not in before.values()]
        growing = [growing[before[j]] if j in before else (kind, []) for j, (kind, _) in enumerate(new)]
        for (_, points), (_, value) in zip(growing, new, strict=True):
            points.append((float(place), value))
    return [(*np.array(points).T, kind) for kind, points in finished + growing]


def _matched(kinds: Sequence[Kind], values: Sequence[float], new: Sequence[tuple[Kind, float]]) -> dict[int, int]:
    """Crossings of a line by those of the next line that go on there: of equal kinds, as many and as near as can be."""
    from scipy.optimize import linear_sum_assignment  # type: ignore[import-untyped]

    if not (kinds and new):
        return {}
    away = np.abs(np.subtract.outer(values, [value for _, value in new]))
    alike = np.array([[kind == other for other, _ in new] for kind in kinds])
    pairs = linear_sum_assignment(np.where(alike, away, 1.0 + 2.0 * away.size * away.max()))
    return {int(j): int(i) for i, j in zip(*pairs, strict=True) if alike[i, j]}


def other_cells(ds: xr.Dataset, at: Mapping[Hashable, object]) -> str | None:
    """The difference between the cells of borders and of a map, in words; None if they may belong together."""
    for name, value in at.items():
        if name in ds.coords and not ds[name].dims and not _equal(ds[name].values, value):
            return f"{name} is {ds[name].values} there and {value} in the map"
    return None


def _equal(values: NDArray[np.generic], other: object) -> NDArray[np.bool_]:
    """Flags of equal values; NaN, which stands for a word, equals itself."""
    others = np.asarray(other)
    if values.dtype.kind in "fiu" and others.dtype.kind in "fiu":
        return np.asarray(np.isclose(values, others, rtol=1e-12, atol=0.0, equal_nan=True))
    return np.asarray(values == others)


def _panel(ds: xr.Dataset, dims: Sequence[Hashable], at: Mapping[Hashable, object]) -> xr.Dataset | None:
    """The borders at the values of a panel; None where there are none."""
    for dim in dims:
        if dim not in at or dim not in ds.coords:
            return None
        places = np.flatnonzero(_equal(ds[dim].values, at[dim]))
        if not places.size:
            return None
        ds = ds.isel({dim: int(places[0])})
    return ds
