"""Facts of the contact that need no integration: thresholds, closed-form cycles, dimensionless groups.

Plain numbers or arrays in SI that broadcast against each other, NaN where a thing does not exist. A module per law:
`curve` (Stribeck), `coulomb` (two numbers, static and kinetic), `cubic` (Thomsen and Fidlin), `ageing` (static
friction that grows with the time in contact).
"""

from stickslip.theory.contacts import (
    CoulombCycle,
    breakaway_time,
    coulomb_cycle,
    critical_speed,
    critical_speed_lightly_damped,
    critical_strength,
    static_friction,
)
from stickslip.theory.curve import (
    Groups,
    cubic,
    cubic_loss_of_stability,
    cubic_pure_slip_speed,
    cubic_slope,
    cubic_stick_slip_limit,
    damping_ratio,
    groups,
    loss_of_stability,
    reversal_friction,
    reversal_speed,
    stick_slip_limit,
    stribeck,
    stribeck_slope,
    tendency,
    unstable_amplitude,
)

__all__ = [
    "CoulombCycle", "Groups", "breakaway_time", "coulomb_cycle", "critical_speed", "critical_speed_lightly_damped",
    "critical_strength", "cubic", "cubic_loss_of_stability", "cubic_pure_slip_speed", "cubic_slope",
    "cubic_stick_slip_limit", "damping_ratio", "groups", "loss_of_stability", "reversal_friction", "reversal_speed",
    "static_friction", "stick_slip_limit", "stribeck", "stribeck_slope", "tendency",
    "unstable_amplitude",
]  # fmt: skip
