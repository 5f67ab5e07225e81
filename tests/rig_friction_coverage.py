"""How often the intervals of `rig friction` hold the truth: records of simulated rigs over decades (docs/rig.md).

    python tests/rig_friction_coverage.py --records 2000 --seed 1

Springs of 0.1 to 100 N/mm, masses of 10 g to 1 kg, loads of 2 to 50 N, friction at break-away of 0.1 to 1 that drops by
10 to 60 %, a4 of 0.1 to 1 of the greatest slip speed (5 mm/s to 2 m/s), the drive 0.02 to 0.3 of it. In 70 % friction
falls along the line of Eq. (2a) while slip slows down, else there is one curve. Slips have 15 to 500 samples; sensors
have none or a bandwidth of 0.05 to 0.45 of the sampling rate, and no noise or up to 3 % (force) and 5 % (acceleration).
The truth is one slip, solved by SciPy. Of the record time, force, acceleration and drive velocity are kept.
"""

import argparse
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from helpers.coverage import covered, table, trials, wrong
from stickslip import rig
from stickslip.theory import stribeck
from stickslip.vocabulary.models.stribeck import coefficients

NAMES = ("mu_start", "mu_reversal", "v_reversal", "mu_stop", "tendency")
ENOUGH = 300  # records that tell a coefficient
_SLIPS, _MOST_SAMPLES = 24, 200_000
_KEPT = ("spring_force", "acceleration", "drive_velocity")


def draw(random, most=_MOST_SAMPLES):
    """A rig that sticks and slips, whose record has at most so many samples, and the truth of its slips."""

    def over(low, high):
        return float(low * (high / low) ** random.random())

    while True:
        p = {"stiffness": over(1e2, 1e5), "mass": over(0.01, 1.0), "normal_load": over(2.0, 50.0)}
        p["mu_start"] = over(0.1, 1.0)
        drop = p["mu_start"] * random.uniform(0.1, 0.6)
        root = np.sqrt(p["stiffness"] * p["mass"])
        fast = drop * p["normal_load"] / root
        p |= {"belt_speed": fast * over(0.02, 0.3), "a4": fast * over(0.1, 1.0), "mu_reversal": p["mu_start"] - drop}
        p |= {"v_reversal": p["a4"] * random.uniform(3.0, 8.0), "damping": random.uniform(0.0, 0.04) * root}
        p["mu_stop"] = np.nan
        if random.random() < 0.7:
            p["mu_stop"] = p["mu_reversal"] + drop * random.uniform(-0.6, 0.9)
        curve = (p["mu_start"], p["mu_reversal"], p["v_reversal"], p["a4"])
        if not 5e-3 < fast < 2.0 or coefficients(*curve)[0] < 0.0 or p["mu_stop"] < 0.02:
            continue
        if (truth := slip(p)) is None:
            continue
        p["rate"] = over(15.0, 500.0) / truth["lasting"]
        p["bandwidth"] = np.nan if random.random() < 0.3 else p["rate"] * over(0.05, 0.45)
        p["force_noise"] = 0.0 if random.random() < 0.15 else drop * p["normal_load"] * over(1e-4, 3e-2)
        peak = drop * p["normal_load"] / p["mass"]
        p["acceleration_noise"] = 0.0 if random.random() < 0.15 else peak * over(1e-3, 5e-2)
        p["seed"] = int(random.integers(2**31))
        if truth["period"] * _SLIPS * p["rate"] <= most and not p["bandwidth"] * truth["lasting"] < 1.5:
            return p, truth


def slip(p):
    """The coefficients of one slip, and how long it, its cycle and the first loading last; None where there is none."""
    k, m, load, c, u = (p[name] for name in ("stiffness", "mass", "normal_load", "damping", "belt_speed"))
    a4 = p["a4"]
    a1, a2, a3 = map(float, coefficients(p["mu_start"], p["mu_reversal"], p["v_reversal"], a4))

    def curve(w):
        return float(stribeck(w, a1, a2, a3, a4))

    def solved(mu, span, state, end):
        def rates(_, y):
            return [(y[1] + c * (u - y[0]) - mu(y[0]) * load) / m, k * (u - y[0])]

        def ends(t, y):
            return rates(t, y)[0] if end == 1 else float(y[0])

        ends.terminal, ends.direction = True, -1
        return solve_ivp(rates, span, state, events=ends, rtol=1e-8, atol=1e-11)

    natural, first = 2.0 * np.pi * np.sqrt(m / k), p["mu_start"] * load - c * u
    little = 1e-3 * natural
    up = solved(curve, (little, 30.0 * natural), (0.5 * k * u / m * little**2, first + k * u * little), 1)
    if not up.t_events[0].size or up.y[0, -1] < 2.0 * u:
        return None
    (top, force), turn = up.y[:, -1], min(up.y[0, -1], p["v_reversal"])
    plain = np.isnan(p["mu_stop"])
    stop = p["mu_start"] if plain else p["mu_stop"]

    def fall(w):
        return curve(w) if plain or w > turn else stop + (curve(turn) - stop) * w / turn

    down = solved(fall, (up.t[-1], up.t[-1] + 5.0 * natural), (top, force), 0)
    if not down.t_events[0].size or not -p["mu_start"] * load < down.y[1, -1] < 0.97 * first:
        return None
    lasting, stick = down.t[-1], (first - down.y[1, -1]) / (k * u)
    if stick < 0.3 * lasting or (np.diff(down.y[0]) > 0).any():
        return None
    truth = {"mu_start": p["mu_start"], "mu_reversal": curve(top), "v_reversal": float(top), "mu_stop": stop}
    truth["tendency"] = truth["mu_start"] - 2.0 * truth["mu_reversal"] + stop
    visible = up.t[np.argmax(up.y[0] > 0.02 * top)]
    return truth | {"lasting": lasting - visible, "period": lasting + stick, "loading": first / (k * u)}


def record_of(p, truth):
    """The record of a rig as sensors make it, two strokes of a dozen slips each."""
    given = {name: value for name, value in p.items() if not np.isnan(value)}
    system = ("mass", "stiffness", "damping", "normal_load", "belt_speed")
    sensor = ("rate", "bandwidth", "force_noise", "acceleration_noise", "seed")
    friction = ("mu_start", "mu_reversal", "v_reversal", "a4", "mu_stop")
    stroke = p["belt_speed"] * (truth["period"] * _SLIPS / 2 + 2.0 * truth["loading"])
    config = rig.make_rig({
        **{section: {name: given[name] for name in names if name in given}
           for section, names in {"system": system, "sensor": sensor, "friction": friction}.items()},
        "drive": {"stroke": stroke, "strokes": 2, "ramp": 0.3 * truth["loading"]},
    })  # fmt: skip
    return next(rig.RigTests(config).tests([0])).record[[*_KEPT]]


def trial(seed, most=_MOST_SAMPLES):
    """One rig, its record, and what `rig friction` tells of it: samples and periods of the bandwidth in a slip, noise
    over the drop or the largest acceleration, and by number whether its interval holds the truth, and half of that."""
    p, truth = draw(np.random.default_rng(seed), most)
    ds = rig.friction(record_of(p, truth))
    drop = truth["mu_start"] - truth["mu_reversal"]
    band = 0.5 * p["rate"] if np.isnan(p["bandwidth"]) else p["bandwidth"]
    noise = max(p["force_noise"] / p["normal_load"], p["acceleration_noise"] * p["mass"] / p["normal_load"]) / drop
    told = [name for name in NAMES if np.isfinite(ds[name])]
    of_slip = {"samples": p["rate"] * truth["lasting"], "band": band * truth["lasting"]}
    one = of_slip | {"noise": noise, "plain": bool(np.isnan(p["mu_stop"]))} | dict.fromkeys(NAMES, np.nan)
    for name in told:
        low, high = float(ds[f"{name}_low"]), float(ds[f"{name}_high"])
        one[name] = float(low <= truth[name] <= high)
        one[f"half of {name}"] = (high - low) / 2.0 / (truth["v_reversal"] if name == "v_reversal" else drop)
    return one


ROWS = {
    "all": "",
    "slips of less than 30 samples": "samples < 30",
    "less than 4 periods of the bandwidth in a slip": "band < 4",
    "noise above 1 %": "noise >= 0.01",
    "one curve": "plain",
    "hysteresis": "not plain",
}


def told(records, name):
    """Coverage in %, and in brackets how many records tell the number, and half the interval."""
    return covered(records, name, f", ± {100 * records[f'half of {name}'].median():.2g} %")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    records = trials(trial, given.records, given.seed)
    print(*table("records", records, ROWS, {name: partial(told, name=name) for name in NAMES}), sep="\n")
    problems = [*wrong("all", records, NAMES, ENOUGH)]  # of coefficients of all records, held too rarely or too often
    print(*problems, sep="\n")
    raise SystemExit(bool(problems))
