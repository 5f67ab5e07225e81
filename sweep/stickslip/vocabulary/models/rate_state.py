"""Contacts with a state: rate-and-state friction, mu_0 + a ln(w/v_0) + b ln(v_0 theta/D_c) of the slip speed w.

The state theta, a time, follows over the slip distance D_c: by the ageing law also at rest, by the slip law only while
there is slip. The slip speed never vanishes, and the belt moves forwards.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stickslip.vocabulary.models.model import Model, Rule, Slider, Values
from stickslip.vocabulary.parameter import FRICTION, SPEED, Parameter, Variable, table

if TYPE_CHECKING:
    from stickslip.vocabulary.models.model import Row
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
)
_RESULTS = (
    Variable("slip_speed_min", "m s-1", "least slip speed on the attractor"),
    Variable("critical_stiffness", "N m-1", "stiffness below which steady sliding is unstable", "regime",
             comment="0 where it is stable on any spring."),
    Variable("critical_frequency", "s-1", "angular frequency of small motions at the critical stiffness", "regime"),
    Variable("growth_rate", "s-1", "rate at which small motions about steady sliding grow", "regime",
             comment="Below 0 where they decay."),
    Variable("growth_frequency", "s-1", "angular frequency of these motions", "regime"),
    Variable("stress_drop", "1", "drop of the spring force in a cycle, over the load"),
    Variable("slip_per_cycle", "m", "slip distance in a cycle"),
)  # fmt: skip
_RULES = (
    Rule("belt_speed", {"belt_speed": -1}, lambda p: p["belt_speed"], lambda p: "above 0 m/s",
         "rate-and-state friction is one of slip in one direction", strict=True),
    Rule("velocity", {"velocity": 1, "belt_speed": -1}, lambda p: p["belt_speed"] - p["velocity"],
         lambda p: f"below the belt speed, {p['belt_speed']:.6g} m/s",
         "rate-and-state friction is one of slip in one direction", strict=True),
)  # fmt: skip


def _contact(by: Scales, *names: str) -> list[Any]:
    """Quantities of cells, as the closed forms take them."""
    return [by.cells[name] for name in (*names, "damping", "normal_load", "belt_speed", "a", "b", "D_c")]


def _critical_stiffness(row: Row, by: Scales) -> Floats:
    from stickslip.theory import rate_state

    return rate_state.critical_stiffness(*_contact(by, "mass"))


def _critical_frequency(row: Row, by: Scales) -> Floats:
    from stickslip.theory import rate_state

    return rate_state.critical_frequency(*_contact(by))


def _growth_rate(row: Row, by: Scales) -> Floats:
    from stickslip.theory import rate_state

    return rate_state.small_motions(*_contact(by, "mass", "stiffness")).growth


def _growth_frequency(row: Row, by: Scales) -> Floats:
    from stickslip.theory import rate_state

    return rate_state.small_motions(*_contact(by, "mass", "stiffness")).frequency


@dataclass(frozen=True, eq=False)
class _RateState(Model):
    def to_kernel(self, cells: Values, by: Scales) -> dict[str, Floats]:
        return {
            "OWN_0": cells["mu_0"],
            "OWN_1": cells["a"],
            "OWN_2": cells["b"],
            "OWN_3": cells["D_c"] / by.length,
            "OWN_4": cells["v_0"] / by.speed,
        }

    def change_scale(self, name: str, cells: Values, by: Scales) -> Floats:
        import numpy as np

        if name == "displacement":
            return np.asarray(cells["mu_0"] * by.length)
        if name in ("belt_speed", "velocity"):
            return np.asarray(np.abs(cells["belt_speed"]))
        return np.asarray(cells["D_c"] / cells["v_0"] if name == "contact_time" else cells["a"])

    def sliders(self, cell: Mapping[str, float], rounded: Callable[[float], float]) -> dict[str, Slider]:
        ends = {name: (0.0, rounded(3.0 * cell[name]), 0.0) for name in ("mu_0", "a", "b") if name in cell}
        shift = rounded(2.0 * cell.get("mu_0", 0.5) * cell["normal_load"] / cell["stiffness"])
        return ends | {"displacement": (-shift, shift, 0.0)}


RATE_STATE = _RateState(
    laws=_LAWS,
    parameters=_PARAMETERS,
    results=_RESULTS,
    rules=dict.fromkeys(_LAWS, _RULES),
    to_si={
        "slip_speed_min": lambda row, by: row("SLOWEST_SLIP") * by.speed,
        "critical_stiffness": _critical_stiffness,
        "critical_frequency": _critical_frequency,
        "growth_rate": _growth_rate,
        "growth_frequency": _growth_frequency,
        "stress_drop": lambda row, by: row("CYCLE_XI_MAX") - row("CYCLE_XI_MIN"),
        "slip_per_cycle": lambda row, by: row("PERIOD") * by.time * by.cells["belt_speed"],
    },
    levels=("mu_0",),
    one_way=True,
)
