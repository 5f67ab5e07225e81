"""Cells in kernel units, run through a block."""

from dataclasses import dataclass

import numpy as np

from stickslip.engine.compiling import kernels
from stickslip_kernels import layout as at
from stickslip_kernels.layout import new_regimes

ARTICLE = (1.0, 0.1, 0.3, 0.1)  # a1..a4 of the article
NAN, INF = float("nan"), float("inf")


def cell(
    belt, curve=ARTICLE, gamma=0.0, mu_static=None, mu_stop=NAN, xi=0.0, eta=NAN, horizon=INF,
    delta=1.0, ageing=0.0, ageing_time=1.0, contact=0.0,
):  # fmt: skip
    """One column of kernel input; mu_static None means that of the curve. ageing is per e-fold of contact time."""
    column = np.zeros(at.CELL_ROWS)
    column[at.GAMMA], column[at.BELT] = gamma, belt
    column[at.A1], column[at.A2], column[at.A3], column[at.A4] = curve
    column[at.MU_STATIC] = curve[0] + curve[2] if mu_static is None else mu_static
    column[at.MU_STOP], column[at.XI_START], column[at.ETA_START], column[at.HORIZON] = mu_stop, xi, eta, horizon
    column[at.DELTA], column[at.AGEING] = delta, ageing
    column[at.AGEING_TIME], column[at.CONTACT_START] = ageing_time, contact
    return column


def block_of(*columns):
    return np.ascontiguousarray(np.array(columns).T)


def columns_of(**rows):
    """Cells (CELL_ROWS, n) from rows by their names in `layout.py` in small letters, sticking at first."""
    rows = {"delta": 1.0, "eta_start": NAN, "horizon": INF} | rows
    values = np.broadcast_arrays(*(np.atleast_1d(value) for value in rows.values()))
    cells = np.zeros((at.CELL_ROWS, values[0].size))
    for name, value in zip(rows, values, strict=True):
        cells[getattr(at, name.upper())] = value
    return cells


def run(cells, rtol=1e-6, max_steps=1e6, until=at.UNTIL_METRICS, stop=0, law="stribeck"):
    """Results of a block (CELL_ROWS, n)."""
    results = new_regimes(cells.shape[1])
    kernels(law).run_regimes(cells, rtol, max_steps, np.array([stop], np.int64), results, until)
    return results


@dataclass
class Outcome:
    """The results of one cell, by their names in `layout.py` in small letters."""

    values: np.ndarray

    def __getattr__(self, name):
        value = self.values[getattr(at, name.upper())]
        return int(value) if name in ("regime", "status", "steps") else float(value)


def outcome(*args, rtol=1e-6, max_steps=1e6, until=at.UNTIL_METRICS, law="stribeck", **kwargs):
    """Run one cell: arguments of `cell` and of `run`."""
    return Outcome(run(block_of(cell(*args, **kwargs)), rtol, max_steps, until, law=law)[:, 0])
