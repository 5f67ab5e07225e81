"""A standing adversary of the engine: random cells over decades, solved by `evaluate` and by an independent judge.

    python tests/adversary.py --cells 10000 --seed 7 [--families steep,ageing] [--rtol 1e-6,1e-9] [--out FILE]

prints every disagreement as a line to paste, and counts by family. Exit status 1 if there is any.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

if __name__ == "__main__":  # as a script, on the sources of this checkout
    root = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(root / folder) for folder in ("tests", "sweep", "kernels")]

from helpers import adversary_memory
from helpers.adversary_cells import FAMILIES, draw
from helpers.adversary_court import MOST_JUDGED, Dispute, columns, compare, horizon_of, minimised, run_engine, stands
from judge import INPUTS, judge
from stickslip.vocabulary.flags import STATUSES

COUNTED = ("cells", "agree", "undecided", "sensitive", "regime", "damped/creep", "late sticks", "wrong number")
AT_HORIZON = "at the horizon"  # whatever the status
HORIZON_RATIO = 3.0  # cells whose horizons differ by less run together


ALL_FAMILIES = (*FAMILIES, *adversary_memory.FAMILIES)


def challenge(family, cells, seed, rtols=(1e-6, 1e-9), shortest=10, threads=1, early_stops=(True, False)):
    """Disputes and counts of `cells` cells of a family.

    shortest : how many disputes are minimised. A cell counts once per rtol and way of stopping.
    """
    if family in adversary_memory.FAMILIES:
        return adversary_memory.challenge(family, cells, seed, rtols, threads)
    rng = np.random.default_rng([seed, sum(map(ord, family))])
    laws, arrays = draw(family, cells, rng)
    disputes, counts = [], Counter()
    for law in dict.fromkeys(laws):
        chosen = np.flatnonzero(laws == law)
        group = [{name: float(arrays[name][i]) for name in INPUTS} for i in chosen]
        verdict = judge(columns(group), law, most_steps=MOST_JUDGED)
        for rtol in rtols:
            for early_stop in early_stops:
                disputes += try_group(family, law, rtol, early_stop, group, verdict, counts, threads)
    told = {}
    for dispute in disputes:  # one cell often fails at every tolerance, and with and without early stop
        told.setdefault((id(dispute.cell), dispute.what), dispute)
    disputes = list(told.values())
    for dispute in disputes[:shortest]:
        minimised(dispute)
    return disputes, counts


def try_group(family, law, rtol, early_stop, group, verdict, counts, threads):
    """Disputes that stand, of cells of one law; `counts` is added to."""
    disputes = []
    for part, horizon in parts(group, law, verdict, early_stop):
        cells, ruled = [group[i] for i in part], {n: v[part] for n, v in verdict.items()}
        ours = run_engine(cells, law, rtol, horizon, threads)
        counts["max steps"] = max(counts["max steps"], int(np.nanmax(ours["steps"])))
        for cell, found in zip(cells, compare(cells, law, rtol, ours, ruled, horizon), strict=True):
            counts["cells"] += 1
            counts["to a horizon"] += not early_stop
            if isinstance(found, str):
                counts[AT_HORIZON if found in STATUSES and not early_stop else found] += 1
                continue
            kept = []
            for what, said, judged, error in found:
                dispute = Dispute(family, law, rtol, early_stop, what, said, judged, cell, error)
                kept.append((stands(dispute), dispute))
            standing = [d for word, d in kept if word == "stands"]
            if standing:
                what = standing[0].what
                counts[what if what in COUNTED else "wrong number"] += 1
                disputes.append(standing[0])
            else:
                counts[kept[0][0] if kept else "agree"] += 1
    return disputes


def parts(group, law, verdict, early_stop):
    """(indices, horizon): all with none, or cells of like horizon together."""
    if early_stop:
        return [(np.arange(len(group)), None)]
    each = np.array([horizon_of([c], law, {n: v[i : i + 1] for n, v in verdict.items()}) for i, c in enumerate(group)])
    bins = np.floor(np.log(each) / np.log(HORIZON_RATIO))
    return [(np.flatnonzero(bins == b), float(each[bins == b].max())) for b in np.unique(bins)]


def table(counted):
    """Counts by family, as text, and the share of cells the engine left unresolved: without a horizon by status."""
    names = (*COUNTED, "max steps")
    unresolved = [s for s in (*STATUSES, AT_HORIZON) if any(c[s] for c in counted.values())]
    lines = [["family", *names, *unresolved]]
    for family, c in counted.items():
        lines.append([family, *(str(c[n]) for n in names), *(share(c, s) for s in unresolved)])
    widths = [max(len(n) + 2, 9) for n in lines[0][1:]]
    return "\n".join(
        f"{first:14}" + "".join(f"{text:>{w}}" for text, w in zip(rest, widths, strict=True)) for first, *rest in lines
    )


def share(counts, unresolved):
    """Of the cells that were run the same way, in per cent."""
    of = counts["to a horizon"] if unresolved == AT_HORIZON else counts["cells"] - counts["to a horizon"]
    return f"{100 * counts[unresolved] / of:.1f} %" if of else "-"


def main(arguments=None):
    """The command line; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, default=1000, help="in all families together")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--families", default=",".join(ALL_FAMILIES))
    parser.add_argument("--rtol", default="1e-6,1e-9")
    parser.add_argument("--minimise", type=int, default=10, help="disputes of a family to minimise")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--out", help="write the disputes to this file as well")
    given = parser.parse_args(arguments)
    families = given.families.split(",")
    rtols = tuple(float(r) for r in given.rtol.split(","))
    counted, lines = {}, []
    for family in families:
        started = time.perf_counter()
        share = -(-given.cells // len(families))
        disputes, counted[family] = challenge(family, share, given.seed, rtols, given.minimise, given.threads)
        found = [d.line() for d in disputes]
        print(*found, sep="\n", end="\n" if found else "")
        print(f"# {family}: {share} cells in {time.perf_counter() - started:.0f} s", flush=True)
        lines += found
    summary = table(counted)
    print(summary)
    if given.out:
        Path(given.out).write_text("\n".join([*lines, "", summary, ""]))
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
