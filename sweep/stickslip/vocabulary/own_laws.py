"""Laws of friction of one's own, without a change to the program: measured tables, and shapes as functions.

Both become laws of the curve mu = a1 + a2 w + a3 shape(w/a4), so that whatever knows a law knows them. To the kernels
they are numbers, polynomials between knots and the *stations* of their shape, and all are computed by the same ones. A
shape that people write as two functions is looked at once, and becomes quintics that have its values and slopes at the
ends and in the middle of each piece. A piece that would miss it is halved.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from functools import cache, partial
from math import inf, isfinite
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval
from numpy.typing import ArrayLike, NDArray

from stickslip.vocabulary.cells import numbers_of
from stickslip.vocabulary.models import LAW_MESSAGES, LAWS, OWN_NAME, PREFIX, TABLE, OwnLaw, add_law, own_law
from stickslip.vocabulary.quantities import CURVE_COLUMNS

Floats = NDArray[np.float64]
Shape = Callable[[float], float]

ENTRY_POINTS = "stickslip.laws"  # group of a package: name of the law, and a module with `shape` and `slope`
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


# --- tables, and shapes as functions ----------------------------------------------------------------------------------

MOST_POINTS = 200
_CLOSEST = 1e-9  # two points, over the fastest speed
_TAKEN = (TABLE, PREFIX)  # beginnings of names


class Table(OwnLaw):
    """A measured friction curve, taken as it is: `law=Table(w, mu)` in place of a1, a2, a3 and a4.

    Parameters
    ----------
    w, mu : array
        Slip speeds (m/s), rising, and friction coefficients, above 0: 2 to 200 points. Texts with units and arrays that
        know theirs are converted.
    monotone : bool
        False: the cubic spline through the points, with continuous curvature. True: Fritsch and Carlson's cubics, which
        do not pass the points on either side, but have jumps of the curvature.

    Below the first and beyond the last point friction stays what it is there. The coefficients are a1 = a2 = 0, a3 the
    friction where the curve begins, and a4 the fastest speed: a3 scales the curve, a4 stretches it, a1 and a2 are
    added.

    Raises
    ------
    TypeError, ValueError
        For points that are no curve, or a spline that is not above 0.
    """

    __slots__ = ("monotone", "mu", "w")
    reach, positive = 1.0, True

    w: Floats
    mu: Floats
    monotone: bool

    def __new__(cls, w: ArrayLike, mu: ArrayLike, monotone: bool = False) -> Table:
        """The law of these points, which is known by its name from now on."""
        speed, friction = (numbers_of(row, value) for row, value in zip(CURVE_COLUMNS, (w, mu), strict=False))
        if fault := fault_of_points(speed, friction):
            raise ValueError(fault[1])
        digest = hashlib.sha256(np.stack([speed, friction]).tobytes() + bytes([bool(monotone)])).hexdigest()[:12]
        self = super().__new__(cls, f"{TABLE}_{digest}")
        self.w, self.mu, self.monotone = speed, friction, bool(monotone)
        self.text = f"{'monotone cubics' if monotone else 'a cubic spline'} through {speed.size} points"
        fastest = float(speed[-1])
        self.coefficients = {"a1": 0.0, "a2": 0.0, "a3": float(friction[0]), "a4": fastest}
        self.stations = _of_spline(speed / fastest, friction / friction[0], self.monotone)
        add_law(self)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return Table, (self.w, self.mu, self.monotone)

    def points(self) -> dict[str, Any]:
        """The points as plain data, which a configuration keeps."""
        return {"speed": self.w.tolist(), "mu": self.mu.tolist(), "monotone": self.monotone}


def beyond_points(name: str, slip_speed: ArrayLike, decay: ArrayLike) -> str | None:
    """A sentence where slip is faster than a law of one's own is known; None where it is not, or the law is none.

    slip_speed, decay : of cells, m/s; the latter is their a4.
    """
    if (own := own_law(name)) is None:
        return None
    speed, fastest = map(np.ravel, np.broadcast_arrays(slip_speed, np.multiply(own.reach, decay)))
    share = np.nan_to_num(speed / fastest)
    if not share.max(initial=0.0) > 1.0:
        return None
    most = int(np.argmax(share))
    return (
        f"slip reaches {speed[most]:.3g} m/s, and the fastest point of the table is at {fastest[most]:.3g} m/s: "
        "beyond, friction is taken to stay what it is there"
    )


def fault_of_points(speed: Floats, friction: Floats) -> tuple[int | None, str] | None:
    """What makes points no curve, and the number of the point that is to blame, if one is; None if nothing does."""
    if speed.ndim != 1 or speed.shape != friction.shape:
        return None, f"got shapes {speed.shape} and {friction.shape} of speed and friction, expected two lists alike"
    if not 2 <= speed.size <= MOST_POINTS:
        return None, f"got {speed.size} points, expected 2 to {MOST_POINTS}"
    wrong = ~(np.isfinite(speed) & np.isfinite(friction) & (speed >= 0.0) & (friction > 0.0))
    wrong[1:] |= ~(np.diff(speed) > _CLOSEST * speed.max())
    if not wrong.any():
        return None
    i = int(np.argmax(wrong))
    expected = "rising speeds of at least 0, each once, and friction coefficients above 0"
    return i, f"got {friction[i]:g} at {speed[i]:g} m/s, expected {expected}"


def _of_spline(z: Floats, shape: Floats, monotone: bool) -> Floats:
    """The cubics through points, the first of which is the shape's 1. Raises ValueError where they are not above 0."""
    from scipy.interpolate import CubicSpline, PchipInterpolator  # type: ignore[import-untyped]

    cubics = PchipInterpolator(z, shape) if monotone else CubicSpline(z, shape)
    bends = cubics.derivative().roots(extrapolate=False)
    if not np.all(cubics(bends[np.isfinite(bends)]) > 0.0):
        raise ValueError("the spline through these points falls below 0 between them; take monotone=True")
    turns = cubics.derivative(2).roots(extrapolate=False)
    places = np.unique(np.concatenate([z, turns[np.isfinite(turns)]]))
    level, last = [1.0, 0.0, 0.0, 0.0], [shape[-1], 0.0, 0.0, 0.0]  # below the first point, and beyond the last one
    powers = np.vstack([*([level] if z[0] > 0.0 else []), cubics.c[::-1].T, last])
    return stations_of(plain_places(places, cubics(places), cubics(places, 1)), np.union1d(z, 0.0), powers)


class RegisteredLaw(OwnLaw):
    """The name of a law that `register_law` made. A process that gets it pickled knows the law."""

    __slots__ = ()
    reach, positive = FASTEST, False

    def __new__(cls, name: str, text: str, stations: Floats) -> RegisteredLaw:
        """The law of this name, which is known by it from now on."""
        self = super().__new__(cls, name)
        self.text, self.stations, self.coefficients = text, stations, {}
        add_law(self)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return RegisteredLaw, (str(self), self.text, self.stations)


def register_law(name: str, shape: Shape, slope: Shape) -> RegisteredLaw:
    """Add a friction law mu = a1 + a2 w + a3 shape(w/a4) of one's own, for this process.

    The shape is looked at once, and becomes a table of polynomials from z = w/a4 = 0 to 10^4: it is that to 1e-9, and
    its slope to 1e-8. Beyond it stays what it is there.

    Parameters
    ----------
    name : str
        A word in small letters that is no law yet, or one of one's own, which is replaced.
    shape, slope : function
        Of z = w/a4 >= 0: the shape, with shape(0) = 1, and its derivative by z. Whatever Python can call.

    Returns
    -------
    RegisteredLaw
        The name, to be given as `law`, or written in a configuration.

    Raises
    ------
    TypeError, ValueError
        For a shape that is none: not finite, below 0, not 1 at 0, with another slope, or with a kink or a jump.
    """
    if not isinstance(name, str) or not re.match(OWN_NAME, name) or name.startswith(_TAKEN) or name in LAWS:
        raise ValueError(f"name: got {name!r}, expected a word in small letters that is no law yet")
    for what, function in (("shape", shape), ("slope", slope)):
        if not callable(function):
            raise TypeError(f"law {name}: got {what}={function!r}, expected a function of z")
    text = f"{getattr(shape, '__doc__', None) or 'a law of your own'}".strip().partition("\n")[0].rstrip(".")
    try:
        return RegisteredLaw(name, text, tabulated(shape, slope))
    except ValueError as error:
        raise ValueError(f"law {name}: {error}") from error.__cause__


def is_law(name: object) -> bool:
    """Return whether a law has this name: of the program, registered, or brought by a package that is installed."""
    if not isinstance(name, str):
        return False
    if name not in LAW_MESSAGES:
        _load_law(name.removeprefix(PREFIX))
    return name in LAW_MESSAGES


@cache
def _load_law(name: str) -> None:
    """Register the law of this name that an installed package brings, if one does. Raises ValueError."""
    from importlib.metadata import entry_points

    for entry in entry_points(group=ENTRY_POINTS, name=name):
        law = entry.load()
        try:
            register_law(name, law.shape, law.slope)
        except AttributeError:
            raise ValueError(f"law {name}: {entry.value} has no functions `shape` and `slope`") from None
