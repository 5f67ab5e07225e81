"""Cells to the kernels that suit them: some of a law may have kernels of their own, which take a tenth of the time.

Which kernels compute a cell depends on that cell alone, so its numbers do not depend on its neighbours.

`friction_at_belt_speed` is the friction curve itself, as the kernels have it.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiled import kernels
from stickslip.engine.compiling import ship
from stickslip.engine.options import Options, StopFlag
from stickslip.engine.scales import to_kernel
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import LAWS, MODELS, PREFIX, TABLE, OwnKernels, model_of
from stickslip_kernels import layout, objects
from stickslip_kernels.allocate import NO_STOPS

Floats = NDArray[np.float64]


def kernels_for(cells: Cells, options: Options) -> tuple[str, ...]:
    """Names of the kernels that the cells of a grid need, each once."""
    own = _own(options)
    if own is None:
        return (options.law,)
    given = {name: cells.along[name][1] if name in cells.along else cells.fixed[name] for name in own.parameters}
    values = [set(np.unique(np.nan_to_num(column)).tolist()) for column in given.values()]
    names = [name for value, name in own.by_value.items() if all(value in column for column in values)]
    others = any(column - set(own.by_value) for column in values)
    return (*names, own.otherwise or options.law) if others else tuple(names)


def has_own_kernels(options: Options) -> bool:
    """Return whether the kernels depend on the cells, and not on their law alone."""
    return _own(options) is not None


def ship_all() -> None:
    """Compile all kernels for all kinds of this processor into the package, for the next wheel to bring."""
    own = [kernels for model in MODELS for kernels in model.own_kernels.values()]
    names = [name for kernels in own for name in (*kernels.by_value.values(), kernels.otherwise) if name]
    laws = dict.fromkeys((*LAWS, *names, *(f"{prefix}{TABLE}" for prefix in ("", PREFIX))))
    ship(objects.shipped_folder(), [*laws], [*objects.kinds_here()])


def _own(options: Options) -> OwnKernels | None:
    return model_of(options.law).own_kernels.get(options.law)


def run_regimes(options: Options, rtol: float, cells: Floats, stop: StopFlag, results: Floats) -> None:
    """`Kernels.run_regimes`, each cell by the kernels that suit it; they are loaded, or compiled, when first needed."""
    max_steps, until = options.max_steps, options.until
    for name, chosen in _kernels(options, cells):
        run = kernels(name).run_regimes
        if chosen is None:
            run(cells, rtol, max_steps, stop, results, until)
            continue
        rows = results[:, : chosen.size]  # there may be more room
        own = np.ascontiguousarray(rows[:, chosen])
        run(np.ascontiguousarray(cells[:, chosen]), rtol, max_steps, stop, own, until)
        rows[:, chosen] = own


def run_signals(
    options: Options, cells: Floats, stop: StopFlag, drive: tuple[Floats, Floats], results: Floats, runs: Floats,
    signals: Floats, stops: Floats = NO_STOPS,
) -> None:  # fmt: skip
    """The same of `Kernels.run_signals`."""
    segments, spans = drive
    rtol, max_steps = options.rtol, options.max_steps
    for name, chosen in _kernels(options, cells):
        run = kernels(name, signals=True).run_signals
        if chosen is None:
            run(cells, rtol, max_steps, stop, drive, results, runs, signals, stops)
            continue
        own, part = np.ascontiguousarray(results[:, chosen]), np.ascontiguousarray(cells[:, chosen])
        run(part, rtol, max_steps, stop, (segments, spans[chosen]), own, runs[chosen], signals, stops)
        results[:, chosen] = own


def _kernels(options: Options, cells: Floats) -> Iterator[tuple[str, NDArray[np.bool_] | None]]:
    """Names of kernels, and which cells are theirs; None for all."""
    own = _own(options)
    if own is None:
        yield options.law, None
        return
    values = cells[[getattr(layout, row) for row in own.rows]]
    left = np.ones(cells.shape[1], bool)
    for value, name in own.by_value.items():
        chosen = (values == value).all(axis=0)
        left &= ~chosen
        if chosen.any():
            yield name, None if chosen.all() else chosen
    if left.any() or not left.size:
        yield own.otherwise or options.law, None if left.all() else left


def friction_at_belt_speed(cells: Parameters, options: Options) -> NDArray[np.float64]:
    """Friction coefficient of each cell where the mass is at rest, and the slip speed that of the belt."""
    rows = to_kernel(cells, np.inf, options)
    return np.asarray(kernels(options.law).friction(rows, np.abs(rows[layout.BELT])))
