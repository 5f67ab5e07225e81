"""Contacts of bristles: any friction curve of `stribeck.py` behind a contact that gives way before it slides.

LuGre and the elasto-plastic model; Dahl's is a3 = 0. A law of a curve becomes one of these where the stiffness of the
contact is given: `contact_stiffness` beside `law: stribeck` is the law lugre_stribeck.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from stickslip.vocabulary.models.memory import BORDER_TOLERANCE, CONTOUR_POINTS, RESULTS, results_to_si
from stickslip.vocabulary.models.model import OwnKernels, Rule, Slider, Values
from stickslip.vocabulary.models.own_law import PREFIX, own_law
from stickslip.vocabulary.models.stribeck import CURVE, OF_CURVE, STRIBECK, CurveModel
from stickslip.vocabulary.parameter import NAN, Parameter, Variable, table

if TYPE_CHECKING:
    from stickslip.theory.memory import Slopes
    from stickslip.vocabulary.models.model import Row
    from stickslip.vocabulary.scales import Floats, Scales

STIFFNESS = "contact_stiffness"  # which makes a contact one of bristles
_LAWS = {f"{PREFIX}{law}": f"contact_stiffness, and the curve of {law}" for law in STRIBECK.laws}

_PARAMETERS = {name: STRIBECK.parameters[name] for name in (*CURVE, "delta")} | table(
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


def law_of_contact(law: str, names: Any) -> str:
    """The law of cells with quantities of these names: that of bristles on its curve where they have a stiffness."""
    return f"{PREFIX}{law}" if STIFFNESS in names and law in STRIBECK.laws else law


def _slopes(law: str, cells: Values) -> Slopes:
    import numpy as np

    from stickslip.theory.curve import weakening
    from stickslip.theory.memory import lugre_slopes

    a1, a2, a3, a4 = (cells[name] for name in CURVE)
    load, speed = cells["normal_load"], np.abs(cells["belt_speed"])
    own = own_law(law)
    z = speed / a4
    shape, slope = own.weakening(z) if own else weakening(law.removeprefix(PREFIX), z, cells["delta"])
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

    def sliders(self, cell: Mapping[str, float], rounded: Callable[[float], float]) -> dict[str, Slider | None]:
        decay = cell[CURVE.decay]
        fading = rounded(0.1 * decay), rounded(10.0 * decay), decay
        return super().sliders(cell, rounded) | {"contact_damping_speed": fading, "contact_time": None}

    def conversions(self, law: str) -> Mapping[str, Callable[[Row, Scales], Floats]]:
        return {**self.to_si} | results_to_si(partial(_slopes, law))


LUGRE = _LuGre(
    laws=_LAWS,
    parameters=_PARAMETERS,
    results=(*RESULTS, _PRESLIDING),
    rules={law: (*BRISTLES_ON_ANY, *([_NOT_RISING] if law.endswith("cubic") else []), *OF_CURVE) for law in _LAWS},
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
