"""The bench: everything of docs/speed.md in one session, interleaved, into benchmarks/results/.

    python benchmarks/run.py [--repeats N] [--only TEXT] [--large] [--out FOLDER]      (or: make bench)

--repeats : at most this many repetitions of each. --only : only peers whose name contains TEXT. --large : maps of 1e7
cells, Dask, and refined maps of 4096 x 4096 as well. Takes about five minutes on two cores.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from functools import partial
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

import numpy as np
from scipy.integrate import solve_ivp

import borders
import floor
import maps
import memory
import problem
import refinement
import report
import rigs
import startup
import whole
from measure import Job, Timings, interleave, machine, timed
from peers import Peer, all_peers
from peers.scipy_events import after_release, cycle, motion, rest
from problem import HORIZON, MU_START, MU_STOP
from stickslip import engine
from stickslip.vocabulary.cells import as_cells

TOLERANCES = (1e-6, 1e-9)
CURVE_TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
OURS = "stickslip (ours)"


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


# --- P1 ---------------------------------------------------------------------------------------------------------------


def ours_as_peer() -> Peer:
    return Peer(
        OURS,
        "root of the series of the step",
        problem.ours,
        dict.fromkeys(TOLERANCES, 10_000),
        solve_threads=problem.ours,
        repeats=5,
    )


def check_reference(cells: problem.Cells, exact: problem.Answer, count: int = 4) -> float:
    """Our answer at rtol 1e-10 against DOP853 at 1e-12: worst relative error of the first re-stick of a few cells."""
    worst, checked = 0.0, 0
    for i in np.flatnonzero(np.isfinite(exact.restick_time)):
        k, belt = cells.k[i], cells.belt[i]
        dt, state = after_release(k, belt)
        release = MU_START / k / belt
        run = solve_ivp(
            motion, (release + dt, HORIZON), state, "DOP853", events=rest, args=(k, belt), rtol=1e-12, atol=1e-15
        )
        worst = max(worst, abs(run.t[-1] / exact.restick_time[i] - 1))
        checked += 1
        if checked == count:
            break
    return worst


def fixed_horizon(peers: list[Peer], most_repeats: int) -> list[dict]:
    """A row for each peer, tolerance and number of threads."""
    cells, exact, _ = problem.p1()
    entries: list[tuple[Peer, float, int, int, Job]] = []
    for peer in peers:
        several = (1, engine.processors()) if peer.solve_threads and engine.processors() > 1 else (1,)
        for rtol, count in peer.sample.items():
            part = cells.part(slice(0, count))
            for threads in several:
                solve = partial(peer.solve_threads, threads=threads) if peer.solve_threads else peer.solve
                action = partial(solve, part, HORIZON, rtol)
                if count > 50:  # compile for these very shapes; slow peers interpret
                    say(f"  compiling {peer.name}, rtol {rtol:g}, {threads} thread(s)")
                    action()
                entries.append((peer, rtol, threads, count, Job(action, min(peer.repeats, most_repeats))))
    interleave([entry[-1] for entry in entries], say)
    rows = []
    for peer, rtol, threads, count, job in entries:
        found = problem.errors(job.result, exact, cells)
        rows.append(
            {
                "peer": peer.name,
                "events": peer.how,
                "rtol": rtol,
                "threads": threads,
                "cells": count,
                "rate": job.timings.rate(count, threads),
                "spread": job.timings.spread(threads),
                "errors": asdict(found),
                "timings": asdict(job.timings),
            }
        )
    return rows


def work_precision(peers: list[Peer]) -> list[dict]:
    """Rate and error on one thread over a range of tolerances, of the peers that are fast enough to have a curve."""
    cells, exact, _ = problem.p1()
    rows = []
    for peer in peers:
        count = max(peer.sample.values(), default=0)
        if count < 1000:
            continue
        part = cells.part(slice(0, count if peer.name == OURS else 1000))  # ours would be idle on so few
        for rtol in CURVE_TOLERANCES:
            action = partial(peer.solve, part, HORIZON, rtol)
            action()
            timings = Timings()
            timed(action, timings)
            found = timed(action, timings)
            error = problem.errors(found, exact, cells)
            if max(error.missed, np.isnan(found.x_end).sum()) > 0.01 * len(part):
                say(f"  {peer.name} gives up at rtol {rtol:g}: no point")
                continue
            rows.append({"peer": peer.name, "rtol": rtol, "rate": len(part) / min(timings.cpu), "error": error.time})
    return rows


def sliding_cells() -> dict:
    """Cells that settle on a rising curve and then slide undisturbed: almost nothing but steps."""
    belt = np.linspace(0.8, 1.0, 2048)
    return {"cells": problem.Cells(np.ones(belt.size), belt), "horizon": 2000.0}


def where_the_time_goes(accepted_sample: int = 100) -> list[dict]:
    """ns per trial step and per event, on one thread.

    A step: CPU time over trial steps of cells that slide without events. An event: what P1 takes beyond its trial
    steps, over the number of its stick phases (re-stick located, stick in closed form, break-away computed; recorded
    extrema and the start and end of cells are included).
    """
    cells, _, _ = problem.p1()
    operations, rows = floor.operations(), []
    sliding = sliding_cells()
    slide = sliding.pop("cells")
    for rtol in TOLERANCES:
        rates: list[float] = []
        jobs = [
            Job(partial(problem.compute, slide, rtol=rtol, early_stop=False, threads=1, **sliding), 5),
            Job(partial(problem.compute, cells, rtol=rtol, horizon=HORIZON, early_stop=False, threads=1), 5),
            Job(lambda rates=rates: rates.append(floor.fma_rate()), 5),
        ]
        interleave(jobs)
        pure, p1 = jobs[:2]
        steps, events = p1.result["steps"].sum(), p1.result["sticks"].sum()
        # Repetition by repetition, whose parts are neighbours in time, and then the medians.
        steps_alone = [seconds / pure.result["steps"].sum() for seconds in pure.timings.cpu]
        beyond = [seconds - step * steps for seconds, step in zip(p1.timings.cpu, steps_alone, strict=True)]
        over_floor = [step * rate / operations["all"] for step, rate in zip(steps_alone, rates, strict=True)]
        seconds, per_step, rate = median(p1.timings.cpu), median(steps_alone), median(rates)
        share = accepted_share(cells.part(slice(0, accepted_sample)), rtol)
        rows.append(
            {
                "rtol": rtol,
                "ns_per_trial_step": per_step * 1e9,
                "ns_per_event": median(beyond) / events * 1e9,
                "accepted_share": share,
                "ns_per_accepted_step": per_step * 1e9 / share if share else None,
                "ns_all_over_steps": seconds / steps * 1e9,
                "share_of_events": median(beyond) / seconds,
                "steps_per_cell": steps / len(cells),
                "events_per_cell": events / len(cells),
                "fma_per_second": rate,
                "operations": operations,
                "floor_ns_per_trial_step": operations["all"] / rate * 1e9,
                "ratio_to_floor": median(over_floor),
            }
        )
    return rows


def accepted_share(cells: problem.Cells, rtol: float) -> float:
    """Accepted over tried steps: the observer of signals looks at each good one."""
    from stickslip.engine.compiling import kernels
    from stickslip_kernels import layout

    n = len(cells)
    full = as_cells(problem.CURVE | {"stiffness": cells.k, "belt_speed": cells.belt})
    columns = engine.to_kernel(full, HORIZON, engine.Options())
    table = np.column_stack([columns[layout.HORIZON], columns[layout.BELT], np.zeros(n)])
    belts = table, np.column_stack([np.arange(n), np.arange(n) + 1.0])
    rows, nothing = layout.new_signals(n), np.empty((layout.SIGNAL_ROWS, 0))
    runs, run = np.zeros((n, layout.RUN_COLUMNS)), kernels("stribeck", signals=True).run_signals
    run(columns, rtol, 1_000_000, np.zeros(1, np.int64), belts, rows, runs, nothing)
    return float(rows[layout.RIG_STEPS_TAKEN].sum() / rows[layout.RIG_STEPS].sum())


# --- P2 and the cost of many cells ------------------------------------------------------------------------------------


def regime_map(most_repeats: int, scipy_cells: int) -> list[dict]:
    """Seconds for 1e6 cells of the plain and of the hysteretic map, all threads, and SciPy on a sample of each."""
    whole, rows = problem.grid(1000), []
    sample = np.random.default_rng(2).choice(len(whole), scipy_cells, replace=False)
    curves = {"plain": np.nan, "hysteretic": MU_STOP}
    threads = engine.processors()
    jobs = {
        name: Job(partial(problem.compute, whole, rtol=1e-6, mu_stop=mu_stop), min(2, most_repeats))
        for name, mu_stop in curves.items()
    }
    interleave(list(jobs.values()), say)
    for name, job in jobs.items():
        regime = job.result["regime"][sample]
        began = process_time()
        found = [cycle(whole.k[i], whole.belt[i], 1e-6, name == "hysteretic") for i in sample]
        scipy_seconds = (process_time() - began) / scipy_cells
        ours = [{1: "stick_slip", 2: "sliding", 3: "sliding"}.get(int(r), "unresolved") for r in regime]
        seconds = median(job.timings.wall)
        rows.append(
            {
                "curve": name,
                "cells": len(whole),
                "threads": threads,
                "seconds": seconds,
                "spread": job.timings.spread(threads),
                "cpu_seconds": median(job.timings.cpu),
                "unresolved": int((job.result["regime"] >= 6).sum()),
                "steps_per_cell": float(job.result["steps"].mean()),
                "scipy_cells": scipy_cells,
                "scipy_seconds_per_cell": scipy_seconds,
                "scipy_same_regime": float(np.mean([a == b for a, b in zip(found, ours, strict=True)])),
                "ratio_all_threads_over_scipy": scipy_seconds * len(whole) / seconds,
                "ratio_one_core_over_scipy": scipy_seconds * len(whole) / median(job.timings.cpu),
            }
        )
    return rows


def cost_of_cells(large: bool, most_repeats: int) -> list[dict]:
    """Time per cell of the plain map over its size, all threads; memory in a separate process."""
    rows = []
    for n in (100, 316, 1000, *((3162,) if large else ())):
        cells = problem.grid(n)
        job = Job(
            partial(problem.compute, cells, rtol=1e-6), 1 if n > 1000 else min(2 if n == 1000 else 5, most_repeats)
        )
        interleave([job])
        row = {"cells": n * n, "us_per_cell": median(job.timings.wall) / (n * n) * 1e6}
        rows.append(row | ({"memory": startup.memory(n)} if n >= 1000 else {}))
    return rows


LAWS = {
    "stribeck": {"law": "stribeck"},
    "stribeck_delta, delta 2": {"law": "stribeck_delta", "delta": 2.0},
    "stribeck_delta, delta 1.5": {"law": "stribeck_delta", "delta": 1.5},
    "rational": {"law": "rational"},
    "cubic": {"law": "cubic", "a4": 0.5},
}


def laws(most_repeats: int) -> list[dict]:
    """Microseconds of CPU time a cell of the plain map, by law, on one thread."""
    cells = problem.grid(100)
    jobs = {
        name: Job(partial(problem.compute, cells, rtol=1e-6, threads=1, **law), min(3, most_repeats))
        for name, law in LAWS.items()
    }
    for job in jobs.values():
        job.action()  # compiles
    interleave(list(jobs.values()))
    return [
        {
            "law": name,
            "us_per_cell": median(job.timings.cpu) / len(cells) * 1e6,
            "steps": float(job.result["steps"].mean()),
        }
        for name, job in jobs.items()
    ]


# --- all of it --------------------------------------------------------------------------------------------------------


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--only", default="")
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "results")
    options = parser.parse_args()
    began = perf_counter()
    say("start-up, compilation")
    results = {"machine": machine(), "startup": {"first_block": startup.first_block(), **startup.first_compile()}}
    engine.warm_up()
    say("whole commands")
    results["whole"] = whole.measure(options.large, options.repeats)
    say("the answer at rtol 1e-10")
    cells, exact, _ = problem.p1()
    results["reference_error"] = check_reference(cells, exact)
    listed = [(peer, peer.available()) for peer in all_peers() if options.only.lower() in peer.name.lower()]
    results["missing"] = [{"peer": peer.name, "reason": reason} for peer, reason in listed if reason]
    peers = [ours_as_peer()] + [peer for peer, reason in listed if not reason]
    say("P1, fixed horizon")
    results["p1"] = fixed_horizon(peers, options.repeats)
    say("work against precision")
    results["work_precision"] = work_precision(peers)
    say("where the time goes")
    results["steps"] = where_the_time_goes()
    say("P2, regime maps")
    results["p2"] = regime_map(options.repeats, 40)
    results["maps"] = maps.measure()
    say("contacts with memory")
    results["memory"] = memory.measure()
    say("P3, test rigs")
    results["p3"] = rigs.measure()
    say("P4, borders")
    results["p4"] = borders.measure()
    say("refined maps")
    results["refinement"] = refinement.measure(4096 if options.large else 1024)
    results["cost"] = cost_of_cells(options.large, options.repeats)
    say("laws")
    results["laws"] = laws(options.repeats)
    results["bench_seconds"] = perf_counter() - began
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "results.json").write_text(json.dumps(results, indent=1, default=float) + "\n")
    table = report.table(results, report.remember(results, options.out))
    (options.out / "table.md").write_text(table)
    report.plot(results, options.out / "plot.png")
    print(table)


if __name__ == "__main__":
    main()
