"""A dataset as people see it, on axes, colour bars, screens and pages: units, words, centres and edges of cells.

The rule for units, in this order:

1. a variable or coordinate with the attribute `display_units` is shown in that unit. Coordinates have it where the
   configuration was written with a unit; `with_units` sets it where people ask for one;
2. a speed is shown as the belt speed is, a force as the normal load, a length in the length of the speeds (mm where
   they are in mm/s): outputs follow inputs;
3. a time is shown in ms where all of it is below 0.1 s, and in microseconds below 0.1 ms; a rate in Hz;
4. everything else is shown in SI.

Files and Python stay SI.

Borders are polylines: the lines of contours, and crossings of lines side by side, joined. A crossing goes on where the
neighbouring line has one with the same regimes below and above, in the same order; where a line has more of a kind than
its neighbour, those are taken that lie nearest. Where nothing agrees there is a gap.
"""

import re
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.grid import quantity_of
from stickslip.dataset.coarse import middles
from stickslip.errors import PlotError, QuantityError
from stickslip.vocabulary import units
from stickslip.vocabulary.display_units import DISPLAY, Unit, spoken

_LEADERS = {"m s-1": ("belt_speed", "velocity"), "N": ("normal_load",), "m": ("displacement", "stroke")}
_SPEED = re.compile(r"\s*([A-Za-zµμ]+)\s*/\s*[A-Za-z]+\s*")  # a unit of speed as a length over a time
_MOST_BESIDE = 3  # parameters that vary together and are still spelled out
_FINER_BELOW = 100.0  # of the finer unit of time: 0.1 s are 100 ms


def unit_of(array: xr.DataArray, values: NDArray[Any] | None = None) -> Unit:
    """The unit in which a variable or coordinate is shown.

    values : those that are shown, where they are not all; of times, their size decides.
    """
    si, name = str(array.attrs.get("units", "1")), array.attrs.get(DISPLAY)
    if si == "1":
        return Unit()
    if name is None:
        name = _unit_of_leader(array, si) or _unit_of_time(array, si, values)
    try:
        return Unit(str(name), units.factor(str(name), si)) if name else si_unit(array)
    except QuantityError:  # not in a file of ours
        return si_unit(array)


def si_unit(array: xr.DataArray) -> Unit:
    """The unit of the file, where numbers are to be shown as they are there."""
    return Unit(units.spelled(str(array.attrs.get("units", "1"))))


def with_units(ds: xr.Dataset, chosen: Mapping[str, str]) -> xr.Dataset:
    """The dataset, whose named variables and coordinates are shown in other units. Raises PlotError."""
    ds = ds.copy()
    for name, unit in chosen.items():
        if name not in ds.variables:
            raise PlotError(f"no {name!r} to show in {unit}; there are {', '.join(map(str, ds.variables))}")
        si = str(ds[name].attrs.get("units", "1"))
        if si == "1":
            raise PlotError(f"cannot show {name} in {unit!r}, expected none: it is a pure number")
        try:
            units.factor(unit, si)
        except QuantityError as error:
            hint = f"\nhint: {error.hint}" if error.hint else ""
            raise PlotError(f"cannot show {name} in {unit!r}, expected a unit like {units.spelled(si)}{hint}") from None
        ds[name].attrs[DISPLAY] = unit
    return ds


def _unit_of_leader(array: xr.DataArray, si: str) -> str | None:
    """The unit of the coordinate that quantities of this kind follow."""

    def first(names: tuple[str, ...]) -> str | None:
        known = (array.coords[name].attrs.get(DISPLAY) for name in names if name in array.coords)
        return next((unit for unit in known if unit is not None), None)

    unit = first(_LEADERS.get(si, ()))
    if unit is None and si == "m":
        speed = _SPEED.fullmatch(first(_LEADERS["m s-1"]) or "")
        return speed[1] if speed else None
    return unit


def _unit_of_time(array: xr.DataArray, si: str, values: NDArray[Any] | None) -> str | None:
    """Seconds, or a part of them, by the largest; a rate in Hz."""
    if si == "s-1":
        return "Hz"
    if si != "s":
        return None
    shown = np.abs(np.asarray(array.values if values is None else values, np.float64))
    largest = float(np.max(shown, where=np.isfinite(shown), initial=0.0))
    if largest == 0.0 or largest >= _FINER_BELOW * 1e-3:
        return "s"
    return "ms" if largest >= _FINER_BELOW * 1e-6 else "µs"


# --- axes -------------------------------------------------------------------------------------------------------------


class MapAxis:
    """One dimension of a map, ready to be drawn or named.

    Numeric if the dimension has a numeric index, laid out as its `axis_spacing` says. Otherwise (named points,
    parameters that vary together) the points are placed side by side under their labels.
    Numbers are in the unit in which the dimension is shown (`display`), `unit`.
    plain : words are for the screen, with more digits and with units as people type them.
    log : logarithmic, whatever the dataset says.
    """

    def __init__(self, ds: xr.Dataset, dim: Hashable, plain: bool = False, log: bool = False) -> None:
        self._plain, self._log = plain, log
        self.dim = dim
        self.length = ds.sizes[dim]
        self._index = ds[dim] if dim in ds.coords else None
        self._beside = [ds[name] for name in ds.coords if name != dim and ds[name].dims == (dim,)]
        self.is_numeric = self._index is not None and self._index.dtype.kind in "fiu"

    @property
    def name(self) -> str:
        """The title without its unit."""
        return self.title.partition(" (")[0]

    @cached_property
    def unit(self) -> Unit:
        """The unit of the numbers."""
        return unit_of(self._index) if self._index is not None and self.is_numeric else Unit()

    @cached_property
    def title(self) -> str:
        """The quantity that the axis shows, with its unit."""
        if self._index is not None:
            return title(self._index)
        return title(self._beside[0]) if len(self._beside) == 1 else str(self.dim).replace("_", " ")

    @cached_property
    def centres(self) -> NDArray[np.float64]:
        """Positions of the points: at their values, or at 0, 1, 2 ... under labels."""
        if self._index is not None and self.is_numeric:
            return np.asarray(self.unit.of(self._index.values.astype(np.float64)))
        return np.arange(self.length, dtype=np.float64)

    @cached_property
    def edges(self) -> NDArray[np.float64]:
        """Borders of the cells: half way between neighbours, on the scale of the axis."""
        return np.exp(_midpoints(np.log(self.centres))) if self.is_log else _midpoints(self.centres)

    def pixel_edges(self, step: int) -> NDArray[np.float64]:
        """Borders of pixels of `step` cells; the last may be shorter."""
        return np.append(self.edges[:-1:step], self.edges[-1])

    def pixel_points(self, step: int) -> NDArray[np.float64]:
        """Positions of the cells in the middle of the pixels."""
        return self.centres[middles(self.length, step)]

    @cached_property
    def is_log(self) -> bool:
        """Tell whether the axis is logarithmic."""
        spacing = None if self._index is None else self._index.attrs.get("axis_spacing")
        return self.is_numeric and (self._log or spacing == "log") and bool((self.centres > 0).all())

    def text(self, i: int) -> str:
        """Point `i` in words: its label, its value, or the values of the parameters that vary together."""
        if self._index is not None:
            value = self._index.values[i]
            return self._quantity(self._index, value) if self.is_numeric else str(value)
        if len(self._beside) == 1:
            return self._quantity(self._beside[0], self._beside[0].values[i])
        if 1 < len(self._beside) <= _MOST_BESIDE:
            return ", ".join(f"{short_name(c)} = {self._quantity(c, c.values[i])}" for c in self._beside)
        return str(i)

    def _quantity(self, array: xr.DataArray, value: float) -> str:
        unit = unit_of(array)
        return unit.text(value) if self._plain else f"{unit.of(value):.4g} {unit.printed}".rstrip()

    def heading(self, i: int) -> str:
        """Point `i` with the name of what it is a point of, short enough for the title of a panel."""
        if self._index is not None and self.is_numeric:
            return f"{short_name(self._index)} = {self.text(i)}"
        if len(self._beside) == 1 and (self._index is None or self.dim == f"{self._beside[0].name}_case"):
            return f"{short_name(self._beside[0])} = {self.text(i)}"
        if self._index is None and 1 < len(self._beside) <= _MOST_BESIDE:
            return self.text(i)
        return f"{self.dim}: {self.text(i)}".replace("_", " ")


def short_name(array: xr.DataArray) -> str:
    """The name of a quantity as people write it: `belt speed`, but `mu_stop` as in a configuration."""
    return spoken(quantity_of(str(array.name)))


def title(array: xr.DataArray, unit: Unit | None = None) -> str:
    """Long name with the unit in which it is shown, if there is one. unit : which, where that is known."""
    name = str(array.attrs.get("long_name", array.name)).replace("_", " ")
    printed = (unit or unit_of(array)).printed
    return f"{name} ({printed})" if printed else name


def _midpoints(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges between neighbouring centres, and as far outside the ends as inside; around a lone centre, a small cell."""
    if len(centres) == 1:
        half = 0.05 * abs(centres[0]) or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    inner = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - inner[0]], inner, [2 * centres[-1] - inner[-1]]])


def axis_names(ds: xr.Dataset, dims: Sequence[Hashable]) -> list[str]:
    """The headings of columns that say where along some dimensions a row of a table is."""
    return [MapAxis(ds, dim, plain=True).name for dim in dims]


def parts_over(ds: xr.Dataset, dims: Sequence[Hashable]) -> Iterator[tuple[list[str], xr.Dataset]]:
    """Each place along some dimensions, as the texts of such columns, and the dataset there."""
    axes = [MapAxis(ds, dim, plain=True) for dim in dims]
    for place in np.ndindex(tuple(ds.sizes[dim] for dim in dims)):
        yield [axis.text(i) for axis, i in zip(axes, place, strict=True)], ds.isel(dict(zip(dims, place, strict=True)))


# --- borders as lines -------------------------------------------------------------------------------------------------


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
