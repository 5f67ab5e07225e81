"""What a cell does, by an independent solver: SI in, SI out. The motion itself is in `motion.py`."""

from collections.abc import Mapping

import numpy as np

from . import layout as at
from .book import answers
from .motion import judge_cells

NAN = float("nan")
DEFAULTS = {
    "damping": 0.0, "delta": 1.0, "mu_stop": NAN, "mu_static": NAN, "ageing_rate": 0.0, "ageing_time": 1.0,
    "displacement": 0.0, "velocity": NAN, "contact_time": 0.0,
}  # fmt: skip
BAND_SHARE = 1e-4
NEEDED = ("mass", "stiffness", "normal_load", "belt_speed", "a1", "a2", "a3", "a4")
INPUTS = (*NEEDED, *DEFAULTS)
REGIMES = ("undecided", "stick_slip", "settles", "rings", "stuck")

ORDINARY = {"rtol": 1e-12, "share": 0.25}
TIGHT = {"rtol": 1e-13, "share": 0.125}


def judge(
    cells: Mapping, law="stribeck", rtol=1e-12, share=0.25, most_steps=3e5, band=BAND_SHARE
) -> dict[str, np.ndarray]:
    """Regime (as one of `REGIMES`) and metrics of any number of cells, in SI; NaN where undefined.

    cells : numbers or arrays by the names of `INPUTS`. rtol : of a step. share : part of a4 by which the slip speed
        may change in one step where the curve is steep. most_steps : budget, after which a cell is undecided.
    band : settling band over the distance from steady sliding at which the slip begins.
    """
    given = np.broadcast_arrays(*(np.atleast_1d(np.asarray({**DEFAULTS, **cells}[n], float)) for n in INPUTS))
    full = dict(zip(INPUTS, given, strict=True))
    rows = to_kernel(full, law)
    rows[:, at.BAND_SHARE], rows[:, at.CENTRE] = band, NAN
    out = answers(judge_cells, rows, at.ANSWERS, rtol, share, most_steps)
    time_to_settle_elsewhere(rows, out, rtol, share, most_steps)
    return to_si(out, full)


def time_to_settle_elsewhere(rows, out, rtol, share, most_steps):
    """A motion that settles on a line of friction is followed again, with its distance from there."""
    away = np.flatnonzero((out[:, at.REGIME] == at.SETTLES) & (out[:, at.XI_SETTLED] != out[:, at.XI_STEADY]))
    again = rows[away]
    again[:, at.CENTRE] = out[away, at.XI_SETTLED]
    if away.size:
        again = answers(judge_cells, again, at.ANSWERS, rtol, share, most_steps)
        out[away, at.SETTLING_TIME] = again[:, at.SETTLING_TIME]


def to_kernel(full, law) -> np.ndarray:
    """SI to the columns of `layout.py`: m = k = N = 1."""
    m, k, load = full["mass"], full["stiffness"], full["normal_load"]
    time, length = np.sqrt(m / k), load / k
    speed = length / time
    rows = np.zeros((m.size, at.CELL_ROWS))
    rows[:, at.BELT], rows[:, at.GAMMA] = full["belt_speed"] / speed, full["damping"] / np.sqrt(k * m)
    rows[:, at.A1], rows[:, at.A2], rows[:, at.A3] = full["a1"], full["a2"] * speed, full["a3"]
    rows[:, at.A4], rows[:, at.DELTA], rows[:, at.LAW] = full["a4"] / speed, full["delta"], at.LAWS.index(law)
    rows[:, at.STATIC] = np.fmax(full["mu_static"], full["a1"] + full["a3"])
    rows[:, at.STOP], rows[:, at.AGEING] = full["mu_stop"], full["ageing_rate"] / np.log(10)
    rows[:, at.AGE_TIME], rows[:, at.CONTACT] = full["ageing_time"] / time, full["contact_time"] / time
    rows[:, at.XI0], rows[:, at.ETA0] = full["displacement"] / length, full["velocity"] / speed
    return rows


def to_si(out, full) -> dict[str, np.ndarray]:
    """Answers to the names of `evaluate`."""
    m, k, load = full["mass"], full["stiffness"], full["normal_load"]
    time, length = np.sqrt(m / k), load / k
    speed = length / time
    units = {
        "breakaway_time": (at.BREAKAWAY_TIME, time), "restick_time": (at.RESTICK_TIME, time),
        "restick_displacement": (at.RESTICK_XI, length), "period": (at.PERIOD, time),
        "stick_time": (at.STICK_TIME, time), "spring_force_max": (at.XI_MAX, load),
        "spring_force_min": (at.XI_MIN, load), "slip_speed_max": (at.SPEED_MAX, speed),
        "acceleration_max": (at.ACCELERATION_MAX, load / m), "energy_per_cycle": (at.HEAT_PER_CYCLE, load * length),
        "mu_breakaway": (at.MU_BREAKAWAY, 1.0),
        "mu_reversal": (at.MU_REVERSAL, 1.0), "equilibrium_crossings": (at.CROSSINGS, 1.0),
        "settling_time": (at.SETTLING_TIME, time), "settled_displacement": (at.XI_SETTLED, length),
        "velocity_amplitude": (at.CYCLE_SPEED_RANGE, 0.5 * speed), "cycle_force_max": (at.CYCLE_XI_MAX, load),
        "cycle_force_min": (at.CYCLE_XI_MIN, load), "loops": (at.LOOPS_PER_CYCLE, 1.0),
        "decrement": (at.DECREMENT, 1.0), "decided_at": (at.DECIDED_AT, time), "releases": (at.BREAKAWAYS, 1.0),
    }  # fmt: skip
    answers = {name: out[:, row] * unit for name, (row, unit) in units.items()}
    answers["tendency"] = answers["mu_breakaway"] - 2.0 * answers["mu_reversal"] + full["mu_stop"]
    answers["displacement_amplitude"] = 0.5 * (out[:, at.CYCLE_XI_MAX] - out[:, at.CYCLE_XI_MIN]) * length
    return {"regime": np.array(REGIMES)[out[:, at.REGIME].astype(int)], **answers}
