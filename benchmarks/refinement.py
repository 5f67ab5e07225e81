"""Refined maps beside their full grids: cells computed, cells wrong, what the audit says, seconds of both.

    python benchmarks/refinement.py [--size 4096]

Writes the rows into benchmarks/results/results.json, from which `python benchmarks/report.py` makes the table. At
4096 x 4096 the full grids take some minutes; `make bench` takes 1024 x 1024.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from measure import machine
from stickslip import engine

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from helpers.refined_maps import CURVES, compared, map_config  # noqa: E402

RESULTS = Path(__file__).parent / "results" / "results.json"


def measure(size: int) -> list[dict]:
    """A row for the plain and one for the hysteretic map, at the defaults of `refine`."""
    here = machine()
    about = {"size": size, "threads": engine.processors(), "measured": f"{here['date']}, load {here['load_at_start']}"}
    return [{"curve": name, **about, **asdict(compared(map_config(size, mu_stop)))} for name, mu_stop in CURVES.items()]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=4096)
    rows = measure(parser.parse_args().size)
    results = json.loads(RESULTS.read_text())
    RESULTS.write_text(json.dumps({**results, "refinement": rows}, indent=1) + "\n")
    print(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
