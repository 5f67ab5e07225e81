"""Laws of friction of one's own: a name, which is all that others see of a law, with the numbers of its shape."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.vocabulary.scales import Floats

PREFIX = "lugre_"  # of the same law behind bristles
TABLE = "table"  # name of the kernels of all laws of one's own
OWN_NAME = "^[a-z][a-z0-9_]{0,39}$"


class OwnLaw(str):
    """The name of a law, which goes wherever a law is named.

    text : what it is, in words. stations : its numbers, as the kernels have them, (STATION_ROWS, STATIONS).
    coefficients : those of its curve that need not be given. reach : w/a4 up to which it is known. positive : whether
    the shape is above 0 at every slip speed.
    """

    __slots__ = ("coefficients", "stations", "text")

    text: str
    stations: Floats
    coefficients: Mapping[str, float]
    reach: float
    positive: bool

    def weakening(self, z: ArrayLike) -> tuple[Floats, Floats]:
        """The shape at z = w/a4, and its slope."""
        import numpy as np
        from numpy.polynomial.polynomial import polyder, polyval

        _, knot, _, _, *powers = self.stations
        piece = np.searchsorted(knot[1:], z, side="right")
        of_piece, t = np.array(powers)[:, piece], np.subtract(z, knot[piece])
        return polyval(t, of_piece, tensor=False), polyval(t, polyder(of_piece), tensor=False)


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


def kernel_of(name: str) -> str:
    """The name of the kernels of a law."""
    if own_law(name) is None:
        return name
    return f"{PREFIX}{TABLE}" if name.startswith(PREFIX) else TABLE


def own_names() -> tuple[str, ...]:
    """Names of those that people gave a name."""
    return tuple(name for name in _KNOWN if not name.startswith(TABLE))


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
