"""The studies: what may be computed instead of a map of every cell, and where each is declared."""

from __future__ import annotations

from typing import NamedTuple


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
    "attractors": Entry("attractors.study:AttractorStudy", "Find which regimes coexist, and what settles."),
    "ramp": Entry("attractors.ramp:RampStudy", "Follow attractors up and down a parameter."),
    "refine": Entry("refinement.study:RefinedMap"),
    "uncertain": Entry("uncertainty.sampling:SampleStudy"),
}
