"""Contacts with an inner state: rate-and-state friction, and bristles.

Rate-and-state friction is mu_0 + a ln(w/v_0) + b ln(v_0 theta/D_c) of the slip speed w. The state theta, a time,
follows over the slip distance D_c: by the ageing law also at rest, by the slip law only while there is slip. Where slip
rests or turns round, friction has its regularised form, a asinh(w/(2 v_0) exp((mu_0 + b ln(v_0 theta/D_c))/a)), which
is the same wherever it is much above a. With cut-offs v_1 and v_2, 1/w is 1/w + 1/v_1, and theta is theta + D_c/v_2,
friction at v_0 being the same (Okubo 1989).

Bristles are any friction curve of `stribeck.py` behind a contact that gives way before it slides: LuGre and the
elasto-plastic model; Dahl's is a3 = 0. A law of a curve becomes one of these where the stiffness of the contact is
given: `contact_stiffness` beside `law: stribeck` is the law lugre_stribeck.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from stickslip.vocabulary.models.model import PREFIX, Model, OwnKernels, Rule, Values, own_law
from stickslip.vocabulary.models.stribeck import CURVE, OF_CURVE, STRIBECK, CurveModel
from stickslip.vocabulary.parameter import FRICTION, NAN, SPEED, Parameter, Variable, table

if TYPE_CHECKING:
    from stickslip.theory.contacts import Slopes
    from stickslip.vocabulary.models.model import Floats, Row, Scales

RESULTS = (
    Variable("slip_speed_min", "m s-1", "least slip speed on the attractor"),
    Variable("critical_stiffness", "N m-1", "stiffness below which steady sliding is unstable", "regime",
             comment="0 where it is stable on any spring, inf where on none. Where friction falls with speed at once "
             "but not in steady sliding, it is unstable above instead."),
    Variable("critical_frequency", "rad s-1", "angular frequency of small motions at the critical stiffness", "regime"),
    Variable("growth_rate", "s-1", "rate at which small motions about steady sliding grow", "regime",
             comment="Below 0 where they decay."),
    Variable("growth_frequency", "rad s-1", "angular frequency of these motions", "regime"),
    Variable("stress_drop", "1", "drop of the spring force in a cycle, over the load"),
    Variable("slip_per_cycle", "m", "slip distance in a cycle"),
)  # fmt: skip
BORDER_TOLERANCE = 1e-4  # cells closer to a border than about that are undecided, or take a million steps
CONTOUR_POINTS = 128  # those next to a border take a hundred times as long as others


def results_to_si(slopes: Callable[[Values], Slopes]) -> dict[str, Callable[[Row, Scales], Floats]]:
    """How these results are found; slopes : of the friction of cells at the speeds of their belts."""

    def theory() -> Any:  # which imports SciPy
        from stickslip.theory import contacts

        return contacts

    def motions(by: Scales) -> Any:
        return theory().small_motions(by.mass, by.stiffness, slopes(by.cells))

    return {
        "damping_ratio": lambda row, by: motions(by).damping_ratio,
        "slip_speed_min": lambda row, by: row("SLOWEST_SLIP") * by.speed,
        "critical_stiffness": lambda row, by: theory().critical_stiffness(by.mass, slopes(by.cells)),
        "critical_frequency": lambda row, by: theory().critical_frequency(slopes(by.cells)),
        "growth_rate": lambda row, by: motions(by).growth,
        "growth_frequency": lambda row, by: motions(by).frequency,
        "stress_drop": lambda row, by: row("CYCLE_XI_MAX") - row("CYCLE_XI_MIN"),
        "slip_per_cycle": lambda row, by: row("PERIOD") * by.time * abs(by.cells["belt_speed"]),
    }


# --- rate and state ---------------------------------------------------------------------------------------------------

_STATE_LAWS = {
    "rate_state_ageing": "mu_0 + a ln(w/v_0) + b ln(v_0 theta/D_c), theta' = 1 - w theta/D_c, Dieterich (1979)",
    "rate_state_slip": "the same, theta' = -(w theta/D_c) ln(w theta/D_c), Ruina (1983)",
}
_OF_STATE = table(
    Parameter("mu_0", "1", "friction coefficient in steady sliding at v_0", "friction", above=0, plausible=FRICTION),
    Parameter("v_0", "m s-1", "slip speed at which friction is mu_0", "friction", above=0, plausible=SPEED),
    Parameter("a", "1", "direct effect a of rate-and-state friction", "friction", above=0, plausible=0.2),
    Parameter("b", "1", "evolution effect b of rate-and-state friction", "friction", at_least=0, plausible=0.2),
    Parameter("D_c", "m", "slip distance over which the state follows", "friction", above=0, plausible=1e-2),
    Parameter(
        "direct_cutoff_speed", "m s-1", "slip speed beyond which friction no longer grows by the direct effect",
        "friction", default=NAN, above=0, word="none", absent="it grows at any speed", plausible=SPEED,
        synonyms="V_1 V1",
    ),
    Parameter(
        "evolution_cutoff_speed", "m s-1", "slip speed beyond which friction no longer falls by the evolution effect",
        "friction", default=NAN, above=0, word="none", absent="it falls at any speed", plausible=SPEED,
        synonyms="V_2 V2",
    ),
)  # fmt: skip
_CUT = ("direct_cutoff_speed", "evolution_cutoff_speed")
_STATE_RULES = (
    Rule("belt_speed", {"belt_speed": 0}, lambda p: abs(p["belt_speed"]), lambda p: "other than 0 m/s",
         "on a belt at rest, slip slows down for ever", strict=True),
)  # fmt: skip


def _slopes_of_state(cells: Values) -> Slopes:
    import numpy as np

    from stickslip.theory.contacts import rate_state_slopes

    load, belt = cells["normal_load"], abs(cells["belt_speed"])
    a, b = (cells[name] / (1.0 + np.nan_to_num(belt / cells[cut])) for name, cut in (("a", _CUT[0]), ("b", _CUT[1])))
    return rate_state_slopes(cells["damping"], load, belt, a, b, cells["D_c"])


@dataclass(frozen=True, eq=False)
class _RateState(Model):
    def to_kernel(self, cells: Values, by: Scales) -> dict[str, Floats]:
        import numpy as np

        return {
            "OWN_0": cells["mu_0"],
            "OWN_1": cells["a"],
            "OWN_2": cells["b"],
            "OWN_3": cells["D_c"] / by.length,
            "OWN_4": cells["v_0"] / by.speed,
            "OWN_5": np.nan_to_num(by.speed / cells[_CUT[0]]),
            "OWN_6": np.nan_to_num(by.speed / cells[_CUT[1]]),
        }

    def change_scale(self, name: str, cells: Values, by: Scales) -> Floats:
        import numpy as np

        if name == "displacement":
            return np.asarray(cells["mu_0"] * by.length)
        if name in ("belt_speed", "velocity"):
            return np.asarray(np.abs(cells["belt_speed"]))
        return np.asarray(cells["D_c"] / cells["v_0"] if name == "contact_time" else cells["a"])


RATE_STATE = _RateState(
    laws=_STATE_LAWS,
    parameters=_OF_STATE,
    results=RESULTS,
    rules=dict.fromkeys(_STATE_LAWS, _STATE_RULES),
    to_si=results_to_si(_slopes_of_state),
    levels=("mu_0",),
    absent={"velocity": "slip at a tenth of the speed of the belt", "contact_time": "the state of steady sliding"},
    growth="growth_rate",
    border_tolerance=BORDER_TOLERANCE,
    contour_points=CONTOUR_POINTS,
    own_kernels={law: OwnKernels(_CUT, ("OWN_5", "OWN_6"), {0.0: law}, f"{law}_cut_off") for law in _STATE_LAWS},
)


# --- bristles ---------------------------------------------------------------------------------------------------------

STIFFNESS = "contact_stiffness"  # which makes a contact one of bristles
_BRISTLE_LAWS = {f"{PREFIX}{law}": f"contact_stiffness, and the curve of {law}" for law in STRIBECK.laws}

_OF_BRISTLES = {name: STRIBECK.parameters[name] for name in (*CURVE, "delta")} | table(
    Parameter(
        STIFFNESS, "N m-1", "stiffness of the contact before it slides", "friction", above=0,
        absent="a rigid contact", synonyms="sigma0 sigma_0 bristle_stiffness tangential_stiffness",
    ),
    Parameter(
        "contact_damping", "N s m-1", "damping of the contact before it slides", "friction", default=0.0, at_least=0,
        synonyms="sigma1 sigma_1 micro_damping bristle_damping",
    ),
    Parameter(
        "contact_damping_speed", "m s-1", "slip speed over which the damping of the contact fades", "friction",
        default=NAN, above=0, word="none", absent="does not fade",
    ),
    Parameter(
        "elastic_part", "1", "share of its deflection up to which the contact is elastic", "friction",
        default=0.0, at_least=0, at_most=0.99,
    ),
)  # fmt: skip
_PRESLIDING = Variable(
    "presliding_displacement", "m", "deflection of the contact at break-away: mu_start times load over stiffness",
    "regime",
)  # fmt: skip
_WHY = "bristles deflect by the friction of the curve over their stiffness, which is above 0 at every slip speed"
_NO_HOLD = Rule(
    "contact_time", {"contact_time": 1}, lambda p: -p["contact_time"], lambda p: "0 s",
    "bristles are relaxed at the start, whatever came before, and friction of theirs does not age",
)  # fmt: skip
BRISTLES_ON_ANY = (  # shape, which may come down to 0
    Rule("a1", {"a1": -1}, lambda p: p["a1"], lambda p: "above 0", _WHY, strict=True, last=True),
    Rule("a3", {"a1": -1, "a3": -1}, lambda p: p["a1"] + p["a3"], lambda p: f"above -a1 = {-p['a1']:.6g}", _WHY,
         strict=True, last=True),
    _NO_HOLD,
)  # fmt: skip
ON_POSITIVE = BRISTLES_ON_ANY[1:]
_NOT_RISING = Rule(
    "a3", {"a3": -1}, lambda p: p["a3"], lambda p: "at least 0", f"{_WHY}; this curve would fall for ever"
)


def _slopes_of_bristles(name: str, cells: Values) -> Slopes:
    import numpy as np

    from stickslip.theory.contacts import lugre_slopes
    from stickslip.theory.curve import weakening

    a1, a2, a3, a4 = (cells[name] for name in CURVE)
    load, speed = cells["normal_load"], np.abs(cells["belt_speed"])
    own = own_law(name)
    z = speed / a4
    shape, slope = own.weakening(z) if own else weakening(name.removeprefix(PREFIX), z, cells["delta"])
    fade = np.nan_to_num(speed / cells["contact_damping_speed"])
    damping = cells["contact_damping"] * np.exp(-np.square(fade))
    return lugre_slopes(
        cells["damping"], speed, load * (a1 + a3 * shape), load * a3 / a4 * slope, load * a2, cells[STIFFNESS], damping
    )


@dataclass(frozen=True, eq=False)
class _LuGre(CurveModel):
    def to_kernel(self, cells: Values, by: Scales) -> dict[str, Floats]:
        import numpy as np

        return super().to_kernel(cells, by) | {
            "CONTACT_STIFFNESS": cells[STIFFNESS] / by.stiffness,
            "CONTACT_DAMPING": cells["contact_damping"] / by.impedance,
            "CONTACT_DAMPING_RATE": np.nan_to_num(by.speed / cells["contact_damping_speed"]),
            "ELASTIC_PART": cells["elastic_part"],
        }

    def conversions(self, name: str) -> Mapping[str, Callable[[Row, Scales], Floats]]:
        return {**self.to_si} | results_to_si(partial(_slopes_of_bristles, name))


LUGRE = _LuGre(
    laws=_BRISTLE_LAWS,
    parameters=_OF_BRISTLES,
    results=(*RESULTS, _PRESLIDING),
    rules={
        law: (*BRISTLES_ON_ANY, *([_NOT_RISING] if law.endswith("cubic") else []), *OF_CURVE) for law in _BRISTLE_LAWS
    },
    to_si={_PRESLIDING.name: lambda row, by: (by.cells["a1"] + by.cells["a3"]) * by.load / by.cells[STIFFNESS]},
    curve=CURVE,
    levels=STRIBECK.levels,
    implied=True,
    growth="growth_rate",
    border_tolerance=BORDER_TOLERANCE,
    contour_points=CONTOUR_POINTS,
    measured=STRIBECK.measured,
    of_laws={name: tuple(f"{PREFIX}{law}" for law in laws) for name, laws in STRIBECK.of_laws.items()},
    own_kernels={
        f"{PREFIX}{law}": OwnKernels(
            own.parameters, own.rows, {at: f"{PREFIX}{name}" for at, name in own.by_value.items()}
        )
        for law, own in STRIBECK.own_kernels.items()
    },
)
