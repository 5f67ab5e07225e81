"""The step between reading a document and checking it: curves fitted to the points it names."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

from stickslip.config.yaml import Document
from stickslip.errors import FitWarning
from stickslip.vocabulary.quantities import MEASURED, REPLACED

COEFFICIENTS = (*REPLACED, "a4")


def fitted(document: Document) -> Document:
    """The document, its section friction with the coefficients fitted to the points that it names.

    Where a curve is given beside the name of the points it came from (a resolved configuration), and nothing is
    read. What is wrong with the section is left to whoever checks it. Raises ConfigError for wrong points, and warns
    of a fit that they do not support.
    """
    data = document.data if isinstance(document.data, dict) else {}
    friction, axes = data.get("friction"), data.get("axes") or ()
    if not isinstance(friction, dict) or friction.get("law", "stribeck") != "stribeck":
        return document
    points = friction.get("fit")
    if not isinstance(points, str) or not points.lower().endswith(".csv"):
        return document
    if {*COEFFICIENTS, *MEASURED} & {*friction, *(axes if isinstance(axes, dict) else ())}:
        return document
    from stickslip.fit import fit_file  # SciPy takes its time

    fit = fit_file(Path(document.name).parent / points)
    if not fit.good:
        warnings.warn(f"{points}: {fit.quality}", FitWarning, stacklevel=4)
    return replace(document, data={**data, "friction": {**friction, **fit.coefficients()}})
