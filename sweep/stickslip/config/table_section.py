"""The step between reading a document and checking it: a measured table in place of the coefficients of a curve."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from stickslip.config.checks import varied_paths
from stickslip.config.examples import points_path
from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, Place, Problem, QuantityError, UnitWarning
from stickslip.errors import Path as KeyPath
from stickslip.vocabulary.models import own_law
from stickslip.vocabulary.own_laws import Table, fault_of_points
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.settings import CURVE_COLUMNS

FORMS = "a CSV file of slip speeds and friction, {file: FILE.csv, monotone: true}, or {speed: [...], mu: [...]}"
_AT: KeyPath = ("friction", "table")
_KEYS = ("file", "speed", "mu", "monotone")


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
    table, kept = _read(document, given)
    if law not in (None, table):
        raise _refused(document, ("friction", "law"), f"got {law} besides a table, expected none: the table is the law")
    if friction.get("fit") is not None:
        raise _refused(document, ("friction", "fit"), "got fit besides a table, expected one of them")
    axes, uncertain = data.get("axes"), data.get("uncertain")
    scattered = uncertain.get("quantities") if isinstance(uncertain, dict) else None
    elsewhere = {str(path[-1]) for path in varied_paths(axes if isinstance(axes, dict) else {})}
    elsewhere |= set(scattered) if isinstance(scattered, dict) else set()
    own = {name: value for name, value in table.coefficients.items() if name not in elsewhere}
    return replace(document, data={**data, "friction": {**own, **friction, "law": str(table), "table": kept}})


def _read(document: Document, given: Any) -> tuple[Table, dict[str, Any]]:
    """The table, and what a resolved configuration says of it."""
    plain = {"file": given} if isinstance(given, str) else given
    if not isinstance(plain, Mapping) or not {"file"} <= plain.keys() and not {"speed", "mu"} <= plain.keys():
        raise _refused(document, _AT, f"got {given!r}, expected {FORMS}")
    if unknown := [key for key in plain if key not in _KEYS]:
        raise _refused(document, (*_AT, unknown[0]), f"unknown key, expected {', '.join(_KEYS)}")
    file, monotone = plain.get("file"), plain.get("monotone", False)
    if not isinstance(monotone, bool):
        raise _refused(document, (*_AT, "monotone"), f"got {monotone!r}, expected true or false")
    if file is not None and not (isinstance(file, str) and file.lower().endswith(".csv")):
        raise _refused(document, (*_AT, "file"), f"got {file!r}, expected the name of a CSV file")
    try:
        if "speed" in plain:  # a resolved configuration has them
            speed, mu = (_numbers(row, plain[row.name]) for row in CURVE_COLUMNS[:2])
            table = Table(speed, mu, monotone)
        else:
            table = _of_file(Path(document.name).parent, str(file), monotone)
    except ConfigError:
        raise
    except (TypeError, ValueError) as error:
        raise _refused(document, _AT, str(error)) from None
    return table, ({} if file is None else {"file": file}) | table.points()


def _numbers(row: Parameter, values: Any) -> list[float]:
    """The numbers of a list in SI. Raises ValueError."""
    if not isinstance(values, list):
        raise ValueError(f"{row.name}: got {values!r}, expected a list")
    numbers = []
    for value in values:
        try:
            numbers.append(row.read(value))
        except QuantityError as error:
            raise ValueError(f"{row.name}: got {value!r}, {error}") from None
    return numbers


def _of_file(folder: Path, name: str, monotone: bool) -> Table:
    """The table of a file beside the configuration, or of one that comes with the package. Raises ConfigError."""
    from stickslip.fit.points import read_points

    beside, shipped = folder / name, points_path(name)
    path = beside if beside.exists() or not shipped.exists() else shipped
    points = read_points(path, CURVE_COLUMNS)
    if caution := points.caution():
        warnings.warn(f"{name}: {caution}", UnitWarning, stacklevel=7)
    if fault := fault_of_points(points["speed"], points["mu"]):
        number, message = fault
        place = None if number is None else Place(points.lines[number], 1)
        hint = "a table is taken as it is: put the points in order and average those at one speed, or fit a curve"
        raise ConfigError(str(path), [Problem((), message, place, hint)])
    return Table(points["speed"], points["mu"], monotone)


def _refused(document: Document, path: KeyPath, message: str) -> ConfigError:
    return ConfigError(document.name, [Problem(path, message, document.values.get(path))])
