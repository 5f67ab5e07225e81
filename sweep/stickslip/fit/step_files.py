"""Records at steps of speed and load from CSV files, and their points as a CSV file that `stickslip fit` reads.

    time [s]; Drehzahl [U/min]; Reibkraft [N]; Normalkraft [N]        begin [s], end [s], speed [mm/s], load [N]
    0,00;     0;                0,02;          10,1                   0,         60,      5,            10

Left a record, right a plan: what was set, and when. Every column has its unit in brackets; others than these are left
out. Friction is a coefficient or, over the load, a force.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from stickslip.errors import ConfigError, Problem, QuantityError
from stickslip.files.atomic import replaced
from stickslip.files.tables import Table, numbers, read_table
from stickslip.fit.headings import PERCENT, PURE, heading, plain
from stickslip.fit.steps import StepPoints, step_points
from stickslip.fit.uncertainty import Floats
from stickslip.vocabulary import units
from stickslip.vocabulary.column_units import column_unit
from stickslip.vocabulary.suggest import listed

_WORDS = {  # of columns that only records in steps and plans have
    "rotation": ("rpm", "upm", "n", "rotation", "rotational speed", "speed of rotation", "drehzahl"),
    "begin": ("begin", "start", "from", "beginn", "von"), "end": ("end", "stop", "to", "ende", "bis"),
}  # fmt: skip
_KINDS = ("time", "speed", "mu", "friction_force", "force", "load")
_UNITS = {"time": "s", "begin": "s", "end": "s", "speed": "m s-1", "force": "N", "load": "N", "mu": "1"}
_TURNS = {  # rad/s of one; people mean turns by 1/min and Hz
    **dict.fromkeys(("rpm", "upm", "u/min", "1/min", "/min", "min-1", "min^-1", "rev/min", "r/min"), math.pi / 30),
    **dict.fromkeys(("hz", "1/s", "s-1", "s^-1", "rev/s", "u/s", "rps"), 2 * math.pi), "rad/s": 1.0,
}  # fmt: skip
_EXAMPLE = "time [s], speed [mm/s], force [N], load [N]"


def read_steps(
    path: Path, plan: Path | None = None, *, radius: float | None = None, load: float | None = None,
    settle: float | None = None,
) -> StepPoints:  # fmt: skip
    """The points of a record at steps of speed and load; see `step_points`.

    Parameters
    ----------
    path : CSV or .xlsx with a column of time, one of friction or of its force, and, without a plan, one of speed
    plan : a table of steps with columns of begin, end and speed, and of the load if it changes
    radius : of the track, m, where speeds are those of rotation
    load : N, where no column tells it
    settle : as for `step_points`

    Raises
    ------
    ConfigError
        For files that cannot be understood, by line and column.
    """
    record = _columns(path, ("time", "speed", "rotation", "mu", "force", "load"), _EXAMPLE)
    table, time, steps = record.table, record.taken("time"), None
    speed = record.speed(radius) if plan is None else np.full(time.shape, np.nan)
    loads = record.found.get("load", np.full(time.shape, np.nan if load is None else load))
    if plan is not None:
        said = _columns(
            plan, ("begin", "end", "speed", "rotation", "load"), "begin [s], end [s], speed [mm/s], load [N]"
        )
        begins, ends, speeds = said.taken("begin"), said.taken("end"), said.speed(radius)
        if (ends <= begins).any() or (begins[1:] < ends[:-1]).any():
            raise _wrong(said.table, "the steps overlap or are out of order", "each ends before the next one begins")
        steps = [*zip(begins.tolist(), ends.tolist(), strict=True)]
        for i, (a, b) in enumerate(steps):
            speed[(time >= a) & (time < b)] = speeds[i]
            if "load" in said.found:
                loads = np.where((time >= a) & (time < b), said.found["load"][i], loads)
    friction = record.found.get("mu")
    if friction is None:
        force = record.taken("force")
        inside = np.isfinite(speed)
        if not (loads[inside] > 0).all():
            hint = "give --load, or a column of the load, with all values above 0"
            raise _wrong(table, "friction is a force, and the load is not known or not above 0", hint)
        friction = np.divide(force, loads, out=np.zeros_like(force), where=loads > 0)
    try:
        return step_points(time, friction, speed, None if np.isnan(loads).all() else loads, settle=settle, steps=steps)
    except ValueError as error:
        raise _wrong(table, str(error)) from None


def write_points(points: StepPoints, path: Path) -> None:
    """Points as CSV that `stickslip fit` and `stickslip compare` read."""
    head = "speed [mm/s], mu, sigma, load [N], begin [s], end [s], independent values"
    columns = (1000 * points.speed, points.mu, points.sigma, points.load, points.begin, points.end, points.independent)
    with replaced(path) as temporary:
        np.savetxt(
            temporary, np.column_stack(columns), "%.7g", delimiter=", ", header=head, comments="", encoding="utf-8"
        )


class _Columns:
    """The columns of a table by their names, in SI."""

    def __init__(self, table: Table, found: dict[str, Floats]) -> None:
        self.table, self.found = table, found

    def taken(self, name: str) -> Floats:
        """A column. Raises ConfigError where it is not there."""
        if name not in self.found:
            headings = listed([repr(cell.text) for cell in self.table.heading], "and")
            raise _wrong(self.table, f"no column of {name} among {headings}", f"for instance '{_EXAMPLE}'")
        return self.found[name]

    def speed(self, radius: float | None) -> Floats:
        """The slip speed, m/s. Raises ConfigError."""
        if "rotation" not in self.found or "speed" in self.found:
            return self.taken("speed")
        if radius is None:
            raise _wrong(self.table, "the speed is one of rotation", "give the radius of the track: --radius '20 mm'")
        return radius * self.found["rotation"]


def _columns(path: Path, known: tuple[str, ...], example: str) -> _Columns:
    """The columns of a table. Raises ConfigError."""
    table = read_table(path, example, is_heading=lambda names: sum(bool(_kind(name, known)) for name in names) > 1)
    found: dict[str, tuple[int, float]] = {}
    problems = []
    for position, cell in enumerate(table.heading):
        unit = heading(cell.text, _KINDS).unit
        turns = _turns(cell.text)
        name = _kind(cell.text, known)
        if not name:
            continue
        try:
            if name in found:
                raise QuantityError("it once", "remove one of the two columns")
            found[name] = position, _factor(name, unit, turns)
        except QuantityError as error:
            problems.append(Problem((), f"got {cell.text!r}, expected {error.expected}", cell.place, error.hint))
    if problems:
        raise ConfigError(table.name, problems)
    values = numbers(table, [position for position, _ in found.values()])
    return _Columns(table, {name: values[position] * factor for name, (position, factor) in found.items()})


def _kind(text: str, known: tuple[str, ...]) -> str:
    """Which of the known columns a heading is; nothing if none."""
    one = heading(text, _KINDS)
    own = next((name for name, words in _WORDS.items() if plain(one.name) in words), "")
    name = own or ("force" if one.is_force() else "mu" if one.kind == "kinetic" else one.kind)
    name = "rotation" if name == "speed" and one.unit and _turns(text) else name
    return name if name in known else ""


def _turns(text: str) -> float | None:
    """rad/s of the unit of rotation in a heading, which may be all of it."""
    one = heading(text, _KINDS)
    return _TURNS.get((one.unit or one.name).lower().replace(" ", ""))


def _factor(name: str, unit: str, turns: float | None) -> float:
    """What numbers are multiplied with to be in SI. Raises QuantityError."""
    if name == "rotation":
        if turns is None:
            raise QuantityError("the unit of a speed of rotation in brackets", "for instance 'rotation [rpm]'")
        return turns
    if name == "mu":
        if unit not in (*PURE, *PERCENT):
            raise QuantityError("no unit", "a friction coefficient is a pure number")
        return 0.01 if unit in PERCENT else 1.0
    if not unit:
        raise QuantityError("its unit in brackets", f"for instance '{name} [{units.spelled(_UNITS[name])}]'")
    return units.si_value(f"1 {column_unit(unit, _UNITS[name])}", _UNITS[name])


def _wrong(table: Table, message: str, hint: str | None = None) -> ConfigError:
    return ConfigError(table.name, [Problem((), message, hint=hint)])
