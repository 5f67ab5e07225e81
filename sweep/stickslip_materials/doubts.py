"""Questions about fits whose numbers are implausible."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.config.describe import DOUBTED_FRICTION, friction_question
from stickslip.vocabulary.models import BREAKAWAY
from stickslip.vocabulary.parameter import SPEED

if TYPE_CHECKING:
    from stickslip_materials.fit.points import Columns


def question_of_fit(breakaway: float, points: Columns) -> str | None:
    """The question about a fitted curve of implausible speeds, or implausible friction at its points or break-away."""
    fastest, most = (float(np.max(points.get(name, 0.0))) for name in ("speed", "mu"))
    if fastest > SPEED["speed" in points.units]:
        return f"measured at up to {fastest:.6g} m/s; did you mean {fastest:.6g} mm/s?"
    if most > DOUBTED_FRICTION:
        return friction_question(most, "measured friction")
    follows = " It follows from the fit, not from a point."
    return f"{friction_question(breakaway, BREAKAWAY)}{follows}" if breakaway > DOUBTED_FRICTION else None
