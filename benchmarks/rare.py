"""A rare regime three ways: brute force, subset simulation, and the border integrated.

    python benchmarks/rare.py --draws 100_000_000

A pad whose belt speed is normal and damping uniform sticks and slips about twice in a million times. Brute
force draws with NumPy and counts; the border is exact and integrated over the two distributions.
"""

from __future__ import annotations

import argparse
from time import perf_counter

import numpy as np
from scipy import stats

import stickslip
from stickslip.config.reader import parse_config
from stickslip.engine import Options, compute, warm_up
from stickslip.vocabulary.cells import as_cells

PAD = {"mass": 1.0, "stiffness": 1.0, "normal_load": 1.0, "a1": 1.0, "a2": 0.1, "a3": 0.3, "a4": 0.1}
MEAN, STD = 0.4388, 0.02  # belt speed, m/s
LOW, HIGH = 0.2, 0.3  # damping, N s/m
TOGETHER = 1_000_000
TEXT = f"""\
system: {{mass: 1, stiffness: 1, normal_load: 1}}
friction: {{a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}}
uncertain:
  quantities: {{belt_speed: {{normal: {{mean: {MEAN}, std: {STD}}}}}, damping: {{uniform: [{LOW}, {HIGH}]}}}}
  subset: {{samples: 2000, repetitions: 16}}
"""


def integrated() -> float:
    """The probability from the exact border over damping: Gauss-Legendre over that, closed form over the speed."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    lines = PAD | {"damping": LOW + (HIGH - LOW) * (1 + nodes) / 2}
    speeds = stickslip.border(lines, "belt_speed", (0.2, 0.6))["border"].values[:, 0]
    return float(weights @ stats.norm.cdf((speeds - MEAN) / STD) / 2)


def counted(draws: int) -> tuple[int, int]:
    """How many of `draws` stick and slip, and how many are undecided."""
    rng, met, unknown, done = np.random.default_rng(20), 0, 0, 0
    while done < draws:
        size = min(TOGETHER, draws - done)
        cells = as_cells(PAD | {"belt_speed": rng.normal(MEAN, STD, size), "damping": rng.uniform(LOW, HIGH, size)})

        def part(start: int, stop: int, cells: dict = cells) -> dict:
            return {name: values[start:stop] for name, values in cells.items()}

        regimes = np.bincount(compute(part, size, Options()).results["regime"], minlength=8)
        met, unknown, done = met + int(regimes[1]), unknown + int(regimes[0] + regimes[6:].sum()), done + size
        print(f"\r{done:,} of {draws:,} draws: {met} stick and slip", end="", flush=True)
    print()
    return met, unknown


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=1_000_000)
    draws = parser.parse_args().draws
    warm_up()
    began = perf_counter()
    found = stickslip.run(parse_config(TEXT))
    p, error = (float(found[name].sel(state="stick_slip")) for name in ("probability", "probability_error"))
    print(
        f"subset      {p:.3e} +- {error:.1e} from {int(found['evaluations']):,} cells in {perf_counter() - began:.1f} s"
    )
    print(f"integrated  {integrated():.4e}")
    began = perf_counter()
    met, unknown = counted(draws)
    brute = f"{met / draws:.3e} +- {np.sqrt(met) / draws:.1e}"
    print(f"brute force {brute} from {draws:,} cells in {perf_counter() - began:.0f} s ({unknown} undecided)")


if __name__ == "__main__":
    main()
