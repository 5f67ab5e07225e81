"""Friction laws: one file each, chosen by the type of a tag, so that the choice costs nothing in the hot loop.

Every law is a *shape* that weakening friction follows over the slip speed w, from shape(0) = 1 on:

    mu(w) = a1 + a2 w + a3 shape(w/a4, delta)

The kernels get the tag of a law as first argument. Its type decides which shape they are compiled with; there is no
branch at run time. A law file holds the tag class, its `TAG`, its RECURRENCE if it has one (`recurrences.py`; such laws
are stepped by the Taylor series of the motion, others by Runge-Kutta), and functions of z = w/a4:

    shape(z, delta)                         the shape itself; straight-line code, for the hot loop
    weakening_slope(z, x, drop, delta)      drop shape'(z), given x = drop shape(z); straight-line code as well
    speed_of_shape_slope(slope, delta)      the largest z with shape'(z) = slope; 0 if it is nowhere that steep,
                                            inf if it is steeper everywhere

and, where they differ from the defaults below,

    inflection(delta)                       from this z on, the slope only grows
    relaxation(delta)                       from this z on, the slope is concave
    last_weakening(delta)                   from this z on, the shape is constant to rounding
    hidden_depth(delta)                     by how much z may dip inside a step below both ends of it (`resolvable.py`)
    steps_over(z, z_end, rise, rise_end)    whether a Taylor step from z to z_end, over which z changes at these rates,
                                            has passed over friction that neither end shows; straight-line code
    bends()                                 whether it bends so much that w'' may vanish twice within a Taylor step; a
                                            constant

The law of a table, whose shape is numbers of a run, is in `../table.py`.
"""

from importlib import import_module
from math import inf

from ....linking import by_law

_NAMES = ("stribeck", "stribeck_delta", "rational", "cubic", "gaussian")
_FILES = {name: import_module(f".{name}", __name__) for name in _NAMES}
LAWS = {name: file.TAG for name, file in _FILES.items()}
RECURRENCES = {type(file.TAG): file.RECURRENCE for file in _FILES.values() if hasattr(file, "RECURRENCE")}


@by_law("ff:f", inline=True)
def shape(law, z, delta):
    """Shape of the law at z = w/a4."""
    raise NotImplementedError


@by_law("ffff:f", inline=True)
def weakening_slope(law, z, x, drop, delta):
    """drop shape'(z), given x = drop shape(z)."""
    raise NotImplementedError


@by_law()
def speed_of_shape_slope(law, slope, delta):
    """The largest z with shape'(z) = slope."""
    raise NotImplementedError


@by_law()
def inflection(law, delta):
    """From this z on, the slope only grows: everywhere, where the curve is convex."""
    return 0.0


@by_law()
def relaxation(law, delta):
    """From this z on, the slope is concave: nowhere, where a law does not say so."""
    return inf


@by_law("f:f")
def last_weakening(law, delta):
    """From this z on, the shape is constant to rounding."""
    return inf


@by_law("f:f")
def hidden_depth(law, delta):
    """Return how far z may dip inside a step below its ends: no limit, where any point of a curve tells all of it."""
    return inf


@by_law(inline=True)
def steps_over(law, z, z_end, rise, rise_end):
    """Return whether a Taylor step has passed over weakening unseen: never, where the shape only grows below z = 0."""
    return False


@by_law(inline=True)
def bends(law):
    """Return whether w'' may vanish twice within a step."""
    return False


@by_law(inline=True)
def passes_unseen(law, z, z_end, rise, rise_end):
    """Return whether a Runge-Kutta step from z to z_end, over which z changes at these rates, may have passed over
    friction unseen: never, where hidden_depth and last_weakening tell it.
    """
    return False


@by_law("ff:f", inline=True)
def next_station(law, z, way):
    """The next place after z, upwards (way 1) or downwards (-1), that no panel of a quadrature over the slope should
    pass: infinitely far, as of an analytic shape.
    """
    return way * inf


@by_law(":b", inline=True)
def has_kinks(law):
    """Return whether the slope may have kinks: never, where the shape is analytic."""
    return False


def _after_tag(function):
    """The function of a law file, with the tag as an additional first argument."""
    return lambda law, *numbers: function(*numbers)


for _file in _FILES.values():
    for _function in (
        shape, weakening_slope, speed_of_shape_slope, inflection, relaxation, last_weakening, hidden_depth, steps_over,
        bends,
    ):  # fmt: skip
        if _of_law := getattr(_file, _function.__name__, None):
            _function.of(type(_file.TAG))(_after_tag(_of_law))
