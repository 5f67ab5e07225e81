"""The contract of a model of the contact: its parameters, its rules, what comes out, and the way to the kernels, whose
units follow from the scales of a cell.

A model is a value, made in a file of its own beside this one. Reader, schema, `evaluate`, datasets and the engine take
from it whatever they need to know of friction, and ask for groups of parameters (`curve`, `levels`), not for names.
The command line reads names alone, so what computes imports NumPy when it is called.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

from stickslip.vocabulary.parameter import Parameter, Variable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Floats = NDArray[np.float64]
    Row = Callable[[str], Floats]  # a row of the kernels, by its name in their `layout`

Values = Mapping[str, Any]  # of quantities in SI: numbers, or arrays that broadcast

ROUNDING = 1e-12  # relative; 0.1 + 0.2 is above 0.3


class Curve(NamedTuple):
    """The names of the parameters of a friction curve, by what they are: level + slope w + drop shape(w/decay)."""

    level: str
    slope: str
    drop: str
    decay: str


class OwnKernels(NamedTuple):
    """Faster kernels for cells with certain values of parameters, the same of all; rows : of these in the kernels.

    otherwise : the kernels of the other cells, where these have not the name of the law.
    """

    parameters: tuple[str, ...]
    rows: tuple[str, ...]
    by_value: Mapping[float, str]
    otherwise: str = ""


def _floats(values: ArrayLike) -> Floats:
    import numpy as np

    return np.asarray(values, np.float64)


def _root(values: Floats) -> Floats:
    import numpy as np

    return np.asarray(np.sqrt(values))


class Scales:
    """The scales of cells, each (n,).

    They are the load N for forces, N/k for displacements, sqrt(m/k) for times, N/sqrt(k m) for speeds, N/m for
    accelerations.
    """

    cells: Mapping[str, Floats]
    mass: Floats
    stiffness: Floats
    load: Floats

    def __init__(self, cells: Mapping[str, Floats]) -> None:
        self.cells = cells
        self.mass, self.stiffness = cells["mass"], cells["stiffness"]
        self.load = cells["normal_load"]

    @cached_property
    def impedance(self) -> Floats:
        """sqrt(k m), N s/m."""
        return _root(self.stiffness * self.mass)

    @property
    def critical_damping(self) -> Floats:
        """2 sqrt(k m), N s/m."""
        return 2.0 * self.impedance

    @property
    def natural_frequency(self) -> Floats:
        """Of the mass on its spring, Hz."""
        return self.rate / (2.0 * pi)

    @cached_property
    def time(self) -> Floats:
        """A radian of the free oscillation, s."""
        return _root(self.mass / self.stiffness)

    @cached_property
    def rate(self) -> Floats:
        """Its inverse, 1/s."""
        return _root(self.stiffness / self.mass)

    @cached_property
    def length(self) -> Floats:
        """Deflection of the spring by the load, m."""
        return _floats(self.load / self.stiffness)

    @cached_property
    def speed(self) -> Floats:
        """m/s."""
        return _floats(self.load / self.impedance)


@dataclass(frozen=True, eq=False)
class Rule:
    """A relation that must hold between quantities of a cell.

    name : the quantity that is to blame. worse : those that `margin` takes, +1 if it falls as the quantity grows, -1 if
    it rises, 0 if it is not monotone; a rule about other quantities than a cell has is left out.
    margin : below 0 where the rule is broken; NaN where it says nothing. slack : of rounding.
    expected, why : in words, of the values that break it; nothing is expected where there is no such value.
    strict : a margin of 0 breaks it as well. last : what comes after it says nothing where it is broken.
    """

    name: str
    worse: Mapping[str, int]
    margin: Callable[[Values], Any]
    expected: Callable[[Mapping[str, float]], str]
    why: str
    slack: Callable[[Values], Any] = field(default=lambda values: 0.0)
    strict: bool = False
    last: bool = False

    def is_broken(self, margin: Any, values: Values) -> Any:
        """True where a margin of these values breaks the rule."""
        return margin <= 0.0 if self.strict else margin < -self.slack(values)

    def breaks(self, values: Values) -> bool:
        """True if any of the cells with these values breaks the rule."""
        broken = self.is_broken(self.margin(values), values)
        return broken if isinstance(broken, bool) else bool(broken.any())


@dataclass(frozen=True, eq=False)
class Model:
    """One model of the contact.

    laws : by name, what each is; `law` chooses the model and the law at once.
    parameters : beside those that all cells have. results : the same of what comes out. rules : by law, what must hold
    between quantities.
    curve : names of the friction curve of steady sliding, if it has the form of `Curve`. levels : the parameters whose
    sum is friction where the curve begins. static : the quantity that may put static friction above that.
    measured : what people measure of a curve, in place of all its parameters but the decay. of_laws : parameters and
    measured quantities that only some laws have, by name.
    own_kernels : of laws some of whose cells have kernels of their own; those of all others have the name of the law.
    to_si : by name of a result, how it is found, in SI, from the rows of the kernels.
    absent : by name, what a quantity of all cells comes to where it is left out, if that differs in this model.
    implied : whether nobody names its laws: they follow from those of another model and a quantity that is given.
    growth : the result of linear theory at whose zero steady sliding loses its stability, if searches of borders are to
    be led by it; else they are by `restick_margin`. border_tolerance, contour_points : of these searches, unless given.
    """

    laws: dict[str, str]
    parameters: Mapping[str, Parameter]
    results: tuple[Variable, ...] = ()
    rules: dict[str, tuple[Rule, ...]] = field(default_factory=dict)
    to_si: Mapping[str, Callable[[Row, Scales], Floats]] = field(default_factory=dict)
    curve: Curve | None = None
    levels: tuple[str, ...] = ()
    static: str | None = None
    measured: Mapping[str, Parameter] = field(default_factory=dict)
    of_laws: dict[str, tuple[str, ...]] = field(default_factory=dict)
    own_kernels: Mapping[str, OwnKernels] = field(default_factory=dict)
    absent: Mapping[str, str] = field(default_factory=dict)
    implied: bool = False
    growth: str | None = None
    border_tolerance: float = 1e-9
    contour_points: int = 512

    @property
    def guide(self) -> str:
        """The result whose zero leads to a border."""
        return self.growth or "restick_margin"

    @cached_property
    def replaced(self) -> tuple[str, ...]:
        """The parameters of the curve that `measured` stands for."""
        return self.curve[:-1] if self.curve and self.measured else ()

    @cached_property
    def needed(self) -> tuple[str, ...]:
        """The parameters that every cell of the model must be given."""
        return tuple(name for name, row in self.parameters.items() if row.default is None)

    @cached_property
    def forms(self) -> tuple[tuple[str, ...], ...]:
        """The ways to give what a cell must be given, by names."""
        rest = tuple(name for name in self.needed if name not in self.replaced)
        return (self.needed, (*self.measured, *rest)) if self.measured else (self.needed,)

    def to_kernel(self, cells: Values, by: Scales) -> dict[str, Floats]:
        """The parameters of the model in kernel units, by names of rows of the kernels' cells."""
        return {}

    def conversions(self, name: str) -> Mapping[str, Callable[[Row, Scales], Floats]]:
        """`to_si` of a law."""
        return self.to_si

    def curve_of(self, cells: Values) -> list[Any]:
        """The parameters of the curves of cells: level, slope, drop, decay."""
        return [cells[name] for name in self.curve or ()]

    def start_of(self, cells: Values) -> Any:
        """Friction where the curves of cells begin."""
        start = cells[self.levels[0]]
        for name in self.levels[1:]:
            start = start + cells[name]
        return start

    def static_of(self, cells: Values) -> Any:
        """Static friction of cells before it ages."""
        import numpy as np

        start = self.start_of(cells)
        return start if self.static is None else np.fmax(cells[self.static], start)

    def completed(self, quantities: Values) -> dict[str, Any]:
        """The quantities of cells, with the parameters that follow from what is measured where it is given."""
        return dict(quantities)

    def with_measured(self, cells: Values) -> dict[str, Any]:
        """Cells with what would be measured of their curves; NaN where a curve has no such thing."""
        return dict(cells)

    def without_measured(self, cells: Values) -> dict[str, Any]:
        """Cells whose parameters follow from what is measured, where that is among them; NaN where no curve is so."""
        return dict(cells)

    def within(self, name: str, cells: Values, least: Floats, most: Floats) -> tuple[Floats, Floats]:
        """The bounds of a quantity, beside the others of its cell. least, most : its own."""
        return least, most

    def change_scale(self, name: str, cells: Values, by: Scales) -> Floats:
        """The scale with which a change of a quantity that may be 0 is compared."""
        return {"displacement": by.length}.get(name, by.mass / by.mass)


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


KNOWN_OWN: dict[str, OwnLaw] = {}  # by name, in this process (`add_law`)


def own_law(name: str) -> OwnLaw | None:
    """The law of one's own of this name, behind bristles or not; None where it is one of the program, or of nobody."""
    return KNOWN_OWN.get(name.removeprefix(PREFIX))


def kernel_of(name: str) -> str:
    """The name of the kernels of a law."""
    if own_law(name) is None:
        return str(name)  # which NumPy may hold
    return f"{PREFIX}{TABLE}" if name.startswith(PREFIX) else TABLE


def own_names() -> tuple[str, ...]:
    """Names of those that people gave a name."""
    return tuple(name for name in KNOWN_OWN if not name.startswith(TABLE))


def law_remedy(given: object) -> str | None:
    """What to do about something given as a law that is none; None where nothing is known."""
    if callable(given):
        return "register_law(name, shape, slope) makes a law of a shape and its slope, and returns its name"
    if not isinstance(given, str):
        return None if given is None else "Table(w, mu) makes a law of measured speeds and friction coefficients"
    if given in ("lugre", "dahl"):
        return "bristles stand on any friction curve: give the contact_stiffness of the contact beside its law"
    if not re.match(OWN_NAME, given):
        return None
    return f"if {given} was registered in another process, call register_law here as well, before anything else"


def coefficients_of(name: str) -> Mapping[str, Any]:
    """The coefficients of a curve that a law brings itself."""
    own = own_law(name)
    return {} if own is None else own.coefficients
