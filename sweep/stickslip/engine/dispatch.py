"""Cells through the kernels: from SI to kernel units, to the kernels that suit them, and back.

Units by the scales of a cell (`vocabulary/scales.py`) and by its model. Some cells of a law may have kernels of their
own, which take a tenth of the time. Which kernels compute a cell depends on that cell alone, so its numbers do not
depend on its neighbours. `friction_at_belt_speed` is the friction curve itself, as the kernels have it.
"""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from stickslip.engine.compiled import kernels
from stickslip.engine.compiling import ship
from stickslip.engine.options import Options, Results, StopFlag, columns
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.models import LAWS, MODELS, PREFIX, TABLE, OwnKernels, model_of
from stickslip.vocabulary.scales import Scales
from stickslip_kernels import layout, objects
from stickslip_kernels.allocate import NO_STOPS

Floats = NDArray[np.float64]
_ROWS = {name: row for name, row in vars(layout).items() if isinstance(row, int)}


def to_kernel(cells: Parameters, horizon: float, options: Options) -> Floats:
    """Cells in SI to the rows of `layout.py`, shape (CELL_ROWS, n); horizon in s."""
    by = Scales(cells)
    rows = np.zeros((layout.CELL_ROWS, by.mass.size))
    rows[layout.GAMMA] = cells["damping"] / by.impedance
    rows[layout.BELT] = cells["belt_speed"] / by.speed
    rows[layout.XI_START] = cells["displacement"] * by.stiffness / by.load
    rows[layout.ETA_START] = cells["velocity"] / by.speed
    rows[layout.CONTACT_START] = cells["contact_time"] * by.rate
    rows[layout.HORIZON] = horizon * by.rate
    for name, values in model_of(options.law).to_kernel(cells, by).items():
        rows[_ROWS[name]] = values
    return rows


_Conversion = Callable[[Floats, Scales], Floats]
_CONVERSIONS: dict[str, _Conversion] = {  # what all cells have; the models have the rest
    "regime": lambda rows, by: rows[layout.REGIME],
    "status": lambda rows, by: rows[layout.STATUS],
    "breakaway_time": lambda rows, by: rows[layout.BREAKAWAY_TIME] * by.time,
    "restick_time": lambda rows, by: rows[layout.RESTICK_TIME] * by.time,
    "restick_displacement": lambda rows, by: rows[layout.RESTICK_XI] * by.length,
    "restick_margin": lambda rows, by: rows[layout.RESTICK_MARGIN] * by.speed,
    "period": lambda rows, by: rows[layout.PERIOD] * by.time,
    "frequency": lambda rows, by: 1.0 / (rows[layout.PERIOD] * by.time),
    "stick_fraction": lambda rows, by: rows[layout.CYCLE_STICK_TIME] / rows[layout.PERIOD],
    "spring_force_max": lambda rows, by: rows[layout.XI_MAX] * by.load,
    "spring_force_min": lambda rows, by: rows[layout.XI_MIN] * by.load,
    "slip_speed_max": lambda rows, by: rows[layout.SPEED_MAX] * by.speed,
    "acceleration_max": lambda rows, by: rows[layout.ACCELERATION_MAX] * by.load / by.mass,
    "energy_per_cycle": lambda rows, by: rows[layout.CYCLE_HEAT] * by.load * by.length,
    "equilibrium_crossings": lambda rows, by: rows[layout.CROSSINGS],
    "settling_time": lambda rows, by: rows[layout.SETTLING_TIME] * by.time,
    "settled_displacement": lambda rows, by: rows[layout.XI_SETTLED] * by.length,
    "displacement_amplitude": lambda rows, by: (
        0.5 * (rows[layout.CYCLE_XI_MAX] - rows[layout.CYCLE_XI_MIN]) * by.length
    ),
    "velocity_amplitude": lambda rows, by: 0.5 * rows[layout.CYCLE_SPEED_RANGE] * by.speed,
    "cycle_force_max": lambda rows, by: rows[layout.CYCLE_XI_MAX] * by.load,
    "cycle_force_min": lambda rows, by: rows[layout.CYCLE_XI_MIN] * by.load,
    "damping_ratio": lambda rows, by: rows[layout.DAMPING_RATIO],
    "steps": lambda rows, by: rows[layout.STEPS],
    "sticks": lambda rows, by: rows[layout.STICKS],
    "stick_time": lambda rows, by: rows[layout.STICK_TIME] * by.time,
    "displacement_end": lambda rows, by: rows[layout.XI_END] * by.length,
    "velocity_end": lambda rows, by: rows[layout.ETA_END] * by.speed,
}


def to_si(rows: Floats, cells: Parameters, options: Options) -> Results:
    """The rows `run_block` filled to the variables people know: those that the options keep, in their order."""
    by, own = Scales(cells), model_of(options.law).conversions(options.law)
    return {
        name: own[name](lambda row: rows[_ROWS[row]], by) if name in own else _CONVERSIONS[name](rows, by)
        for name in columns(options)
    }


def by_theory(name: str, cells: Parameters, options: Options) -> Floats:
    """A result of the model that linear theory knows: no cell is computed."""

    def no_row(row: str) -> Floats:
        raise KeyError(f"{name} needs {row} of cells that are computed")

    return np.asarray(model_of(options.law).conversions(options.law)[name](no_row, Scales(cells)))


def signals_to_si(signals: Floats, cells: Parameters, columns: Floats) -> Results:
    """Signals on steady belts, in SI, by names of `TRACE_VARIABLES`.

    cells, columns : of each sample, in SI and in kernel units; those of a single cell serve all samples.
    """
    by = Scales(cells)
    xi, eta, friction, mode = signals
    force, relative = xi * by.load, (columns[layout.BELT] - eta) * by.load / by.impedance
    accelerating = (mode != layout.STICK) & (mode != layout.HOLD)
    return {
        "displacement": force / by.stiffness,
        "velocity": cells["belt_speed"] - relative,
        "relative_speed": relative,
        "friction_coefficient": friction,
        "spring_force": force,
        "acceleration": np.where(accelerating, friction - xi - columns[layout.GAMMA] * eta, 0.0) * by.load / by.mass,
        "mode": mode,
    }


# --- kernels ----------------------------------------------------------------------------------------------------------


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


def friction_at_belt_speed(cells: Parameters, options: Options) -> Floats:
    """Friction coefficient of each cell where the mass is at rest, and the slip speed that of the belt."""
    rows = to_kernel(cells, np.inf, options)
    return np.asarray(kernels(options.law).friction(rows, np.abs(rows[layout.BELT])))
