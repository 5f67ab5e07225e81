"""A record of a rig as an observation of `explain`: its features stroke by stroke, and those of simulated rigs.

    observed: [{record: felt.csv, drive: rig.yaml}]

becomes an observation at the conditions of the rig, with the features of the record and all that a simulated one needs.
The first stroke starts from rest, and the last one ends with the record: both are left out. All others repeat each
other: they tell how features scatter, and of a simulated rig the second one is enough.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import xarray as xr

from stickslip.config.model import Config, Group, Values
from stickslip.config.sections import Friction
from stickslip.config.yaml import Document
from stickslip.engine import Results, StopFlag
from stickslip.errors import ConfigError, Path, QuantityError, StoppedError
from stickslip.studies.draws import drawn_cells
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.quantities import DECIDED, QUANTITIES, REGIMES, listed
from stickslip_rig.evaluation import features_of_strokes, strokes_of
from stickslip_rig.quantities import CONDITIONS, FORCES
from stickslip_rig.records import read_record
from stickslip_rig.sections import sections_of
from stickslip_rig.signals import Flags, Floats
from stickslip_rig.simulation import RigTests, load_rig, make_rig
from stickslip_rig.sticks import find_sticks

# Features that change smoothly with parameters, as counts do not.
COMPARED = ("static_force", "dynamic_force", "drop_mean", "stick_fraction", "acceleration_max", "stick_slip_period")
_ALIKE = 0.01  # relative: conditions of the measured and the simulated test that differ by less are the same
_SLIPS = 3  # of a stroke that sticks and slips, at least: it slips once after the reversal in any case
_SAME = 0.1  # of a stroke: how far the duration of a record may be off
_FEWEST = "4 at least, since the first and the last one do not count; 3 where the scatter is given, scatter: 0.02"
_SIMULATED = 2.1  # strokes: somewhat more than the second, since stick phases are not seen well where a record ends
_WHOLE = 3
_OVERSAMPLING = 4  # of simulated rigs; what more would change is far below the scatter of strokes
_EXPLAIN = "explain"
_OF_RIG = ("system", "friction", "start", "drive", "sensor", "features", "solver")  # what a simulated record needs
_FORMS = {"record": (str, "the name of a CSV file: record: felt.csv"),
          "drive": (str | Mapping, "the configuration of the rig: drive: rig.yaml")}  # fmt: skip


# --- between reading a document and checking it -----------------------------------------------------------------------


def with_records(document: Document) -> Document:
    """The document, its observations with the features of the records that they name.

    Where features stand beside the name (a resolved configuration), nothing is read. What is wrong with the section is
    left to whoever checks it. Raises ConfigError for wrong records, and records of other tests.
    """
    data = document.data if isinstance(document.data, dict) else {}
    section, uncertain = data.get(_EXPLAIN), data.get("uncertain")
    observations = section.get("observed") if isinstance(section, dict) else None
    if not isinstance(section, dict) or not isinstance(observations, list):
        return document
    quantities = uncertain.get("quantities") if isinstance(uncertain, dict) else None
    unknown = [*quantities] if isinstance(quantities, dict) else []
    whole = [_whole(document, (_EXPLAIN, "observed", i), given, unknown) if _names_record(given) else given
             for i, given in enumerate(observations)]  # fmt: skip
    return replace(document, data={**data, _EXPLAIN: {**section, "observed": whole}})


def _names_record(given: Any) -> bool:
    return isinstance(given, dict) and bool({"record", "drive"} & given.keys()) and "features" not in given


def _whole(document: Document, path: Path, given: dict[str, Any], unknown: Collection[str]) -> dict[str, Any]:
    """An observation with what its record says. unknown : quantities that are not taken from the rig."""
    for key, (kind, expected) in _FORMS.items():
        if not isinstance(given.get(key), kind):
            what, place = (f"got {given[key]!r}", (*path, key)) if key in given else ("missing", path)
            raise document.refused(place, f"{what}, expected {expected}")
    conditions, key = {}, ""
    try:
        for key in [name for name in given if name in QUANTITIES]:
            conditions[key] = QUANTITIES[key].read(given[key])
        key, drive = "drive", given["drive"]
        rig = load_rig(_beside(document, drive)) if isinstance(drive, str) else make_rig(drive, "<drive>")
        rig = rig.at(**conditions)
        if rig.axes:
            names = [member.name for axis in rig.axes for member in axis.members]
            raise ValueError(f"varies {listed(names, 'and')}, expected one test: say which value beside the record")
        key = "record"
        record = read_record(_beside(document, given["record"]))
        features = observed(record, rig, unknown, bool(given.get("scatter")))
    except ConfigError:
        raise
    except QuantityError as error:
        raise document.refused((*path, key), f"got {given[key]!r}, expected {error.expected}") from None
    except ValueError as error:
        name = given[key] if isinstance(given[key], str) else key
        raise document.refused((*path, key), f"{name}: {error}") from None
    plain = rig.resolved()
    at = {name: value for name, value in plain["system"].items() if name not in unknown}
    return {**at, **features, **given, "drive": {name: plain[name] for name in _OF_RIG}}


def _beside(document: Document, name: str) -> str:
    """A file beside the configuration, or else from the folder that the program runs in."""
    beside = FilePath(document.name).parent / name
    return str(beside if beside.exists() else name)


# --- what a record says -----------------------------------------------------------------------------------------------


def observed(record: xr.Dataset, rig: Config, unknown: Collection[str], scatter: bool) -> dict[str, Any]:
    """What a record says that was made on a rig, some quantities of which are unknown, as the keys of an observation.

    features : of each stroke that counts. regime : what it may have been. known : names of what the record has, without
    which simulated ones are evaluated as well. scatter : whether that of its features is given.

    Raises ValueError for a record of another test.
    """
    _check_conditions(record, rig, unknown)
    drive, _, settings, _ = sections_of(rig)
    time, strokes, whole = record["time"].values, int(drive.strokes), RigTests(rig).duration(0)
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
    known = [str(name) for name in record.variables if name not in ("time", "material")]
    return {"features": features, "regime": regime, "known": known}


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


# --- what simulated rigs say ------------------------------------------------------------------------------------------


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
        self._known = frozenset({*known, "stiffness"})  # by which sticks are seen in a short record, too
        drive, sensor, self._settings, _ = sections_of(config)
        oversampling = min(_OVERSAMPLING, sensor.oversampling)
        self._config = config.with_sections(
            drive=drive.model_copy(update={"strokes": _WHOLE}),
            sensor=sensor.model_copy(update={"oversampling": oversampling}), friction=friction,
        )  # fmt: skip

    def __call__(self, drawn: Parameters, stop: StopFlag, moved: Callable[[int], None] | None) -> tuple[Results, Flags]:
        """Features and regime of draws, (n,) each, and which are possible. Raises StoppedError."""
        size = next(iter(drawn.values())).size
        members = tuple(Values.model_construct(name=name, values=tuple(v.tolist())) for name, v in drawn.items())
        axis = Group.model_construct(name="draw", members=members, labels=tuple(map(str, range(size))))
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
        needed = () if self._known & {*FORCES} & {*record.variables} else FORCES
        known = record.drop_vars([name for name in record.variables if name not in (*self._known, "time", *needed)])
        sticks = find_sticks(known, self._settings)
        return strokes_of(sticks, sticks.time[0] + stroke * np.array([1.0, 2.0]), self._settings)
