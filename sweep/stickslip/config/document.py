"""The steps between reading a document and checking it: what its words, and the files of points it names, stand for.

    observed: [...]              explain: {observed: [...]}
    prior: {mass: 100 g}         system: {mass: 100 g}
    prior: {a1: {uniform: ...}}  uncertain: {quantities: {a1: {uniform: ...}}}
    prior: {laws: [...]}         explain: {laws: [...]}, and friction: {law: ...} of the first
    predict: {axes: ...}         axes: ...

so that priors are read, checked and drawn as all uncertain quantities are. Places in the file stay what they were. A
measured table takes the place of the coefficients of a curve; points are fitted by one, or by several.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import reduce
from operator import getitem
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.config.checks import varied_paths
from stickslip.config.examples import points_path
from stickslip.config.problems import ProblemCollector
from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, FitWarning, Path, Place, QuantityError, UnitWarning
from stickslip.vocabulary.models import CURVE, PREFIX, own_law
from stickslip.vocabulary.own_laws import Table, fault_of_points
from stickslip.vocabulary.parameter import Parameter
from stickslip.vocabulary.quantities import MEASURED, QUANTITIES
from stickslip.vocabulary.settings import CURVE_COLUMNS, EXPLAIN, OF_PRIOR, law_of
from stickslip.vocabulary.suggest import listed

if TYPE_CHECKING:
    from stickslip.fit import MaterialFit

OWN_WORDS = ("observed", "prior", "predict", *EXPLAIN)  # at the top of a file of observations
LAWS_FITTED = ("stribeck",)  # whose curves are fitted to points
AXIS = "material"  # the axis of several fits, unless they are in a group (zip) that has a name
FORMS = "a CSV file of slip speeds and friction, {file: FILE.csv, monotone: true}, or {speed: [...], mu: [...]}"
_AT: Path = ("friction", "table")
_KEYS = ("file", "speed", "mu", "monotone")


def _named_file(document: Document, name: str) -> FilePath:
    """A file of points beside the configuration, or the one of the package that is called so."""
    beside, shipped = FilePath(document.name).parent / name, points_path(name)
    return beside if beside.exists() or not shipped.exists() else shipped


# --- observations -----------------------------------------------------------------------------------------------------


def with_observations(document: Document) -> Document:
    """The document of a configuration that a file of observations stands for; any other as it is.

    Raises ConfigError for what has no place in one.
    """
    data = document.data
    if not isinstance(data, dict) or not {"observed", "prior"} & data.keys():
        return document
    _check_words(document)
    whole: dict[str, Any] = {key: value for key, value in data.items() if key not in OWN_WORDS}
    before: tuple[dict[Path, Any], ...] = (document.keys, document.values, document.texts)
    after = [{p: place for p, place in places.items() if not p or p[0] not in OWN_WORDS} for places in before]
    moves = list(_moves(data))
    for old, new in moves:
        inside: Any = whole
        for key in new[:-1]:
            inside = inside.setdefault(key, {})
        inside[new[-1]] = reduce(getitem, old, data)
        for places, moved in zip(before, after, strict=True):
            moved |= {(*new, *p[len(old) :]): place for p, place in places.items() if p[: len(old)] == old}
            for length in range(1, len(new)) if old[:1] in places else ():  # one word stands for several sections
                moved.setdefault(new[:length], places[old[:1]])
    laws = whole["explain"].get("laws")
    first = laws[0] if isinstance(laws, list) and laws else laws
    if isinstance(first, str):
        whole.setdefault("friction", {}).setdefault("law", law_of(first)[0])
    keys, values, texts = after
    return replace(document, data=whole, keys=keys, values=values, texts=texts, moved={new: old for old, new in moves})


def _check_words(document: Document) -> None:
    """Raise ConfigError for what is wrong with the words themselves."""
    data, problems = document.data, ProblemCollector(document)
    if not isinstance(data.get("observed"), list) or not data["observed"]:
        example = "observed: [{belt_speed: 20 mm/s, normal_load: 10 N, regime: stick_slip}]"
        problems.add(("observed",), "no observation, expected a list of what was seen", example, at_key=True)
    if "prior" not in data:
        problems.add(("prior",), "missing, expected what is known before: values and distributions of quantities")
    prior = problems.mapping(data.get("prior"), ("prior",), "quantities")
    problems.known_keys(prior, ("prior",), (*QUANTITIES, *OF_PRIOR, "laws"))
    problems.keys_of(data.get("predict"), ("predict",), ("axes", "draws"))
    for key in {"uncertain", "axes", "explain"} & data.keys():
        problems.add((key,), "got it besides observed and prior, expected one of them", at_key=True)
    problems.raise_any()


def _moves(data: dict[str, Any]) -> Iterator[tuple[Path, Path]]:
    """Where things stand in a file of observations, and where in a configuration."""
    for key in ("observed", *EXPLAIN):
        if key in data:
            yield (key,), ("explain", key)
    for name, value in data["prior"].items():
        if name == "laws":
            yield ("prior", name), ("explain", name)
        elif name in OF_PRIOR:
            yield ("prior", name), ("uncertain", name)
        elif isinstance(value, dict):
            yield ("prior", name), ("uncertain", "quantities", name)
        else:
            yield ("prior", name), (QUANTITIES[name].section, name)
    for name in data.get("predict", {}):
        yield ("predict", name), ("axes",) if name == "axes" else ("explain", name)


# --- tables -----------------------------------------------------------------------------------------------------------


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
            table = _of_file(_named_file(document, str(file)), str(file), monotone)
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
    for value in values:
        try:
            numbers.append(row.read(value))
        except QuantityError as error:
            raise ValueError(f"{row.name}: got {value!r}, {error}") from None
    return numbers


def _of_file(path: FilePath, name: str, monotone: bool) -> Table:
    """The table of a file, called by this name. Raises ConfigError."""
    from stickslip.fit.points import read_points

    points = read_points(path, CURVE_COLUMNS)
    if caution := points.caution():
        warnings.warn(f"{name}: {caution}", UnitWarning, stacklevel=7)
    if fault := fault_of_points(points["speed"], points["mu"]):
        number, message = fault
        place = None if number is None else Place(points.lines[number], 1)
        hint = "a table is taken as it is: put the points in order and average those at one speed, or fit a curve"
        raise ConfigError.of(path, message, hint, place=place)
    return Table(points["speed"], points["mu"], monotone)


# --- fits -------------------------------------------------------------------------------------------------------------


def with_fits(document: Document) -> Document:
    """The document, its curves with the coefficients fitted to the points that it names.

    One curve is known (section friction), or as uncertain as the points leave it (section uncertain). Several, of a
    list of files or a table of several materials, are an axis with the materials as labels, or part of a group (zip).

    Where a curve is given beside the name of the points it came from (a resolved configuration), and nothing is
    read. What is wrong with the section is left to whoever checks it. Raises ConfigError for wrong points, and warns
    of a fit that they do not support.
    """
    data = document.data if isinstance(document.data, dict) else {}
    friction, axes, uncertain = data.get("friction", {}), data.get("axes") or {}, data.get("uncertain") or {}
    if not isinstance(friction, dict) or friction.get("law", "stribeck") not in LAWS_FITTED:
        return document
    axes = axes if isinstance(axes, dict) else {}
    given = {*friction, *(str(path[-1]) for path in varied_paths(axes))}
    if {*CURVE, *MEASURED} & given:
        return document
    for name, axis in axes.items():
        group = axis.get("zip") if isinstance(axis, dict) else None
        if isinstance(group, dict) and (files := _files(group)):
            return replace(document, data={**data, "axes": {**axes, name: _in_group(axis, _fits(document, files))}})
    if files := _files(friction):
        return _in_section(document, data, friction, files)
    if isinstance(uncertain, dict) and len(files := _files(uncertain)) == 1:
        return _scattered(document, data, uncertain, files[0])
    return document


def _files(section: dict[str, Any]) -> list[str]:
    """The files of points that a section names; none if what it says is wrong."""
    fit = section.get("fit")
    names = fit if isinstance(fit, list) else [fit]
    right = all(isinstance(name, str) and name.lower().endswith(".csv") for name in names)
    return [str(name) for name in names] if right else []


def _fits(document: Document, files: list[str]) -> list[MaterialFit]:
    """The fits of files beside the configuration, or of those that come with the package."""
    from stickslip.fit import fit_materials  # SciPy takes its time

    fits = fit_materials([_named_file(document, name) for name in files], columns=CURVE_COLUMNS)
    for fit in fits:
        if fit.curve is not None and not fit.curve.good:
            name = files[0] if len(fits) == 1 else fit.name
            warnings.warn(f"{name}: {fit.curve.quality}", FitWarning, stacklevel=6)
    return fits


def _in_section(document: Document, data: dict[str, Any], friction: dict[str, Any], files: list[str]) -> Document:
    """One curve for all cells, or an axis of several, the outermost."""
    fits = _fits(document, files)
    if len(fits) == 1 and not isinstance(friction["fit"], list):
        return replace(document, data={**data, "friction": {**friction, **_coefficients(fits[0])}})
    axes = data.get("axes") or {}
    if not isinstance(axes, dict):
        return document  # the reader says what is wrong with it
    if AXIS in axes:
        message = f"these fits are an axis called {AXIS}, and there is another of this name"
        hint = f"call that one otherwise, or put the fits into it: {AXIS}: {{zip: {{fit: [...]}}}}"
        raise document.refused(("friction", "fit"), message, hint)
    return replace(document, data={**data, "axes": {AXIS: _in_group({"zip": {}}, fits), **axes}})


def _in_group(axis: dict[str, Any], fits: list[MaterialFit]) -> dict[str, Any]:
    """A group with the coefficients of several curves in place of `fit`, whose labels they are unless it has some."""
    curves = [_coefficients(fit) for fit in fits]
    names = dict.fromkeys(name for curve in curves for name in curve)
    columns = {name: [curve.get(name, "none") for curve in curves] for name in names}
    others = {key: value for key, value in axis["zip"].items() if key != "fit"}
    return {"labels": [fit.name for fit in fits]} | axis | {"zip": columns | others}


def _coefficients(fit: MaterialFit) -> dict[str, float]:
    assert fit.curve is not None
    return fit.curve.coefficients()


def _scattered(document: Document, data: dict[str, Any], uncertain: dict[str, Any], file: str) -> Document:
    """The document with the coefficients as normal quantities, correlated as the fit says; those it assumed are fixed.

    What the section says of their truncation stays.
    """
    quantities = uncertain.get("quantities") or {}
    if not isinstance(quantities, dict) or any(
        isinstance(own := quantities.get(name, {}), dict) and set(own) - {"truncated"} for name in CURVE
    ):
        return document  # given already, or wrong
    fits = _fits(document, [file])
    fit = fits[0].curve
    if fit is None or len(fits) > 1:
        several = listed([one.name for one in fits], "and")
        message = f"{file} holds {len(fits)} materials ({several}), expected one"
        raise document.refused(("uncertain", "fit"), message, "write a file for each")
    variance = np.diag(fit.covariance)
    if unknown := [name for name, one in zip(CURVE, variance, strict=True) if not np.isfinite(one)]:
        message = f"the points of {file} do not determine {listed(unknown, 'and')}"
        hint = f"measure more points where it matters, or give {CURVE.level} to {CURVE.decay} distributions of your own"
        raise document.refused(("uncertain", "fit"), message, hint)
    known, free = fit.coefficients(), np.flatnonzero(variance > 0)
    names, std = [CURVE[i] for i in free], np.sqrt(variance[free])
    matrix = fit.covariance[np.ix_(free, free)] / np.outer(std, std)
    np.fill_diagonal(matrix, 1.0)
    drawn = {
        name: {"normal": {"mean": known[name], "std": float(one)}, **(quantities.get(name) or {})}
        for name, one in zip(names, std, strict=True)
    }
    own = uncertain.get("correlation")
    blocks = [*(own if isinstance(own, list) else [own] if own is not None else [])]
    if len(names) > 1:
        blocks.append({"between": names, "matrix": matrix.tolist()})
    section = {**uncertain, "quantities": {**quantities, **drawn}} | ({"correlation": blocks} if blocks else {})
    fixed = {name: value for name, value in known.items() if name not in names}
    return replace(document, data={**data, "friction": {**data.get("friction", {}), **fixed}, "uncertain": section})
