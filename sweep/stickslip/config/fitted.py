"""The step between reading a document and checking it: curves fitted to the points it names."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.config.yaml import Document
from stickslip.errors import ConfigError, FitWarning, Problem
from stickslip.vocabulary.quantities import MEASURED, REPLACED
from stickslip.vocabulary.words import listed

if TYPE_CHECKING:
    from stickslip.fit import CurveFit

COEFFICIENTS = (*REPLACED, "a4")


def fitted(document: Document) -> Document:
    """The document, its curve with the coefficients fitted to the points that it names: known (section friction), or
    as uncertain as the points leave them (section uncertain).

    Where a curve is given beside the name of the points it came from (a resolved configuration), and nothing is
    read. What is wrong with the section is left to whoever checks it. Raises ConfigError for wrong points, and warns
    of a fit that they do not support.
    """
    data = document.data if isinstance(document.data, dict) else {}
    friction, axes, uncertain = data.get("friction", {}), data.get("axes") or (), data.get("uncertain") or {}
    if not isinstance(friction, dict) or friction.get("law", "stribeck") != "stribeck":
        return document
    given = {*friction, *(axes if isinstance(axes, dict) else ())}
    if {*COEFFICIENTS, *MEASURED} & given:
        return document
    if (points := _points(friction)) is not None:
        return replace(document, data={**data, "friction": {**friction, **_fit(document, points).coefficients()}})
    if isinstance(uncertain, dict) and (points := _points(uncertain)) is not None:
        return _scattered(document, data, uncertain, points)
    return document


def _points(section: dict[str, Any]) -> str | None:
    """The file of points that a section names."""
    points = section.get("fit")
    return points if isinstance(points, str) and points.lower().endswith(".csv") else None


def _fit(document: Document, points: str) -> CurveFit:
    from stickslip.fit import fit_file  # SciPy takes its time

    fit = fit_file(Path(document.name).parent / points)
    if not fit.good:
        warnings.warn(f"{points}: {fit.quality}", FitWarning, stacklevel=5)
    return fit


def _scattered(document: Document, data: dict[str, Any], uncertain: dict[str, Any], points: str) -> Document:
    """The document with a1 to a4 as normal quantities that are correlated as the fit says; those it assumed are fixed.

    What the section says of their truncation stays.
    """
    quantities = uncertain.get("quantities") or {}
    if not isinstance(quantities, dict) or any(
        isinstance(own := quantities.get(name, {}), dict) and set(own) - {"truncated"} for name in COEFFICIENTS
    ):
        return document  # given already, or wrong
    fit = _fit(document, points)
    variance = np.diag(fit.covariance)
    if unknown := [name for name, one in zip(COEFFICIENTS, variance, strict=True) if not np.isfinite(one)]:
        message = f"the points of {points} do not determine {listed(unknown, 'and')}"
        path = ("uncertain", "fit")
        hint = "measure more points where it matters, or give a1 to a4 distributions of your own"
        raise ConfigError(document.name, [Problem(path, message, document.values.get(path), hint)])
    known = fit.coefficients()
    free = [i for i, one in enumerate(variance) if one > 0]
    names = [COEFFICIENTS[i] for i in free]
    std = np.sqrt(variance[free])
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
    fixed = {name: known[name] for name in COEFFICIENTS if name not in names}
    return replace(document, data={**data, "friction": {**data.get("friction", {}), **fixed}, "uncertain": section})
