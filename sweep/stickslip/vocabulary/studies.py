"""The studies: what may be computed instead of a map of every cell, and where each is declared."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import xarray as xr


class Entry(NamedTuple):
    """A row of `STUDIES`.

    place : file and class in the room `studies`. command : what the command of this name does, where there is one.
    """

    place: str
    command: str = ""


# By the key of the section that asks for it, which is the name of the command and the attribute `result` as well.
STUDIES: dict[str, Entry] = {
    "border": Entry("borders.border:BorderStudy", "Find where along a parameter the regime changes."),
    "contours": Entry("borders.contours:ContourStudy", "Follow the borders of regimes in a plane."),
    "margins": Entry("margins.margins:MarginStudy"),
    "goal": Entry("goal.study:GoalStudy", "Find the region in which a part is quiet over a range."),
    "attractors": Entry("attractors.study:AttractorStudy", "Find which regimes coexist, and what settles."),
    "ramp": Entry("attractors.ramp:RampStudy", "Follow attractors up and down a parameter."),
    "refine": Entry("refinement.study:RefinedMap"),
    "uncertain": Entry("uncertainty.sampling:SampleStudy"),
    "explain": Entry("explain.study:ExplainStudy"),
}
EXPLAIN = "explain"  # whose quantities are those of the section `uncertain`
RECORDS = "stickslip.rig.observation"  # how a record of a rig is an observation of it
WITH_UNCERTAIN = (EXPLAIN, "goal")  # that may stand beside this section

# Results that are no studies, by a variable or a dimension of theirs.
_MARKS = {"model_rpn": "rig", "time": "trajectory", "quiet_above": "comparison"}


def kind_of(ds: xr.Dataset) -> str:
    """The kind of a result: the key of a study, rig, trajectory, comparison, or map."""
    if (kind := ds.attrs.get("result")) in STUDIES:
        return str(kind)
    names = {*map(str, ds.variables), *map(str, ds.dims)}
    return next((kind for mark, kind in _MARKS.items() if mark in names), "map")
