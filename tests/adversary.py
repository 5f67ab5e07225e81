"""A standing adversary of the engine: random cells over decades, solved by `evaluate` and by an independent judge.

    python tests/adversary.py --cells 10000 --seed 7 [--families steep,ageing] [--rtol 1e-6,1e-9]

prints every disagreement as a line to paste, and counts by family. Exit status 1 if there is any.
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd

if __name__ == "__main__":  # as a script, on the sources of this checkout
    root = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(root / folder) for folder in ("tests", "sweep", "kernels")]

from helpers import adversary_cells, adversary_court, adversary_memory
from helpers.adversary_cells import Dispute, take
from stickslip.vocabulary.quantities import STATUSES

COURTS = dict.fromkeys(adversary_cells.FAMILIES, adversary_court)
COURTS |= dict.fromkeys(adversary_memory.FAMILIES, adversary_memory)


def challenge(family, cells, seed, rtols=(1e-6, 1e-9)):
    """Disputes that stand, and counts, of `cells` cells of a family. A cell counts once per rtol and horizon."""
    court, rng = COURTS[family], np.random.default_rng([seed, sum(map(ord, family))])
    disputes, counts = {}, Counter()
    for law, group in court.draw(family, cells, rng).items():
        verdict = court.judged(group, law)
        for rtol in rtols:
            for part, horizon in court.parts(group, verdict):
                own, ruled = take(group, part), take(verdict, part)
                ours = court.run_engine(own, law, rtol, horizon)
                counts["max steps"] = max(counts["max steps"], int(np.nanmax(ours["steps"])))
                for i, outcome in enumerate(court.compare(own, law, rtol, ours, ruled, horizon)):
                    counts["cells"] += 1
                    if isinstance(outcome, str):
                        counts["at the horizon" if outcome in STATUSES and horizon else outcome] += 1
                        continue
                    of_cell = Dispute(family, law, rtol, horizon, take(own, slice(i, i + 1)))
                    words = {what: court.stands(of_cell, what, said) for what, said, *_ in outcome}
                    standing = [one for one in outcome if words[one[0]] == "stands"]
                    counts[standing[0][0] if standing else next(iter(words.values()), "agree")] += 1
                    if standing:  # one cell often fails at every tolerance, and with and without a horizon
                        disputes.setdefault((law, float(own["mass"][i]), standing[0][0]), of_cell.line(*standing[0]))
    return list(disputes.values()), counts


def main(arguments=None):
    """The command line; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=1000, help="in all families together")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--families", default=",".join(COURTS))
    parser.add_argument("--rtol", default="1e-6,1e-9")
    given = parser.parse_args(arguments)
    families, counted, lines = given.families.split(","), {}, []
    rtols = tuple(map(float, given.rtol.split(",")))
    for family in families:
        started, share = time.perf_counter(), -(-given.cells // len(families))
        disputes, counted[family] = challenge(family, share, given.seed, rtols)
        print(*disputes, f"# {family}: {share} cells in {time.perf_counter() - started:.0f} s", sep="\n", flush=True)
        lines += disputes
    print(pd.DataFrame.from_dict(counted, orient="index").fillna(0).astype(int).to_string())
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
