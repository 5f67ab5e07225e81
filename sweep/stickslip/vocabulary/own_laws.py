"""Laws of friction of one's own, without a change to the program: measured tables, and shapes as functions.

Both become laws of the curve mu = a1 + a2 w + a3 shape(w/a4), so that whatever knows a law knows them. To the kernels
they are numbers (`tabulating.py`), and all are computed by the same ones.
"""

from __future__ import annotations

import hashlib
import pickle
import re
from functools import cache
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.vocabulary.cell_values import numbers_of
from stickslip.vocabulary.models import LAW_MESSAGES, LAWS, OWN_NAME, PREFIX, TABLE, OwnLaw, add_law, own_law
from stickslip.vocabulary.settings import CURVE_COLUMNS
from stickslip.vocabulary.tabulating import FASTEST, Floats, Shape, plain_places, stations_of, tabulated

ENTRY_POINTS = "stickslip.laws"  # group of a package: name of the law, and a module with `shape` and `slope`
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


def beyond_points(law: str, slip_speed: ArrayLike, decay: ArrayLike) -> str | None:
    """A sentence where slip is faster than a law of one's own is known; None where it is not, or the law is none.

    slip_speed, decay : of cells, m/s; the latter is their a4.
    """
    if (own := own_law(law)) is None:
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


# --- shapes as functions ----------------------------------------------------------------------------------------------


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


# --- laws that packages bring -----------------------------------------------------------------------------------------


def pickled_law(law: str) -> bytes:
    """A registered law for another process, which knows it once it has unpickled this; nothing for other laws."""
    own = own_law(law)
    return pickle.dumps(own) if isinstance(own, RegisteredLaw) else b""


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
