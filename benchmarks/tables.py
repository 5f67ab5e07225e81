"""Tables in Markdown of what a run measured."""

from __future__ import annotations

from typing import Any

OURS = "stickslip (ours)"
BASELINE = "Numba scalar"
BATCH = "heyoka, batch"


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


def memory_table(rows: list[dict[str, Any]]) -> str:
    """Maps of contacts with memory; a column of diffrax where it was measured."""
    peer = any("diffrax" in row for row in rows)
    lines = [
        [
            row["map"],
            f"{100 * row['settle']:.0f} %",
            str(row["unresolved"]),
            number(row["steps"]),
            number(row["ns"]),
            number(row["us"]),
            f"{number(row['scipy'] / row['us'] * 1e6)} ({row['off']:.0e})" if "scipy" in row else "",
            *([over_diffrax(row)] if peer else []),
        ]
        for row in rows
    ]
    header = [
        "map",
        "settle",
        "unresolved",
        "steps a cell",
        "ns a step",
        "µs a cell",
        "over four cycles of Radau (whose period is off by)",
        *(["over the same of diffrax, Kvaerno5, a batch of 64"] if peer else []),
    ]
    return markdown(header, lines)


def over_diffrax(row: dict[str, Any]) -> str:
    """How many times as long diffrax takes, by how much its periods are off, and how many cells it did not finish."""
    if "diffrax" not in row:
        return ""
    times = number(row["diffrax"] / row["us"] * 1e6)
    return f"{times} ({row['diffrax_off']:.0e}, {row['diffrax_unfinished']} unfinished)"


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
    """Whole commands."""
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
