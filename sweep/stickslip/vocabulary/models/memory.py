"""What models with an inner state have in common: the results that only they have."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from stickslip.vocabulary.models.model import Values
from stickslip.vocabulary.parameter import Variable

if TYPE_CHECKING:
    from stickslip.theory.memory import Slopes
    from stickslip.vocabulary.models.model import Row
    from stickslip.vocabulary.scales import Floats, Scales

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

    def critical_stiffness(row: Row, by: Scales) -> Floats:
        from stickslip.theory import memory

        return memory.critical_stiffness(by.mass, slopes(by.cells))

    def critical_frequency(row: Row, by: Scales) -> Floats:
        from stickslip.theory import memory

        return memory.critical_frequency(slopes(by.cells))

    def growth_rate(row: Row, by: Scales) -> Floats:
        from stickslip.theory import memory

        return memory.small_motions(by.mass, by.stiffness, slopes(by.cells)).growth

    def growth_frequency(row: Row, by: Scales) -> Floats:
        from stickslip.theory import memory

        return memory.small_motions(by.mass, by.stiffness, slopes(by.cells)).frequency

    def damping_ratio(row: Row, by: Scales) -> Floats:
        import numpy as np

        growth, frequency = growth_rate(row, by), growth_frequency(row, by)
        return np.asarray(-growth / np.hypot(growth, frequency))

    return {
        "damping_ratio": damping_ratio,
        "slip_speed_min": lambda row, by: row("SLOWEST_SLIP") * by.speed,
        "critical_stiffness": critical_stiffness,
        "critical_frequency": critical_frequency,
        "growth_rate": growth_rate,
        "growth_frequency": growth_frequency,
        "stress_drop": lambda row, by: row("CYCLE_XI_MAX") - row("CYCLE_XI_MIN"),
        "slip_per_cycle": lambda row, by: row("PERIOD") * by.time * abs(by.cells["belt_speed"]),
    }
