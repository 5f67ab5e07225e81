"""Laws of friction of one's own, without a change to the program: measured tables, and shapes as functions.

Both become laws of the curve mu = a1 + a2 w + a3 shape(w/a4), so that whatever knows a law knows them. The kernels get
beside the shape its *stations*, places between which it is nearly a cubic and its slope monotone.
"""

from __future__ import annotations

import hashlib
import pickle
import re
from collections.abc import Callable
from functools import cache
from math import inf, isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.vocabulary.cell_values import numbers_of
from stickslip.vocabulary.code_digest import code_digest
from stickslip.vocabulary.models import LAW_MESSAGES, LAWS, OWN_NAME, PREFIX, OwnLaw, add_law, own_law
from stickslip.vocabulary.settings import CURVE_COLUMNS

Floats = NDArray[np.float64]
Shape = Callable[[float, float], float]
Series = Callable[[int, tuple[float, ...], tuple[float, ...], tuple[float, ...], float], float]

ENTRY_POINTS = "stickslip.laws"  # group of a package: name of the law, and a module with `shape` and `slope`
MOST_POINTS = 200
_ROWS, _STATIONS = 6, 512  # as the kernels have them
_CLOSEST = 1e-9  # two points, over the fastest speed
TABLE = "table"  # name of the kernels of all tables
_TAKEN = (TABLE, PREFIX)  # beginnings of names
_EXPONENTS = (1.0, 1.5, 2.0, 3.0, 5.0)  # at which a shape is looked at
_Z = np.concatenate([[0.0], np.geomspace(1e-4, 1e4, 1601)])  # where
_UNLIKE, _ROUNDING = 1e-3, 1e-12  # of the slope, of the shape: a difference of shapes within it is that of the slope
_STEADY = 0.3  # change of the slope in which Simpson's rule is good to a thousandth of that
_NOTHING = 1e-290  # the same where the shape has all but vanished
_STARTS = (0.02, 0.1, 0.5, 1.0, 3.0, 10.0)  # of motions along which a recurrence is tried
_MOTION = (1.0, 1.0, 0.3, -0.2, *[0.0] * 10)  # z over where it starts, as a series in time
_NEAR, _UNLIKE_SERIES = 0.3, 1e-5  # how far, over the radius of convergence; of the slope
_BENT = 1e-4  # by which a cubic between neighbouring stations may miss the shape
_TURNED = 1e-6  # of the range of slopes: so much there and back is a turn


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
        self.kernel, self.functions, self.positive = TABLE, None, True
        self.text = f"{'monotone cubics' if monotone else 'a cubic spline'} through {speed.size} points"
        self.fastest = float(speed[-1])
        self.coefficients = {"a1": 0.0, "a2": 0.0, "a3": float(friction[0]), "a4": self.fastest}
        self.stations = _spline_stations(speed / self.fastest, friction / friction[0], self.monotone)
        add_law(self, with_exponent=False)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return Table, (self.w, self.mu, self.monotone)

    def points(self) -> dict[str, Any]:
        """The points as plain data, which a configuration keeps."""
        return {"speed": self.w.tolist(), "mu": self.mu.tolist(), "monotone": self.monotone}


def beyond_points(law: str, slip_speed: ArrayLike, fastest: ArrayLike) -> str | None:
    """A sentence where slip is faster than the fastest point of a table; None where it is not, or the law is none.

    slip_speed, fastest : of cells, m/s; the latter is their a4.
    """
    if not isinstance(own_law(law), Table):
        return None
    speed, known = map(np.ravel, np.broadcast_arrays(slip_speed, fastest))
    reach = np.nan_to_num(speed / known)
    if not reach.max(initial=0.0) > 1.0:
        return None
    most = int(np.argmax(reach))
    return (
        f"slip reaches {speed[most]:.3g} m/s, and the fastest point of the table is at {known[most]:.3g} m/s: beyond, "
        "friction is taken to stay what it is there"
    )


def fault_of_points(speed: Floats, friction: Floats) -> tuple[int | None, str] | None:
    """What makes points no curve, and the number of the point that is to blame, if one is; None if nothing does."""
    if speed.ndim != 1 or speed.shape != friction.shape:
        return (
            None,
            f"got speeds of shape {speed.shape} and friction of shape {friction.shape}, expected two lists alike",
        )
    if not 2 <= speed.size <= MOST_POINTS:
        return None, f"got {speed.size} points, expected 2 to {MOST_POINTS}"
    for i, (w, mu) in enumerate(zip(speed.tolist(), friction.tolist(), strict=True)):
        if not (isfinite(w) and w >= 0.0):
            return i, f"got the slip speed {w:g} m/s, expected a number of at least 0"
        if not (isfinite(mu) and mu > 0.0):
            return i, f"got the friction coefficient {mu:g} at {w:g} m/s, expected a number above 0"
        if i and not w - speed[i - 1] > _CLOSEST * speed.max():
            return i, f"got the slip speed {w:g} m/s after {speed[i - 1]:g} m/s, expected rising ones, each once"
    return None


def _spline_stations(z: Floats, shape: Floats, monotone: bool) -> Floats:
    """The cubics through points, the first of which is the shape's 1. Raises ValueError where they are not above 0."""
    from scipy.interpolate import CubicSpline, PchipInterpolator  # type: ignore[import-untyped]

    cubics = PchipInterpolator(z, shape) if monotone else CubicSpline(z, shape)
    bends = cubics.derivative().roots(extrapolate=False)
    if not np.all(cubics(bends[np.isfinite(bends)]) > 0.0):
        raise ValueError("the spline through these points falls below 0 between them; take monotone=True")
    level = np.array([[0.0, 1.0, 0.0, 0.0, 0.0]])  # below the first point
    pieces = np.column_stack([cubics.x[:-1], *cubics.c[::-1]])
    if z[0] > 0.0:
        pieces = np.concatenate([level, pieces])
    tangent, last = [0.0, 1.0, pieces[0, 2], 0.0, 0.0], [z[-1], shape[-1], 0.0, 0.0, 0.0]
    knots = np.array([tangent, *pieces, last]).T
    turns = cubics.derivative(2).roots(extrapolate=False)
    places = np.unique(np.concatenate([z, turns[np.isfinite(turns)]]))
    return _stations(_plain_places(places, cubics(places), cubics(places, 1)), knots)


def _stations(places: Floats, knots: Floats | None = None) -> Floats:
    """What the kernels must know of a law. knots : of a table, with their cubics."""
    rows = np.zeros((_ROWS, _STATIONS))
    rows[:2] = inf
    for k, row in enumerate((np.union1d(places, 0.0), *(() if knots is None else (knots[0, 1:],)))):
        rows[k, 0], rows[k, 1 : row.size + 1] = 0.0, row
    if knots is not None:
        rows[2:, : knots.shape[1]] = knots[1:]
    return rows


# --- shapes as functions ----------------------------------------------------------------------------------------------


class RegisteredLaw(OwnLaw):
    """The name of a law that `register_law` made. A process that gets it pickled knows the law."""

    __slots__ = ()

    def __reduce__(self) -> tuple[Any, ...]:
        import cloudpickle  # type: ignore[import-untyped]  # takes functions along that no module of a file has

        return _registered, (str(self), cloudpickle.dumps(self.functions))


def _registered(name: str, functions: bytes) -> RegisteredLaw:
    return register_law(name, *pickle.loads(functions))


def register_law(name: str, shape: Shape, slope: Shape, recurrence: Series | None = None) -> RegisteredLaw:
    """Add a friction law mu = a1 + a2 w + a3 shape(w/a4, delta) of one's own, for this process.

    Parameters
    ----------
    name : str
        A word in small letters that is no law yet, or one of one's own, which is replaced.
    shape, slope : function
        Of z = w/a4 >= 0 and of the exponent delta, which need not matter: the shape, with shape(0) = 1, and its
        derivative by z. Plain functions, or such that `numba.njit` made, of what Numba compiles.
    recurrence : function, optional
        Of (n, z, s, d, delta), n >= 1: coefficient n of the power series in time of the slope along any motion, given
        coefficients 0 to n of z and of the shape, and 0 to n - 1 of the slope, as sequences. With it slips are
        integrated by Taylor series, as under laws of the program.

    Returns
    -------
    RegisteredLaw
        The name, to be given as `law`, or written in a configuration.

    Raises
    ------
    TypeError, ValueError
        For a shape that is none, by values at z from 0 to 10^4: not finite, below 0, not 1 at 0, or with another slope.
    """
    if not isinstance(name, str) or not re.match(OWN_NAME, name) or name.startswith(_TAKEN) or name in LAWS:
        raise ValueError(f"name: got {name!r}, expected a word in small letters that is no law yet")
    for what, function in (("shape", shape), ("slope", slope)):
        if not callable(function):
            raise TypeError(f"law {name}: got {what}={function!r}, expected a function of (z, delta)")
    functions = (shape, slope) if recurrence is None else (shape, slope, recurrence)
    try:
        digest = code_digest(*functions)
    except ValueError as error:
        raise ValueError(f"law {name}: {error}") from None
    tables = {delta: _look_at(name, shape, slope, delta) for delta in _EXPONENTS}
    if recurrence is not None:
        for delta in _EXPONENTS:
            _try_recurrence(name, (shape, slope, recurrence), delta)
    with_exponent = any(not np.array_equal(one[0], tables[1.0][0]) for one in tables.values())
    law = RegisteredLaw(name)
    law.kernel, law.functions, law.coefficients, law.fastest = f"own_{digest}", functions, {}, inf
    law.text = f"{getattr(shape, '__doc__', None) or 'a law of your own'}".strip().partition("\n")[0].rstrip(".")
    law.positive = False
    places = np.unique(np.concatenate([_plain_places(_Z, *one) for one in tables.values()]))
    if places.size > _STATIONS - 2:
        raise ValueError(f"law {name}: the shape bends {places.size} times, expected at most {_STATIONS - 2}")
    law.stations = _stations(places)
    add_law(law, with_exponent)
    return law


def _look_at(name: str, shape: Shape, slope: Shape, delta: float) -> tuple[Floats, Floats]:
    """The shape and its slope at places `_Z`. Raises ValueError for what is no shape, or not its slope."""

    def values(what: str, function: Shape, places: Floats) -> Floats:
        found = []
        for z in places.tolist():
            try:
                found.append(float(function(z, delta)))
            except Exception as error:  # of code that people wrote
                raise ValueError(f"law {name}: {what}({z:g}, {delta:g}) fails: {error}") from error
            if not isfinite(found[-1]):
                raise ValueError(f"law {name}: {what}({z:g}, {delta:g}) is {found[-1]}, expected a finite number")
        return np.array(found)

    at, slopes = values("shape", shape, _Z), values("slope", slope, _Z)
    if abs(at[0] - 1.0) > 1e-12:
        raise ValueError(f"law {name}: shape(0, {delta:g}) is {at[0]:g}, expected 1: a3 is friction at rest less a1")
    if (low := int(np.argmin(at))) and at[low] < 0.0:
        raise ValueError(
            f"law {name}: shape({_Z[low]:g}, {delta:g}) is {at[low]:g}, expected at least 0, as friction is in slip"
        )
    between = values("slope", slope, 0.5 * (_Z[1:] + _Z[:-1]))
    ends = np.stack([slopes[:-1], between, slopes[1:]])
    noise = _UNLIKE * np.abs(ends).max(axis=0) + _ROUNDING * at[:-1] / np.diff(_Z) + _NOTHING
    rise, mean = np.diff(at) / np.diff(_Z), (ends[0] + 4.0 * ends[1] + ends[2]) / 6.0
    off = np.maximum(ends.min(axis=0) - rise, rise - ends.max(axis=0)) - noise
    steady = np.ptp(ends, axis=0) < _STEADY * np.abs(ends).max(axis=0)
    unlike = np.where(steady, np.abs(mean - rise) - noise, -inf)  # at a kink, but not in three places in a row
    off[:-2] = np.maximum(off[:-2], np.min([unlike[:-2], unlike[1:-1], unlike[2:]], axis=0))
    if off[worst := int(np.argmax(off))] > 0.0:
        raise ValueError(
            f"law {name}: slope({_Z[worst]:g}, {delta:g}) is {slopes[worst]:g}, and the shape rises by {rise[worst]:g}"
        )
    return at, slopes


def _try_recurrence(name: str, functions: tuple[Callable[..., float], ...], delta: float) -> None:
    """Try a recurrence along motions. Raises ValueError where it fails, or its series is not the slope."""
    shape, slope, recurrence = (getattr(one, "py_func", one) for one in functions)
    for start in _STARTS:
        z = tuple(start * part for part in _MOTION)
        s: tuple[float, ...] = (float(shape(start, delta)),)
        d: tuple[float, ...] = (float(slope(start, delta)),)
        for n in range(1, len(z)):
            s += (sum(j * z[j] * d[n - j] for j in range(1, n + 1)) / n,)
            try:
                d += (float(recurrence(n, z[: n + 1], s, d, delta)),)
            except Exception as error:  # of code that people wrote
                raise ValueError(f"law {name}: recurrence({n}, ...) fails from z = {start:g} on: {error}") from error
        size = max(map(abs, d[:2]))
        t = _NEAR / max([1.0, *((abs(value) / size) ** (1.0 / n) for n, value in enumerate(d) if n and size)])
        series, there = (sum(value * t**n for n, value in enumerate(row)) for row in (d, z))
        if not abs(series - slope(there, delta)) <= _UNLIKE_SERIES * size:
            raise ValueError(
                f"law {name}: from z = {start:g} to {there:g} the series of the recurrence gives the slope {series:g}, "
                f"and slope({there:g}, {delta:g}) is {slope(there, delta):g}"
            )


def _plain_places(z: Floats, shape: Floats, slope: Floats) -> Floats:
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
    least, turns, extreme, direction = _TURNED * float(np.ptp(values)), [], 0, 0
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


# --- laws that packages bring -----------------------------------------------------------------------------------------


def pickled_law(law: str) -> bytes:
    """A registered law for another process, which knows it once it has unpickled this; nothing for other laws."""
    own = own_law(law)
    if own is None or own.functions is None:
        return b""
    return pickle.dumps(own)


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
            register_law(name, law.shape, law.slope, getattr(law, "recurrence", None))
        except AttributeError:
            raise ValueError(f"law {name}: {entry.value} has no functions `shape` and `slope`") from None
