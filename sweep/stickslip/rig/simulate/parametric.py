"""A simulated rig as a function of its parameters, for `identify`."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.model import Config
from stickslip.errors import NotReachedError
from stickslip.rig.simulate.config import RigConfig, make_rig
from stickslip.rig.simulate.identify import Parameters, Simulator
from stickslip.rig.simulate.simulation import RigTests
from stickslip.vocabulary.flags import STATUS_MESSAGES, STATUSES
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.suggest import listed


def simulator(rig: RigConfig, names: Sequence[str], number: int = 0) -> Simulator:
    """The record of one test of a rig as a function of the quantities `names`, in SI.

    number : of the test, whose other quantities stay as they are. Noise is that of the configuration, the same in every
    record; where the measured record is simulated too, give the two different seeds. Raises ValueError for names of
    nothing that the configuration gives. What it returns raises ConfigError for quantities that do not fit together,
    and NotReachedError for a test that is not integrated to its end.
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
