"""Cells with a cycle, of every kind there is, and one period of each by SciPy."""

import csv
from pathlib import Path

import numpy as np
import pytest

from helpers.nightly import few
from stickslip.vocabulary.models import STRIBECK
from stickslip.vocabulary.quantities import PARAMETERS_OF

UNIT = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0}
PAIR = UNIT | {"belt_speed": 0.1, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
COULOMB = {
    "mass": 0.1, "stiffness": 5000.0, "normal_load": 10.0, "belt_speed": 0.02, "a1": 0.3, "a2": 0.0, "a3": 0.0,
    "a4": 1.0, "mu_static": 0.5,
}  # fmt: skip
SUSTAINED = {  # by what the status says of them
    "slip_cycle": ("stribeck_delta", UNIT | {
        "belt_speed": 0.0038, "a1": 0.2, "a2": 0.0, "a3": 0.0134, "a4": 0.003, "damping": 1.87, "delta": 1.53,
    }),
    "neutral_ringing": ("stribeck", UNIT | {
        "belt_speed": 0.3, "a1": 0.5, "a2": 0.0, "a3": 0.0, "a4": 1.0, "displacement": 0.6, "velocity": 0.1,
    }),
    "fall_hold_cycle": ("cubic", UNIT | {
        "belt_speed": 0.4, "a1": 0.6, "a2": 0.06, "a3": 0.9, "a4": 0.8, "mu_stop": 0.2,
    }),
    "two_way_slip_cycle": ("stribeck_delta", {
        "mass": 1.0369126, "stiffness": 132436.76, "normal_load": 5799.841, "belt_speed": 626.60325, "a1": 0.36728741,
        "a2": 1.2541713e-05, "a3": 0.41540515, "a4": 15.220826, "damping": 0.064656976, "delta": 2.1932135,
    }),
}  # fmt: skip
STICKING = {
    "stribeck": ("stribeck", PAIR),
    "backwards": ("stribeck", PAIR | {"belt_speed": -0.1}),
    "damped": ("stribeck", PAIR | {"damping": 0.05}),
    "peak of static friction": ("stribeck", PAIR | {"mu_static": 1.5}),
    "ageing": ("stribeck", PAIR | {"ageing_rate": 0.05, "ageing_time": 0.5}),
    "hysteresis": ("stribeck", PAIR | {"mu_stop": 1.15}),
    "gaussian": ("stribeck_delta", PAIR | {"delta": 2.0}),
    "delta": ("stribeck_delta", PAIR | {"delta": 1.5}),
    "rational": ("rational", PAIR),
    "cubic": ("cubic", PAIR | {"a2": 0.05, "a4": 0.6}),
}


def faster(cell, times=1000.0):
    """The same motion, so many times as fast: 100 Hz instead of 0.1 Hz."""
    to_be = {"mass": -2, "damping": -1, "belt_speed": 1, "velocity": 1, "a2": -1, "a4": 1, "ageing_time": -1}
    return {name: value * times ** to_be.get(name, 0) for name, value in cell.items()}


def common_first(cases):
    """Names of cases; those slow whose kernels are compiled for them."""
    return few(cases, [name for name, (law, _) in cases.items() if law == "stribeck"])


OTHERS = pytest.mark.parametrize("others", few([False, True], 1))


def hard_cells(regime, others):
    """Law and cell of the rows of `hard.csv` that have a regime, with the row itself; of other kernels or of common."""
    with (Path(__file__).parents[1] / "data" / "hard.csv").open() as file:
        for row in csv.DictReader(file):
            if row["regime"] == regime and others == (row["law"] != "stribeck"):
                yield row["law"], {name: float(row[name]) for name in PARAMETERS_OF[STRIBECK]}, row


def coulomb_harmonics(cell, damping, count, before):
    """Harmonics of the acceleration of a Coulomb cycle, integrated by hand; `before` s of sticking before break-away.

    The slip velocity is a free vibration, Re(c exp(lam t)) from the belt speed on; in stick there is no acceleration.
    """
    from stickslip.theory.contacts import coulomb_cycle

    m, k, load, v = (cell[name] for name in ("mass", "stiffness", "normal_load", "belt_speed"))
    cycle = coulomb_cycle(m, k, load, v, cell["mu_static"], cell["a1"], damping)
    kappa = (cell["mu_static"] - cell["a1"]) * load / (v * np.sqrt(k * m))
    zeta = damping / (2.0 * np.sqrt(k * m))
    b = np.sqrt(1.0 - zeta**2)
    lam, c = complex(-zeta, b) * np.sqrt(k / m), v * complex(1.0, (kappa - zeta) / b)
    omega, slip = 2.0 * np.pi / float(cycle.period) * np.arange(1, count + 1), float(cycle.slip_time)
    total = sum(
        0.5 * a * r * np.expm1((r - 1j * omega) * slip) / (r - 1j * omega)
        for a, r in ((c, lam), (np.conj(c), np.conj(lam)))
    )
    return total * np.exp(-1j * omega * before) / float(cycle.period), cycle
