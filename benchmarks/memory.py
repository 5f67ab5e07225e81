"""Cost of maps of contacts with memory, and of a few of their cycles by others at the same tolerance: Radau of SciPy,
and Kvaerno5 of diffrax where that is installed.

    python benchmarks/memory.py      # half a minute; with diffrax, several

48 x 48 cells, CPU time on one thread, rtol 1e-6. Belt speeds from 1e-7 to 0.1 m/s; stiffnesses from 2 to 400 N/mm, as
in configs/rate_state.yaml, or from 0.03 to 30 times the critical one at each speed. Bristles: configs/lugre.yaml.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from statistics import median
from time import process_time

import numpy as np
from scipy.integrate import solve_ivp

from measure import Job, interleave
from stickslip import engine
from stickslip.config.grid import build_grid, options_of
from stickslip.config.reader import load_config
from stickslip.config.resolve import config_path
from stickslip.theory import contacts
from stickslip.vocabulary.cells import Cells, as_cells

SIDE, TURNS, SAMPLE, CYCLES, STUCK = 48, 3, 8, 4, 5.0
BATCH, MOST_STEPS = 64, 8192  # cells of diffrax, and its steps, ten times as many as ours
ROCK = {"mass": 1.0, "normal_load": 10.0, "mu_0": 0.6, "v_0": 1e-6, "a": 0.010, "b": 0.018, "D_c": 1e-6}
NAMES = ("mass", "stiffness", "normal_load", "belt_speed", "a", "b", "D_c", "mu_0", "v_0")
SPEEDS = np.geomspace(1e-7, 0.1, SIDE)


def maps() -> dict[str, tuple[Cells, engine.Options]]:
    """Cells in random order, and how they are computed, by name."""
    slopes = contacts.rate_state_slopes(0.0, ROCK["normal_load"], SPEEDS, ROCK["a"], ROCK["b"], ROCK["D_c"])
    critical = np.geomspace(0.03, 30.0, SIDE)[:, None] * contacts.critical_stiffness(ROCK["mass"], slopes)
    plain = np.geomspace(2e3, 4e5, SIDE)[:, None] * np.ones(SIDE)
    order = np.random.default_rng(4).permutation(SIDE**2)
    cases = {}
    for law in ("rate_state_ageing", "rate_state_slip"):
        for where, stiffness in (("", plain), (", about critical", critical)):
            varied = {"stiffness": stiffness, "belt_speed": np.broadcast_to(SPEEDS, stiffness.shape)}
            varied = {name: values.ravel()[order] for name, values in varied.items()}
            cases[law + where] = Cells.of(as_cells(ROCK | varied, law)), engine.Options(law=law, threads=1)
    config = load_config(config_path("lugre"))
    bristles = {name: values[order] for name, values in build_grid(config)[:].items()}
    return cases | {"lugre": (Cells.of(bristles), replace(options_of(config), threads=1))}


def measure() -> list[dict]:
    """Rows of maps: microseconds and steps a cell, nanoseconds a step, what became of the cells, SciPy's seconds."""
    cases = maps()
    jobs = {name: Job(partial(engine.compute, *case), TURNS) for name, case in cases.items()}
    for cells, options in cases.values():
        engine.compute(Cells.of(cells[:1]), options)  # compiles
    interleave(list(jobs.values()))
    rows = []
    for name, job in jobs.items():
        results, seconds = job.result.results, median(job.timings.cpu)
        regimes = results["regime"]
        row = {
            "map": name, "us": seconds / regimes.size * 1e6, "steps": float(results["steps"].mean()),
            "ns": seconds / results["steps"].sum() * 1e9, "settle": float(np.isin(regimes, (2, 3)).mean()),
            "unresolved": int((regimes >= 6).sum()),
        }  # fmt: skip
        if name == "rate_state_ageing":
            row |= against_scipy(cases[name][0], results) | against_diffrax(cases[name][0], results)
        rows.append(row)
    return rows


def against_scipy(cells: Cells, results: engine.Results) -> dict:
    """Seconds of Radau for a few cells that stick-slip, and by how much its last period differs from ours."""
    sticks = np.flatnonzero(results["regime"] == 1)[:SAMPLE]
    began = process_time()
    periods = [period({name: values[n] for name, values in cells[:].items()}, results["period"][n]) for n in sticks]
    seconds = (process_time() - began) / sticks.size
    return {"scipy": seconds, "off": float(np.max(np.abs(periods / results["period"][sticks] - 1.0)))}


def period(cell: dict[str, float], about: float) -> float:
    """The last of a few cycles from our start on, by Radau in spring force, ln w and ln theta."""
    values = tuple(cell[name] for name in NAMES)
    steady, a, b = steady_friction(values), cell["a"], cell["b"]

    def motion(t, state):
        return rates(state, values, steady, np.exp)

    def passes(t, state):
        return state[1]

    passes.direction = 1.0
    start = ((steady - STUCK * a + STUCK * b) / a, -STUCK, STUCK)
    times = solve_ivp(motion, (0.0, CYCLES * about), start, "Radau", events=passes, rtol=1e-6, atol=1e-6).t_events[0]
    return times[-1] - times[-2]


def steady_friction(values: tuple) -> np.ndarray:
    """Of cells with values of NAMES, at the speed of the belt."""
    _, _, _, v, a, b, _, mu_0, v_0 = values
    return mu_0 + (a - b) * np.log(v / v_0)


def rates(state: tuple, values: tuple, steady: float, exp: Callable) -> tuple:
    """Of F/(a N), ln(w/v), ln(theta v/D_c)."""
    (f, phi, psi), (m, k, load, v, a, b, d, *_) = state, values
    w = v * exp(phi)
    rise = load * (a * f - steady - a * phi - b * psi) / (m * w)
    return k * (v - w) / (a * load), rise, v / d * (exp(-psi) - exp(phi))


def against_diffrax(cells: Cells, results: engine.Results) -> dict:
    """Seconds a cell of Kvaerno5 for a batch of cells that stick-slip, compiled before; their steps; by how much the
    last period differs from ours; how many did not come so far. Nothing where diffrax is not installed.
    """
    if find_spec("diffrax") is None:
        return {}
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    sticks = np.flatnonzero(results["regime"] == 1)[:BATCH]
    values = tuple(np.broadcast_to(cells[:][name], results["regime"].shape)[sticks] for name in NAMES)
    about, steady = results["period"][sticks], steady_friction(values)

    def motion(t, state, cell):  # over the period
        values, steady, about = cell
        return about * jnp.stack(rates(tuple(state), values, steady, jnp.exp))

    @jax.jit
    @jax.vmap
    def solve(start, cell):
        return diffrax.diffeqsolve(
            diffrax.ODETerm(motion), diffrax.Kvaerno5(), 0.0, float(CYCLES), None, start, cell,
            saveat=diffrax.SaveAt(ts=[CYCLES - 1.0, CYCLES]), max_steps=MOST_STEPS, throw=False,
            stepsize_controller=diffrax.PIDController(rtol=1e-6, atol=1e-6),
        )  # fmt: skip

    a, b = values[4], values[5]
    start = np.stack([(steady - STUCK * a + STUCK * b) / a, np.full_like(a, -STUCK), np.full_like(a, STUCK)], axis=1)
    jax.block_until_ready(solve(start, (values, steady, about)))  # compiles
    began = process_time()
    solution = jax.block_until_ready(solve(start, (values, steady, about)))
    seconds = (process_time() - began) / sticks.size
    states, ended = np.asarray(solution.ys), np.isfinite(solution.ys).all(axis=(1, 2))
    slopes = jax.vmap(motion, (None, 0, 0))(0.0, states[:, 1], (values, steady, about))
    off = ((states[:, 1, 0] - states[:, 0, 0]) / np.asarray(slopes)[:, 0])[
        ended
    ]  # of the spring, which is being loaded
    steps = float(np.mean(solution.stats["num_steps"]))
    return {
        "diffrax": seconds, "diffrax_off": float(np.max(np.abs(off))), "diffrax_steps": steps,
        "diffrax_unfinished": int((~ended).sum()),
    }  # fmt: skip


if __name__ == "__main__":
    from tables import memory_table

    print(memory_table(measure()))
