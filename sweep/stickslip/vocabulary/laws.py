"""The friction laws, by the shape of the weakening of friction."""

from __future__ import annotations

# Shapes of the weakening of friction: mu = a1 + a2 w + a3 shape(w/a4), shape(0) = 1.
LAW_MESSAGES = {
    "stribeck": "exp(-w/a4), Eq. (2) of the article",
    "stribeck_delta": "exp(-(w/a4)^delta), delta = 2 being Gaussian",
    "rational": "1/(1 + w/a4), the law of Leine et al. (1998) with a1 = a2 = 0",
    "cubic": "1 - 3/2 w/a4 + 1/2 (w/a4)^3, the law of Thomsen and Fidlin (2003) with a2 = 0",
}
LAWS = tuple(LAW_MESSAGES)
