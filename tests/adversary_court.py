"""Engine against judge: where they disagree, whether that stands, and the shortest way to say so."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import stickslip
from adversary_cells import to_units
from judge import DEFAULTS, INPUTS, TIGHT, judge
from stickslip.variables import REGIMES, STATUSES

CLASS = {"stick_slip": "stick_slip", "damped": "settles", "creep": "settles", "sustained": "rings", "stuck": "stuck"}
NUMBERS = (
    "breakaway_time", "restick_time", "restick_displacement", "period", "stick_time", "spring_force_max",
    "spring_force_min", "slip_speed_max", "acceleration_max", "energy_per_cycle",
)  # fmt: skip
OWED = 100.0  # errors owed, in units of rtol
HORIZON_LOOPS = 60
SLOWEST_DECREMENT = 1e-4  # decay or growth this slow: whether it "rings" is a matter of words
MOST_JUDGED = 2e5
FEW_STEPS = 100_000  # while minimising


@dataclass
class Dispute:
    """One cell on which engine and judge disagree. `what` is "regime" or the name of a number."""

    family: str
    law: str
    rtol: float
    early_stop: bool
    what: str
    ours: object
    judged: object
    cell: dict
    error: float = np.nan  # of a number, in units of rtol
    sensitivity: float = np.nan  # what rtol in the inputs does to the number, in units of rtol

    def line(self):
        """To paste into Python."""
        given = ", ".join(f"{n}={v!r}" for n, v in self.cell.items() if not _is_default(n, v))
        how = "" if self.early_stop else f", early_stop=False, horizon={horizon_of([self.cell], self.law):.6g}"
        call = f'stickslip.evaluate(dict({given}), rtol={self.rtol:g}, law="{self.law}"{how})'
        more = "" if self.what == "regime" else f" ({self.error:.3g} rtol; inputs +-rtol: {self.sensitivity:.2g} rtol)"
        return f"{call}  # {self.family}: {self.what}: ours {_text(self.ours)}, judge {_text(self.judged)}{more}"


def _is_default(name, value):
    return name in DEFAULTS and (value == DEFAULTS[name] or (np.isnan(value) and np.isnan(DEFAULTS[name])))


def _text(value):
    return value if isinstance(value, str) else f"{value:.10g}"


def columns(cells):
    """A list of cells as arrays by name."""
    return {name: np.array([c[name] for c in cells]) for name in INPUTS}


def horizon_of(cells, law, verdict=None):
    """Some 60 cycles or free oscillations after the first break-away (s): the longest of the cells."""
    c = columns(cells)
    verdict = verdict or judge(c, law, most_steps=MOST_JUDGED)
    loop = 2 * np.pi * np.sqrt(c["mass"] / c["stiffness"])
    start = np.fmax(np.nan_to_num(verdict["breakaway_time"]), np.nan_to_num(verdict["restick_time"]))
    return float(np.max(start + HORIZON_LOOPS * np.fmax(verdict["period"], loop)))


def run_engine(cells, law, rtol, horizon=None, threads=1, max_steps=1_000_000):
    """`evaluate` as arrays, with regimes by class and the stick time per period."""
    ds = stickslip.evaluate(
        columns(cells), rtol, horizon, early_stop=horizon is None, threads=threads, law=law, max_steps=max_steps
    )
    ours = {name: ds[name].values for name in ds.data_vars}
    names = np.array(REGIMES)[ours["regime"]]
    ours["regime"] = np.array([CLASS.get(name, name) for name in names])
    ours["stick_time_all"] = ours.get("stick_time", np.full(len(names), np.nan))
    ours["stick_time"] = ours["stick_fraction"] * ours["period"]
    return ours


def scales(cells, verdict):
    """What the error of each number is measured by."""
    c = columns(cells)
    force = c["normal_load"] * (c["a1"] + c["a3"])
    scale = {name: np.abs(verdict[name]) for name in NUMBERS}
    scale["restick_displacement"] = force / c["stiffness"]
    scale["spring_force_max"] = scale["spring_force_min"] = force
    scale["stick_time"] = np.abs(verdict["period"])
    scale["acceleration_max"] = np.fmax(scale["acceleration_max"], force / c["mass"])
    return scale


def errors(cells, ours, verdict, rtol):
    """Errors of the numbers in units of rtol, by name; inf where only one side has a number.

    Cycles of an unequal number of loops have no common period; what no cycle defines is compared for all.
    """
    scale = scales(cells, verdict)
    found = {}
    for name in NUMBERS:
        a, b = ours[name], verdict[name]
        with np.errstate(all="ignore"):
            error = np.abs(a - b) / scale[name] / rtol
        error = np.where(a == b, 0.0, error)
        one_sided = np.isnan(a) != np.isnan(b)
        found[name] = np.where(np.isnan(a) & np.isnan(b), 0.0, np.where(one_sided, np.inf, error))
    return found


def late_sticks_wrong(cells, ours, verdict, horizon):
    """Whether a run to the horizon sticks on where the judge says it does not, or the other way round."""
    at_rest = np.nan_to_num(ours["stick_time_all"])
    cycles = (horizon - np.nan_to_num(verdict["breakaway_time"])) / verdict["period"] * np.fmax(verdict["loops"], 1.0)
    sticking = verdict["regime"] == "stick_slip"
    with np.errstate(invalid="ignore"):
        too_few = ours["sticks"] < 0.9 * cycles - 3
        too_many = ours["sticks"] > 1.1 * cycles + 3
    silent = np.isin(verdict["regime"], ("settles", "rings")) & (ours["sticks"] > verdict["releases"] + 0.5)
    wrong = np.where(sticking, too_few | too_many, silent & (at_rest > 0.0))
    return wrong & (ours["status"] == STATUSES.index("horizon_reached"))  # not where the step budget ran out


# --- re-judging ---


def stands(dispute):
    """ "stands", "undecided" or "sensitive": the word of a tighter judge, and of judges of slightly different cells."""
    one, law, rtol = [dispute.cell], dispute.law, dispute.rtol
    first = judge(columns(one), law, most_steps=MOST_JUDGED)
    tight = judge(columns(one), law, most_steps=4 * MOST_JUDGED, **TIGHT)
    if tight["regime"][0] != first["regime"][0] or tight["regime"][0] == "undecided":
        return "undecided"
    near = neighbours(dispute.cell, rtol)
    others = judge(columns(near), law, most_steps=MOST_JUDGED)
    if (others["regime"] != tight["regime"][0]).any():
        return "undecided"
    if dispute.what in ("regime", "late sticks"):
        return "stands"
    if errors(one, first, tight, rtol)[dispute.what][0] > 0.1 * OWED:
        return "undecided"
    moved = errors(near, {n: np.full(len(near), tight[n][0]) for n in NUMBERS}, others, rtol)[dispute.what]
    dispute.sensitivity = float(np.max(moved))
    return "sensitive" if dispute.sensitivity > 0.3 * OWED else "stands"


def neighbours(cell, rtol):
    """Cells whose inputs differ by up to rtol, one from another."""
    rng = np.random.default_rng(1)
    near = [{n: v * (1.0 + rtol * rng.choice((-1.0, 1.0))) for n, v in cell.items()} for _ in range(6)]
    for other in near:  # what must be equal, or may not be smaller, stays so
        for name in ("mu_static", "mu_stop"):
            if cell[name] == cell["a1"] + cell["a3"]:
                other[name] = other["a1"] + other["a3"]
        other["mu_static"] = max(other["mu_static"], other["a1"] + other["a3"])
        if cell["velocity"] == cell["belt_speed"]:
            other["velocity"] = other["belt_speed"]
        other["delta"] = max(other["delta"], 1.0)
    return near


def disagreement(cell, law, rtol, early_stop, what=None):
    """The first disagreement on a cell as (what, ours, judged, error), or None. what : look at this alone."""
    one = [cell]
    verdict = judge(columns(one), law, most_steps=MOST_JUDGED)
    horizon = None if early_stop else horizon_of(one, law, verdict)
    ours = run_engine(one, law, rtol, horizon, max_steps=FEW_STEPS)
    found = compare(one, law, rtol, ours, verdict, horizon)
    kinds = [f for f in found[0] if what is None or f[0] == what]
    return kinds[0] if kinds else None


def compare(cells, law, rtol, ours, verdict, horizon=None):
    """For every cell the list of disagreements (what, ours, judged, error); the string "unresolved" or "undecided"
    stands for a cell that cannot be compared."""
    error = errors(cells, ours, verdict, rtol)
    slow = np.abs(2 * np.pi * ours["damping_ratio"]) < SLOWEST_DECREMENT
    slow |= np.abs(verdict["decrement"]) < SLOWEST_DECREMENT
    late = late_sticks_wrong(cells, ours, verdict, horizon) if horizon else np.zeros(len(cells), bool)
    outcome = []
    for i in range(len(cells)):
        ruled, said = verdict["regime"][i], ours["regime"][i]
        if ruled == "undecided" or ({ruled, said} == {"settles", "rings"} and slow[i]):
            outcome.append("undecided")
        elif said == "unresolved":
            outcome.append("unresolved")
        elif said != ruled:
            outcome.append([("regime", str(said), str(ruled), np.nan)])
        else:
            wrong = (
                []
                if not late[i]
                else [("late sticks", float(ours["sticks"][i]), float(verdict["releases"][i]), np.nan)]
            )
            wrong += [
                (n, float(ours[n][i]), float(verdict[n][i]), float(error[n][i])) for n in NUMBERS if error[n][i] > OWED
            ]
            outcome.append(wrong)
    return outcome


# --- minimising ---


def minimised(dispute):
    """The same disagreement on the plainest cell that still shows it: defaults, few digits, m = k = N = 1."""
    best = dict(dispute.cell)

    def survives(cell):
        nonlocal best
        try:
            found = disagreement(cell, dispute.law, dispute.rtol, dispute.early_stop, dispute.what)
        except ValueError:  # not a cell
            return False
        if found is None:
            return False
        trial = Dispute(dispute.family, dispute.law, dispute.rtol, dispute.early_stop, *found[:3], cell, found[3])
        if stands(trial) != "stands":
            return False
        best = cell
        dispute.ours, dispute.judged, dispute.error, dispute.sensitivity = *found[1:], trial.sensitivity
        return True

    survives(to_units(best))
    for name, plain in DEFAULTS.items():
        if not _is_default(name, best[name]):
            survives({**best, name: plain})
    for name in INPUTS:
        if _is_default(name, best[name]):
            continue
        for digits in range(1, 9):
            shorter = float(f"{best[name]:.{digits}g}")
            if shorter == best[name] or survives({**best, name: shorter}):
                break
    dispute.cell = best
    return dispute
