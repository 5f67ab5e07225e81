"""The friction laws, by the shape of the weakening of friction."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

# Shapes of the weakening of friction: mu = a1 + a2 w + a3 shape(w/a4), shape(0) = 1.
LAW_MESSAGES = {
    "stribeck": "exp(-w/a4), Eq. (2) of the article",
    "stribeck_delta": "exp(-(w/a4)^delta), delta = 2 being Gaussian",
    "rational": "1/(1 + w/a4), the law of Leine et al. (1998) with a1 = a2 = 0",
    "cubic": "1 - 3/2 w/a4 + 1/2 (w/a4)^3, the law of Thomsen and Fidlin (2003) with a2 = 0",
}
LAWS = tuple(LAW_MESSAGES)
NO_MINIMUM = "friction rises first and falls without end then: hysteresis is defined by the minimum of a curve"


def rise_to_a_maximum(law: str, cell: Mapping[str, ArrayLike]) -> NDArray[np.float64]:
    """Slope of the curve at standstill (s/m) where it rises first and then falls without end; elsewhere -1.

    Such a curve has a maximum and no minimum at which the falling branch of `mu_stop` could end.
    """
    import numpy as np  # here, since the command line needs the names alone

    a2, a3, a4 = (np.asarray(cell[name], np.float64) for name in ("a2", "a3", "a4"))
    first = 1.5 if law == "cubic" else np.where(np.greater(cell.get("delta", 1.0), 1.0), 0.0, 1.0)
    falls_at_last = (a3 < 0.0) & ((a2 < 0.0) | (law == "cubic"))
    return np.where(falls_at_last, a2 - first * a3 / a4, -1.0)
