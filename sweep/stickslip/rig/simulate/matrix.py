"""A whole test matrix: the features of every test, over the dimensions of the grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from stickslip import engine
from stickslip.dataset.build import grid_coordinates
from stickslip.dataset.provenance import provenance
from stickslip.rig.analysis.table import features, missing_features, rate
from stickslip.rig.quantities import EXACT, FEATURES, PER_PEAK
from stickslip.rig.simulate.config import RigConfig
from stickslip.rig.simulate.simulation import RigTests
from stickslip.vocabulary.flags import FLAGS, STATUSES

Progress = Callable[[int, int], None]

_MOST_TOGETHER = 32  # tests a thread takes at a time, as many as there are lanes


def run_matrix(rig: RigConfig, progress: Progress | None = None) -> xr.Dataset:
    """Features, model RPN and what the integration gives of every test, over the dimensions of the grid.

    The numbers do not depend on the threads. A test that was not integrated to its end has a status that says why, and
    NaN.
    progress : called with (tests done, tests in all), now and then. Ctrl-C leaves with KeyboardInterrupt.
    """
    tests = RigTests(rig)
    size, stop, done = tests.grid.size, engine.stop_flag(), 0
    threads = tests.options.threads or engine.processors()
    together = min(_MOST_TOGETHER, -(-size // threads))
    engine.warm_up(tests.options.law, signals=True)
    rows: list[tuple[xr.Dataset, Mapping[str, float]]] = [None] * size  # type: ignore[list-item]

    def judge(first: int) -> int:
        numbers = range(first, min(first + together, size))
        for test in tests.tests(numbers, stop):
            found = missing_features() if test.record is None else features(test.record, rig.features)
            rows[test.number] = (found, test.exact)
        return len(numbers)

    def count(finished: list[int]) -> None:
        nonlocal done
        done += sum(finished)
        if progress:
            progress(done, size)

    engine.spread(judge, range(0, size, together), threads, stop, count)
    return _dataset(tests, rows)


def _dataset(tests: RigTests, rows: Sequence[tuple[xr.Dataset, Mapping[str, float]]]) -> xr.Dataset:
    """The rows over the grid."""
    grid = tests.grid
    variables: dict[str, Any] = {}
    for name in FEATURES:
        values = np.stack([row[name].values for row, _ in rows])
        dims = (*grid.dims, *(("peak",) if name in PER_PEAK else ()))
        variables[name] = xr.Variable(dims, values.reshape(grid.shape + values.shape[1:]), rows[0][0][name].attrs)
    for name, declared in EXACT.items():
        attributes: dict[str, Any] = {"units": declared.units, "long_name": declared.long_name}
        values = np.array([exact[name] for _, exact in rows]).reshape(grid.shape)
        if name in FLAGS:
            values = values.astype(np.int8)
            attributes |= {"flag_values": np.arange(len(STATUSES), dtype=np.int8), "flag_meanings": " ".join(STATUSES)}
        variables[name] = xr.Variable(grid.dims, values, attributes, {"_FillValue": None} if name in FLAGS else None)
    rig = tests.rig
    attributes = provenance(rig.to_yaml(), title=rig.config.title, action="rig")
    return rate(xr.Dataset(variables, grid_coordinates(grid), attributes), rig.risk)


def as_table(found: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """The first tests of a matrix in one row, along the dimension `record`, whose index are their names."""
    variables = {
        str(name): xr.Variable(("record", *v.dims[v.ndim - 1 :]) if name in PER_PEAK else ("record",), _flat(v, name))
        for name, v in found.data_vars.items()
    }
    whole = xr.Dataset({name: v[: len(names)] for name, v in variables.items()})
    return whole.assign_coords(record=list(names))


def _flat(values: xr.DataArray, name: object) -> Any:
    return values.values.reshape(-1, values.shape[-1]) if name in PER_PEAK else values.values.ravel()
