"""The results as a Markdown table and as a plot. Every number comes from `results.json`.

python benchmarks/report.py [--docs]      # once more, without measuring; with --docs into docs/speed.md
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

OURS = "stickslip (ours)"
BASELINE = "Numba scalar"
BATCH = "heyoka, batch"
RESULTS = Path(__file__).parent / "results"
DOCS = Path(__file__).parents[1] / "docs" / "speed.md"
BEGIN, END = "<!-- begin: written by benchmarks/report.py --docs -->", "<!-- end -->"


def number(value: float | None) -> str:
    if value is None or value != value:
        return ""
    if value >= 1000:
        return f"{value:,.0f}"
    return f"{value:.3g}"


def markdown(header: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|" + " --- |" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def find(results: dict[str, Any], name: str, rtol: float, threads: int = 1) -> dict[str, Any] | None:
    for row in results["p1"]:
        if row["peer"].startswith(name) and row["rtol"] == rtol and row["threads"] == threads:
            return row
    return None


def best(row: dict[str, Any]) -> float:
    """Rate of the fastest repetition: what a neighbour on the same processor did not slow down."""
    return row["cells"] / min(row["timings"]["cpu"])


def fastest_peer(results: dict[str, Any], rtol: float) -> dict[str, Any] | None:
    """The fastest of any kind on one thread."""
    others = [row for row in results["p1"] if row["rtol"] == rtol and row["threads"] == 1 and row["peer"] != OURS]
    return max(others, key=lambda row: row["rate"], default=None)


def at_equal_error(results: dict[str, Any], name: str, error: float) -> float | None:
    """Rate of a peer where its error is `error`, on the straight line through its work-precision points (logs)."""
    import numpy as np

    rows = [row for row in results["work_precision"] if row["peer"].startswith(name) and row["error"] > 0.0]
    points = sorted((row["error"], row["rate"]) for row in rows)
    if len(points) < 2 or not points[0][0] <= error <= points[-1][0]:
        return None
    logs = np.log(np.array(points))
    return float(np.exp(np.interp(np.log(error), logs[:, 0], logs[:, 1])))


def p1_table(results: dict[str, Any]) -> str:
    rows = []
    for row in results["p1"]:
        if row["threads"] != 1:
            continue
        base = find(results, BASELINE, row["rtol"])
        ours = find(results, OURS, row["rtol"])
        errors = row["errors"]
        rows.append(
            [
                row["peer"],
                row["events"],
                f"{row['rtol']:g}",
                f"{row['cells']:,}",
                f"{number(row['rate'])} ±{100 * row['spread']:.0f} %",
                number(row["rate"] / base["rate"]) if base else "",
                number(ours["rate"] / row["rate"]) if ours else "",
                f"{errors['time']:.1e}",
                f"{errors['x']:.1e}",
                str(errors["missed"]),
            ]
        )
    header = ["peer", "events", "rtol", "cells", "trajectories/s", "x baseline", "ours over it"]
    return markdown(header + ["error: re-stick time", "re-stick x", "missed"], rows)


def threads_table(results: dict[str, Any]) -> str:
    """Wall-clock rates here, so that one and several threads are measured alike."""
    rows = []
    for row in results["p1"]:
        if row["threads"] == 1:
            continue
        one = find(results, row["peer"], row["rtol"])
        ratio = sorted(
            a / b for a, b in zip(one["timings"]["wall"], row["timings"]["wall"], strict=True)
        )  # repetition by repetition: neighbours in time
        middle = ratio[len(ratio) // 2]
        rows.append([row["peer"], f"{row['rtol']:g}", str(row["threads"]), number(row["rate"]), f"{middle:.2f}"])
    return markdown(["peer", "rtol", "threads", "trajectories/s", "over one thread"], rows)


def steps_table(results: dict[str, Any]) -> str:
    rows = []
    for row in results["steps"]:
        rows.append(
            [
                f"{row['rtol']:g}",
                number(row["ns_all_over_steps"]),
                number(row["ns_per_trial_step"]),
                number(row["ns_per_accepted_step"]),
                number(row["floor_ns_per_trial_step"]),
                number(row["ratio_to_floor"]),
                number(row["ns_per_event"]),
                f"{100 * row['share_of_events']:.0f} %",
                number(row["steps_per_cell"]),
                number(row["events_per_cell"]),
            ]
        )
    header = [
        "rtol",
        "ns, all of P1 over its trial steps",
        "ns per trial step",
        "ns per accepted step",
        "floor, ns per trial step",
    ]
    header += ["step over floor", "ns per event", "time in events", "steps per cell", "events per cell"]
    return markdown(header, rows)


def p2_table(results: dict[str, Any]) -> str:
    rows = []
    for row in results["p2"]:
        rows.append(
            [
                row["curve"],
                f"{row['cells']:,}",
                f"{row['seconds']:.2f} ±{100 * row['spread']:.0f} %",
                number(row["cpu_seconds"]),
                number(row["steps_per_cell"]),
                f"{1e3 * row['scipy_seconds_per_cell']:.1f} ms",
                f"{100 * row['scipy_same_regime']:.0f} %",
                number(row["ratio_one_core_over_scipy"]),
                number(row["ratio_all_threads_over_scipy"]),
            ]
        )
    threads = results["p2"][0]["threads"] if results["p2"] else 0
    header = ["curve", "cells", f"seconds, {threads} threads", "CPU seconds", "steps per cell", "SciPy per cell"]
    header += ["SciPy finds the same regime", "over SciPy, core against core", f"{threads} threads against one SciPy"]
    return markdown(header, rows)


def maps_table(rows: list[dict[str, Any]]) -> str:
    lines = []
    for row in rows:
        asked = "" if row["asked"] is None else f"≤ {row['asked']:g}"
        numbers = [f"{row[name]:.2f}" for name in ("us", "over_p2", "regime_us", "regime_over_p2")]
        lines.append(
            [row["map"], f"{100 * row['settle']:.0f} %", number(row["steps"]), *numbers[:2], asked, *numbers[2:]]
        )
    return markdown(
        ["map", "settle", "steps a cell", "µs a cell", "over P2", "asked", "regime alone, µs", "over P2"], lines
    )


def p3_table(row: dict[str, Any]) -> str:
    cells = [f"{row['rigs']:,}", number(row["samples_per_rig"]), f"{1e3 * row['seconds_per_rig']:.2f} ms"]
    cells += [f"{1e3 * row['scipy_seconds_per_rig']:,.0f} ms", number(row["ratio"])]
    cells += [f"{row['same_sticks']} of {row['scipy_rigs']}", f"{row['worst_breakaway_error']:.0e}"]
    header = ["rigs", "samples each", "CPU time of one, ours", "SciPy", "over SciPy, core against core"]
    header += ["as many sticks", "first break-away, difference", "our energy-balance residual"]
    return markdown(header, [[*cells, f"{row['worst_energy_error']:.0e}"]])


def p4_table(row: dict[str, Any] | None) -> str:
    if row is None:
        return "Not measured in this run.\n"
    cells = [f"{row['lines']:,}", number(row["borders_per_second"]), number(row["bisection_per_second"])]
    cells += [number(row["scipy_per_second"]), number(row["ratio"]), f"{row['worst_difference']:.0e}"]
    header = ["lines", "borders per CPU second", "the same by bisection", f"SciPy, {row['scipy_lines']} lines"]
    return markdown([*header, "over SciPy, core against core", "largest difference"], [cells])


def refinement_table(rows: list[dict[str, Any]]) -> str:
    """Refined maps beside their full grids."""
    lines = [
        [
            row["curve"],
            f"{row['size']:,} x {row['size']:,}",
            f"{row['computed']:,}",
            number(row["cells"] / row["computed"]),
            f"{row['wrong']:,}",
            f"{100 * row['bound']:.2g} %",
            f"{row['seconds']:.2f}",
            number(row["seconds_full"]),
            number(row["seconds_full"] / row["seconds"]),
        ]
        for row in rows
    ]
    header = ["curve", "map", "cells computed", "times fewer", "cells wrong", "bound of the audit (95 %)", "seconds"]
    return markdown([*header, "seconds, full grid", "over the full grid"], lines)


def whole_table(results: dict[str, Any]) -> str:
    """What a user waits for."""
    rows = [
        [
            row["what"],
            duration(row["seconds"]),
            duration(row["most"]),
            duration(row["kernels"]),
            "" if row["asked"] is None else f"≤ {duration(row['asked'])}",
            "" if row["asked"] is None else "yes" if row["seconds"] <= row["asked"] else "**no**",
        ]
        for row in results["whole"]["rows"]
    ]
    text = markdown(["from the shell to the prompt", "median", "longest", "of which kernels", "asked", "met"], rows)
    if dask := results["whole"]["dask"]:
        text += f"""
Cells a second of a map of 1e7 cells as the command says them: {number(dask["threads"])} on two threads,
{number(dask["dask"])} on two workers of one thread each, {dask["ratio"]:.2f} times (asked: ≥ 0.9).
"""
    return text


def duration(seconds: float | None) -> str:
    if seconds is None:
        return ""
    return f"{1e6 * seconds:.0f} µs" if seconds < 1e-3 else f"{seconds:.2f} s"


def laws_table(rows: list[dict[str, Any]]) -> str:
    lines = [[row["law"], f"{row['us_per_cell']:.2f}", number(row["steps"])] for row in rows]
    return markdown(["law", "µs of CPU time a cell", "steps"], lines)


def targets(results: dict[str, Any]) -> str:
    """The targets, beside what this run measured."""
    rows: list[list[str]] = []

    def add(what: str, value: float | None, bound: float | None, least: bool = True) -> None:
        asked = "" if bound is None else f"{'≥' if least else '≤'} {bound:g}"
        if value is None or bound is None:
            rows.append([what, asked, "not measured" if value is None else number(value), ""])
            return
        met = value >= bound if least else value <= bound
        rows.append([what, asked, number(value), "yes" if met else "**no**"])

    for rtol, times, error in ((1e-6, 25, 1e-6), (1e-9, 60, 5e-10)):
        ours, base = find(results, OURS, rtol), find(results, BASELINE, rtol)
        peer = fastest_peer(results, rtol)
        add(f"over the scalar Numba baseline, rtol {rtol:g}", ours["rate"] / base["rate"] if base else None, times)
        add("the same, best repetition of each", best(ours) / best(base) if base else None, None)
        name = peer["peer"] if peer else "fastest peer"
        add(f"over the fastest peer ({name}), rtol {rtol:g}", ours["rate"] / peer["rate"] if peer else None, 12)
        # the same at equal error, which is what a tolerance is for
        for against in (BASELINE, BATCH):
            rate, theirs = at_equal_error(results, OURS, error), at_equal_error(results, against, error)
            add(f"over {against} at equal error {error:g}", rate / theirs if rate and theirs else None, None)
        add(f"median error of the re-stick time, rtol {rtol:g}", ours["errors"]["time"], error, least=False)
        several = [row for row in results["p1"] if row["peer"] == OURS and row["rtol"] == rtol and row["threads"] > 1]
        for row in several:
            ratio = sorted(a / b for a, b in zip(ours["timings"]["wall"], row["timings"]["wall"], strict=True))
            add(f"{row['threads']} threads over one, rtol {rtol:g}", ratio[len(ratio) // 2], 0.95 * row["threads"])
    for row in results["p2"]:
        each, bound = row["cpu_seconds"] / row["cells"] * 1e6, {"plain": 0.45, "hysteretic": 0.65}[row["curve"]]
        add(f"µs of CPU time a map cell, {row['curve']} curve", each, bound, least=False)
        add(f"over a SciPy user per cell, {row['curve']} curve", row["ratio_all_threads_over_scipy"], 5000)
    add("test rigs over a SciPy user, core against core", results["p3"]["ratio"], 200)
    for row in results["steps"]:
        add(f"step over its floor, rtol {row['rtol']:g}", row["ratio_to_floor"], 2, least=False)
        add(f"ns per event, rtol {row['rtol']:g}", row["ns_per_event"], 60 if row["rtol"] == 1e-6 else 40, least=False)
    per_cell = [row["us_per_cell"] for row in results["cost"]]
    add("cost per cell, most expensive map size over cheapest", max(per_cell) / min(per_cell), 1.2, least=False)
    for row in results["refinement"]:
        name = f"refined {row['curve']} map, {row['size']:,} x {row['size']:,}"
        add(f"{name}: times fewer cells", row["cells"] / row["computed"], 100 if row["size"] == 4096 else None)
        add(f"{name}: share of cells wrong", row["wrong"] / row["cells"], 1e-4, least=False)
    memory = [row["memory"] for row in results["cost"] if "memory" in row]
    if memory:
        most = max(memory, key=lambda row: row["cells"])
        add(
            f"peak memory of a run of {most['cells']:.0e} cells into a file, GB",
            most["peak_bytes"] / 1e9,
            1.0,
            least=False,
        )
    add("quickstart, shell to first block, s", results["startup"]["first_block"]["seconds"], None)
    add("first compilation of a law, s", results["startup"]["compile"], 15, least=False)
    return markdown(["target", "asked", "measured", "met"], rows)


def headline(results: dict[str, Any]) -> dict[str, str]:
    """What a run says of its processor, in words: a column of the table by processor."""
    found = {"kernels for": results["machine"]["kernels"], "measured": results["machine"]["date"][:10]}
    for rtol in (1e-6, 1e-9):
        ours, base, peer = find(results, OURS, rtol), find(results, BASELINE, rtol), find(results, BATCH, rtol)
        found[f"P1 at {rtol:g} over the scalar baseline"] = number(ours["rate"] / base["rate"]) if base else ""
        found[f"P1 at {rtol:g} over heyoka, batch"] = number(ours["rate"] / peer["rate"]) if peer else ""
    for row in results["steps"]:
        found[f"ns per event, {row['rtol']:g}"] = number(row["ns_per_event"])
    for row in results["p2"]:
        found[f"P2, {row['curve']} curve, µs of CPU time a cell"] = number(row["cpu_seconds"] / row["cells"] * 1e6)
    for row in results["maps"][1:]:
        found[f"{row['map']}, over P2"] = number(row["over_p2"])
        found[f"{row['map']}, regime alone, over P2"] = number(row["regime_over_p2"])
    found["first compilation of a law"] = duration(results["startup"]["compile"])
    return found | {row["what"]: duration(row["seconds"]) for row in results["whole"]["rows"]}


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

Whole commands with file and plot, kernels compiled before. Asked of maps: 1.5 times what the kernels take, and 1.5 s.

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
    """Replace what stands between the marks in docs/speed.md by the table, its headings one level down."""
    page = DOCS.read_text()
    before, _, rest = page.partition(BEGIN)
    _, _, after = rest.partition(END)
    body = text.split("\n", 2)[2].replace("\n## ", "\n### ")
    DOCS.write_text(f"{before}{BEGIN}\n{body}{END}{after}")


if __name__ == "__main__":
    # The table and the plot again, from results.json; with --docs into docs/speed.md as well.
    found = json.loads((RESULTS / "results.json").read_text())
    text = table(found, remember(found, RESULTS))
    (RESULTS / "table.md").write_text(text)
    plot(found, RESULTS / "plot.png")
    if "--docs" in sys.argv[1:]:
        into_docs(text)
    print(text)
