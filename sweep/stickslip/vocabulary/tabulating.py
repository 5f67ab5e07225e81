"""The numbers of a table, as the kernels have them: polynomials between knots, and the *stations* of their shape.

A shape that people write as two functions is looked at once, and becomes quintics that have its values and slopes at
the ends and in the middle of each piece. A piece that would miss it is halved.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import inf, isfinite

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Shape = Callable[[float], float]

FASTEST = 1e4  # z up to which a shape is looked at
_ROWS, _TERMS, _STATIONS = 4, 6, 512  # as the kernels have them (`layout.py`)
_BUCKETS = (np.arange(_STATIONS) + (1013 << 4) << 48).view(np.float64) * (1.0 - 1e-12) - 2.0**-10  # begin just above
_PIECES = _STATIONS - 3  # below the first knot, and beyond the last one, there is one each; rows end in inf
_GRID = 1e-3 * np.sinh(np.linspace(0.0, np.arcsinh(1e3 * FASTEST), 65))  # the first knots
_NODES = np.array([0.0, 0.5, 1.0])  # of a piece: what fixes it
_BETWEEN = np.linspace(0.0, 1.0, 18)[1:-1]  # what tries it
_SHAPE, _SLOPE = 5e-10, 5e-9  # that a table may miss where it is tried, the latter over the steepest slope
_ROUNDING = 4e-15  # of differences of the shape
_NARROWEST = 1e-8  # piece; one that misses a shape holds a kink or a jump
_FINER = np.arange(4) / 4.0  # parts of pieces that may be stations
_BENT = 1e-4  # by which a cubic between neighbouring stations may miss the shape
_TURNED, _FLAT = 1e-6, 1e-9  # of the range of slopes, of the steepest: so much there and back is a turn


def stations_of(places: Floats, knots: Floats, powers: Floats) -> Floats:
    """What the kernels must know. powers : by knot, the coefficients of the polynomial from there on, (n, any)."""
    rows = np.zeros((_ROWS + _TERMS, _STATIONS))
    rows[:2] = inf
    for row, starts, values in zip(rows, rows[2:], (np.union1d(places, 0.0), knots), strict=False):
        row[0], row[1 : values.size + 1] = 0.0, values
        starts[:] = np.searchsorted(row[1:], _BUCKETS, side="right")
    rows[_ROWS : _ROWS + 2, 0] = powers[0, :2]  # the tangent, below the first knot
    rows[_ROWS : _ROWS + powers.shape[1], 1 : knots.size + 1] = powers.T
    return rows


def tabulated(shape: Shape, slope: Shape) -> Floats:
    """The numbers of a shape that people wrote. Raises ValueError where it is none, or no table has it."""
    shape_at, slope_at = partial(_values, "shape", shape), partial(_values, "slope", slope)
    if abs((start := shape_at(np.zeros(1))[0]) - 1.0) > 1e-12:
        raise ValueError(f"shape(0) is {start:g}, expected 1: a3 is friction at rest less a1")
    knots = _GRID
    while True:
        low, width = knots[:-1, None], np.diff(knots)[:, None]
        nodes, places = low + width * _NODES, low + width * _BETWEEN
        values, slopes = shape_at(nodes), slope_at(nodes)
        if (least := values.min()) < -_ROUNDING:
            z = nodes.flat[np.argmin(values)]
            raise ValueError(f"shape({z:g}) is {least:g}, expected at least 0, as friction is in slip")
        # of differences from the start of each piece, so that little is lost to rounding
        powers = np.hstack([values - values[:, :1], slopes * width]) @ _OF_NODES + values[:, :1] * _CONSTANT
        size = np.maximum(values, 1.0).max(axis=1, keepdims=True)
        off = np.abs(polyval(_BETWEEN, powers.T) - shape_at(places)) / (_SHAPE * size)
        slope_off = np.abs(polyval(_BETWEEN, polyder(powers.T)) / width - slope_at(places))
        slope_off /= _SLOPE * np.abs(slopes).max() + _ROUNDING * size / width
        missed = np.maximum(off, slope_off).max(axis=1) > 1.0
        if not missed.any():
            break
        narrow = np.argmin(np.where(missed, width[:, 0], inf))
        if knots.size + np.count_nonzero(missed) > _PIECES + 1 or width[narrow, 0] < _NARROWEST:
            rise = (values[narrow, 2] - values[narrow, 0]) / width[narrow, 0]
            raise ValueError(
                f"no smooth curve near z = {knots[narrow]:.6g}: slope({nodes[narrow, 1]:.6g}) is "
                f"{slopes[narrow, 1]:.6g}, and the shape rises by {rise:.6g} there; expected a shape without kinks and "
                "jumps and its derivative; Table(w, mu) takes points"
            )
        knots = np.union1d(knots, nodes[missed, 1])
    finer = np.ravel(low + width * _FINER)
    places = plain_places(
        finer, np.ravel(polyval(_FINER, powers.T)), np.ravel(polyval(_FINER, polyder(powers.T)) / width)
    )
    at_last = values[-1, -1] * _CONSTANT  # beyond the last knot the shape stays what it is there
    return stations_of(places, knots, np.vstack([powers / width ** np.arange(_TERMS), at_last]))


def _of_nodes() -> Floats:
    """The coefficients of a quintic from its values and slopes at `_NODES`, as a matrix to multiply them with."""
    powers = np.vander(_NODES, _TERMS, increasing=True)
    slopes = np.hstack([np.zeros((_NODES.size, 1)), powers[:, :-1] * np.arange(1, _TERMS)])
    return np.linalg.inv(np.vstack([powers, slopes])).T


_OF_NODES, _CONSTANT = _of_nodes(), np.eye(_TERMS)[0]


def _values(what: str, function: Shape, places: Floats) -> Floats:
    """A function that people wrote, at places. Raises ValueError where it fails, or gives no finite number."""
    values = np.empty(places.shape)
    for n, z in enumerate(places.flat):
        try:
            values.flat[n] = value = float(function(float(z)))
        except Exception as error:  # of code that people wrote
            raise ValueError(f"{what}({z:g}) fails: {error}") from error
        if not isfinite(value):
            raise ValueError(f"{what}({z:g}) is {value}, expected a finite number")
    return values


def plain_places(z: Floats, shape: Floats, slope: Floats) -> Floats:
    """As few of the places `z` as will do: from one to the next the slope is monotone, and a cubic nearly the shape."""
    turns, chosen, start, last = _turns(slope), [0], 0, z.size - 1
    while start < last:
        end, limit = start + 1, min([turn for turn in turns if turn > start], default=last)
        step = limit - start
        while step:  # as far as it goes, by doubling and halving
            if end + step <= limit and _is_cubic(z[start : end + step + 1], shape[start:], slope[start:]):
                end += step
            step //= 2
        chosen.append(start := end)
    return z[chosen]


def _turns(values: Floats) -> list[int]:
    """Numbers of the extrema of a row that goes there and back by more than rounding and noise do."""
    turns, extreme, direction = list[int](), 0, 0
    least = max(_TURNED * float(np.ptp(values)), _FLAT * float(np.abs(values).max()))
    for i, value in enumerate(values.tolist()):
        change = value - values[extreme]
        if direction * change > 0.0 or direction == 0 and abs(change) > least:
            extreme, direction = i, 1 if change > 0.0 else -1
        elif abs(change) > least:
            turns.append(extreme)
            extreme, direction = i, -direction
    return turns


def _is_cubic(z: Floats, shape: Floats, slope: Floats) -> bool:
    """Return whether a shape is nearly a cubic from the first to the last of these places."""
    last = z.size - 1
    h, t = z[last] - z[0], (z - z[0]) / (z[last] - z[0])
    cubic = (
        shape[0] * (1.0 + 2.0 * t) * (1.0 - t) ** 2 + shape[last] * t * t * (3.0 - 2.0 * t)
        + h * t * (1.0 - t) * (slope[0] * (1.0 - t) - slope[last] * t)
    )  # fmt: skip
    return bool(np.all(np.abs(cubic - shape[: z.size]) <= _BENT * (1.0 + np.abs(shape[: z.size]))))
