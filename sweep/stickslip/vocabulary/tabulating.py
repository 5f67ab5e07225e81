"""The numbers of a table, as the kernels have them: polynomials between knots, and the *stations* of their shape.

A shape that people write as two functions is looked at once, and becomes quintics that have its values and slopes at
the ends and in the middle of each piece. A piece that would miss it is halved.
"""

from __future__ import annotations

from collections.abc import Callable
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
_SHAPE, _SLOPE = 1e-9, 1e-8  # what a table may miss, the latter over the steepest slope
_ROUNDING = 4e-15  # of differences of the shape
_NARROWEST = 1e-8  # piece; one that misses a shape holds a kink or a jump
_UNLIKE, _STEP = 1e-6, 1e-3  # of the slope: that of another shape; of a piece, for a difference
_FINER = 4  # than the pieces: places that may be stations
_BENT = 1e-4  # by which a cubic between neighbouring stations may miss the shape
_TOO_MUCH = (
    f"{{law}}: {_PIECES} polynomials do not have the shape to {_SHAPE:g} and its slope to {_SLOPE:g}, at last near "
    "z = {z:.6g}; expected one that bends less"
)
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


def tabulated(law: str, shape: Shape, slope: Shape) -> Floats:
    """The numbers of a shape that people wrote. Raises ValueError where it is none, or no table has it."""
    if abs((start := _values(law, "shape", shape, np.zeros(1))[0]) - 1.0) > 1e-12:
        raise ValueError(f"{law}: shape(0) is {start:g}, expected 1: a3 is friction at rest less a1")
    pieces = _Pieces(law, shape, slope, _GRID)
    while pieces.missing.any():
        pieces = pieces.halved()
    return pieces.stations()


class _Pieces:
    """Quintics between knots. missing : those that miss the shape.

    Raises ValueError for what is no shape.
    """

    def __init__(self, law: str, shape: Shape, slope: Shape, knots: Floats) -> None:
        self._of, self._knots, self._widths = (law, shape, slope), knots, np.diff(knots)
        at, between = (knots[:-1, None] + self._widths[:, None] * share for share in (_NODES, _BETWEEN))
        self._shape, self._slope = _values(law, "shape", shape, at), _values(law, "slope", slope, at)
        if (least := self._shape.min()) < -_ROUNDING:
            z = at.flat[np.argmin(self._shape)]
            raise ValueError(f"{law}: shape({z:g}) is {least:g}, expected at least 0, as friction is in slip")
        start = self._shape[:, :1]  # of which all that follows is a difference, so that little is lost to rounding
        self._powers = np.hstack([self._shape - start, self._slope * self._widths[:, None]]) @ _OF_NODES
        self._powers[:, :1] += start
        off = np.abs(self._at(_BETWEEN)[0] - _values(law, "shape", shape, between)).max(axis=1)
        slope_off = np.abs(self._at(_BETWEEN)[1] - _values(law, "slope", slope, between)).max(axis=1)
        size, self._steepest = np.maximum(self._shape.max(axis=1), 1.0), np.abs(self._slope).max()
        self._rounding = _ROUNDING * size / self._widths  # of a difference over a piece
        self.missing = (off > _SHAPE * size) | (slope_off > _SLOPE * self._steepest + self._rounding)

    def _at(self, shares: Floats) -> tuple[Floats, Floats]:
        """The polynomials and their slopes at these shares of each piece."""
        slopes = polyval(shares, polyder(self._powers.T)) / self._widths[:, None]
        return polyval(shares, self._powers.T), slopes

    def halved(self) -> _Pieces:
        """Those that miss the shape in halves. Raises ValueError where that is of no use."""
        (law, shape, slope), narrow = self._of, np.flatnonzero(self.missing & (self._widths < _NARROWEST))
        if narrow.size:
            raise ValueError(
                f"{law}: the shape has a kink or a jump near z = {self._knots[narrow[0]]:.6g}, expected a smooth one; "
                "Table(w, mu) takes points"
            )
        middles = (self._knots[:-1] + 0.5 * self._widths)[self.missing]
        if self._knots.size + middles.size <= _PIECES + 1:
            return _Pieces(law, shape, slope, np.union1d(self._knots, middles))
        step = _STEP * self._widths[self.missing]
        slopes, (low, high) = _values(law, "slope", slope, middles), (middles - step, middles + step)
        rise = (_values(law, "shape", shape, high) - _values(law, "shape", shape, low)) / (high - low)
        unlike = np.abs(slopes - rise) - _UNLIKE * self._steepest - _ROUNDING / step
        if unlike[worst := int(np.argmax(unlike))] > 0.0:
            z, here, there = middles[worst], slopes[worst], rise[worst]
            raise ValueError(f"{law}: slope({z:g}) is {here:g}, and the shape rises by {there:g}")
        raise ValueError(_TOO_MUCH.format(law=law, z=middles[np.argmin(step)]))

    def stations(self) -> Floats:
        """What the kernels must know; beyond the last knot the shape stays what it is there."""
        powers = np.zeros((self._knots.size, _TERMS))
        powers[:-1] = self._powers / self._widths[:, None] ** np.arange(_TERMS)
        powers[-1, 0] = self._shape[-1, -1]
        shares = np.arange(_FINER) / _FINER
        finer = np.ravel(self._knots[:-1, None] + self._widths[:, None] * shares)
        places = plain_places(finer, *map(np.ravel, self._at(shares)))
        if places.size > _PIECES:
            raise ValueError(_TOO_MUCH.format(law=self._of[0], z=places[np.argmin(np.diff(places))]))
        return stations_of(places, self._knots, powers)


def _of_nodes() -> Floats:
    """The coefficients of a quintic from its values and slopes at `_NODES`, as a matrix to multiply them with."""
    powers = np.vander(_NODES, _TERMS, increasing=True)
    slopes = np.hstack([np.zeros((_NODES.size, 1)), powers[:, :-1] * np.arange(1, _TERMS)])
    return np.linalg.inv(np.vstack([powers, slopes])).T


_OF_NODES = _of_nodes()


def _values(law: str, what: str, function: Shape, places: Floats) -> Floats:
    """A function that people wrote, at places. Raises ValueError where it fails, or gives no finite number."""
    values = np.empty(places.shape)
    for n, z in enumerate(places.flat):
        try:
            values.flat[n] = value = float(function(float(z)))
        except Exception as error:  # of code that people wrote
            raise ValueError(f"{law}: {what}({z:g}) fails: {error}") from error
        if not isfinite(value):
            raise ValueError(f"{law}: {what}({z:g}) is {value}, expected a finite number")
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
