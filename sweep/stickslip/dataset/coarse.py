"""Maps of any size, chunk by chunk: shares of their regimes, cells that need attention, and pixels.

A chunk read here is whole along the last dimensions, like those our files are stored in, and consists of whole stored
chunks of a lazy array where that is possible, so that none of them is read twice.

A pixel of n x m cells has one value that stands for all of them: the most frequent flag, with a mark where the
pixel holds others as well, or the mean of the cells that have a value. Nothing is skipped, so a thin regime shows at
least as a mark.
"""

import shlex
from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import ceil, prod
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip.config.reader import parse_config
from stickslip.errors import ConfigError
from stickslip.vocabulary.quantities import FLAGS, did_you_mean, listed

MOST_VALUES = 2**21  # of a chunk: 16 MiB of float64
Chunk = dict[Hashable, slice]
Pixel = tuple[int, int]  # rows and columns of cells
_LEFT_OUT = -1  # where `where` left a flag out; no flag has this code
BAD_REGIMES = ("failed", "unresolved", "not_computed")  # cells that say nothing about the contact
NOT_KEPT = "not kept"  # in place of a status
_CODES = 256  # what fits in the byte of a flag


@dataclass(frozen=True)
class Coarse:
    """One value per pixel, shape (pixels down, pixels across).

    mixed : where a pixel holds more than one flag; None for numbers, and where every pixel is one cell.
    present : the flags of all cells, ascending, also those that are nowhere the most frequent; empty for numbers.
    """

    values: NDArray[Any]
    mixed: NDArray[np.bool_] | None = None
    present: tuple[int, ...] = ()


def pixel_for(shape: tuple[int, int], most: tuple[int, int]) -> Pixel:
    """The smallest pixel with which there are no more than `most` along a side."""
    return max(1, ceil(shape[0] / most[0])), max(1, ceil(shape[1] / most[1]))


def pixel_note(pixel: Pixel, is_flag: bool) -> str:
    """The meaning of a pixel, in words; nothing where it is one cell."""
    if pixel == (1, 1):
        return ""
    rows, columns = pixel
    cells = f"{columns} x {rows} cells" if rows > 1 and columns > 1 else f"{rows * columns} cells"
    what = "their most frequent value" if is_flag else "the mean of those that have a value"
    return f"each pixel shows {cells}: {what}"


def flags(array: xr.DataArray, pixel: Pixel) -> Coarse:
    """The most frequent flag of every pixel (of equally frequent ones that with the lower code), and which are mixed.

    array : integers over two dimensions; or what `where` makes of them, with NaN for cells that were left out. Pixels
        of which all cells were left out are masked.
    """
    if array.dtype.kind == "f":
        coarse = flags(array.fillna(_LEFT_OUT).astype(np.int8), pixel)
        known = tuple(code for code in coarse.present if code != _LEFT_OUT)
        hidden = coarse.values == _LEFT_OUT
        masked = np.ma.masked_array(np.where(hidden, min(known, default=0), coarse.values), hidden)
        return Coarse(masked, coarse.mixed, known)
    if pixel == (1, 1):
        cells = array.values
        return Coarse(cells, None, tuple(np.unique(cells).tolist()))
    codes: set[int] = set()
    values, mixed = _blank(array.shape, pixel, array.dtype), _blank(array.shape, pixel, np.dtype(np.bool_))
    for place, cells in _chunks(array, pixel):
        present = np.unique(cells[cells != _LEFT_OUT])
        if not present.size:
            values[place] = _LEFT_OUT
            continue
        counts = np.stack([_sums(cells == code, pixel, np.int32) for code in present])
        values[place] = np.where(counts.any(axis=0), present[counts.argmax(axis=0)], _LEFT_OUT)
        mixed[place] = np.count_nonzero(counts, axis=0) > 1
        codes |= set(present.tolist())
    return Coarse(values, mixed, tuple(sorted(codes)))


def numbers(array: xr.DataArray, pixel: Pixel) -> Coarse:
    """The mean of every pixel over its cells with a finite value; NaN where there is none.

    array : numbers over two dimensions.
    """
    if pixel == (1, 1):
        return Coarse(array.values.astype(np.float64, copy=False))
    means = _blank(array.shape, pixel, np.dtype(np.float64))
    for place, cells in _chunks(array, pixel):
        finite = np.isfinite(cells)
        counts = _sums(finite, pixel, np.int32)
        with np.errstate(invalid="ignore", over="ignore"):  # 0/0 is what NaN means here
            means[place] = _sums(np.where(finite, cells, 0.0), pixel, np.float64) / counts
    return Coarse(means)


def centres(array: xr.DataArray, pixel: Pixel) -> NDArray[np.float64]:
    """The value at the cell in the middle of every pixel (`middles`): exact, where a mean would be blurred."""
    rows, columns = (middles(n, step) for n, step in zip(array.shape, pixel, strict=True))
    return np.asarray(array.isel(dict(zip(array.dims, (rows, columns), strict=True))).values, np.float64)


def middles(length: int, step: int) -> NDArray[np.intp]:
    """The number of the cell in the middle of each pixel along an axis; the last pixel may be short."""
    starts = np.arange(0, length, step)
    return (starts + np.minimum(starts + step, length)) // 2


def _blank(shape: tuple[int, ...], pixel: Pixel, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Room for one value per pixel."""
    return np.zeros([ceil(length / step) for length, step in zip(shape, pixel, strict=True)], dtype)


def _chunks(array: xr.DataArray, pixel: Pixel) -> Iterator[tuple[tuple[slice, ...], NDArray[Any]]]:
    """Slices of pixels and the cells of each chunk, which is made of whole pixels."""
    across = max(1, MOST_VALUES // pixel[0] // pixel[1]) * pixel[1]
    down = max(1, MOST_VALUES // pixel[0] // min(across, array.shape[1])) * pixel[0]
    for chunk in cut(array.sizes, dict(zip(array.dims, (down, across), strict=True))):
        steps = zip(chunk.values(), pixel, strict=True)
        place = tuple(slice(part.start // step, ceil(part.stop / step)) for part, step in steps)
        yield place, array.isel(chunk).values


def _sums(cells: NDArray[Any], pixel: Pixel, dtype: type[np.generic]) -> NDArray[Any]:
    """The sum of every pixel; those at the ends may be short."""
    (rows, columns), (down, across) = pixel, (ceil(n / step) for n, step in zip(cells.shape, pixel, strict=True))
    if cells.shape != (down * rows, across * columns):
        whole = np.zeros((down * rows, across * columns), cells.dtype)
        whole[: cells.shape[0], : cells.shape[1]] = cells
        cells = whole
    columnwise = cells.reshape(down, rows, across * columns).sum(axis=1, dtype=dtype)  # first down: the sum is shorter
    return np.asarray(columnwise.reshape(down, across, columns).sum(axis=2))


# --- chunks -----------------------------------------------------------------------------------------------------------


def chunks(array: xr.DataArray, most: int = MOST_VALUES) -> Iterator[Chunk]:
    """Chunks of at most `most` values (or of one stored chunk) that make up the array, in the order of its cells."""
    stored = {dim: max(lengths) for dim, lengths in array.chunksizes.items()}
    stored = stored or array.encoding.get("preferred_chunks", {})  # of a file that is read without dask
    steps = _steps(array.dims, array.sizes, stored, most)
    return cut(array.sizes, dict(zip(array.dims, steps, strict=True)))


def cut(lengths: Mapping[Hashable, int], steps: Mapping[Hashable, int]) -> Iterator[Chunk]:
    """Ranges of `steps` points along each dimension, the last ones shorter; the last dimension runs fastest."""
    starts = (range(0, length, steps[dim]) for dim, length in lengths.items())
    for corner in product(*starts):
        places = zip(lengths.items(), corner, strict=True)
        yield {dim: slice(start, min(start + steps[dim], length)) for (dim, length), start in places}


def _steps(
    dims: Sequence[Hashable], lengths: Mapping[Hashable, int], stored: Mapping[Hashable, int], most: int
) -> list[int]:
    """Points per chunk along each dimension: a stored chunk, and more from the last dimension on if there is room."""
    steps = [min(stored.get(dim, 1), max(1, lengths[dim])) for dim in dims]
    for i in reversed(range(len(dims))):
        length = max(1, lengths[dims[i]])
        room = most // prod(steps[:i] + steps[i + 1 :])
        steps[i] = length if room >= length else max(steps[i], room // steps[i] * steps[i])
        if steps[i] < length:
            break
    return steps


# --- what is in a map -------------------------------------------------------------------------------------------------


class Share(NamedTuple):
    """Number of cells, and their part of all cells."""

    cells: int
    fraction: float


def summary(ds: xr.Dataset) -> dict[str, Share]:
    """The regimes that occur, in the order of `REGIMES`, with their number of cells and their share of the dataset."""
    cells = flag_counts(ds["regime"])
    total = max(1, sum(cells.values()))
    return {name: Share(n, n / total) for name, n in cells.items() if n}


def flag_counts(flags: xr.DataArray) -> dict[str, int]:
    """Number of cells with each value of a flag, by name, in one pass that holds little in memory.

    Codes without a name, which a newer version may have written, are counted as ``code_9``.
    """
    counts, flag = np.zeros(_CODES, np.int64), str(flags.name)
    for chunk in chunks(flags):
        part = flags.isel(chunk).values
        counts += np.bincount(part[~np.isnan(part)].astype(np.uint8), minlength=_CODES)
    return {_name(flag, code): int(n) for code, n in enumerate(counts) if n or code < len(FLAGS[flag])}


def remark(parts: Mapping[str, Share], file: str) -> str | None:
    """A line about cells without a result, and the command that lists them; None if there are none.

    parts : as `summary` gives them. file : of the map.
    """
    counts = [f"{parts[name].cells:,} {name.replace('_', ' ')}" for name in BAD_REGIMES if name in parts]
    return f"{listed(counts, 'and')} cells: stickslip inspect {shlex.quote(file)}" if counts else None


def table_remark(ds: xr.Dataset) -> str | None:
    """A sentence on slip that is faster than the fastest point of the table that a map was computed with."""
    text, speeds = str(ds.attrs.get("configuration", "")), ds.get("slip_speed_max")
    if speeds is None or "law: table_" not in text:
        return None
    from stickslip.vocabulary.own_laws import beyond_points

    law, known = parse_config(text).friction.law, ds["a4"]
    parts = ((speeds.isel(chunk), known.isel(chunk, missing_dims="ignore")) for chunk in chunks(speeds))
    beyond = (beyond_points(law, *(array.values for array in xr.broadcast(*part))) for part in parts)
    return next(filter(None, beyond), None)


# --- cells one by one -------------------------------------------------------------------------------------------------


class MapCell(NamedTuple):
    """One cell: its number in the map, its position by dimension, and what became of it."""

    number: int
    position: dict[str, int]
    regime: str
    status: str


class Survey(NamedTuple):
    """The contents of a map.

    counts : cells by (regime, status), the most frequent first; the status is NOT_KEPT where the map holds none.
    wanted : how many cells were asked for.
    cells : the first of those.
    """

    counts: dict[tuple[str, str], int]
    wanted: int
    cells: list[MapCell]


def survey(ds: xr.Dataset, *, regimes: Collection[str] = (), statuses: Collection[str] = (), limit: int = 20) -> Survey:
    """Count the cells of a map by what became of them, and list the first `limit` of some.

    regimes, statuses : which cells to list, by names; without any, those that failed, are unresolved or were not
        computed.
    Raises ConfigError for names that do not exist, and where statuses are asked of a map that does not hold them.
    """
    chosen_regimes = _chosen("regime", regimes or (() if statuses else BAD_REGIMES))
    chosen = np.logical_and.outer(chosen_regimes, _chosen("status", statuses))
    has_status = "status" in ds.data_vars
    if statuses and not has_status:
        raise ConfigError.of("--status", "the map holds no status", "output.variables says what a map holds")

    def names(regime: int, status: int) -> tuple[str, str]:
        return _name("regime", regime), _name("status", status) if has_status else NOT_KEPT

    counts, cells = np.zeros(chosen.size, np.int64), list[MapCell]()
    for chunk in chunks(ds["regime"]):
        regime = ds["regime"].isel(chunk).values.astype(np.uint8)
        status = ds["status"].isel(chunk).values.astype(np.uint8) if has_status else np.zeros_like(regime)
        counts += np.bincount(regime.ravel().astype(np.intp) * _CODES + status.ravel(), minlength=chosen.size)
        for inside in np.argwhere(chosen[regime, status])[: limit - len(cells)].tolist():
            place = [part.start + i for part, i in zip(chunk.values(), inside, strict=True)]
            position, at = dict(zip(map(str, chunk), place, strict=True)), tuple(inside)
            number = int(np.ravel_multi_index(place, ds["regime"].shape))
            cells.append(MapCell(number, position, *names(regime[at], status[at])))
    present = np.flatnonzero(counts)
    ranked = present[np.argsort(-counts[present], kind="stable")]
    counted = {names(*divmod(int(code), _CODES)): int(counts[code]) for code in ranked}
    return Survey(counted, int(counts[chosen.ravel()].sum()), cells)


def _chosen(flag: str, names: Collection[str]) -> NDArray[np.bool_]:
    """Marks of the codes of a flag that have these names; of all, without any names."""
    known = list(FLAGS[flag])
    chosen = np.full(_CODES, not names)
    for name in names:
        if name not in known:
            raise ConfigError.of(f"--{flag}", f"got {name!r}, expected {listed(known)}", did_you_mean(name, known))
        chosen[known.index(name)] = True
    return chosen


def _name(flag: str, code: int) -> str:
    names = list(FLAGS[flag])
    return names[code] if code < len(names) else f"code_{code}"
