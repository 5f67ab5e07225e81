"""Laws of friction of one's own: a name, which is all that others see of a law, with what computes it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.vocabulary.scales import Floats

PREFIX = "lugre_"  # of the same law behind bristles
OWN_NAME = "^[a-z][a-z0-9_]{0,39}$"


class OwnLaw(str):
    """The name of a law, which goes wherever a law is named.

    kernel : name of its kernels, which tells the contents. text : what it is, in words. stations : its numbers, as the
    kernels have them, (STATION_ROWS, STATIONS). functions : shape and slope of (z, delta), and perhaps the recurrence
    of the slope; None where numbers tell all.
    coefficients : those of its curve that need not be given. fastest : slip speed (m/s) up to which it is known.
    positive : whether the shape is above 0 at every slip speed.
    """

    __slots__ = ("coefficients", "fastest", "functions", "kernel", "positive", "stations", "text")

    kernel: str
    text: str
    stations: Floats
    functions: tuple[Callable[..., float], ...] | None
    coefficients: Mapping[str, float]
    fastest: float
    positive: bool

    def weakening(self, z: ArrayLike, delta: ArrayLike) -> tuple[Floats, Floats]:
        """The shape at z = w/a4, and its slope."""
        import numpy as np

        if self.functions is not None:
            shape, slope = (np.vectorize(one, otypes=[float])(z, delta) for one in self.functions[:2])
            return shape, slope
        _, knot, *cubic = self.stations
        k = np.searchsorted(knot[1:], z, side="right")
        t, (c0, c1, c2, c3) = np.subtract(z, knot[k]), (row[k] for row in cubic)
        return c0 + t * (c1 + t * (c2 + t * c3)), c1 + t * (2.0 * c2 + t * 3.0 * c3)


class OnBristles(str):
    """The name of a law of one's own behind bristles, with that law."""

    __slots__ = ("own",)

    own: OwnLaw

    def __new__(cls, own: OwnLaw) -> OnBristles:
        """The name that the law has there."""
        self = super().__new__(cls, f"{PREFIX}{own}")
        self.own = own
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return OnBristles, (self.own,)


_KNOWN: dict[str, OwnLaw] = {}


def note(law: OwnLaw) -> None:
    """Let a law be known by its name in this process, in place of one that had it."""
    _KNOWN[str(law)] = law


def own_law(name: str) -> OwnLaw | None:
    """The law of one's own of this name, behind bristles or not; None where it is one of the program, or of nobody."""
    return _KNOWN.get(name.removeprefix(PREFIX))


def own_names() -> tuple[str, ...]:
    """Names of those that people gave a name."""
    return tuple(name for name, law in _KNOWN.items() if law.functions is not None)


def law_remedy(law: object) -> str | None:
    """What to do about something given as a law that is none; None where nothing is known."""
    if callable(law):
        return "register_law(name, shape, slope) makes a law of a shape and its slope, and returns its name"
    if not isinstance(law, str):
        return None if law is None else "Table(w, mu) makes a law of measured speeds and friction coefficients"
    if not re.match(OWN_NAME, law):
        return None
    return f"if {law} was registered in another process, call register_law here as well, before anything else"


def coefficients_of(law: str) -> Mapping[str, Any]:
    """The coefficients of a curve that a law brings itself."""
    own = own_law(law)
    return {} if own is None else own.coefficients
