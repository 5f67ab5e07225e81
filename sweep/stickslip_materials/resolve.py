"""What files of measured points stand for in a configuration: a curve as it is (`friction.table`), or fitted, by one or
by several (`friction.fit`, `uncertain.fit`, `axes.NAME.zip.fit`)."""

from __future__ import annotations

import warnings
from contextlib import suppress
from dataclasses import replace
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.config.resolve import LAWS_FITTED, points_path, varied_paths
from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, FitWarning, Place, UnitWarning
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.own_laws import fault_of_points
from stickslip.vocabulary.quantities import CURVE_COLUMNS, MEASURED, QUANTITIES, listed

if TYPE_CHECKING:
    from stickslip_materials.fit import MaterialFit

AXIS = "material"  # the axis of several fits, unless they are in a group (zip) that has a name


def _named_file(document: Document, name: str) -> FilePath:
    """A file of points beside the configuration, or the one of the package that is called so."""
    beside, shipped = FilePath(document.name).parent / name, points_path(name)
    return beside if beside.exists() or not shipped.exists() else shipped


# --- tables -----------------------------------------------------------------------------------------------------------


def with_points(document: Document) -> Document:
    """The document, with the points of the file that `friction.table` names beside its name. Raises ConfigError.

    Where they are there (a resolved configuration), nothing is read; what is wrong is left to whoever checks it.
    """
    from stickslip_materials.fit.points import read_points

    friction = document.data["friction"]
    given = friction["table"]
    plain = {"file": given} if isinstance(given, str) else given
    name = plain.get("file") if isinstance(plain, dict) else None
    if not (isinstance(name, str) and name.lower().endswith(".csv")) or {"speed", "mu"} & plain.keys():
        return document
    points = read_points(path := _named_file(document, name), CURVE_COLUMNS)
    if caution := points.caution():
        warnings.warn(f"{name}: {caution}", UnitWarning, stacklevel=6)
    if fault := fault_of_points(points["speed"], points["mu"]):
        number, message = fault
        place = None if number is None else Place(points.lines[number], 1)
        hint = "a table is taken as it is: put the points in order and average those at one speed, or fit a curve"
        raise ConfigError.of(path, message, hint, place=place)
    table = plain | {column: points[column].tolist() for column in ("speed", "mu")}
    return replace(document, data={**document.data, "friction": {**friction, "table": table}})


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
    friction, axes, uncertain = (data.get(name) or {} for name in ("friction", "axes", "uncertain"))
    if not isinstance(friction, dict) or friction.get("law", "stribeck") not in LAWS_FITTED:
        return document
    axes = axes if isinstance(axes, dict) else {}
    if {*CURVE, *MEASURED} & {*friction, *(str(path[-1]) for path in varied_paths(axes))}:
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
    from stickslip_materials.fit import fit_materials  # SciPy takes its time

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
        return replace(document, data={**data, "friction": {**friction, **fits[0].coefficients()}})
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
    curves = [fit.coefficients() for fit in fits]
    names = dict.fromkeys(name for curve in curves for name in curve)
    columns = {name: [curve.get(name, "none") for curve in curves] for name in names}
    others = {key: value for key, value in axis["zip"].items() if key != "fit"}
    return {"labels": [fit.name for fit in fits]} | axis | {"zip": columns | others}


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
        several = listed([each.name for each in fits], "and")
        message = f"{file} holds {len(fits)} materials ({several}), expected one"
        raise document.refused(("uncertain", "fit"), message, "write a file for each")
    variance = np.diag(fit.covariance)
    if unknown := [name for name, square in zip(CURVE, variance, strict=True) if not np.isfinite(square)]:
        message = f"the points of {file} do not determine {listed(unknown, 'and')}"
        hint = f"measure more points where it matters, or give {CURVE.level} to {CURVE.decay} distributions of your own"
        raise document.refused(("uncertain", "fit"), message, hint)
    known, free = fit.coefficients(), np.flatnonzero(variance > 0)
    names, std = [CURVE[i] for i in free], np.sqrt(variance[free])
    matrix = fit.covariance[np.ix_(free, free)] / np.outer(std, std)
    np.fill_diagonal(matrix, 1.0)
    drawn = {
        name: {
            "normal": {"mean": row.in_file(known[name]), "std": row.in_file(float(deviation))},
            **(quantities.get(name) or {}),
        }
        for name, deviation in zip(names, std, strict=True)
        if (row := QUANTITIES[name])
    }
    section = {**uncertain, "quantities": {**quantities, **drawn}}
    if len(names) > 1:
        own = uncertain.get("correlation") or {"between": [], "matrix": []}
        with suppress(KeyError, TypeError):  # the reader says what is wrong with it
            others, rows = own["between"], [[*row, *[0.0] * len(names)] for row in own["matrix"]]
            rows += [[*[0.0] * len(others), *row] for row in matrix.tolist()]
            section["correlation"] = {"between": [*others, *names], "matrix": rows}
    fixed = {name: value for name, value in known.items() if name not in names}
    return replace(document, data={**data, "friction": {**data.get("friction", {}), **fixed}, "uncertain": section})
