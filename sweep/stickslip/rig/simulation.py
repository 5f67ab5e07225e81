"""Simulated rigs: records of tests as sensors would make them, the features of a matrix of tests, and records as a
function of parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from stickslip import engine
from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.dataset.build import grid_coordinates
from stickslip.dataset.provenance import provenance
from stickslip.errors import NotReachedError
from stickslip.rig import apparatus
from stickslip.rig.config import RigConfig, make_rig
from stickslip.rig.evaluation import features, missing_features, rate
from stickslip.rig.identification import Parameters, Simulator
from stickslip.rig.labels import Dimension, dimension, point_name
from stickslip.rig.quantities import EXACT, FEATURES, MATERIAL
from stickslip.rig.records import make_record
from stickslip.rig.signals import Floats
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import FLAGS, MODES, STATUS_MESSAGES, STATUSES
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.settings import CONDITIONS
from stickslip.vocabulary.suggest import listed

Progress = Callable[[int, int], None]

_SAMPLES = 4_000_000  # of motions that are computed together
_BATCH = 128  # rigs, four times the lanes
_MOST_TOGETHER = 32  # tests a thread takes at a time, as many as there are lanes
_REACHED = STATUSES.index("horizon_reached")


@dataclass(frozen=True)
class RigTest:
    """One rig: its number in the matrix, its name, its record (None if it was not integrated to its end), and
    what the integration itself gives, by names of `EXACT`."""

    number: int
    name: str
    record: xr.Dataset | None
    exact: Mapping[str, float]


@dataclass(frozen=True)
class RigTests:
    """All tests of a configuration, numbered as the cells of its grid."""

    rig: RigConfig

    @cached_property
    def grid(self) -> Cells:
        """The grid of the matrix."""
        return build_grid(self.rig.config)

    def drive(self, cell: Mapping[str, float]) -> Floats:
        """The drive of one test."""
        return apparatus.segments(self.rig.drive.profile, self.rig.drive.strokes, cell)

    def name(self, number: int) -> str:
        """The points that distinguish a test from the others, in words."""
        return point_name(self._dimensions, number) or self.rig.config.title

    @cached_property
    def _dimensions(self) -> list[Dimension]:
        points = xr.Dataset(coords=grid_coordinates(self.grid))
        return [dimension(points, dim) for dim in self.grid.dims]

    def tests(self, numbers: Sequence[int], stop: engine.StopFlag | None = None) -> Iterator[RigTest]:
        """The tests of these numbers, one after the other, by this thread alone."""
        stop = engine.stop_flag() if stop is None else stop
        sensor = self.rig.sensor
        for batch in self._batches(numbers):
            cells = {name: np.array([cell[name] for cell, _ in batch.values()]) for name in self._cell(numbers[0])}
            drives = [drive for _, drive in batch.values()]
            sampling = engine.Sampling(sensor.rate * sensor.oversampling, cells["waiting_time"])
            runs = engine.compute_rigs(cells, drives, sampling, self.options, stop)
            for i, (number, (cell, drive)) in enumerate(batch.items()):
                exact = {name: float(runs.results[name][i]) for name in EXACT}
                finished = exact["status"] == _REACHED
                record = self._record(number, cell, runs.signals[i], drive) if finished else None
                yield RigTest(number, self.name(number), record, exact)

    @property
    def options(self) -> engine.Options:
        """Options of the integration."""
        config = self.rig.config
        solver, threads = config.solver, config.execution.threads
        return engine.Options(config.friction.law, rtol=solver.rtol, max_steps=solver.max_steps, threads=threads)

    def _cell(self, number: int) -> dict[str, float]:
        """The quantities of one test."""
        return {name: float(values[0]) for name, values in self.grid[number : number + 1].items()}

    def _batches(self, numbers: Sequence[int]) -> Iterator[dict[int, tuple[dict[str, float], Floats]]]:
        """Cells and drives of tests that are computed together: as many as their samples allow."""
        batch: dict[int, tuple[dict[str, float], Floats]] = {}
        samples = 0.0
        fine = self.rig.sensor.rate * self.rig.sensor.oversampling
        for number in numbers:
            cell = self._cell(number)
            drive = self.drive(cell)
            own = (float(drive[:, 0].sum()) - cell["waiting_time"]) * fine
            if batch and (samples + own > _SAMPLES or len(batch) >= _BATCH):
                yield batch
                batch, samples = {}, 0.0
            batch[number] = cell, drive
            samples += own
        if batch:
            yield batch

    def _record(
        self, number: int, cell: Mapping[str, float], signals: Mapping[str, Floats], drive: Floats
    ) -> xr.Dataset:
        """The sensors' record of a motion, from the first stroke on."""
        sensor = self.rig.sensor
        acceleration = apparatus.accelerations(signals["velocity"], sensor)
        spring = cell["stiffness"] * apparatus.midway(signals["displacement"])
        damper = cell["damping"] * apparatus.midway(signals["velocity"])
        friction = cell["mass"] * acceleration + damper + spring
        time = apparatus.times(signals["velocity"].size, sensor)
        noise = np.random.default_rng([sensor.seed, number])
        speed, way = apparatus.motion(drive, time + cell["waiting_time"])
        # Through the same sensor, so that a stick ends where the force shows its end.
        sticks = apparatus.sensed((signals["mode"][1:] == MODES.index("stick")).astype(np.float64), sensor) > 0.5
        recorded = {
            "spring_force": apparatus.noisy(apparatus.sensed(spring, sensor), sensor.force_noise, noise),
            "friction_force": apparatus.sensed(friction, sensor),
            "acceleration": apparatus.noisy(apparatus.sensed(acceleration, sensor), sensor.acceleration_noise, noise),
            "drive_velocity": speed,
            "drive_displacement": way,
            "stick": sticks,
        }
        conditions: dict[str, float | str] = {name: cell[name] for name in CONDITIONS if name in cell}
        conditions |= {"drive_speed": cell["belt_speed"], MATERIAL: self._material(number)}
        return make_record(time, recorded, conditions).assign_attrs(title=self.name(number))

    def _material(self, number: int) -> str:
        """The name of the material: that of the point on a labelled axis, the title where there is none."""
        at = np.unravel_index(number, self.grid.shape) if self.grid.shape else ()
        for dim, i in zip(self.grid.dims, at, strict=True):
            first = next(c for c in self.grid.coords if c.dim == dim)
            if first.labels is not None and first.name != dim.removesuffix("_case"):
                return first.labels[int(i)]
        return self.rig.config.title


# --- a whole matrix ---------------------------------------------------------------------------------------------------


def run_matrix(rig: RigConfig, progress: Progress | None = None) -> xr.Dataset:
    """Simulate every test of a rig and evaluate its record.

    The numbers do not depend on the threads. Ctrl-C leaves with KeyboardInterrupt.

    Parameters
    ----------
    rig
        The matrix: `load_rig` or `make_rig`.
    progress
        Called with (tests done, tests in all), now and then.

    Returns
    -------
    Dataset
        Features, model RPN and what the integration gives, over the dimensions of the grid. A test that was not
        integrated to its end has a status that says why, and NaN.
    """
    tests = RigTests(rig)
    size, stop, done = tests.grid.size, engine.stop_flag(), 0
    threads = tests.options.threads or engine.processors()
    together = min(_MOST_TOGETHER, -(-size // threads))
    engine.warm_up(tests.options.law, signals=True)
    rows: list[tuple[xr.Dataset, Mapping[str, float]]] = [None] * size  # type: ignore[list-item]

    def evaluate(first: int) -> int:
        numbers = range(first, min(first + together, size))
        for test in tests.tests(numbers, stop):
            row = missing_features() if test.record is None else features(test.record, rig.features)
            rows[test.number] = (row, test.exact)
        return len(numbers)

    def count(finished: list[int]) -> None:
        nonlocal done
        done += sum(finished)
        if progress:
            progress(done, size)

    engine.spread(evaluate, range(0, size, together), threads, stop, count)
    return _dataset(tests, rows)


def _dataset(tests: RigTests, rows: Sequence[tuple[xr.Dataset, Mapping[str, float]]]) -> xr.Dataset:
    """The rows over the grid."""
    grid, rig = tests.grid, tests.rig
    variables: dict[str, Any] = {}
    for name in FEATURES:
        values = np.stack([row[name].values for row, _ in rows])
        dims = (*grid.dims, *rows[0][0][name].dims)
        variables[name] = xr.Variable(dims, values.reshape(grid.shape + values.shape[1:]), rows[0][0][name].attrs)
    for name, declared in EXACT.items():
        attributes: dict[str, Any] = {"units": declared.units, "long_name": declared.long_name}
        values = np.array([exact[name] for _, exact in rows]).reshape(grid.shape)
        if name in FLAGS:
            values = values.astype(np.int8)
            attributes |= {"flag_values": np.arange(len(STATUSES), dtype=np.int8), "flag_meanings": " ".join(STATUSES)}
        variables[name] = xr.Variable(grid.dims, values, attributes, {"_FillValue": None} if name in FLAGS else None)
    attributes = provenance(rig.to_yaml(), title=rig.config.title, action="rig")
    return rate(xr.Dataset(variables, grid_coordinates(grid), attributes), rig.risk)


def as_table(matrix: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """The first tests of a matrix in one row, along the dimension `record`, whose index are their names."""
    dims = matrix["sticks"].dims
    stacked = matrix.drop_vars(matrix.coords).stack(record=dims, create_index=False) if dims else (
        matrix.drop_vars(matrix.coords).expand_dims("record"))  # fmt: skip
    return stacked.isel(record=slice(len(names))).transpose("record", ...).assign_coords(record=list(names))


# --- a function of parameters -----------------------------------------------------------------------------------------


def simulator(rig: RigConfig, names: Sequence[str], number: int = 0) -> Simulator:
    """Make one test of a rig a function of some quantities, for `identify`.

    Noise is that of the configuration, the same in every record; where the measured record is simulated too, give the
    two different seeds.

    Parameters
    ----------
    rig
        The rig.
    names
        Quantities that the function takes, in SI.
    number
        Of the test, whose other quantities stay as they are.

    Returns
    -------
    function
        From quantities by name to the record. Raises ConfigError for those that do not fit together, and
        NotReachedError for a test that is not integrated to its end.

    Raises
    ------
    ValueError
        For names of nothing that the configuration gives.
    """
    fixed = _one_test(rig.config, number)
    values_of(rig, names, number)

    def simulate(parameters: Parameters) -> xr.Dataset:
        if parameters.keys() != set(names):
            raise ValueError(f"parameters: got {listed(parameters, 'and')}, expected {listed(names, 'and')}")
        data = deepcopy(fixed)
        for name, value in parameters.items():
            data[QUANTITIES[name].section][name] = float(value)
        (test,) = RigTests(make_rig(data, rig.config.title)).tests([0])
        if test.record is None:
            status = STATUSES[int(test.exact["status"])]
            at = ", ".join(f"{name} = {value:.6g}" for name, value in parameters.items())
            raise NotReachedError(f"{at}: {STATUS_MESSAGES[status]}")
        return test.record

    return simulate


def values_of(rig: RigConfig, names: Sequence[str], number: int = 0) -> dict[str, float]:
    """Quantities of one test of a rig, in SI. Raises ValueError for names of nothing that the configuration gives."""
    fixed = _one_test(rig.config, number)
    given = {name: row for name, row in QUANTITIES.items() if name in fixed[row.section]}
    if foreign := [name for name in names if name not in given]:
        raise ValueError(f"names: got {listed(foreign, 'and')}, expected some of {listed(given)}")
    return {name: given[name].read(fixed[given[name].section][name]) for name in names}


def _one_test(config: Config, number: int) -> dict[str, Any]:
    """The configuration of one test, as plain data without axes. Raises IndexError."""
    plain = config.resolved()
    shape = tuple(axis.size for axis in config.axes)
    if not 0 <= number < int(np.prod(shape, dtype=int)):
        raise IndexError(f"test {number} of {int(np.prod(shape, dtype=int))}")
    for axis, i in zip(config.axes, np.unravel_index(number, shape) if shape else (), strict=True):
        for member in axis.members:
            row = QUANTITIES[member.name]
            plain[row.section][row.name] = row.written(float(member.points()[i]))
    return plain | {"axes": {}}
