"""Friction laws: one file each, chosen by the type of a tag, so that the choice costs nothing in the hot loop.

Every law is a *shape* that weakening friction follows over the slip speed w, from shape(0) = 1 on:

    mu(w) = a1 + a2 w + a3 shape(w/a4, delta)

The kernels get the tag of a law as first argument. Its type decides which shape they are compiled with; there is no
branch at run time. A law file holds the tag class, its `TAG`, and four functions of z = w/a4:

    shape(z, delta)                         the shape itself; straight-line code, for the hot loop
    weakening_slope(z, x, drop, delta)      drop shape'(z), given x = drop shape(z); straight-line code as well
    speed_of_slope(slope, delta)            the largest z with shape'(z) = slope; 0 if it is nowhere that steep,
                                            inf if it is steeper everywhere
    inflection(delta)                       from this z on, the slope only grows
    last_weakening(delta)                   from this z on, the shape is constant to rounding; inf if never
    hidden_depth(delta)                     by how much z may dip inside a step below both ends of it (`steep.py`)
"""

from typing import Any

from numba.extending import overload

from . import cubic, rational, stribeck, stribeck_delta

LAWS = {"stribeck": stribeck.TAG, "stribeck_delta": stribeck_delta.TAG, "rational": rational.TAG, "cubic": cubic.TAG}
_FILES = {type(file.TAG): file for file in (stribeck, stribeck_delta, rational, cubic)}
_HOT: Any = {"forceinline": True, "error_model": "numpy", "fastmath": {"contract"}, "_nrt": False}


def shape(law, z, delta):
    """Shape of the law at z = w/a4 (compiled code only)."""
    raise NotImplementedError


def is_exponential(law):
    """Whether the law (its type) weakens as e^-z, so that a slip can be stepped by its Taylor series."""
    return law.instance_class is stribeck.Stribeck


def weakening_slope(law, z, x, drop, delta):
    """drop shape'(z), given x = drop shape(z) (compiled code only)."""
    raise NotImplementedError


def speed_of_shape_slope(law, slope, delta):
    """The largest z with shape'(z) = slope (compiled code only)."""
    raise NotImplementedError


def inflection(law, delta):
    """From this z on, the slope only grows (compiled code only)."""
    raise NotImplementedError


def last_weakening(law, delta):
    """From this z on, the shape is constant to rounding (compiled code only)."""
    raise NotImplementedError


def hidden_depth(law, delta):
    """How far z may dip inside a step below its ends (compiled code only)."""
    raise NotImplementedError


@overload(shape, jit_options=_HOT)
def _shape(law, z, delta):
    of_law = _FILES[law.instance_class].shape
    return lambda law, z, delta: of_law(z, delta)


@overload(weakening_slope, jit_options=_HOT)
def _weakening_slope(law, z, x, drop, delta):
    of_law = _FILES[law.instance_class].weakening_slope
    return lambda law, z, x, drop, delta: of_law(z, x, drop, delta)


@overload(speed_of_shape_slope)
def _speed_of_shape_slope(law, slope, delta):
    of_law = _FILES[law.instance_class].speed_of_slope
    return lambda law, slope, delta: of_law(slope, delta)


@overload(inflection)
def _inflection(law, delta):
    of_law = _FILES[law.instance_class].inflection
    return lambda law, delta: of_law(delta)


@overload(last_weakening)
def _last_weakening(law, delta):
    of_law = _FILES[law.instance_class].last_weakening
    return lambda law, delta: of_law(delta)


@overload(hidden_depth)
def _hidden_depth(law, delta):
    of_law = _FILES[law.instance_class].hidden_depth
    return lambda law, delta: of_law(delta)
