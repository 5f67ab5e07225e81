"""The load of a test, as remarks and lines above the heading of a table give it."""

from __future__ import annotations

import re

from stickslip.errors import ConfigError, Place, Problem, QuantityError
from stickslip.files.tables import NUMBER, Table
from stickslip.fit.headings import heading
from stickslip.vocabulary import units
from stickslip.vocabulary.column_units import column_unit
from stickslip.vocabulary.quantities import PARAMETERS
from stickslip.vocabulary.suggest import listed


def load_above(table: Table) -> tuple[float, int] | None:
    """The load (N) that a remark or a line above the heading gives, `Prüflast;15;N`, and that line; None if none does.

    Raises ConfigError where several say different loads, or one says it in a way nobody understands.
    """
    found: list[tuple[float, int]] = []
    for line in [*((remark,) for remark in table.remarks), *table.above]:
        words = [cell.text for cell in line if cell.text]
        if not words:
            continue
        text = words[0] if len(words) > 1 else words[0].replace("=", ":")
        name, _, value = (text, "", " ".join(words[1:])) if len(words) > 1 else text.partition(":")
        one = heading(name.strip(" :="))
        if one.kind != "load" or not value.strip():
            continue
        problem = Problem((), f"got {' '.join(words)!r}, expected a load such as '15 N'", line[0].place)
        try:
            if re.match(r"[1-9]\d{0,2}[.,]\d{3}(?!\d)", value.strip()):  # 1.500 N may be 1500 N
                raise QuantityError("a load")
            number, _, unit = value.strip().replace(",", ".").partition(" ")
            load = units.si_value(f"{number} {column_unit(unit.strip(' []()') or one.unit, 'N')}", "N")
        except QuantityError:
            raise ConfigError(table.name, [problem]) from None
        if load <= 0:
            raise ConfigError(table.name, [problem])
        found.append((load, line[0].place.line))
    if len({load for load, _ in found}) > 1:
        message = f"got the loads {listed([f'{load:g} N' for load, _ in found], 'and')}, expected one"
        raise ConfigError(table.name, [Problem((), message, Place(found[1][1], 1))])
    return found[0] if found else None


def newtons(load: float | str) -> float:
    """A load that people give, in N: a number, or a text with a unit. Raises ConfigError."""
    try:
        return PARAMETERS["normal_load"].read(float(load) if NUMBER.fullmatch(str(load)) else load)
    except QuantityError as error:
        message = f"got {load!r}, expected {error.expected}"
        raise ConfigError("--load", [Problem((), message, hint=error.hint)]) from None
