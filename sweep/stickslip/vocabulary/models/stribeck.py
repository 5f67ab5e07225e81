"""The model of this program: friction mu(w) = a1 + a2 w + a3 shape(w/a4) of the slip speed w, with stick.

On the way down to standstill friction may follow a line to `mu_stop` instead, static friction may lie above the curve,
and grow with the time in contact. The curve is given by its coefficients, or by what people measure: friction at
break-away and at the minimum of the curve, and the speed there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, log
from typing import TYPE_CHECKING, Any, NamedTuple

from stickslip.vocabulary.models.model import ROUNDING, Curve, Model, OwnKernels, Rule, Values
from stickslip.vocabulary.parameter import FALL, FRICTION, NAN, Parameter, Variable, table

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.vocabulary.models.model import Floats, Scales

FORMULA = "a1 + a2 w + a3 exp(-w/a4)"  # of the law stribeck
OF_HYSTERESIS = ("mu_reversal", "tendency")  # results that only a curve with `mu_stop` has
NO_MINIMUM = "friction rises first and falls without end then: hysteresis is defined by the minimum of a curve"
CURVE = Curve("a1", "a2", "a3", "a4")
BREAKAWAY = "mu_start"
FITTED = (*CURVE, BREAKAWAY)  # what a fit tells of a curve
_WITH_EXPONENT = "stribeck_delta"  # the law that has `delta`
_DECADE = log(10.0)
_LEAST_CHANGE = 1e-3  # of a friction coefficient that may be 0

# Shapes of the weakening of friction, shape(0) = 1.
_LAWS = {
    "stribeck": "exp(-w/a4), Eq. (2) of the article",
    "stribeck_delta": "exp(-(w/a4)^delta), delta = 2 being Gaussian",
    "rational": "1/(1 + w/a4), the law of Leine et al. (1998) with a1 = a2 = 0",
    "cubic": "1 - 3/2 w/a4 + 1/2 (w/a4)^3, the law of Thomsen and Fidlin (2003) with a2 = 0",
}

_PARAMETERS = table(
    Parameter(
        "a1", "1", "friction coefficient a1, constant part of the Stribeck curve", "friction",
        at_least=0, plausible=FRICTION,
    ),
    Parameter("a2", "s m-1", "slope a2 of the rising branch of the Stribeck curve", "friction"),
    Parameter("a3", "1", "drop a3 of the declining branch of the Stribeck curve", "friction", plausible=FRICTION),
    Parameter(
        "a4", "m s-1", "decay speed a4 of the declining branch of the Stribeck curve", "friction",
        above=0, plausible=FALL, synonyms="vs v_s v_st stribeck_velocity stribeck_speed decay_speed "
        "characteristic_speed",
    ),
    Parameter("delta", "1", "exponent of the law stribeck_delta", "friction", default=1.0, at_least=1),
    Parameter(
        "mu_stop", "1", "friction coefficient as the slip speed falls to zero", "friction",
        default=NAN, at_least=0, word="none", absent="no hysteresis", plausible=FRICTION,
    ),
    Parameter(
        "mu_static", "1", "static friction coefficient", "friction", default=NAN, at_least=0, word="mu_start",
        absent="mu_start = a1 + a3", plausible=FRICTION, synonyms="mu_s mus static_friction",
    ),
    Parameter(
        "ageing_rate", "1", "growth of static friction per decade of contact time", "friction",
        default=0.0, at_least=0, synonyms="aging_rate beta",
    ),
    Parameter(
        "ageing_time", "s", "contact time from which static friction grows", "friction", default=1.0, above=0,
        synonyms="aging_time t0",
    ),
)  # fmt: skip

_MEASURED = table(
    Parameter("mu_start", "1", "friction coefficient at break-away", "friction", above=0, plausible=FRICTION),
    Parameter(
        "mu_reversal", "1", "friction coefficient at the minimum of the Stribeck curve", "friction",
        at_least=0, plausible=FRICTION,
        synonyms="mu_k mu_d mu_min mu_kinetic mu_dynamic kinetic_friction dynamic_friction",
    ),
    Parameter(
        "v_reversal", "m s-1", "speed at the minimum of the Stribeck curve", "friction", above=0,
        plausible=FALL, synonyms="v_min vmin v_m",
    ),
)  # fmt: skip

_RESULTS = (
    Variable(
        "mu_reversal", "1", "friction coefficient at the reversal point as it occurred",
        comment="NaN unless mu_stop is given: then friction returns along a line from there to mu_stop.",
    ),
    Variable("mu_breakaway", "1", "friction coefficient at the last break-away, ageing included"),
    Variable(
        "tendency", "1", "stick-slip tendency mu_breakaway - 2 mu_reversal + mu_stop",
        comment="Eq. (3) with what occurred in this motion: friction at break-away, mu_static and ageing included, and "
        "at reversal, which is not the minimum of the curve. It diagnoses a motion, it does not predict one. NaN "
        "unless mu_stop is given.",
    ),
)  # fmt: skip


# --- the curve from what people measure -------------------------------------------------------------------------------


class Coefficients(NamedTuple):
    """The coefficients of the Stribeck curve that the measured form stands for."""

    a1: Floats
    a2: Floats
    a3: Floats


def coefficients(mu_start: ArrayLike, mu_reversal: ArrayLike, v_reversal: ArrayLike, a4: ArrayLike) -> Coefficients:
    """Coefficients a1, a2, a3 of the curve S(w) = a1 + a2 w + a3 exp(-w/a4) with S(0) = mu_start and its minimum
    mu_reversal at w = v_reversal.

    Arrays that broadcast; speeds in m/s, a4 > 0, v_reversal > 0. From S'(v) = 0, S(0) and S(v), with r = v/a4:
    a2 = (mu_start - mu_reversal)/(a4 (e^r - 1) - v), a3 = a2 a4 e^r, a1 = mu_start - a3.
    """
    import numpy as np

    start, drop = np.asarray(mu_start, np.float64), np.subtract(mu_start, mu_reversal)
    with np.errstate(divide="ignore", over="ignore"):  # a minimum at zero speed: a3 and -a1 are infinite
        r = np.minimum(np.divide(v_reversal, a4), 1000.0)  # e^-r is 0 from there on
        share = -np.expm1(-r) - r * np.exp(-r)  # drop/a3; written in e^-r, which cannot overflow
        a3 = drop / share
    return Coefficients(start - a3, a3 * np.exp(-r) / a4, a3)


# --- rules ------------------------------------------------------------------------------------------------------------


def _between_levels(start: tuple[str, ...], of_start: str) -> tuple[Rule, ...]:
    """The rules mu_stop <= mu_start <= mu_static, mu_start being the sum of the quantities `start`."""

    def level(values: Values) -> Any:
        return values["mu_start"] if start == ("mu_start",) else values["a1"] + values["a3"]

    def slack(values: Values) -> Any:
        return abs(level(values)) * ROUNDING

    return (
        Rule("mu_stop", {"mu_stop": 1, **dict.fromkeys(start, -1)}, lambda p: level(p) - p["mu_stop"],
             lambda p: f"at most mu_start{of_start} = {level(p):.6g}",
             "friction at standstill cannot exceed that at break-away", slack),
        Rule("mu_static", {"mu_static": -1, **dict.fromkeys(start, 1)}, lambda p: p["mu_static"] - level(p),
             lambda p: f"at least mu_start{of_start} = {level(p):.6g}",
             "static friction is at least that of the curve; leave mu_static out for mu_start", slack),
    )  # fmt: skip


def _minimum(shape: str) -> Rule:
    """Hysteresis needs a curve with a minimum, at which the falling branch of `mu_stop` could end: none that rises to a
    maximum and falls without end then. The margin is minus the slope at standstill of such a curve.
    """

    def margin(p: Values) -> Any:
        if isinstance(p["a3"], float) and (p["a3"] >= 0.0 or p["mu_stop"] != p["mu_stop"]):
            return inf
        import numpy as np

        a2, a3, a4 = (np.asarray(p[name], np.float64) for name in ("a2", "a3", "a4"))
        first = 1.5 if shape == "cubic" else np.where(np.greater(p.get("delta", 1.0), 1.0), 0.0, 1.0)
        falls_at_last = (a3 < 0.0) & ((a2 < 0.0) | (shape == "cubic"))
        return np.where(np.isnan(p["mu_stop"]), np.nan, np.where(falls_at_last, first * a3 / a4 - a2, 1.0))

    names = {"mu_stop": 1, "a2": 0, "a3": -1, "a4": -1} | ({"delta": -1} if shape == _WITH_EXPONENT else {})
    return Rule(
        "mu_stop", names, margin,
        lambda p: "none with " + ", ".join(f"{name} = {p[name]:.6g}" for name in ("a2", "a3", "a4")), NO_MINIMUM,
    )  # fmt: skip


def _lacking(p: Mapping[str, float]) -> str:
    rest = ", ".join(f"{name} = {p[name]:.6g}" for name in ("mu_start", "mu_reversal", "a4"))
    return f"more: with {rest} it makes a1 = {float(coefficients(**p).a1):.3g}, which is below 0"


_START = Rule(
    "a3", {"a1": -1, "a3": -1}, lambda p: p["a1"] + p["a3"], lambda p: f"at least -a1 = {-p['a1']:.6g}",
    "the curve starts at mu_start = a1 + a3, which is the static friction",
    slack=lambda p: ROUNDING * p["a1"], last=True,
)  # fmt: skip
OF_CURVE = (  # as it is measured
    Rule(
        "mu_reversal", {"mu_reversal": 1, "mu_start": -1}, lambda p: p["mu_start"] - p["mu_reversal"],
        lambda p: f"less than mu_start = {p['mu_start']:.6g}",
        "a curve without a minimum is given by a1, a2, a3 and a4, with a3: 0", strict=True, last=True,
    ),
    # a1 falls with mu_start and a4 and rises with the rest, as long as mu_start > mu_reversal
    Rule(
        "v_reversal", {"mu_start": 1, "mu_reversal": -1, "v_reversal": -1, "a4": 1}, lambda p: coefficients(**p).a1,
        _lacking, "raise v_reversal or lower a4",
    ),
)  # fmt: skip
OF_ANY_SHAPE = (_START, *_between_levels(("a1", "a3"), " = a1 + a3"))
_RULES = {
    law: (*OF_ANY_SHAPE, _minimum(law), *_between_levels(("mu_start",), ""), *OF_CURVE) for law in _LAWS
}  # fmt: skip


# --- the model --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class CurveModel(Model):
    """A model whose steady sliding follows one of these curves."""

    def to_kernel(self, cells: Values, by: Scales) -> dict[str, Floats]:
        """The coefficients of the curve."""
        a1, a2, a3, a4 = self.curve_of(cells)
        return {"A1": a1, "A2": a2 * by.speed, "A3": a3, "A4": a4 / by.speed, "DELTA": cells["delta"]}

    def completed(self, quantities: Values) -> dict[str, Any]:
        """The coefficients that follow from what is measured of a curve."""
        known = dict(quantities)
        if "a4" in known and _MEASURED.keys() <= known.keys():
            known |= coefficients(*(known[name] for name in (*_MEASURED, "a4")))._asdict()
        return known

    def with_measured(self, cells: Values) -> dict[str, Any]:
        """The minimum of a curve that falls for ever towards a1 (a2 = 0) lies at an infinite speed."""
        import numpy as np

        from stickslip.theory import reversal_friction, reversal_speed  # SciPy takes its time

        a1, a2, a3, a4 = self.curve_of(cells)
        speed = reversal_speed(a2, a3, a4)
        has = (a3 > 0) & (a2 >= 0) & (speed > 0)
        measured = (self.start_of(cells), reversal_friction(a1, a2, a3, a4), speed)
        return {**cells, **{n: np.where(has, values, np.nan) for n, values in zip(_MEASURED, measured, strict=True)}}

    def without_measured(self, cells: Values) -> dict[str, Any]:
        """Cells with the coefficients instead; NaN where no curve is so."""
        if not _MEASURED.keys() <= cells.keys():
            return dict(cells)
        import numpy as np

        rest = {name: values for name, values in cells.items() if name not in _MEASURED}
        start, minimum, speed = (cells[name] for name in _MEASURED)
        with np.errstate(invalid="ignore"):  # no drop down to a minimum at standstill
            curve = coefficients(start, minimum, speed, cells["a4"])._asdict()
        curve["a1"] = np.where(start >= minimum, curve["a1"], np.nan)
        return rest | {name: np.where(np.isnan(start), cells[name], values) for name, values in curve.items()}

    def within(self, name: str, cells: Values, least: Floats, most: Floats) -> tuple[Floats, Floats]:
        """Bounds that the rules between levels of friction leave."""
        import numpy as np

        start = self.start_of(cells)
        stop, static = (np.asarray(cells.get(of, np.nan)) for of in ("mu_stop", "mu_static"))
        if name in ("mu_start", "mu_reversal"):  # a1 >= 0, and mu_reversal <= mu_start
            unit = coefficients(1.0, 0.0, cells["v_reversal"], cells["a4"])
            with np.errstate(divide="ignore", invalid="ignore"):
                share = 1.0 - 1.0 / unit.a3
                if name == "mu_reversal":
                    return cells["mu_start"] * share, cells["mu_start"]
                least = np.fmax(cells["mu_reversal"], stop)
                return least, np.fmin(cells["mu_reversal"] / share, static)
        if name == "mu_static":
            return np.maximum(least, start), most
        if name == "mu_stop":
            return least, np.minimum(most, start)
        if name in self.levels:
            rest = start - cells[name]
            least = np.maximum(least, np.nan_to_num(stop, nan=0.0) - rest)
            most = np.minimum(most, np.nan_to_num(static, nan=np.inf) - rest)
        return least, most

    def change_scale(self, name: str, cells: Values, by: Scales) -> Floats:
        """Scales of friction, speed and displacement."""
        import numpy as np

        start = self.start_of(cells)
        if name == "a2":
            return np.asarray(np.where(cells["a3"] > 0, cells["a3"], np.maximum(start, 1.0)) / cells["a4"])
        if name in ("belt_speed", "velocity"):
            return np.asarray(np.where(cells["belt_speed"] != 0, np.abs(cells["belt_speed"]), cells["a4"]))
        friction = np.maximum(start, _LEAST_CHANGE)
        if name == "displacement":
            return np.asarray(friction * by.load / by.stiffness)
        return np.asarray(cells["ageing_time"] if name == "contact_time" else friction)


@dataclass(frozen=True, eq=False)
class _Stribeck(CurveModel):
    def to_kernel(self, cells: Values, by: Scales) -> dict[str, Floats]:
        return super().to_kernel(cells, by) | {
            "MU_STATIC": self.static_of(cells),
            "MU_STOP": cells["mu_stop"],
            "AGEING": cells["ageing_rate"] / _DECADE,
            "AGEING_TIME": cells["ageing_time"] * by.rate,
        }


STRIBECK = _Stribeck(
    laws=_LAWS,
    parameters=_PARAMETERS,
    results=_RESULTS,
    rules=_RULES,
    to_si={
        "mu_reversal": lambda row, by: row("MU_REVERSAL"),
        "mu_breakaway": lambda row, by: row("MU_BREAKAWAY"),
        "tendency": lambda row, by: row("MU_BREAKAWAY") - 2.0 * row("MU_REVERSAL") + by.cells["mu_stop"],
    },
    curve=CURVE,
    levels=("a1", "a3"),
    static="mu_static",
    measured=_MEASURED,
    of_laws={"delta": (_WITH_EXPONENT,), **dict.fromkeys(_MEASURED, ("stribeck",))},
    # Exponents with which the motion has a Taylor series.
    own_kernels={"stribeck_delta": OwnKernels(("delta",), ("DELTA",), {1.0: "stribeck", 2.0: "gaussian"})},
)
