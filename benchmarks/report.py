"""The results as a Markdown table and as a plot. Every number comes from `results.json`.

python benchmarks/report.py [--docs]      # once more, without measuring; with --docs into docs/speed.md
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from tables import (
    BASELINE,
    BATCH,
    OURS,
    duration,
    find,
    laws_table,
    maps_table,
    markdown,
    memory_table,
    number,
    p1_table,
    p2_table,
    p3_table,
    p4_table,
    refinement_table,
    steps_table,
    targets,
    threads_table,
    whole_table,
)

RESULTS = Path(__file__).parent / "results"
DOCS = Path(__file__).parents[1] / "docs" / "speed.md"
BEGIN, END = "<!-- begin: written by benchmarks/report.py --docs -->", "<!-- end -->"


def headline(results: dict[str, Any]) -> dict[str, str]:
    """The column of a run in the table by processor."""
    column = {"kernels for": results["machine"]["kernels"], "measured": results["machine"]["date"][:10]}
    for rtol in (1e-6, 1e-9):
        ours, base, peer = find(results, OURS, rtol), find(results, BASELINE, rtol), find(results, BATCH, rtol)
        column[f"P1 at {rtol:g} over the scalar baseline"] = number(ours["rate"] / base["rate"]) if base else ""
        column[f"P1 at {rtol:g} over heyoka, batch"] = number(ours["rate"] / peer["rate"]) if peer else ""
    for row in results["steps"]:
        column[f"ns per event, {row['rtol']:g}"] = number(row["ns_per_event"])
    for row in results["p2"]:
        column[f"P2, {row['curve']} curve, µs of CPU time a cell"] = number(row["cpu_seconds"] / row["cells"] * 1e6)
    for row in results["maps"][1:]:
        column[f"{row['map']}, over P2"] = number(row["over_p2"])
        column[f"{row['map']}, regime alone, over P2"] = number(row["regime_over_p2"])
    column["first compilation of a law"] = duration(results["startup"]["compile"])
    return column | {row["what"]: duration(row["seconds"]) for row in results["whole"]["rows"]}


def processors_table(columns: dict[str, dict[str, str]]) -> str:
    """The last run on each kind of processor, side by side; ratios hold within a column."""
    names = dict.fromkeys(name for column in columns.values() for name in column)
    rows = [[name, *(column.get(name, "") for column in columns.values())] for name in names]
    return markdown(["", *columns], rows)


def remember(results: dict[str, Any], folder: Path) -> dict[str, dict[str, str]]:
    """Put the headline of a run into its processor's column, in a file beside the results; all columns."""
    path, machine = folder / "processors.json", results["machine"]
    columns = json.loads(path.read_text()) if path.exists() else {}
    wide = "avx512f" in machine["vector_instructions"] and "v3" not in machine["kernels"]
    kind = "AVX-512" if wide else "AVX2" if "avx2" in machine["vector_instructions"] else "other"
    columns[f"{kind}: {machine['processor']}"] = headline(results)
    path.write_text(json.dumps(columns, indent=1, ensure_ascii=False) + "\n")
    return columns


def table(results: dict[str, Any], columns: dict[str, dict[str, str]]) -> str:
    machine, startup = results["machine"], results["startup"]
    cost = markdown(
        ["cells", "µs per cell", "peak memory of a run into a file, MB", "bytes per cell"],
        [
            [
                f"{row['cells']:,}",
                number(row["us_per_cell"]),
                number(row["memory"]["peak_bytes"] / 1e6) if "memory" in row else "",
                number(row["memory"]["bytes_per_cell"]) if "memory" in row else "",
            ]
            for row in results["cost"]
        ],
    )
    operations = results["steps"][0]["operations"]
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    missing = "".join(f"- {row['peer']}: {row['reason']}\n" for row in results["missing"]) or "- none\n"
    rate = results["steps"][0]["fma_per_second"]
    return f"""# Speed, one run

{machine["date"]}; {machine["processor"]} ({", ".join(machine["vector_instructions"])}), {machine["cores"]} cores,
load {machine["load_at_start"]} before the run; Python {machine["python"]}, {packages}.
The run took {results["bench_seconds"]:.0f} s. Written by `make bench`; ratios hold within this run only.

## By processor

`make bench` writes the column of its machine. AVX2 on a machine that has more:
`NUMBA_CPU_NAME=x86-64-v3 NUMBA_CPU_FEATURES= make bench`.

{processors_table(columns)}
## What a user waits for

Whole commands with file and plot, kernels compiled before. Asked of maps: twice the CPU time of their kernels on one
thread; of nine cells: CPU time 0.6 times that of a million.

{whole_table(results)}
## Against the targets

{targets(results)}
## P1, fixed horizon, one thread

Trajectories per CPU second of one thread, median and half the range of the repetitions. Errors are medians over cells,
relative, against our answer at rtol 1e-10, which SciPy's DOP853 at 1e-12 meets to {results["reference_error"]:.1e}.

{p1_table(results)}
Not run:

{missing}
## P1 on several threads (wall clock)

{threads_table(results)}
## A step and its floor, one thread

The floor is {operations["all"]} operations per trial step over {rate / 1e9:.1f}e9 packed FMA/s, measured in this run:
{", ".join(f"{name} {count}" for name, count in operations.items() if name != "all")}.

{steps_table(results)}
## P2, regime maps at rtol 1e-6

{p2_table(results)}
Plain maps of 10,000 cells by friction law, one thread (a4 = 0.5 m/s for `cubic`, 0.1 m/s for the others):

{laws_table(results["laws"])}
### Maps that people compute, one thread

`python benchmarks/maps.py`: CPU time a cell. *quickstart* is configs/quickstart.yaml; the others have P2's stiffnesses
and belt speeds from 0.05 to 1.2 m/s, the ringing one from 0.45 m/s on, where nearly all settle.

{maps_table(results["maps"])}
### Contacts with memory, one thread

`python benchmarks/memory.py`: maps of 48 x 48 cells over 1e-7 to 0.1 m/s, stiffnesses as in configs/rate_state.yaml, or
from 0.03 to 30 times the critical one at each speed; configs/lugre.yaml. Asked of rate-and-state friction: 100 µs a
cell.

{memory_table(results.get("memory", []))}
## P3, test rigs at rtol 1e-6

Two strokes of 5 mm at 1 to 30 mm/s, with different springs and friction curves, the motion sampled 8,000 times a
second.

{p3_table(results["p3"])}
## P4, borders to 1e-9

{p4_table(results.get("p4"))}
## Cost of many cells (plain map, all threads)

{cost}
## Refined maps at the defaults of `refine`, all threads

`python benchmarks/refinement.py --size {results["refinement"][0]["size"]}`; the full grid is computed once, to compare.
Measured {results["refinement"][0]["measured"]} before it, on {results["refinement"][0]["threads"]} threads.

{refinement_table(results["refinement"])}
## Start-up

Quickstart, kernels compiled before: {startup["first_block"]["seconds"]:.2f} s from the shell to the first block. First
compilation: {startup["compile"]:.1f} s; loading from the cache {startup["load_from_cache"]:.2f} s; imports \
{startup["import"]:.2f} s.
"""


def plot(results: dict[str, Any], path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    names = list(dict.fromkeys(row["peer"] for row in results["work_precision"]))
    for name, marker in zip(names, "osD^vPX*", strict=False):
        rows = [row for row in results["work_precision"] if row["peer"] == name]
        ours = name == OURS
        axes.loglog(
            [row["error"] for row in rows],
            [row["rate"] for row in rows],
            marker=marker,
            markersize=4,
            linewidth=2 if ours else 1,
            color="black" if ours else None,
            label=name,
        )
    for row in results["p1"]:
        if row["threads"] == 1 and row["peer"] not in names and row["errors"]["time"] == row["errors"]["time"]:
            axes.plot(row["errors"]["time"], row["rate"], ".", color="0.5")
            label = row["peer"].split(",")[0].replace(" RHS", "")
            axes.annotate(label, (row["errors"]["time"], row["rate"]), fontsize=6, color="0.35")
    axes.invert_xaxis()
    axes.set_xlabel("median relative error of the first re-stick time")
    axes.set_ylabel("trajectories per second, one thread")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7)
    figure.savefig(path, dpi=130)


def into_docs(text: str) -> None:
    """Replace what stands between the marks in docs/speed.md by the first tables, their headings one level down."""
    page = DOCS.read_text()
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    body = text.split("\n", 2)[2].partition("\n## P1, fixed horizon")[0].replace("\n## ", "\n### ")
    DOCS.write_text(f"{before}{BEGIN}\n{body}\n{END}{after}")


if __name__ == "__main__":
    # The table and the plot again, from results.json; with --docs into docs/speed.md as well.
    results = json.loads((RESULTS / "results.json").read_text())
    text = table(results, remember(results, RESULTS))
    (RESULTS / "table.md").write_text(text)
    plot(results, RESULTS / "plot.png")
    if "--docs" in sys.argv[1:]:
        into_docs(text)
    print(text)
