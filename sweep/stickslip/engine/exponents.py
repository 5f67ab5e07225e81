"""Cells of `stribeck_delta` by their exponent: 1 and 2 have kernels of their own, which take a tenth of the time.

Which kernels compute a cell depends on that cell alone, so its numbers do not depend on its neighbours.

`friction_at_belt_speed` is the friction curve itself, as the kernels have it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiled import kernels
from stickslip.engine.options import Options, StopFlag
from stickslip.engine.scales import to_kernel
from stickslip.vocabulary.cells import Parameters
from stickslip_kernels import layout
from stickslip_kernels.allocate import NO_STOPS

Floats = NDArray[np.float64]
OWN_KERNELS = {1.0: "stribeck", 2.0: "gaussian"}  # by exponent: laws of the kernels that have a Taylor step


def kernels_for(options: Options, exponents: Iterable[float]) -> tuple[str, ...]:
    """Names of the kernels that cells of a law with these exponents need, each once."""
    own = OWN_KERNELS if options.law == "stribeck_delta" else {}
    return tuple(dict.fromkeys(own.get(exponent, options.law) for exponent in exponents))


def run_regimes(options: Options, rtol: float, cells: Floats, stop: StopFlag, results: Floats) -> None:
    """`Kernels.run_regimes`, each cell by the kernels that suit it; they are loaded, or compiled, when first needed."""
    max_steps, early_stop = options.max_steps, options.early_stop
    for name, chosen in _kernels(options, cells[layout.DELTA]):
        run = kernels(name).run_regimes
        if chosen is None:
            run(cells, rtol, max_steps, stop, results, early_stop)
            continue
        rows = results[:, : chosen.size]  # there may be more room
        own = np.ascontiguousarray(rows[:, chosen])
        run(np.ascontiguousarray(cells[:, chosen]), rtol, max_steps, stop, own, early_stop)
        rows[:, chosen] = own


def run_signals(
    options: Options, cells: Floats, stop: StopFlag, drive: tuple[Floats, Floats], results: Floats, runs: Floats,
    signals: Floats, stops: Floats = NO_STOPS,
) -> None:  # fmt: skip
    """The same of `Kernels.run_signals`."""
    segments, spans = drive
    rtol, max_steps = options.rtol, options.max_steps
    for name, chosen in _kernels(options, cells[layout.DELTA]):
        run = kernels(name, signals=True).run_signals
        if chosen is None:
            run(cells, rtol, max_steps, stop, drive, results, runs, signals, stops)
            continue
        own, part = np.ascontiguousarray(results[:, chosen]), np.ascontiguousarray(cells[:, chosen])
        run(part, rtol, max_steps, stop, (segments, spans[chosen]), own, runs[chosen], signals, stops)
        results[:, chosen] = own


def _kernels(options: Options, exponents: Floats) -> Iterator[tuple[str, NDArray[np.bool_] | None]]:
    """Names of kernels, and which cells are theirs; None for all."""
    if options.law != "stribeck_delta":
        yield options.law, None
        return
    left = np.ones(exponents.size, bool)
    for exponent, name in OWN_KERNELS.items():
        chosen = exponents == exponent
        left &= ~chosen
        if chosen.any():
            yield name, None if chosen.all() else chosen
    if left.any() or not left.size:
        yield options.law, None if left.all() else left


def friction_at_belt_speed(cells: Parameters, options: Options) -> NDArray[np.float64]:
    """Friction coefficient of each cell where the mass is at rest, and the slip speed that of the belt."""
    rows = to_kernel(cells, np.inf, options)
    return np.asarray(kernels(options.law).friction(rows, np.abs(rows[layout.BELT])))
