"""Configurations of simulated rigs, and what SciPy says of the same rigs."""

import numpy as np

from helpers.scipy_rig import Rig, trapezoidal
from stickslip_rig.api import make_rig

FELT = {
    "system": {"mass": 0.1, "stiffness": 5000.0, "damping": 2.0, "normal_load": 10.0, "belt_speed": 0.01},
    "friction": {"a1": 0.28, "a2": 0.0, "a3": 0.12, "a4": 0.02, "ageing_rate": 0.01},
    "drive": {"stroke": 0.004, "strokes": 2, "ramp": 0.05, "dwell": 0.1, "waiting_time": 0.5},
    "sensor": {"rate": 2000.0},
}


def data(**changes):
    """The felt rig as plain data, with other sections or other keys of them; a key that is None goes."""
    found = {section: dict(values) for section, values in FELT.items()}
    for section, values in changes.items():
        if isinstance(values, dict):
            found[section] = {k: v for k, v in (found.get(section, {}) | values).items() if v is not None}
        else:
            found[section] = values
    return found


def rig(**changes):
    """The felt rig; `changes` as for `data`."""
    return make_rig(data(**changes))


def random_data(seed, **changes):
    """A rig of random parameters, some of them with ageing, dwells, or a static friction above the curve."""
    random = np.random.default_rng([20, seed])
    u = random.uniform
    system = {"mass": u(0.02, 0.3), "stiffness": 10 ** u(3, 4.3), "damping": u(0, 3), "normal_load": u(5, 20),
              "belt_speed": u(0.005, 0.02)}  # fmt: skip
    friction = {"a1": u(0.1, 0.5), "a2": u(0, 2), "a3": u(0, 0.4), "a4": u(0.002, 0.02), "ageing_time": 0.1,
                "ageing_rate": float(random.choice([0.0, 0.02]))}  # fmt: skip
    if random.random() < 0.3:
        friction["mu_static"] = friction["a1"] + friction["a3"] + u(0, 0.1)
    drive = {"stroke": 0.003, "ramp": u(0.01, 0.1), "dwell": float(random.choice([0.0, u(0, 0.2)])),
             "waiting_time": float(random.choice([0.0, u(0, 1)]))}  # fmt: skip
    return data(**{"system": system, "friction": friction, "drive": drive} | changes)


def reference(found):
    """The same rig by SciPy, from plain data in SI."""
    system, friction, drive = found["system"], found["friction"], found["drive"]
    way = trapezoidal(
        drive["stroke"], system["belt_speed"], drive["ramp"], drive["dwell"], drive["strokes"], drive["waiting_time"]
    )
    return Rig(
        way, system["mass"], system["stiffness"], system["damping"], system["normal_load"],
        tuple(friction[name] for name in ("a1", "a2", "a3", "a4")), friction.get("mu_static", np.nan),
        friction["ageing_rate"], friction.get("ageing_time", 1.0),
    )  # fmt: skip


def exact(solved, per_period=2000):
    """What the phases of a reference say, by names of `rig.quantities.EXACT`."""
    sticking = [p for p in solved.phases if p.sticks]
    begun = [p for p, before in zip(solved.phases, [None, *solved.phases], strict=False)
             if p.sticks and not (before and before.sticks)]  # fmt: skip
    largest = max(abs(p.acceleration) for p in sticking)
    for p in (p for p in solved.phases if not p.sticks):
        t = np.linspace(p.start, p.end, 2 + int(per_period * (p.end - p.start) / solved.period))
        x, v, *_ = p.state(t)
        slip = np.maximum(p.sigma * (p.velocity + p.acceleration * (t - p.start) - v), 0.0)
        force = p.sigma * solved.load * solved.mu(slip) - solved.stiffness * x - solved.damping * v
        largest = max(largest, float(np.abs(force).max()) / solved.mass)
    found = {
        "sticks_exact": len(begun), "slips_exact": len(solved.breakaways),
        "stick_time": sum(p.end - p.start for p in sticking), "acceleration_max_exact": largest,
        "drive_work": solved.y[3], "friction_heat": solved.y[4], "damper_heat": solved.y[5],
    }  # fmt: skip
    if solved.breakaways:
        first = next(p for p in solved.phases if not p.sticks)
        x, v, *_ = first.state(first.start)
        found["breakaway_time"] = solved.breakaways[0]
        needed = solved.stiffness * x + solved.damping * v + solved.mass * first.acceleration
        # where the plate changes its acceleration, what is needed may jump over what the contact can give
        given = solved.mu_static + solved.beta * np.log10(1 + solved.breakaways[0] / solved.t0)
        found["breakaway_force"] = min(needed, solved.load * given)
    return found
