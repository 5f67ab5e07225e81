"""Engine against judge, rigid contacts: where they disagree, and whether that stands.

Cells, verdicts and answers of the engine are arrays by name.
"""

import numpy as np

import stickslip
from helpers import adversary_cells
from helpers.adversary_cells import take
from judge import BAND_SHARE, TIGHT, judge, to_kernel
from judge.curve import weakened
from stickslip.vocabulary.quantities import REGIMES, STATUSES

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
HORIZON_RATIO = 3.0  # cells whose horizons differ by less run together
MOST_JUDGED = 2e5


def draw(family, n, rng):
    """{law: cells}, n cells in all."""
    laws, cells = adversary_cells.draw(family, n, rng)
    return {law: take(cells, laws == law) for law in dict.fromkeys(laws.tolist())}


def judged(cells, law, most_steps=MOST_JUDGED, **options):
    return judge(cells, law, most_steps=most_steps, **options)


def parts(cells, verdict):
    """(indices, horizon): all with none, and cells of like horizon together.

    A horizon is some 60 cycles or free oscillations after the first break-away (s): the longest of the cells.
    """
    yield np.arange(cells["mass"].size), None
    loop = 2 * np.pi * np.sqrt(cells["mass"] / cells["stiffness"])
    start = np.fmax(np.nan_to_num(verdict["breakaway_time"]), np.nan_to_num(verdict["restick_time"]))
    each = start + HORIZON_LOOPS * np.fmax(verdict["period"], loop)
    bins = np.floor(np.log(each) / np.log(HORIZON_RATIO))
    for b in np.unique(bins):
        yield np.flatnonzero(bins == b), float(each[bins == b].max())


def run_engine(cells, law, rtol, horizon=None):
    """`evaluate` as arrays, with regimes by class, and the stick time per period."""
    ds = stickslip.evaluate(cells, rtol, horizon, early_stop=horizon is None, law=law)
    ours = {name: ds[name].values for name in ds.data_vars}
    names = np.array(REGIMES)[ours["regime"]]
    ours["kind"], ours["regime"] = names, np.array([CLASS.get(name, name) for name in names])
    ours["stick_time_all"] = ours.get("stick_time", np.full(len(names), np.nan))
    ours["stick_time"] = ours["stick_fraction"] * ours["period"]
    return ours


def scales(cells, verdict):
    """What the error of each number is measured by."""
    impedance = np.sqrt(cells["stiffness"] * cells["mass"])
    force = np.fmax(cells["normal_load"] * (cells["a1"] + cells["a3"]), impedance * np.abs(cells["belt_speed"]))
    force = np.fmax(
        force, np.fmax(cells["stiffness"] * np.abs(cells["displacement"]), impedance * np.abs(cells["velocity"]))
    )
    scale = {name: np.abs(verdict[name]) for name in NUMBERS}
    for name in ("spring_force_max", "spring_force_min", "cycle_force_max", "cycle_force_min"):
        scale[name] = force
    for name in ("restick_displacement", "settled_displacement", "displacement_amplitude"):
        scale[name] = force / cells["stiffness"]
    scale["velocity_amplitude"] = scale["slip_speed_max"]
    scale["tendency"] = scale["mu_reversal"] = scale["mu_breakaway"]
    way = np.abs(cells["belt_speed"]) * np.nan_to_num(verdict["period"])
    scale["energy_per_cycle"] = np.fmax(scale["energy_per_cycle"], LITTLE_HEAT * force * way)
    scale["stick_time"] = np.abs(verdict["period"])
    scale["acceleration_max"] = np.fmax(scale["acceleration_max"], force / cells["mass"])
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
    return SAME_TIME * (
        np.nan_to_num(verdict["settling_time"]) + 2 * np.pi * np.sqrt(cells["mass"] / cells["stiffness"])
    )


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


def stands_by_band(dispute, what, ours, judged_kind):
    """ "undecided" where a slightly different band would say what the engine says, or something else again."""
    others = [judged(dispute.cell, dispute.law, band=BAND_SHARE * b) for b in BANDS]
    if what == "settling_time":
        times, allowed = [v["settling_time"][0] for v in others], time_allowed(dispute.cell, others[0])[0]
        inside = min(times) - allowed <= ours <= max(times) + allowed
        return "undecided" if inside or not np.isfinite(times).all() else "stands"
    counts = {str(kind_of(v)[0]) if what == "damped/creep" else v[what][0] for v in others}
    return "undecided" if len(counts | {judged_kind}) > 1 else "stands"


# --- re-judging ---


def stands(dispute, what, ours):
    """ "stands", "undecided" or "sensitive": the word of a tighter judge, and of judges of slightly different cells."""
    one, law, rtol = dispute.cell, dispute.law, dispute.rtol
    first, tight = judged(one, law), judged(one, law, 4 * MOST_JUDGED, **TIGHT)
    regime = tight["regime"][0]
    if regime != first["regime"][0] or regime == "undecided":
        return "undecided"
    near = neighbours(one, rtol)
    others = judged(near, law)
    if (others["regime"] != regime).any():
        return "undecided"
    if what in BY_BAND:
        kind = str(kind_of(first)[0]) if what == "damped/creep" else first[what][0]
        return stands_by_band(dispute, what, ours, kind)
    if what not in NUMBERS:
        return "stands"
    if errors(one, first, tight, rtol)[what][0] > 0.1 * OWED:
        return "undecided"
    moved = errors(near, {n: np.full(6, tight[n][0]) for n in NUMBERS}, others, rtol)[what]
    return "sensitive" if np.max(moved) > 0.3 * OWED else "stands"


def neighbours(cell, rtol):
    """Six cells whose inputs differ by up to rtol, one from another; what must be equal, or no smaller, stays so."""
    rng = np.random.default_rng(1)
    near = {n: v * (1.0 + rtol * rng.choice((-1.0, 1.0), 6)) for n, v in cell.items()}
    static = near["a1"] + near["a3"]
    for name in ("mu_static", "mu_stop"):
        near[name] = np.where(cell[name] == cell["a1"] + cell["a3"], static, near[name])
    near["mu_static"] = np.where(near["mu_static"] < static, static, near["mu_static"])
    near["velocity"] = np.where(cell["velocity"] == cell["belt_speed"], near["belt_speed"], near["velocity"])
    near["delta"] = np.maximum(near["delta"], 1.0)
    return near


def grazes(cells, verdict, rtol):
    """Whether the stick phases are so short that the slip speed, without them, would dip by less than a tolerance."""
    phase = np.sqrt(cells["stiffness"] / cells["mass"]) * verdict["stick_time"] / np.fmax(verdict["loops"], 1.0)
    return 0.5 * np.abs(cells["belt_speed"]) * phase**2 < rtol * verdict["slip_speed_max"]


def compare(cells, law, rtol, ours, verdict, horizon=None):
    """For every cell the list of disagreements (what, ours, judged, error); a string stands for a cell that cannot be
    compared: "undecided", or the status with which the engine left it unresolved."""
    error = errors(cells, ours, verdict, rtol)
    slow = np.abs(2 * np.pi * ours["damping_ratio"]) < SLOWEST_DECREMENT
    slow |= np.abs(verdict["decrement"]) < SLOWEST_DECREMENT
    grazing, negative = grazes(cells, verdict, rtol), negative_friction(cells, law, ours, verdict)
    late = late_sticks_wrong(cells, ours, verdict, horizon) if horizon else np.zeros(len(error["period"]), bool)
    outcome = []
    for i in range(len(error["period"])):
        ruled, said = verdict["regime"][i], ours["regime"][i]
        near = slow[i] if {ruled, said} == {"settles", "rings"} else grazing[i] and ruled == "stick_slip"
        if ruled == "undecided" or (near and said != ruled):
            outcome.append("undecided")
        elif said == "unresolved" or negative[i]:
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


def negative_friction(cells, law, ours, verdict):
    """Whether the engine rightly gives no verdict because friction would drive the motion."""
    speeds = verdict["slip_speed_max"] * np.sqrt(cells["stiffness"] * cells["mass"]) / cells["normal_load"]
    drops = np.array([weakened(row, w) for row, w in zip(to_kernel(cells, law), speeds, strict=True)])
    negative = cells["a1"] + cells["a3"] - drops < 0.0
    return negative & (ours["status"] == STATUSES.index("negative_friction"))
