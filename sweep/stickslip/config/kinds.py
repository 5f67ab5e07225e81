"""The two kinds of configurations: maps, and tests on a rig, which have a drive. They exclude each other."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from stickslip.config.sections import Drive
from stickslip.config.studies import STUDIES
from stickslip.errors import Path
from stickslip.vocabulary.quantities import DRIVE, QUANTITIES

OF_RIGS = ("drive", "sensor")  # sections

_COMPUTES_MAPS = "without a drive it is a map, which stickslip run computes"


class Misplaced(NamedTuple):
    """Something that does not belong into a configuration of its kind, or is missing there."""

    path: Path
    message: str
    hint: str | None = None


def has(rig: bool, name: str) -> bool:
    """Whether a configuration of a rig, or of a map, may have a section, or a quantity, of this name."""
    return name not in STUDIES if rig else not (name in OF_RIGS or name in DRIVE)


def misplaced(rig: bool, data: Mapping[str, Any]) -> Iterator[Misplaced]:
    """What does not belong into the plain data of a rig, or of a map."""
    axes = data.get("axes")
    varied = varied_paths(axes if isinstance(axes, dict) else {})
    yield from _misplaced_in_rig(data, varied) if rig else _misplaced_in_map(data, varied)


def _misplaced_in_rig(data: Mapping[str, Any], varied: list[Path]) -> Iterator[Misplaced]:
    velocities = [path for path in varied if path[-1] == "velocity"]
    if _given(data, "start", "velocity") not in (None, "sticking"):
        velocities = [("start", "velocity")]
    for path in velocities:
        yield Misplaced(path, "expected none: a rig starts sticking")
    for path, allowed in ((("solver", "horizon"), (None,)), (("solver", "early_stop"), (None, True))):
        if _given(data, *path) not in allowed:
            yield Misplaced(path, "expected none: a test ends with its drive")
    if _given(data, "execution", "dask") is not None:
        yield Misplaced(("execution", "dask"), "expected none: tests are computed by threads of this process")
    if "drive" not in data:
        yield Misplaced(("drive",), "missing, expected what moves the plate: drive: {stroke: 10 mm}", _COMPUTES_MAPS)


def _misplaced_in_map(data: Mapping[str, Any], varied: list[Path]) -> Iterator[Misplaced]:
    for key in OF_RIGS:
        if key in data:
            yield Misplaced((key,), "expected no drive or sensor in a map", "stickslip rig computes rigs")
    for path in varied:
        if path[-1] in DRIVE:
            yield Misplaced(path, f"{path[-1]} belongs to the drive of a rig", "stickslip rig has one")


def _given(data: Mapping[str, Any], section: str, key: str) -> object:
    found = data.get(section)
    return found.get(key) if isinstance(found, dict) else None


def varied_paths(axes: Mapping[str, Any]) -> list[Path]:
    """The positions of the quantities along axes, whether they are right or wrong."""
    paths: list[Path] = []
    for name, axis in axes.items():
        zipped = axis.get("zip") if isinstance(axis, dict) else None
        if isinstance(zipped, dict):
            paths += [("axes", name, "zip", member) for member in zipped if member in QUANTITIES]
        elif name in QUANTITIES:
            paths.append(("axes", name))
    return paths


def ramp_of_no_use(drive: Drive, given: Mapping[str, list[Path]]) -> Iterator[Misplaced]:
    """A ramp that the profile does not have."""
    if drive.profile == "sine" and "ramp" in given and drive.ramp != QUANTITIES["ramp"].default:
        message = "got a ramp with the profile sine, expected none"
        yield Misplaced(given["ramp"][0], message, "the profile trapezoid has one")


def with_ramp(rig: bool, fixed: Mapping[str, float], drive: Drive, is_given: bool) -> dict[str, float]:
    """`fixed` with the ramp that holds where none is mentioned, which must fit into the stroke as well; without a ramp
    where the profile has none."""
    if drive.profile == "sine":
        return {name: value for name, value in fixed.items() if name != "ramp"}
    return dict(fixed) if not rig or is_given else {**fixed, "ramp": float(QUANTITIES["ramp"].default or 0.0)}
