"""The picture of a view: cells computed or read, as colours, numbers and words."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from math import prod

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import distance_transform_edt  # type: ignore[import-untyped]

from stickslip.config.grid import options_of
from stickslip.config.model import Config
from stickslip.dataset import coarse
from stickslip.dataset.coarse import Pixel
from stickslip.dataset.display import MapAxis, unit_of
from stickslip.engine import StopFlag, blocks, in_order, warm_up
from stickslip.errors import StoppedError
from stickslip.plots.palette import FLAG_COLOURS, UNDEFINED_COLOUR, Paint, marked, paint, regime_label
from stickslip.runs.work import MapStudy
from stickslip.vocabulary.display_units import Unit, number, unit_for
from stickslip.vocabulary.quantities import FLAGS, VARIABLES
from stickslip.vocabulary.units import spelled
from stickslip_explore.view import FULL, Sides, Source, View

Floats = NDArray[np.float64]
SHADES = 256  # colours of a picture
_LEVELS = SHADES - 1  # of the colours of numbers; the last one is for cells without a value
HOVER = ("regime", "frequency", "stick_fraction", "velocity_amplitude", "slip_speed_max", "spring_force_max")
_ORDER = {name: i for i, name in enumerate(VARIABLES)}
_BLANK = "#ffffff"  # of cells without a flag
_TICKS = 5  # of the scale of colours
_PLACES, _SHAPE, _WIDE = 40, 3.0, 0.09  # places along a side where names may stand; their shape, and room in all places


@dataclass(frozen=True, eq=False)
class MapSide:
    """One side of a map in the coordinates of the page: values in a unit, their logarithm, or positions 0, 1, 2 ...

    ends : edges of the first and the last pixel. centres, values : of the pixels, there and in SI. labels : of listed
    points.
    """

    name: str
    title: str
    kind: str
    unit: Unit
    ends: tuple[float, float]
    centres: Floats
    values: Floats
    labels: tuple[str, ...] = ()

    def place(self, value: ArrayLike) -> Floats:
        """The coordinates on the page of values in SI, or of positions."""
        if self.kind == "listed":
            return np.asarray(value, np.float64)
        scaled = np.asarray(value, np.float64) / self.unit.size
        return np.asarray(np.log10(scaled) if self.kind == "log" else scaled)

    def nearest(self, place: float) -> int:
        """The pixel at a coordinate of the page."""
        return int(np.abs(self.centres - place).argmin())

    def at(self, i: int) -> float | int:
        """The coordinate of pixel `i`: a value in SI, or the position of a listed point."""
        return i if self.kind == "listed" else float(self.values[i])

    def text(self, at: float | int) -> str:
        """Such a coordinate in words."""
        return self.labels[int(at)] if self.kind == "listed" else self.unit.text(float(at), 4)


@dataclass(frozen=True, eq=False)
class PixelColumn:
    """One variable over the pixels, in a unit; codes of flags as they are, with their names. NaN: no value."""

    name: str
    label: str
    unit: Unit
    values: NDArray[np.float32]
    names: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class MapPicture:
    """A map as it is drawn.

    shades : (rows, columns), numbers of colours in `palette`, which has `SHADES`. legend : names and colours of flags.
    ticks : of the scale of a number, places from 0 to 1 with their words. note : what a pixel shows, where it is not
    one cell. regions : names of flags, and where they are written: x and y.
    """

    y: MapSide
    x: MapSide
    variable: str
    title: str
    shades: NDArray[np.uint8]
    palette: tuple[str, ...]
    legend: tuple[tuple[str, tuple[str, ...]], ...]
    ticks: tuple[tuple[float, str], ...]
    note: str
    columns: tuple[PixelColumn, ...]
    regions: tuple[tuple[str, float, float], ...] = ()

    @property
    def units(self) -> dict[str, Unit]:
        """In what the numbers under the pointer are told, by variable."""
        return {column.name: column.unit for column in self.columns if not column.names}


def computed(config: Config, stop: StopFlag) -> xr.Dataset | None:
    """The map of a configuration; None if the flag was raised on the way. In blocks, on threads."""
    study = MapStudy(config, options_of(config))
    for kernel in study.kernels:
        warm_up(kernel)
    parts = blocks(prod(study.shape), study.options)
    try:
        columns = [*in_order(lambda cells: study.compute(cells, stop), parts, study.options.threads)]
    except StoppedError:
        return None
    return study.dataset(columns, {"title": config.title})


def read(source: Source, view: View) -> xr.Dataset:
    """The cells of a view that shows what its file holds: two dimensions of it, nothing read yet."""
    assert source.computed is not None
    ds, at = source.computed, {}
    dims = dict(zip(source.axes, ds["regime"].dims, strict=True))
    for name, dim in dims.items():
        if name not in view.plane:
            at[dim] = view.points.get(name, 0)
            if name not in view.points and MapAxis(ds, dim).is_numeric:
                value = view.values.get(name, source.typical[name])
                at[dim] = int(np.abs(ds[dim].values - value).argmin())
    return ds.isel(at).transpose(dims[view.y], dims[view.x], ...)


def variables(ds: xr.Dataset) -> list[tuple[str, str]]:
    """The variables that can be drawn: names and titles, in the order of the vocabulary, whatever that of a file is."""
    dims = ds["regime"].dims
    names = [str(name) for name in ds.data_vars if ds[name].dims == dims and name != "steps"]
    ordered = sorted(names, key=lambda name: _ORDER.get(name, len(_ORDER)))
    return [(name, _label(ds[name])) for name in ordered]


def picture(ds: xr.Dataset, view: View, most: Sides = FULL) -> MapPicture:
    """The map in a dataset over (y, x), reduced where it has more cells than the page has pixels, `most`."""
    y_dim, x_dim = ds["regime"].dims
    if unsorted := [dim for dim in (y_dim, x_dim) if MapAxis(ds, dim).is_numeric and (np.diff(ds[dim]) < 0).any()]:
        ds = ds.sortby(unsorted)  # which copies it all
    pixel = coarse.pixel_for((ds.sizes[y_dim], ds.sizes[x_dim]), most)
    variable = view.variable if view.variable in ds.data_vars else "regime"
    is_flag = variable in FLAG_COLOURS
    shades, palette, painted, values = _shaded(ds[variable], variable, pixel)
    unit = unit_shown(ds[variable], values)
    title = f"{_label(ds[variable])} ({unit.name})" if unit.name else _label(ds[variable])
    hover = HOVER if pixel == (1, 1) else ("regime",)
    names = dict.fromkeys((*(name for name in hover if name in ds), variable))
    columns = tuple(_column(ds[name], pixel) for name in names)
    y, x = side(ds, y_dim, view.y, pixel[0]), side(ds, x_dim, view.x, pixel[1])
    return MapPicture(
        y, x, variable, title, shades, palette, _legend(painted), _ticks(painted, unit),
        coarse.pixel_note(pixel, is_flag), columns, regions(variable, shades, y, x) if is_flag else (),
    )  # fmt: skip


def regions(variable: str, codes: NDArray[np.uint8], y: MapSide, x: MapSide) -> tuple[tuple[str, float, float], ...]:
    """Places for the names of flags, so that colours are not needed to tell them apart: what is farthest from all else,
    letters being wider than high; what is too narrow for a name has none."""
    rows, columns = (np.arange(_PLACES) * n // _PLACES for n in codes.shape)
    few = codes[np.ix_(rows, columns)]
    named = []
    for code in np.unique(few[few < len(FLAGS[variable])]):  # mixed pixels belong to none
        inside = np.pad(few == code, 1)
        away = distance_transform_edt(inside, sampling=(_SHAPE, 1.0))[1:-1, 1:-1]
        i, j = np.unravel_index(int(away.argmax()), away.shape)
        if away[i, j] >= _WIDE * _PLACES:
            name = regime_label(list(FLAGS[variable])[code]).partition(" (")[0]
            named.append((name, float(x.centres[columns[j]]), float(y.centres[rows[i]])))
    return tuple(named)


def side(ds: xr.Dataset, dim: Hashable, name: str, step: int) -> MapSide:
    """A dimension of a map as a side of its picture, in pixels of `step` cells."""
    axis = MapAxis(ds, dim, plain=True)
    evenly = axis.is_numeric and _is_even(axis)
    if not evenly:
        places = np.arange(axis.length, dtype=np.float64)
        labels = tuple(axis.text(i) for i in range(axis.length))
        return MapSide(name, axis.title, "listed", Unit(), (-0.5, axis.length - 0.5), places, places, labels)
    values, edges = axis.unit.to_si(axis.pixel_points(step)), axis.unit.to_si(axis.edges)
    unit = unit_shown(ds[dim], np.sqrt(values[0] * values[-1]) if axis.is_log else values)
    words = str(ds[dim].attrs.get("long_name", name))
    title = f"{words} ({unit.name})" if unit.name else words
    scale = MapSide(name, title, "log" if axis.is_log else "linear", unit, (0.0, 1.0), values, values)
    ends, centres = scale.place(np.array([edges[0], edges[-1]])), scale.place(values)
    return MapSide(name, title, scale.kind, unit, (float(ends[0]), float(ends[1])), centres, values)


def _is_even(axis: MapAxis) -> bool:
    """True if pixels of one width show the cells where they are."""
    if axis.length < 2:
        return False
    steps = np.diff(np.log(axis.centres) if axis.is_log else axis.centres)
    return bool(np.allclose(steps, steps.mean(), rtol=1e-3, atol=0.0))


def _shaded(
    array: xr.DataArray, variable: str, pixel: Pixel
) -> tuple[NDArray[np.uint8], tuple[str, ...], Paint, NDArray[np.generic]]:
    """A variable as numbers of colours, the colours, and how they were chosen: those of all plots."""
    if variable in FLAG_COLOURS:
        reduced = coarse.flags(array, pixel)
        values = marked(variable, reduced)
        known = np.ma.compressed(values)  # cells that were left out (`where`) have no flag
        painted = paint(variable, known, reduced.present)
        colours = [to_hex(painted.colours(painted.norm(code))) for code in range(2 * len(FLAG_COLOURS[variable]))]
        shades = np.ma.filled(values.astype(np.uint8), len(colours))
        return shades, (*colours, *[_BLANK] * (SHADES - len(colours))), painted, known
    values = coarse.numbers(array, pixel).values
    painted = paint(variable, values)
    finite = np.isfinite(values)
    shares = np.asarray(painted.norm(np.where(finite, values, float(painted.norm.vmin or 0.0))), np.float64)
    shades = np.where(finite, np.clip(shares * (_LEVELS - 1), 0, _LEVELS - 1).round(), _LEVELS)
    colours = [to_hex(painted.colours(i / (_LEVELS - 1))) for i in range(_LEVELS)]
    return shades.astype(np.uint8), (*colours, UNDEFINED_COLOUR), painted, values


def _legend(painted: Paint) -> tuple[tuple[str, tuple[str, ...]], ...]:
    entries = []
    for entry in painted.handles():
        patches = entry if isinstance(entry, tuple) else (entry,)
        entries.append((str(patches[0].get_label()), tuple(to_hex(patch.get_facecolor()) for patch in patches)))
    return tuple(entries)


def _ticks(painted: Paint, unit: Unit) -> tuple[tuple[float, str], ...]:
    """The scale of a number, in a unit."""
    if painted.flags is not None:
        return ()
    places = np.linspace(0.0, 1.0, _TICKS)
    at = np.asarray(painted.norm.inverse(places), np.float64) / unit.size
    return tuple((float(place), number(float(value))) for place, value in zip(places, at, strict=True))


def _column(array: xr.DataArray, pixel: Pixel) -> PixelColumn:
    name = str(array.name)
    if name in FLAGS:
        labels = tuple(map(regime_label, FLAGS[name]))
        codes = np.ma.filled(coarse.flags(array, pixel).values.astype(np.float32), np.nan)
        return PixelColumn(name, name, Unit(), codes, labels)
    values = coarse.numbers(array, pixel).values
    unit = unit_shown(array, _usual(values))
    return PixelColumn(name, name.replace("_", " "), unit, (values / unit.size).astype(np.float32))


def unit_shown(array: xr.DataArray, values: ArrayLike) -> Unit:
    """The unit for an array of a dataset: that which people asked for, else what suits the values."""
    si, shown = str(array.attrs.get("units", "1")), unit_of(array)
    if shown.name not in (spelled(si), "Hz", "s", "ms", "µs"):
        return Unit(shown.name, shown.size)
    return unit_for(si, values)


def _usual(values: Floats) -> Sequence[float]:
    """The usual size of the values where they are not zero, as amplitudes are of what settles."""
    finite = np.abs(values[np.isfinite(values) & (values != 0)])
    return [float(np.median(finite))] if finite.size else []


def _label(array: xr.DataArray) -> str:
    return str(array.attrs.get("long_name", array.name))
