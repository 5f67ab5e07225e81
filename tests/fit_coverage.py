"""How often the intervals of `fit` hold the truth: fits of made-up points over decades (docs/materials.md).

    python tests/fit_coverage.py --fits 5000 --seed 1

A true curve is drawn, points of it are measured, the fit is asked what it knows. Speeds go over 1.5 to 3 decades up to
0.05 to 2 m/s; the speed scale lies between three times the slowest point (linear speeds: 0.6 times) and a quarter of
the fastest; friction falls by a fifth to all of a1 and rises by 5 to 60 % of it; points scatter by 0.3 to 4 % of the
mean friction. Uneven: by up to a factor of 3.3 along the speed, and at random besides. An interval is printed unless
both of its ends are open. The border is the closed form of the end of stick-slip without a damper, its interval that of
1,000 draws, as in `compare`.

Sweeps (--sweeps) go up and down one to three times, with 6 to 40 points a branch and 1 to 5 % of noise; on the way down
half of them follow the line of Eq. (2a) to a mu_stop, 0.4 to 1.5 of the fall below friction at break-away.
"""

import argparse
import sys
from functools import partial

import numpy as np

from helpers.coverage import LEAST, MOST, covered, table, trials, wrong
from stickslip.theory import reversal_speed, stick_slip_limit, stribeck
from stickslip.theory.curve import SHAPES
from stickslip_materials.fit import draw_curves, fit_curve

COUNTS, SPEEDS = (5, 6, 8, 10, 14, 20, 30, 60), ("log", "linear", "clusters")
NOISES = ("equal", "proportional", "uneven", "sigma given")
KINDS = ("falling", "falling", "falling", "rising", "flat", "outlier", "other law")
NAMES = ("a1", "a2", "a3", "a4", "mu_start")
ENOUGH = 200  # fits of which an interval is printed


def speeds_of(random, how, count):
    fastest = 10 ** random.uniform(-1.3, 0.3)
    slowest = fastest * 10 ** -random.uniform(1.5, 3)
    if how == "linear":
        return np.linspace(fastest / count, fastest, count)
    if how == "log":
        return np.geomspace(slowest, fastest, count)
    centres = np.geomspace(slowest, fastest, max(4, min(6, count // 3)))
    return np.sort(centres[np.arange(count) % centres.size] * random.uniform(0.9, 1.1, count))


def trial(seed):
    """One fit: what it says of itself, and whether printed intervals of coefficients and the border hold the truth."""
    random = np.random.default_rng(seed)
    count, how, noise, kind = (random.choice(np.array(of)) for of in (COUNTS, SPEEDS, NOISES, KINDS))
    w = speeds_of(random, str(how), int(count))
    a1 = random.uniform(0.05, 0.6)
    rise = 0.0 if kind == "flat" else random.uniform(0.05, 0.6) * a1 / w[-1]
    drop = 0.0 if kind in ("flat", "rising") else random.uniform(0.2, 1.2) * a1
    a4 = 10 ** random.uniform(np.log10((0.6 if how == "linear" else 3.0) * w[0]), np.log10(w[-1] / 4))
    law = str(random.choice([*SHAPES][1:])) if kind == "other law" else "stribeck"
    mu = a1 + rise * w + drop * SHAPES[law](w / a4)
    level = 10 ** random.uniform(-2.5, -1.4)
    sigma = level * (mu if noise == "proportional" else np.full(w.size, mu.mean()))
    if noise == "uneven":
        place = np.log(w) - np.log(w).mean()
        sigma = sigma * np.exp(random.uniform(-1.2, 1.2) * place / np.ptp(place) + random.normal(0, 0.3, w.size))
    y = np.maximum(mu + sigma * random.standard_normal(w.size), 1e-4)
    if kind == "outlier":
        y[random.integers(w.size)] += random.choice([-1, 1]) * random.uniform(0.3, 1.0) * np.ptp(mu)
        y = np.maximum(y, 1e-4)
    fit = fit_curve(w, y, sigma if noise == "sigma given" else None, law=law)
    truth = {"a1": a1, "a2": rise, "a3": drop, "a4": a4, "mu_start": a1 + drop}
    bias, extrapolated = fit.mu_start / truth["mu_start"] - 1, fit.mu_start > 2 * y.max()
    one = {
        "kind": str(kind),
        "good": fit.good,
        "determined": fit.determined,
        "extrapolated": extrapolated,
        "bias": bias,
    }
    one |= dict.fromkeys((*NAMES, "border"), np.nan)
    for name in NAMES:
        low, high = fit.interval[name]
        if not (low <= 0 and np.isinf(high)) and not (name == "a4" and drop == 0):
            one[name] = float(low * (1 - 1e-9) <= truth[name] <= high * (1 + 1e-9))
    has_border = fit.determined and fit.has_intervals and drop > 0 and law == "stribeck"
    if has_border and (drawn := draw_curves(fit, 1000, falling=True)):
        one["border"] = holds_border(drawn.coefficients, rise, drop, a4)
    return one


def holds_border(drawn, rise, drop, a4):
    truth = float(np.nan_to_num(stick_slip_limit(rise, drop, a4, 0.0, 1.0)))
    ends = np.nan_to_num(stick_slip_limit(np.maximum(drawn["a2"], 1e-300), drawn["a3"], drawn["a4"], 0.0, 1.0))
    ends = np.sort(np.where(drawn["a2"] > 0, ends, np.inf))
    return float(ends[25] * (1 - 1e-6) <= truth <= ends[-26] * (1 + 1e-6))


ROWS = {
    "all": "",
    "called good": "good",
    "determined, not good": "determined and not good",
    "not determined": "not determined",
    **{kind: f"kind == '{kind}'" for kind in dict.fromkeys(KINDS)},
}
COLUMNS = {
    "good": lambda fits: f"{100 * fits['good'].mean():.0f} %",
    **{name: partial(covered, name=name) for name in (*NAMES, "border")},
    "mu_start off by, median": lambda fits: f"{100 * fits['bias'].median():+.1f} %",
}


def sweep(seed):
    """One sweep up and down: whether its branches differ, a mu_stop was fitted, its interval holds the truth."""
    random = np.random.default_rng(seed)
    count, noise, loops = random.choice([6, 8, 12, 20, 40]), random.uniform(0.01, 0.05), random.choice([1, 1, 2, 3])
    up, a1 = np.geomspace(0.01, 1.0, count), random.uniform(0.05, 0.6)
    drop, rise = random.uniform(0.3, 1.2) * a1, random.uniform(0.1, 0.6) * a1
    a4 = 10 ** random.uniform(np.log10(0.03), np.log10(1 / 6))
    speed = np.tile(np.r_[up, up[::-1]], loops)
    mu = stribeck(speed, a1, rise, drop, a4)
    least = min(float(reversal_speed(rise, drop, a4)), 1.0)
    stop, differs = a1 + drop * (1 - random.uniform(0.4, 1.5)), bool(random.random() < 0.5)
    if differs:
        line = stop + (stribeck(least, a1, rise, drop, a4) - stop) * speed / least
        falls = np.tile(np.r_[np.zeros(count, bool), np.ones(count, bool)], loops)
        mu = np.where(falls & (speed < least), line, mu)
    fit = fit_curve(speed, mu * (1 + noise * random.standard_normal(speed.size)))
    low, high = fit.interval.get("mu_stop", (0.0, 0.0))
    otherwise = "while the speed falls, " in fit.quality
    return {"differs": differs, "shown": high > 0, "held": low <= stop <= high, "otherwise": otherwise}


def of_sweeps(sweeps):
    """A line on sweeps, and whether it is as it should be."""
    differ, otherwise = sweeps[sweeps["differs"]], sweeps["otherwise"].mean()
    invented, held = sweeps.loc[~sweeps["differs"], "shown"].mean(), differ.loc[differ["shown"], "held"].mean()
    text = (
        f"{len(sweeps)} sweeps: mu_stop in {100 * differ['shown'].mean():.1f} % of those that have one, held in "
        f"{100 * held:.1f} %; in {100 * invented:.2f} % of the others; another difference in {100 * otherwise:.2f} %"
    )
    return text, LEAST <= held <= MOST and invented <= 0.015 and otherwise <= 0.02


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fits", type=int, default=5000)
    parser.add_argument("--sweeps", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    fits, sweeps = trials(trial, options.fits, options.seed), trials(sweep, options.sweeps, options.seed)
    print(*table("fits", fits, ROWS, COLUMNS), sep="\n")
    problems = [
        *wrong("all", fits, NAMES, ENOUGH),
        *wrong("called good", fits[fits["good"]], (*NAMES, "border"), ENOUGH),
    ]
    if invented := sum(fits["extrapolated"] & fits["determined"]):
        problems.append(f"{invented} fits called determined have a mu_start of more than twice what was measured")
    line, is_right = of_sweeps(sweeps)
    print(line)
    problems += [] if is_right else [line]
    print("\n".join(problems), file=sys.stderr)
    sys.exit(bool(problems))
