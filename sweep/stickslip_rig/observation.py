"""A record of a rig as an observation of `explain`: its features stroke by stroke, and those of simulated rigs.

The first stroke starts from rest, and the last one ends with the record: both are left out. All others repeat each
other: they tell how features scatter, and of a simulated rig the second one is enough.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from stickslip.config.model import Config, Group, Values
from stickslip.config.sections import Friction
from stickslip.engine import Results, StopFlag
from stickslip.errors import StoppedError
from stickslip.studies.draws import drawn_cells
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.flags import DECIDED, REGIMES
from stickslip.vocabulary.suggest import listed
from stickslip_rig.evaluation import features_of_strokes, strokes_of
from stickslip_rig.quantities import FORCES
from stickslip_rig.records import read_record
from stickslip_rig.sections import sections_of
from stickslip_rig.signals import Floats
from stickslip_rig.simulation import RigTests, load_rig, make_rig
from stickslip_rig.sticks import find_sticks
from stickslip_rig.vocabulary import CONDITIONS

__all__ = ["SimulatedRecords", "observed", "read_record", "rig_of"]  # which are called by the name of this room
# Features that change smoothly with parameters, as counts do not.
COMPARED = ("static_force", "dynamic_force", "drop_mean", "stick_fraction", "acceleration_max", "stick_slip_period")
_ALIKE = 0.01  # relative: conditions of the measured and the simulated test that differ by less are the same
_SLIPS = 3  # of a stroke that sticks and slips, at least: it slips once after the reversal in any case
_SAME = 0.1  # of a stroke: how far the duration of a record may be off
_FEWEST = "4 at least, since the first and the last one do not count; 3 where the scatter is given, scatter: 2 %"
_SIMULATED = 2.1  # strokes: somewhat more than the second, since stick phases are not seen well where a record ends
_WHOLE = 3
_OVERSAMPLING = 4  # of simulated rigs; what more would change is far below the scatter of strokes


class Observed(NamedTuple):
    """What a record says. features : of each stroke that counts. regime : what it may have been. known : names of what
    the record has, without which simulated ones are evaluated as well."""

    features: dict[str, list[float]]
    regime: list[str]
    known: list[str]


def rig_of(given: str | Mapping[str, Any], conditions: Mapping[str, float]) -> Config:
    """The configuration of the rig of one test, in a file or a mapping, at these conditions.

    Raises ConfigError, and ValueError for several tests.
    """
    rig = (load_rig(given) if isinstance(given, str) else make_rig(given, "<drive>")).at(**conditions)
    if rig.axes:
        names = [member.name for axis in rig.axes for member in axis.members]
        raise ValueError(f"varies {listed(names, 'and')}, expected one test: say which value beside the record")
    return rig


def observed(record: xr.Dataset, rig: Config, unknown: Collection[str], scatter: bool) -> Observed:
    """What a record says that was made on a rig, some quantities of which are unknown.

    scatter : whether that of its features is given. Raises ValueError for a record of another test.
    """
    _check_conditions(record, rig, unknown)
    drive, _, settings, _ = sections_of(rig)
    time, strokes = record["time"].values, int(drive.strokes)
    whole = RigTests(rig).duration(0)
    if abs(time[-1] - time[0] - whole) > _SAME * whole / strokes:
        raise ValueError(f"lasts {time[-1] - time[0]:.4g} s, and {strokes} strokes of drive {whole:.4g} s, "
                         "expected the same test, from the first stroke on")  # fmt: skip
    if strokes < (3 if scatter else 4):
        raise ValueError(f"has {strokes} strokes, expected {_FEWEST}")
    parts = features_of_strokes(record, time[0] + np.linspace(0.0, whole, strokes + 1)[1:-1], settings)
    if "slips" not in parts:
        raise ValueError("does not show stick phases well enough: `stickslip rig features` says why")
    features = {name: parts[name].tolist() for name in COMPARED
                if name in parts and (parts[name] > 0).all() and (scatter or np.ptp(parts[name]) > 0)}  # fmt: skip
    if not features:
        raise ValueError(f"none of {listed(COMPARED)} is defined in all strokes: `stickslip rig features` says why")
    regime = ["stick_slip"] if _sticks_and_slips(parts) else [name for name in DECIDED if name != "stick_slip"]
    return Observed(features, regime, [str(name) for name in record.variables if name not in ("time", "material")])


def _check_conditions(record: xr.Dataset, rig: Config, unknown: Collection[str]) -> None:
    """Raises ValueError for a condition of the record that the rig has otherwise, unless it is unknown."""
    given = {**rig.fixed(), "drive_speed": rig.fixed()["belt_speed"]}
    for name, row in CONDITIONS.items():
        is_unknown = name in unknown or name == "drive_speed" and "belt_speed" in unknown
        if is_unknown or name not in record.coords or name not in given:
            continue
        if abs(float(record[name]) - given[name]) > _ALIKE * abs(given[name]):
            unit = units.spelled(row.units)
            there = f"{given[name]:g} {unit} in drive"
            raise ValueError(f"{name} is {float(record[name]):g} {unit}, and {there}, expected the same test")


def _sticks_and_slips(parts: Mapping[str, Floats]) -> bool:
    return bool(np.median(parts["slips"]) >= _SLIPS)


class _Draws(RigTests):
    """Tests with the same noise, of which the sensors record what there is of the measured one."""

    def __init__(self, config: Config, known: frozenset[str]) -> None:
        super().__init__(config)
        self.recorded = {*known, *(() if known & {*FORCES} else FORCES)}

    def stroke(self, number: int) -> float:
        """How long a stroke takes, s."""
        return float(super().segments(number)[:, 0].sum() - self._cell(number)["waiting_time"]) / _WHOLE

    def segments(self, number: int) -> Floats:
        """The drive up to somewhat after the second stroke."""
        whole = super().segments(number)
        end = self._cell(number)["waiting_time"] + _SIMULATED * self.stroke(number)
        begins = np.cumsum(whole[:, 0]) - whole[:, 0]
        part = whole[begins < end]
        part[-1, 0] = end - begins[len(part) - 1]
        return part

    def noise(self, number: int) -> np.random.Generator:
        """That of the first."""
        return super().noise(0)


class SimulatedRecords:
    """Records of one test as a function of draws.

    rig : of the test. known : names of what the measured record has. friction : that holds instead of the rig's.
    """

    def __init__(self, rig: Mapping[str, Any], known: Iterable[str], friction: Friction) -> None:
        config = make_rig(rig)
        sections = sections_of(config)
        drive = sections.drive.model_copy(update={"strokes": _WHOLE})
        oversampling = min(_OVERSAMPLING, sections.sensor.oversampling)
        sensor = sections.sensor.model_copy(update={"oversampling": oversampling})
        self._config = config.with_sections(drive=drive, sensor=sensor, friction=friction)
        self._known = frozenset({*known, "stiffness"})  # by which sticks are seen in a short record, too

    def __call__(
        self, drawn: Parameters, stop: StopFlag, moved: Callable[[int], None] | None
    ) -> tuple[Results, np.ndarray[Any, np.dtype[np.bool_]]]:
        """Features and regime of draws, (n,) each, and which are possible. Raises StoppedError."""
        size = next(iter(drawn.values())).size
        members = tuple(Values.model_construct(name=name, values=tuple(v.tolist())) for name, v in drawn.items())
        labels = tuple(map(str, range(size)))
        axis = Group.model_construct(name="draw", members=members, labels=labels)
        tests = _Draws(self._config.without(*drawn).model_copy(update={"axes": (axis,)}), self._known)
        _, possible = drawn_cells(tests.grid, np.arange(size), drawn, tests.options)
        results: Results = {name: np.full(size, np.nan) for name in COMPARED}
        results["regime"] = np.full(size, REGIMES.index("failed"), np.int8)
        for test in tests.tests(np.flatnonzero(possible).tolist(), stop):
            if stop[0]:
                raise StoppedError
            results["regime"][test.number] = REGIMES.index("unresolved")
            if test.record is not None:
                parts = self._evaluated(test.record, tests.stroke(test.number))
                results["regime"][test.number] = REGIMES.index("stick_slip" if _sticks_and_slips(parts) else "damped")
                for name in COMPARED:
                    results[name][test.number] = parts[name][-1]
            if moved:
                moved(1)
        return results, possible

    def _evaluated(self, record: xr.Dataset, stroke: float) -> dict[str, Floats]:
        """The features of the second stroke, of the part of a record that the measured one has as well."""
        settings = sections_of(self._config).features
        needed = () if self._known & {*FORCES} & {*record.variables} else FORCES
        known = record.drop_vars([name for name in record.variables if name not in (*self._known, "time", *needed)])
        sticks = find_sticks(known, settings)
        return strokes_of(sticks, sticks.time[0] + stroke * np.array([1.0, 2.0]), settings)
