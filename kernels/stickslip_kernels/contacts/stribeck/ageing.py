"""Static friction that grows with the time in contact.

mu_static + ageing ln(1 + t/ageing_time): Rabinowicz (1958); Dieterich (1972) for the logarithm. `ageing` counts per
e-fold of time here; per decade it is ln(10) times as much.
"""

from math import log1p

from ... import layout as at
from ...jit import compiled


@compiled
def static_friction(cells, c, age):
    """Largest load the contact of cell c bears after a time in contact."""
    if cells[at.AGEING, c] == 0.0:
        return cells[at.MU_STATIC, c]
    return cells[at.MU_STATIC, c] + cells[at.AGEING, c] * log1p(age / cells[at.AGEING_TIME, c])
