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

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from stickslip.theory import reversal_speed, stick_slip_limit, stribeck
from stickslip.theory.curve import SHAPES
from stickslip_materials.fit import draw_curves, fit_curve

COUNTS, SPEEDS = (5, 6, 8, 10, 14, 20, 30, 60), ("log", "linear", "clusters")
NOISES = ("equal", "proportional", "uneven", "sigma given")
KINDS = ("falling", "falling", "falling", "rising", "flat", "outlier", "other law")
NAMES = ("a1", "a2", "a3", "a4", "mu_start")
LEAST, MOST, ENOUGH = 0.92, 0.98, 200  # coverage of 95 % intervals that is right, in rows of so many fits


@dataclass
class Trial:
    """One fit. held : by coefficient and `border`, whether a printed interval holds the truth."""

    count: int
    speeds: str
    noise: str
    kind: str
    good: bool
    determined: bool
    extrapolated: bool
    bias: float
    left_out: bool = False
    shape: bool = False
    held: dict[str, bool] = field(default_factory=dict)


def speeds_of(random: np.random.Generator, how: str, count: int) -> np.ndarray:
    fastest = 10 ** random.uniform(-1.3, 0.3)
    slowest = fastest * 10 ** -random.uniform(1.5, 3)
    if how == "linear":
        return np.linspace(fastest / count, fastest, count)
    if how == "log":
        return np.geomspace(slowest, fastest, count)
    centres = np.geomspace(slowest, fastest, max(4, min(6, count // 3)))
    return np.sort(centres[np.arange(count) % centres.size] * random.uniform(0.9, 1.1, count))


def trial(seed: tuple[int, int]) -> Trial:
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
    one = Trial(int(count), str(how), str(noise), str(kind), fit.good, fit.determined,
                fit.mu_start > 2 * y.max(), fit.mu_start / truth["mu_start"] - 1, bool(fit.outliers),
                "another shape" in fit.quality)  # fmt: skip
    for name in NAMES:
        low, high = fit.interval[name]
        if not (low <= 0 and np.isinf(high)) and not (name == "a4" and drop == 0):
            one.held[name] = low * (1 - 1e-9) <= truth[name] <= high * (1 + 1e-9)
    has_border = fit.determined and fit.has_intervals and drop > 0 and law == "stribeck"
    if has_border and (drawn := draw_curves(fit, 1000, falling=True)):
        one.held["border"] = _holds_border(drawn.coefficients, rise, drop, a4)
    return one


def _holds_border(drawn: dict[str, np.ndarray], rise: float, drop: float, a4: float) -> bool:
    truth = float(np.nan_to_num(stick_slip_limit(rise, drop, a4, 0.0, 1.0)))
    ends = np.nan_to_num(stick_slip_limit(np.maximum(drawn["a2"], 1e-300), drawn["a3"], drawn["a4"], 0.0, 1.0))
    ends = np.sort(np.where(drawn["a2"] > 0, ends, np.inf))
    return bool(ends[25] * (1 - 1e-6) <= truth <= ends[-26] * (1 + 1e-6))


ROWS: dict[str, Callable[[Trial], bool]] = {
    "all": lambda one: True,
    "called good": lambda one: one.good,
    "determined, not good": lambda one: one.determined and not one.good,
    "not determined": lambda one: not one.determined,
    "an outlier left out": lambda one: one.left_out,
    "said to have another shape": lambda one: one.shape,
    **{f"{n} points": lambda one, n=n: one.count == n for n in COUNTS},
    **{f"{how} speeds": lambda one, how=how: one.speeds == how for how in SPEEDS},
    **{f"scatter {noise}": lambda one, noise=noise: one.noise == noise for noise in NOISES},
    **{f"{kind}": lambda one, kind=kind: one.kind == kind for kind in dict.fromkeys(KINDS)},
}  # fmt: skip


def table(trials: list[Trial]) -> Iterator[str]:
    """The rows of the table, in Markdown: coverage in %, (in brackets) the share of fits whose interval is printed."""
    names = (*NAMES, "border")
    yield f"| fits | number | good | {' | '.join(names)} | mu_start off by, median |"
    yield f"| --- | --- | --- |{' --- |' * (len(names) + 1)}"
    for title, belongs in ROWS.items():
        some = [one for one in trials if belongs(one)]
        cells = []
        for name in names:
            printed = [one.held[name] for one in some if name in one.held]
            cells.append(f"{100 * np.mean(printed):.1f} ({100 * len(printed) / len(some):.0f} %)" if printed else "")
        good = f"{100 * np.mean([one.good for one in some]):.0f} %" if some else ""
        bias = f"{100 * np.median([one.bias for one in some]):+.1f} %" if some else ""
        yield f"| {title} | {len(some)} | {good} | {' | '.join(cells)} | {bias} |"


def wrong(trials: list[Trial]) -> Iterator[str]:
    """Rows whose intervals hold the truth too seldom or too often, and fits that invent friction."""
    for title, names in (("all", NAMES), ("called good", (*NAMES, "border"))):
        some = [one for one in trials if ROWS[title](one)]
        for name in names:
            printed = [one.held[name] for one in some if name in one.held]
            if len(printed) >= ENOUGH and not LEAST <= np.mean(printed) <= MOST:
                yield f"{title}: {name} is held in {100 * np.mean(printed):.1f} % of {len(printed)}"
    if invented := sum(one.extrapolated and one.determined for one in trials):
        yield f"{invented} fits called determined have a mu_start of more than twice what was measured"


@dataclass
class Sweep:
    """One sweep up and down. shown : a mu_stop was fitted. held : its interval holds the truth. otherwise : another
    difference of the branches was seen."""

    differs: bool
    shown: bool
    held: bool
    otherwise: bool


def sweep(seed: tuple[int, int]) -> Sweep:
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
    return Sweep(differs, high > 0, low <= stop <= high, "while the speed falls, " in fit.quality)


def of_sweeps(sweeps: list[Sweep]) -> tuple[str, bool]:
    """A line on sweeps, and whether it is as it should be."""
    differ, agree = ([one for one in sweeps if one.differs is differs] for differs in (True, False))
    shown = [one.held for one in differ if one.shown]
    held, invented = float(np.mean(shown)), float(np.mean([one.shown for one in agree]))
    otherwise = float(np.mean([one.otherwise for one in sweeps]))
    text = (
        f"{len(sweeps)} sweeps: mu_stop in {100 * len(shown) / len(differ):.1f} % of those that have one, held in "
        f"{100 * held:.1f} %; in {100 * invented:.2f} % of the others; another difference in {100 * otherwise:.2f} %"
    )
    return text, LEAST <= held <= MOST and invented <= 0.015 and otherwise <= 0.02


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fits", type=int, default=5000)
    parser.add_argument("--sweeps", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with ProcessPoolExecutor() as pool:
        results = [*pool.map(trial, [(options.seed, i) for i in range(options.fits)], chunksize=10)]
        sweeps = [*pool.map(sweep, [(options.seed, i) for i in range(options.sweeps)], chunksize=10)]
    problems: list[str] = []
    if results:
        print("\n".join(table(results)))
        problems += wrong(results)
    if sweeps:
        line, is_right = of_sweeps(sweeps)
        print(line)
        problems += [] if is_right else [line]
    print("\n".join(problems), file=sys.stderr)
    sys.exit(bool(problems))
