"""Engine against judge, contacts with memory: random cells over decades, what is compared, what stands."""

import numpy as np

import stickslip
from helpers.adversary_cells import exponents, log_uniform, some
from judge import memory
from stickslip.vocabulary.quantities import REGIMES, STATUSES

NAN = float("nan")
PLAIN = {
    "damping": 0.0, "displacement": 0.0, "velocity": NAN, "contact_time": 0.0, "delta": 1.0, "a2": 0.0,
    "contact_damping": 0.0, "contact_damping_speed": NAN, "elastic_part": 0.0,
    "direct_cutoff_speed": NAN, "evolution_cutoff_speed": NAN,
}  # fmt: skip
MOST_STEPS = 50_000  # of the engine
OWED = 100.0  # errors owed, in units of rtol
NOISE = 1000.0  # tolerances: deviation from steady sliding at the band, below which errors decide what hangs on it
BY_BAND = ("settling_time", "equilibrium_crossings")
CLOSE_TO_STICKING = 0.01  # of the least slip speed at which a cycle counts as stick-slip
SAME_TIME = 1e-3  # of settling, and of a free oscillation
BAND_EDGE, BAND_BY_RTOL = 0.02, 1e5  # change of the band that decides nothing; errors of the load count
NUMBERS = (
    "period", "cycle_force_max", "cycle_force_min", "spring_force_max", "spring_force_min", "slip_speed_min",
    "slip_speed_max", "acceleration_max", "energy_per_cycle",
)  # fmt: skip


# --- cells ------------------------------------------------------------------------------------------------------------


def rate_state(rng, n):
    """Mass numbers from 1e-12 to 1e3, stiffness from 1e-3 to 1e3 of the critical one, a quarter of them close to it."""
    load, distance, a = log_uniform(rng, 0.1, 1e4, n), log_uniform(rng, 1e-7, 1e-3, n), log_uniform(rng, 1e-3, 0.05, n)
    speed, inertia = log_uniform(rng, 1e-9, 1.0, n), log_uniform(rng, 1e-12, 1e3, n)
    b = a * rng.uniform(0.2, 4.0, n)
    damping = some(rng, 0.4, n, log_uniform(rng, 1e-4, 3.0, n)) * np.abs(b - a) * load / speed
    mass = inertia * a * load * distance / speed**2
    at_once, steady = a * load / speed + damping, (a - b) * load / speed + damping
    critical = np.abs(steady) * speed / distance * (1.0 + mass * speed / distance / at_once)
    side = 1.0 + rng.choice([-1.0, 1.0], n) * log_uniform(rng, 1e-3, 0.3, n)
    stiffness = critical * np.where(rng.random(n) < 0.25, side, log_uniform(rng, 1e-3, 1e3, n))
    steady_load = 0.6 - (b - a) * np.log(speed / 1e-6)
    kick = some(rng, 0.3, n, rng.normal(0.0, 5.0, n)) * a
    way, slip = np.where(rng.random(n) < 0.2, -1.0, 1.0), log_uniform(rng, 1e-6, 30.0, n)
    slip *= rng.choice([1.0, 0.0, -1.0], n, p=[0.7, 0.15, 0.15])  # of which some is none, or backwards
    return {
        "mass": mass, "stiffness": stiffness, "normal_load": load, "belt_speed": way * speed, "damping": damping,
        "mu_0": np.full(n, 0.6), "v_0": np.full(n, 1e-6), "a": a, "b": b, "D_c": distance,
        "displacement": way * some(rng, 0.4, n, (steady_load + kick) * load / stiffness),
        "velocity": way * some(rng, 0.4, n, speed * (1.0 - slip), NAN),
        "contact_time": some(rng, 0.4, n, distance / speed * log_uniform(rng, 1e-4, 1e6, n)),
    }  # fmt: skip


def cut_offs(rng, n):
    """The same with cut-offs, at speeds from a hundredth to a million times that of the belt; critical is without."""
    cells = rate_state(rng, n)
    for name in ("direct_cutoff_speed", "evolution_cutoff_speed"):
        cells[name] = some(rng, 0.7, n, np.abs(cells["belt_speed"]) * log_uniform(rng, 1e-2, 1e6, n), NAN)
    return cells


def bristles(rng, n):
    """Soft to all but rigid contacts, damped or not, elastic parts, falling and rising curves, belts both ways."""
    mass, stiffness, load = log_uniform(rng, 1e-2, 1e2, n), log_uniform(rng, 1e2, 1e6, n), log_uniform(rng, 1.0, 1e3, n)
    impedance = np.sqrt(mass * stiffness)
    speed, s_0 = load / impedance, log_uniform(rng, 0.3, 1e7, n)
    way = np.where(rng.random(n) < 0.2, -1.0, 1.0)
    a1, a3, belt = (
        rng.uniform(0.05, 0.6, n),
        some(rng, 0.9, n, rng.uniform(0.0, 0.5, n)),
        log_uniform(rng, 1e-4, 3.0, n),
    )
    a4 = np.where(rng.random(n) < 0.3, belt * log_uniform(rng, 0.1, 10.0, n), log_uniform(rng, 1e-3, 3.0, n))
    damped = some(rng, 0.7, n, log_uniform(rng, 1e-3, 3.0, n))
    sliding = rng.random(n) < 0.3
    return {
        "mass": mass, "stiffness": stiffness, "normal_load": load, "belt_speed": way * belt * speed,
        "damping": some(rng, 0.7, n, log_uniform(rng, 1e-3, 1.0, n)) * impedance,
        "a1": a1, "a2": some(rng, 0.5, n, log_uniform(rng, 1e-3, 1.0, n)) / speed, "a3": a3, "a4": a4 * speed,
        "delta": exponents(rng, n, 3.0), "contact_stiffness": s_0 * stiffness,
        "contact_damping": damped * np.sqrt(s_0) * impedance,
        "contact_damping_speed": some(rng, 0.4, n, log_uniform(rng, 1e-3, 100.0, n), NAN) * speed,
        "elastic_part": some(rng, 0.4, n, rng.uniform(0.0, 0.95, n)),
        "displacement": np.where(sliding, way * (a1 + a3) * rng.uniform(0.0, 1.5, n), 0.0) * load / stiffness,
        "velocity": np.where(sliding & (rng.random(n) < 0.7), way * belt * rng.uniform(-2.0, 3.0, n), NAN) * speed,
        "contact_time": np.zeros(n),
    }  # fmt: skip


def heavy(rng, n):
    """The slip law with much inertia, whose cycles are come to slowly and whose slip rests or turns round at first."""
    load, distance, a = log_uniform(rng, 0.1, 1e3, n), log_uniform(rng, 1e-6, 1e-4, n), log_uniform(rng, 3e-3, 0.05, n)
    speed, b = log_uniform(rng, 1e-5, 1e-2, n), a * rng.uniform(1.1, 4.0, n)
    mass = log_uniform(rng, 1.0, 1e5, n) * a * load * distance / speed**2
    critical = (b - a) * load / distance * (1.0 + mass * speed**2 / (distance * a * load))
    return {
        "mass": mass, "stiffness": critical * log_uniform(rng, 1e-4, 0.999, n), "normal_load": load, "a": a, "b": b,
        "belt_speed": speed, "mu_0": rng.uniform(0.2, 0.7, n), "v_0": log_uniform(rng, 1e-6, 1e-4, n), "D_c": distance,
        "velocity": speed * rng.choice([1.0, 1.3], n),
        "contact_time": distance / speed * log_uniform(rng, 0.01, 100.0, n),
    }  # fmt: skip


FAMILIES = {"rate_state": rate_state, "cut_offs": cut_offs, "heavy": heavy, "bristles": bristles}
LAWS = {
    "rate_state": ("rate_state_ageing", "rate_state_slip"),
    "cut_offs": ("rate_state_ageing", "rate_state_slip"),
    "heavy": ("rate_state_slip",),
    "bristles": ("stribeck", "stribeck_delta", "rational", "cubic"),
}


def draw(family, n, rng):
    """{law: cells}, about n cells."""
    every = {}
    for law in LAWS[family]:
        cells = FAMILIES[family](rng, -(-n // len(LAWS[family])))
        if law != "stribeck_delta":
            cells.pop("delta", None)
        if law == "cubic":  # meaningless far beyond its minimum, at a4
            cells["a4"] = np.abs(cells["belt_speed"]) / rng.uniform(0.02, 0.5, cells["a4"].size)
            cells["velocity"] = np.full(cells["a4"].size, NAN)
        every[law] = cells
    return every


# --- the court --------------------------------------------------------------------------------------------------------


def judged(cells, law, **options):
    """Verdicts in SI by the names of `evaluate`; of belts that run backwards mirrored back."""
    whole = {**{n: np.full(cells["mass"].size, v) for n, v in PLAIN.items()}, **cells}
    rows = memory.kernel_rows(whole, law)
    out = np.full((len(rows), memory.ANSWERS), NAN)
    out[:, memory.REGIME] = memory.UNDECIDED
    rate_state = law.startswith("rate_state")
    turns = rate_state & ~np.isnan(whole["velocity"]) & ~(whole["velocity"] / cells["belt_speed"] < 1.0)
    cut = (rows[:, [memory.CUT_1, memory.CUT_2]] > 0.0).any(axis=1)
    out[~turns] = memory.judge_memory(rows[~turns], **options)
    if rate_state:  # where logarithms do not lead to an end, neither do they here
        turns |= out[:, memory.REGIME] == memory.UNDECIDED
        turns &= ~cut  # slip both ways has none in the judge
        rows[turns] = memory.kernel_rows(whole, law, regularised=True)[turns]
        out[turns] = memory.judge_memory(rows[turns], **options)
    m, k, load = cells["mass"], cells["stiffness"], cells["normal_load"]
    time, speed, back = np.sqrt(m / k), load / np.sqrt(k * m), cells["belt_speed"] < 0.0
    by = {name: out[:, getattr(memory, name)] for name in memory.NAMES}
    cycle, slowest = by["REGIME"] == memory.CYCLE, by["SLOWEST"] / rows[:, memory.BELT]
    damped = np.where(by["CROSSINGS"] >= 2.0, "damped", "creep")
    sticks = np.where(slowest < 1e-3, "stick_slip", "sustained")
    settles = np.where(by["REGIME"] == memory.SETTLES, damped, "undecided")
    high, low = (np.where(cycle, by[f"F_{end}"], by[f"WHOLE_{end}"]) for end in ("MAX", "MIN"))
    forces = {"cycle_force": (by["F_MAX"], by["F_MIN"]), "spring_force": (high, low)}
    fastest = np.maximum(by["FASTEST"], -by["SLOWEST"])
    return {
        "regime": np.where(cycle, sticks, settles), "slowest": slowest, "cycle": cycle, "time": time,
        **{f"{name}_max": np.where(back, -low, high) * load for name, (high, low) in forces.items()},
        **{f"{name}_min": np.where(back, -high, low) * load for name, (high, low) in forces.items()},
        "period": by["PERIOD"] * time, "slip_speed_min": by["SLOWEST"] * speed,
        "slip_speed_max": np.where(cycle, fastest, by["WHOLE_FASTEST"]) * speed,
        "acceleration_max": np.where(cycle, by["ACCELERATION"], by["WHOLE_ACCELERATION"]) * load / m,
        "energy_per_cycle": by["HEAT"] * load * load / k, "settling_time": by["SETTLING"] * time,
        "equilibrium_crossings": by["CROSSINGS"], "at_band": by["AT_BAND"],
    }  # fmt: skip


def parts(cells, verdict):
    """(indices, horizon): all, with none."""
    yield np.arange(cells["mass"].size), None


def run_engine(cells, law, rtol, horizon=None):
    ds = stickslip.evaluate(cells, rtol, horizon, law=law, max_steps=MOST_STEPS)
    return {name: ds[name].values for name in ds.data_vars}


def errors(cells, law, ours, verdict, rtol):
    """In units of rtol, by name."""
    force = np.fmax(np.abs(verdict["spring_force_max"]), np.abs(verdict["spring_force_min"]))
    own = 10.0 * cells["a"] if "a" in cells else cells["a1"] + cells["a3"]
    force, belt, cycle = np.fmax(force, cells["normal_load"] * own), np.abs(cells["belt_speed"]), verdict["cycle"]
    impedance = np.sqrt(cells["stiffness"] * cells["mass"])
    with np.errstate(all="ignore"):  # of a cycle that is small beside the load, errors of the load are all of it
        small = np.fmax(0.1 * force / (verdict["cycle_force_max"] - verdict["cycle_force_min"]), 1.0)
        found = {}
        for name in NUMBERS:
            a, b, of_force = ours[name], verdict[name], "force" in name
            scale = force if of_force else np.abs(b)
            if name == "slip_speed_min" and law.startswith("rate_state"):  # over decades: of its logarithm
                a, b = np.log(a / belt), np.log(b / belt)
                scale = np.fmax(np.abs(b), 1.0)
            elif name == "slip_speed_min":
                scale = np.fmax(scale, belt)
            if name == "energy_per_cycle":
                scale = np.fmax(scale, 0.1 * force * belt * np.nan_to_num(verdict["period"]))
            error = np.abs(a - b) / scale / rtol
            if not law.startswith("rate_state") and not of_force:
                error = np.where(cycle, error / small, error)
            if name.startswith("spring_force") or name == "slip_speed_max":
                # in the band, motions that settle are not followed
                inside = memory.BAND * np.fmax(force, verdict["slip_speed_max"] * impedance)
                inside /= scale * (1.0 if of_force else impedance)
                error = np.where(cycle, error, np.fmax(error - inside / rtol, 0.0))
            found[name] = np.where(np.isnan(b) | (a == b), 0.0, np.where(np.isnan(a), np.inf, error))
            if name.startswith("cycle") or name in ("energy_per_cycle", "period", "slip_speed_min"):
                found[name] = np.where(cycle, found[name], 0.0)
    return found


def compare(cells, law, rtol, ours, verdict, horizon=None):
    """For every cell a list of (what, ours, judged, error), or a word."""
    error, outcome = errors(cells, law, ours, verdict, rtol), []
    for i, ruled in enumerate(verdict["regime"]):
        said, status = REGIMES[int(ours["regime"][i])], STATUSES[int(ours["status"][i])]
        near = abs(np.log(max(verdict["slowest"][i], 1e-300) / 1e-3)) < CLOSE_TO_STICKING
        if said in ("unresolved", "failed") or status == "irregular":
            outcome.append(status)
        elif ruled == "undecided" or (near and {said, ruled} == {"stick_slip", "sustained"}):
            outcome.append("undecided")
        elif {said, ruled} == {"damped", "creep"} and not verdict["at_band"][i] > NOISE * rtol:
            outcome.append("undecided")
        elif said != ruled:
            outcome.append([("regime", said, str(ruled), NAN)])
        else:
            wrong = [
                (n, float(ours[n][i]), float(verdict[n][i]), float(error[n][i])) for n in NUMBERS if error[n][i] > OWED
            ]
            if said in ("damped", "creep") and verdict["at_band"][i] > NOISE * rtol:
                wrong += by_band(ours, verdict, i)
            outcome.append(wrong)
    return outcome


def by_band(ours, verdict, i):
    wrong = []
    a, b = float(ours["settling_time"][i]), float(verdict["settling_time"][i])
    if not np.isnan(b) and not abs(a - b) < SAME_TIME * (b + 2.0 * np.pi * verdict["time"][i]):
        wrong.append(("settling_time", a, b, abs(a - b) / b / 1e-3))
    a, b = float(ours["equilibrium_crossings"][i]), float(verdict["equilibrium_crossings"][i])
    if not np.isnan(verdict["settling_time"][i]) and a != b:
        wrong.append(("equilibrium_crossings", a, b, NAN))
    return wrong


def stands(dispute, what, said):
    """ "stands", "undecided" or "sensitive": by a tighter judge, and of cells that differ by rtol."""
    cells, law, rtol, rng = dispute.cell, dispute.law, dispute.rtol, np.random.default_rng(1)
    first, tight = judged(cells, law), judged(cells, law, tolerance=1e-11, most_steps=400_000)
    near = {n: np.repeat(v, 6) * (1.0 + rtol * rng.choice((-1.0, 1.0), 6)) for n, v in cells.items()}
    for name in PLAIN.keys() & near.keys():
        near[name] = np.where(np.repeat(cells[name], 6) == PLAIN[name], PLAIN[name], near[name])
    others = judged(near, law)
    if tight["regime"][0] != first["regime"][0] or (others["regime"] != first["regime"][0]).any():
        return "undecided"
    if what in NUMBERS and np.isfinite(said):
        if errors(cells, law, first, tight, rtol)[what][0] > 0.1 * OWED:
            return "undecided"
        ours = {n: np.full(6, tight[n][0]) for n in NUMBERS}
        return "sensitive" if errors(near, law, ours, others, rtol)[what].max() > 0.3 * OWED else "stands"
    if what == "regime" and set(first["regime"]) <= {"damped", "creep"}:
        return by_band_edge(cells, law, "equilibrium_crossings", first, others, rtol, NAN)
    return by_band_edge(cells, law, what, first, others, rtol, said) if what in BY_BAND else "stands"


def by_band_edge(cells, law, what, first, others, rtol, said):
    """ "undecided" where slightly different bands, or cells, say what the engine says, or something else again."""
    edge = max(BAND_EDGE, BAND_BY_RTOL * rtol)
    bands = [memory.BAND * (1.0 + change) for change in (-edge, -0.5 * edge, 0.5 * edge, edge)]
    edges = [judged(cells, law, band=band)[what][0] for band in bands] + [first[what][0], *others[what]]
    if what == "settling_time":
        allowed = SAME_TIME * (first[what][0] + 2.0 * np.pi * first["time"][0])
        return "undecided" if min(edges) - allowed <= said <= max(edges) + allowed else "stands"
    return "undecided" if len(set(edges)) > 1 else "stands"
