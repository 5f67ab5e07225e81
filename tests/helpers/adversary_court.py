"""Engine against judge: where they disagree, whether that stands, and the shortest way to say so."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import stickslip
from helpers.adversary_cells import to_units
from judge import BAND_SHARE, DEFAULTS, INPUTS, TIGHT, judge, to_kernel
from judge.curve import weakened
from stickslip.vocabulary.flags import REGIMES, STATUSES

SETTLES = ("damped", "creep")
CLASS = {"stick_slip": "stick_slip", "damped": "settles", "creep": "settles", "sustained": "rings", "stuck": "stuck"}
NUMBERS = (
    "breakaway_time", "restick_time", "restick_displacement", "period", "stick_time", "spring_force_max",
    "spring_force_min", "slip_speed_max", "acceleration_max", "energy_per_cycle", "cycle_force_max", "cycle_force_min",
    "displacement_amplitude", "velocity_amplitude", "settled_displacement", "mu_breakaway", "mu_reversal", "tendency",
)  # fmt: skip
BY_BAND = ("damped/creep", "equilibrium_crossings", "settling_time")  # what hangs on the settling band
OWED = 100.0  # errors owed, in units of rtol
SAME_TIME = 1e-3  # of settling, and of a free oscillation
BANDS = (0.99, 1.01)  # what changes between these bands, in units of the true one, is not decided
HORIZON_LOOPS = 60
SLOWEST_DECREMENT = 1e-4  # decay or growth this slow: whether it decays is a matter of definition
LITTLE_HEAT = 0.01  # of the work of static friction over the displacement of the belt: less heat is a small difference
MOST_JUDGED = 2e5


@dataclass
class Dispute:
    """One cell on which engine and judge disagree. `what` is "regime", "late sticks", one of BY_BAND or NUMBERS."""

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
        more = f" ({self.error:.3g} rtol; inputs +-rtol: {self.sensitivity:.2g} rtol)" if self.what in NUMBERS else ""
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


def run_engine(cells, law, rtol, horizon=None, threads=1):
    """`evaluate` as arrays, with regimes by class, and the stick time per period."""
    ds = stickslip.evaluate(columns(cells), rtol, horizon, early_stop=horizon is None, threads=threads, law=law)
    ours = {name: ds[name].values for name in ds.data_vars}
    names = np.array(REGIMES)[ours["regime"]]
    ours["kind"], ours["regime"] = names, np.array([CLASS.get(name, name) for name in names])
    ours["stick_time_all"] = ours.get("stick_time", np.full(len(names), np.nan))
    ours["stick_time"] = ours["stick_fraction"] * ours["period"]
    return ours


def scales(cells, verdict):
    """What the error of each number is measured by."""
    c = columns(cells)
    impedance = np.sqrt(c["stiffness"] * c["mass"])
    force = np.fmax(c["normal_load"] * (c["a1"] + c["a3"]), impedance * np.abs(c["belt_speed"]))
    force = np.fmax(force, np.fmax(c["stiffness"] * np.abs(c["displacement"]), impedance * np.abs(c["velocity"])))
    scale = {name: np.abs(verdict[name]) for name in NUMBERS}
    for name in ("spring_force_max", "spring_force_min", "cycle_force_max", "cycle_force_min"):
        scale[name] = force
    for name in ("restick_displacement", "settled_displacement", "displacement_amplitude"):
        scale[name] = force / c["stiffness"]
    scale["velocity_amplitude"] = scale["slip_speed_max"]
    scale["tendency"] = scale["mu_reversal"] = scale["mu_breakaway"]
    way = np.abs(c["belt_speed"]) * np.nan_to_num(verdict["period"])
    scale["energy_per_cycle"] = np.fmax(scale["energy_per_cycle"], LITTLE_HEAT * force * way)
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
    left = horizon - verdict["decided_at"]
    cycles = left / verdict["period"] * np.fmax(verdict["loops"], 1.0)
    sticking = (verdict["regime"] == "stick_slip") & (left > 0.0)
    with np.errstate(invalid="ignore"):
        too_few = ours["sticks"] - verdict["releases"] < 0.95 * cycles - 3
        too_many = ours["sticks"] - verdict["releases"] > 1.05 * cycles + 3
    silent = np.isin(verdict["regime"], ("settles", "rings")) & (ours["sticks"] > verdict["releases"] + 0.5)
    wrong = np.where(sticking, too_few | too_many, silent & (at_rest > 0.0))
    return wrong & (ours["status"] == STATUSES.index("horizon_reached"))  # not where the step budget ran out


# --- what hangs on the settling band ---


def kind_of(verdict):
    """Damped or creep; the class of a motion that does not settle."""
    damped = np.where(verdict["equilibrium_crossings"] >= 2.0, *SETTLES)
    return np.where(verdict["regime"] == "settles", damped, verdict["regime"])


def time_allowed(cells, verdict):
    """By how much times of settling may differ."""
    c = columns(cells)
    return SAME_TIME * (np.nan_to_num(verdict["settling_time"]) + 2 * np.pi * np.sqrt(c["mass"] / c["stiffness"]))


def by_band(cells, ours, verdict, i):
    """Disagreements on what hangs on the band, of a cell that settles on both sides.

    A motion that is known to settle before it comes into the band has no time, and crosses as often as was seen.
    """
    wrong, kind = [], str(kind_of(verdict)[i])
    if ours["kind"][i] != kind:
        wrong.append(("damped/creep", str(ours["kind"][i]), kind, np.nan))
    known = np.isfinite(ours["settling_time"][i]) and np.isfinite(verdict["settling_time"][i])
    allowed = {"equilibrium_crossings": 0.0, "settling_time": time_allowed(cells, verdict)[i]}
    for name, most in allowed.items():
        if known and abs(ours[name][i] - verdict[name][i]) > most:
            wrong.append((name, float(ours[name][i]), float(verdict[name][i]), np.nan))
    return wrong


def stands_by_band(dispute):
    """ "undecided" where a slightly different band would say what the engine says, or something else again."""
    one = [dispute.cell]
    others = [judge(columns(one), dispute.law, most_steps=MOST_JUDGED, band=BAND_SHARE * b) for b in BANDS]
    if dispute.what == "settling_time":
        times, allowed = [v["settling_time"][0] for v in others], time_allowed(one, others[0])[0]
        inside = min(times) - allowed <= dispute.ours <= max(times) + allowed
        return "undecided" if inside or not np.isfinite(times).all() else "stands"
    counts = {dispute.judged} | {
        str(kind_of(v)[0]) if dispute.what == "damped/creep" else v[dispute.what][0] for v in others
    }
    return "undecided" if len(counts) > 1 else "stands"


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
    if dispute.what in BY_BAND:
        return stands_by_band(dispute)
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
    ours = run_engine(one, law, rtol, horizon)
    found = compare(one, law, rtol, ours, verdict, horizon)
    kinds = [f for f in found[0] if what is None or f[0] == what]
    return kinds[0] if kinds else None


def grazes(cells, verdict, rtol):
    """Whether the stick phases are so short that the slip speed, without them, would dip by less than a tolerance."""
    c = columns(cells)
    phase = np.sqrt(c["stiffness"] / c["mass"]) * verdict["stick_time"] / np.fmax(verdict["loops"], 1.0)
    return 0.5 * np.abs(c["belt_speed"]) * phase**2 < rtol * verdict["slip_speed_max"]


def compare(cells, law, rtol, ours, verdict, horizon=None):
    """For every cell the list of disagreements (what, ours, judged, error); a string stands for a cell that cannot be
    compared: "undecided", or the status with which the engine left it unresolved."""
    error = errors(cells, ours, verdict, rtol)
    slow = np.abs(2 * np.pi * ours["damping_ratio"]) < SLOWEST_DECREMENT
    slow |= np.abs(verdict["decrement"]) < SLOWEST_DECREMENT
    grazing = grazes(cells, verdict, rtol)
    late = late_sticks_wrong(cells, ours, verdict, horizon) if horizon else np.zeros(len(cells), bool)
    outcome = []
    for i in range(len(cells)):
        ruled, said = verdict["regime"][i], ours["regime"][i]
        near = slow[i] if {ruled, said} == {"settles", "rings"} else grazing[i] and ruled == "stick_slip"
        if ruled == "undecided" or (near and said != ruled):
            outcome.append("undecided")
        elif said == "unresolved" or negative_friction(cells[i], law, ours, verdict, i):
            outcome.append(STATUSES[ours["status"][i]])
        elif said != ruled:
            outcome.append([("regime", str(said), str(ruled), np.nan)])
        else:
            wrong = by_band(cells, ours, verdict, i) if ruled == "settles" else []
            if late[i]:
                wrong.append(("late sticks", float(ours["sticks"][i]), float(verdict["releases"][i]), np.nan))
            wrong += [
                (n, float(ours[n][i]), float(verdict[n][i]), float(error[n][i])) for n in NUMBERS if error[n][i] > OWED
            ]
            outcome.append(wrong)
    return outcome


def negative_friction(cell, law, ours, verdict, i):
    """Whether the engine rightly gives no verdict because friction would drive the motion."""
    if STATUSES[ours["status"][i]] != "negative_friction":
        return False
    row = to_kernel(columns([cell]), law)[0]
    speed = cell["normal_load"] / np.sqrt(cell["stiffness"] * cell["mass"])
    return cell["a1"] + cell["a3"] - weakened(row, verdict["slip_speed_max"][i] / speed) < 0.0


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
