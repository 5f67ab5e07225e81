"""Distances of cells from a border: along each parameter by itself, and by the cheapest change of several.

`reach.py` says how far each parameter may go, `single.py` asks the engine and looks along one parameter at a time,
`joint.py` along rays in the space of all of them; `margins.py` puts it together.
"""

from stickslip.studies.margins.margins import MarginStudy
from stickslip.studies.margins.section import OPPOSITE, Margins

__all__ = ["OPPOSITE", "MarginStudy", "Margins"]
