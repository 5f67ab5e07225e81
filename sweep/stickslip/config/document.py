"""The step between reading a document and checking it in which a table of points takes the place of coefficients."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from math import nan
from typing import TYPE_CHECKING, Any

from stickslip.config.checks import varied_paths
from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, Path, QuantityError
from stickslip.vocabulary.cell_values import scales_of
from stickslip.vocabulary.models import PREFIX, own_law
from stickslip.vocabulary.own_laws import Table
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import QUANTITIES
from stickslip.vocabulary.settings import CURVE_COLUMNS
from stickslip.vocabulary.units import each_with_unit

if TYPE_CHECKING:
    pass

LAWS_FITTED = ("stribeck",)  # whose curves are fitted to points
FORMS = "a CSV file of slip speeds and friction, {file: FILE.csv, monotone: true}, or {speed: [...], mu: [...]}"
_AT: Path = ("friction", "table")
_KEYS = ("file", "speed", "mu", "monotone")


# --- damping ----------------------------------------------------------------------------------------------------------

_SHARE = re.compile(r"\s*([-+0-9.eE]+)\s*%(\s*of critical)?\s*")


def with_damping(document: Document) -> Document:
    """The document with a damping in percent of critical damping, 2 sqrt(k m), in N s/m.

    Raises ConfigError where mass or stiffness is not one value beside it.
    """
    data = document.data
    system = data.get("system") if isinstance(data, dict) else None
    written = system.get("damping") if isinstance(system, dict) else None
    share = _SHARE.fullmatch(written) if isinstance(written, str) else None
    if share is None or not isinstance(system, dict):
        return document
    try:
        own = [name for name in system if name in QUANTITIES and name != "damping"]
        by = scales_of({name: QUANTITIES[name].read(system[name]) for name in own})
        damping = float(share[1]) / 100.0 * float(by.critical_damping)
    except ValueError:  # QuantityError is one
        damping = nan
    if not damping >= 0.0:
        text = f"got {written!r}, a share of critical damping, expected one mass and one stiffness beside it"
        raise document.refused(("system", "damping"), text, "or write the damping in N s/m")
    return replace(document, data={**data, "system": {**system, "damping": f"{damping!r} N s/m"}})


def with_table(document: Document) -> Document:
    """The document, with the points of the table that it names, the law they make, and its coefficients where none are
    given. Raises ConfigError for points that are no curve.
    """
    data = document.data if isinstance(document.data, dict) else {}
    friction = data.get("friction")
    if not isinstance(friction, dict):
        return document
    law, given = friction.get("law"), friction.get("table")
    if given is None:
        known = own_law(law) if isinstance(law, str) else None
        if not isinstance(known, Table):
            return document
        given = known.points()
    table, kept = _table(document, given)
    if law not in (None, table, f"{PREFIX}{table}"):  # behind bristles, in a resolved configuration
        raise document.refused(("friction", "law"), f"got {law} besides a table, expected none: the table is the law")
    if friction.get("fit") is not None:
        raise document.refused(("friction", "fit"), "got fit besides a table, expected one of them")
    axes, uncertain = data.get("axes"), data.get("uncertain")
    scattered = uncertain.get("quantities") if isinstance(uncertain, dict) else None
    elsewhere = {str(path[-1]) for path in varied_paths(axes if isinstance(axes, dict) else {})}
    elsewhere |= set(scattered) if isinstance(scattered, dict) else set()
    own = {name: value for name, value in table.coefficients.items() if name not in elsewhere}
    return replace(document, data={**data, "friction": {**own, **friction, "law": str(table), "table": kept}})


def _table(document: Document, given: Any) -> tuple[Table, dict[str, Any]]:
    """The table, and what a resolved configuration says of it."""
    plain = {"file": given} if isinstance(given, str) else given
    if not isinstance(plain, Mapping) or not {"file"} <= plain.keys() and not {"speed", "mu"} <= plain.keys():
        raise document.refused(_AT, f"got {given!r}, expected {FORMS}")
    if unknown := [key for key in plain if key not in _KEYS]:
        raise document.refused((*_AT, unknown[0]), f"unknown key, expected {', '.join(_KEYS)}")
    file, monotone = plain.get("file"), plain.get("monotone", False)
    if not isinstance(monotone, bool):
        raise document.refused((*_AT, "monotone"), f"got {monotone!r}, expected true or false")
    if file is not None and not (isinstance(file, str) and file.lower().endswith(".csv")):
        raise document.refused((*_AT, "file"), f"got {file!r}, expected the name of a CSV file")
    try:
        if "speed" in plain:  # a resolved configuration has them
            speed, mu = (_numbers(row, plain[row.name]) for row in CURVE_COLUMNS[:2])
            table = Table(speed, mu, monotone)
        else:
            raise TypeError(f"nothing here reads {file}, expected {FORMS}")
    except ConfigError:
        raise
    except (TypeError, ValueError) as error:
        raise document.refused(_AT, str(error)) from None
    return table, ({} if file is None else {"file": file}) | table.points()


def _numbers(row: Parameter, values: Any) -> list[float]:
    """The numbers of a list in SI. Raises ValueError."""
    if not isinstance(values, list):
        raise ValueError(f"{row.name}: got {values!r}, expected a list")
    numbers = []
    try:
        values = each_with_unit(values, row.units)
    except QuantityError as error:
        raise ValueError(f"{row.name}: expected {error.expected}") from None
    for value in values:
        try:
            numbers.append(row.read(value))
        except QuantityError as error:
            raise ValueError(f"{row.name}: got {value!r}, {error}") from None
    return numbers
