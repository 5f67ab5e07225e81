"""Simulated rigs: records as sensors would make them, of one test or of a whole matrix."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from stickslip import engine
from stickslip.config.grid import build_grid
from stickslip.dataset.build import grid_coordinates
from stickslip.rig.quantities import EXACT, MATERIAL
from stickslip.rig.records.record import make_record
from stickslip.rig.simulate import sensor as sensors
from stickslip.rig.simulate.config import RigConfig
from stickslip.rig.simulate.drive import motion, segments
from stickslip.rig.words import Along, along, name_of
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import MODES, STATUSES
from stickslip.vocabulary.settings import CONDITIONS

Floats = NDArray[np.float64]

_TOGETHER = 4_000_000  # samples of motions that are computed together
_MOST_TOGETHER = 128  # rigs, four times the lanes
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
        return segments(self.rig.drive.profile, self.rig.drive.strokes, cell)

    def name(self, number: int) -> str:
        """What distinguishes a test from the others, in words."""
        return name_of(self._dimensions, number) or self.rig.config.title

    @cached_property
    def _dimensions(self) -> list[Along]:
        points = xr.Dataset(coords=grid_coordinates(self.grid))
        return [along(points, dim) for dim in self.grid.dims]

    def tests(self, numbers: Sequence[int], stop: engine.StopFlag | None = None) -> Iterator[RigTest]:
        """The tests of these numbers, one after the other, by this thread alone."""
        stop = engine.stop_flag() if stop is None else stop
        for together in self._batches(numbers):
            parts = [self.grid[n : n + 1] for n in together]
            cells = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
            drives = [self.drive(self._one(n)) for n in together]
            sensor = self.rig.sensor
            sampling = engine.Sampling(sensor.rate * sensor.oversampling, cells["waiting_time"])
            runs = engine.compute_rigs(cells, drives, sampling, self.options, stop)
            for i, number in enumerate(together):
                exact = {name: float(runs.results[name][i]) for name in EXACT}
                finished = exact["status"] == _REACHED
                record = self._record(number, runs.signals[i], drives[i]) if finished else None
                yield RigTest(number, self.name(number), record, exact)

    @property
    def options(self) -> engine.Options:
        """How the rigs are integrated."""
        config = self.rig.config
        solver, threads = config.solver, config.execution.threads
        return engine.Options(config.friction.law, rtol=solver.rtol, max_steps=solver.max_steps, threads=threads)

    def _one(self, number: int) -> dict[str, float]:
        return {name: float(values[0]) for name, values in self.grid[number : number + 1].items()}

    def _batches(self, numbers: Sequence[int]) -> Iterator[list[int]]:
        """Tests that are computed together: as many as their samples allow."""
        batch: list[int] = []
        samples = 0.0
        fine = self.rig.sensor.rate * self.rig.sensor.oversampling
        for number in numbers:
            cell = self._one(number)
            own = (float(self.drive(cell)[:, 0].sum()) - cell["waiting_time"]) * fine
            if batch and (samples + own > _TOGETHER or len(batch) >= _MOST_TOGETHER):
                yield batch
                batch, samples = [], 0.0
            batch.append(number)
            samples += own
        if batch:
            yield batch

    def _record(self, number: int, signals: Mapping[str, Floats], drive: Floats) -> xr.Dataset:
        """What the sensors show of a motion, from the first stroke on."""
        cell, sensor = self._one(number), self.rig.sensor
        acceleration = sensors.accelerations(signals["velocity"], sensor)
        spring = cell["stiffness"] * sensors.midway(signals["displacement"])
        damper = cell["damping"] * sensors.midway(signals["velocity"])
        friction = cell["mass"] * acceleration + damper + spring
        time = sensors.times(signals["velocity"].size, sensor)
        noise = np.random.default_rng([sensor.seed, number])
        speed, way = motion(drive, time + cell["waiting_time"])
        # Through the same sensor, so that a stick ends where the force shows its end.
        sticks = sensors.seen((signals["mode"][1:] == MODES.index("stick")).astype(np.float64), sensor) > 0.5
        found = {
            "spring_force": sensors.noisy(sensors.seen(spring, sensor), sensor.force_noise, noise),
            "friction_force": sensors.seen(friction, sensor),
            "acceleration": sensors.noisy(sensors.seen(acceleration, sensor), sensor.acceleration_noise, noise),
            "drive_velocity": speed,
            "drive_displacement": way,
            "stick": sticks,
        }
        conditions: dict[str, float | str] = {name: cell[name] for name in CONDITIONS if name in cell}
        conditions |= {"drive_speed": cell["belt_speed"], MATERIAL: self._material(number)}
        return make_record(time, found, conditions).assign_attrs(title=self.name(number))

    def _material(self, number: int) -> str:
        """The name of the material: that of the point on a labelled axis, the title where there is none."""
        for dim, i in self._point(number).items():
            along = [c for c in self.grid.coords if c.dim == dim]
            if along[0].labels is not None and along[0].name != dim.removesuffix("_case"):
                return along[0].labels[i]
        return self.rig.config.title

    def _point(self, number: int) -> dict[str, int]:
        """Where on each dimension a test lies."""
        at = np.unravel_index(number, self.grid.shape) if self.grid.shape else ()
        return {dim: int(i) for dim, i in zip(self.grid.dims, at, strict=True)}
