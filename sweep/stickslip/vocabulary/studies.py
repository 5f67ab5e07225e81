"""The studies: what may be computed instead of a map of every cell, and where each is declared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip import extensions
from stickslip.extensions import StudyEntry

if TYPE_CHECKING:
    import xarray as xr


# By the key of the section that asks for it, which is the name of the command and the attribute `result` as well.
STUDIES: dict[str, StudyEntry] = {
    "border": StudyEntry("stickslip.studies.border:BorderStudy", "Find where along a parameter the regime changes."),
    "contours": StudyEntry("stickslip.studies.contours:ContourStudy", "Follow the borders of regimes in a plane."),
    "margins": StudyEntry("stickslip.studies.margins:MarginStudy"),
    "attractors": StudyEntry(
        "stickslip.studies.attractors:AttractorStudy", "Find which regimes coexist, and what settles."
    ),
    "ramp": StudyEntry("stickslip.studies.ramp:RampStudy", "Follow attractors up and down a parameter."),
    "refine": StudyEntry("stickslip.studies.refine:RefinedMap"),
    "uncertain": StudyEntry("stickslip.studies.uncertain:SampleStudy"),
} | extensions.brought("studies")
BESIDE = {key: study for study, entry in STUDIES.items() for key in entry.beside}  # sections by key: their study
WITH_UNCERTAIN = tuple(key for key, entry in STUDIES.items() if entry.with_uncertain)  # may stand beside this section

# Results that are no studies, by a variable or a dimension of theirs.
_MARKS = {"time": "trajectory", **extensions.brought("marks")}


def kind_of(ds: xr.Dataset) -> str:
    """The kind of a result: the key of a study, trajectory, comparison, or map."""
    if (kind := ds.attrs.get("result")) in STUDIES:
        return str(kind)
    names = {*map(str, ds.variables), *map(str, ds.dims)}
    return next((kind for mark, kind in _MARKS.items() if mark in names), "map")
