"""Contacts with a state: rate-and-state friction, mu_0 + a ln(w/v_0) + b ln(v_0 theta/D_c) of the slip speed w.

The state theta, a time, follows over the slip distance D_c: by the ageing law also at rest, by the slip law only while
there is slip. Where slip rests or turns round, friction has its regularised form, a asinh(w/(2 v_0) exp((mu_0 +
b ln(v_0 theta/D_c))/a)), which is the same wherever it is much above a. With cut-offs v_1 and v_2, 1/w is 1/w + 1/v_1,
and theta is theta + D_c/v_2, friction at v_0 being the same (Okubo 1989).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stickslip.vocabulary.models.memory import BORDER_TOLERANCE, CONTOUR_POINTS, RESULTS, results_to_si
from stickslip.vocabulary.models.model import Model, OwnKernels, Rule, Slider, Values
from stickslip.vocabulary.parameter import FRICTION, NAN, SPEED, Parameter, table

if TYPE_CHECKING:
    from stickslip.theory.memory import Slopes
    from stickslip.vocabulary.scales import Floats, Scales

_LAWS = {
    "rate_state_ageing": "mu_0 + a ln(w/v_0) + b ln(v_0 theta/D_c), theta' = 1 - w theta/D_c, Dieterich (1979)",
    "rate_state_slip": "the same, theta' = -(w theta/D_c) ln(w theta/D_c), Ruina (1983)",
}
_PARAMETERS = table(
    Parameter("mu_0", "1", "friction coefficient in steady sliding at v_0", "friction", above=0, plausible=FRICTION),
    Parameter("v_0", "m s-1", "slip speed at which friction is mu_0", "friction", above=0, plausible=SPEED),
    Parameter("a", "1", "direct effect a of rate-and-state friction", "friction", above=0, plausible=(0.2, 0.2)),
    Parameter("b", "1", "evolution effect b of rate-and-state friction", "friction", at_least=0, plausible=(0.2, 0.2)),
    Parameter("D_c", "m", "slip distance over which the state follows", "friction", above=0, plausible=(1e-2, 1.0)),
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
_RULES = (
    Rule("belt_speed", {"belt_speed": 0}, lambda p: abs(p["belt_speed"]), lambda p: "other than 0 m/s",
         "on a belt at rest, slip slows down for ever", strict=True),
)  # fmt: skip


def _slopes(cells: Values) -> Slopes:
    import numpy as np

    from stickslip.theory.memory import rate_state_slopes

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

    def sliders(self, cell: Mapping[str, float], rounded: Callable[[float], float]) -> dict[str, Slider | None]:
        ends: dict[str, Slider | None] = {
            name: (rounded(0.01 * cell[name]), rounded(3.0 * cell[name]), 0.0)
            for name in ("mu_0", "a", "b")
            if name in cell
        }
        shift = rounded(2.0 * cell.get("mu_0", 0.5) * cell["normal_load"] / cell["stiffness"])
        belt = abs(cell["belt_speed"]) or 1.0
        cut_off = rounded(0.1 * belt), rounded(100.0 * belt), 10.0 * belt
        ends |= dict.fromkeys(("direct_cutoff_speed", "evolution_cutoff_speed"), cut_off)
        return ends | {"displacement": (-shift, shift, 0.0)}


RATE_STATE = _RateState(
    laws=_LAWS,
    parameters=_PARAMETERS,
    results=RESULTS,
    rules=dict.fromkeys(_LAWS, _RULES),
    to_si=results_to_si(_slopes),
    levels=("mu_0",),
    absent={"velocity": "slip at a tenth of the speed of the belt", "contact_time": "the state of steady sliding"},
    growth="growth_rate",
    border_tolerance=BORDER_TOLERANCE,
    contour_points=CONTOUR_POINTS,
    own_kernels={law: OwnKernels(_CUT, ("OWN_5", "OWN_6"), {0.0: law}, f"{law}_cut_off") for law in _LAWS},
)
