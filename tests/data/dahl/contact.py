"""Dahl's contact: friction is a spring that yields, z' = sigma w (1 - |z|/mu sign(w z)).

P. R. Dahl, A solid friction model, Aerospace Corporation TOR-0158(3107-18)-1 (1968). z is friction over load, in row
WEAK; mu and sigma, the stiffness of the contact over that of the spring, are the contact's own rows of cells. Steps are
of the classical Runge-Kutta method, of one length.
"""

from typing import NamedTuple

from .. import contacts
from .. import layout as at
from ..arithmetic import select
from ..dense import interpolate
from ..jit import compiled
from ..layout import DONE, RUNNING
from ..observers.recurrence import Recurrence
from . import smooth


class Dahl(NamedTuple):
    """Tag of this contact, and of its only law."""

    code: int


TAG = Dahl(0)
LAWS, LINKED, REGIMES = {"dahl": TAG}, (), Recurrence
STEP = 0.02  # of a radian of the free oscillation with the contact as a second spring


@compiled(inline=True)
def rates(s, i, t, y, w, z):
    """y', w', z' of lane i at t after the start of its step."""
    bound = s[at.RATE + i] * w * (1.0 - select(w >= 0.0, z, -z) / s[at.DROP + i])
    return s[at.B + i] + t * s[at.ALPHA + i] - w, y - s[at.G + i] * w - z, bound


@compiled(inline=True)
def derive(m, i):
    s = m.s
    dy, dw, dz = rates(s, i, 0.0, s[at.Y + i], s[at.W + i], s[at.WEAK + i])
    s[at.DW + i], s[at.JERK + i] = dw, dy - s[at.G + i] * dw - dz


@compiled
def begin_cell(m, i, c):
    if smooth.open_cell(m, i, c) == DONE:
        return DONE
    s = m.s
    s[at.DROP + i], s[at.RATE + i] = m.cells[at.OWN_0, c], m.cells[at.OWN_1, c]
    s[at.STEP + i] = STEP / (1.0 + s[at.RATE + i]) ** 0.5
    derive(m, i)
    return RUNNING


@compiled
def try_step(m):
    s = m.s
    for i in range(at.WIDTH):
        h = min(s[at.STEP + i], s[at.TAU_END + i] - s[at.TAU + i])
        y, w, z = s[at.Y + i], s[at.W + i], s[at.WEAK + i]
        y1, w1, z1 = rates(s, i, 0.0, y, w, z)
        y2, w2, z2 = rates(s, i, 0.5 * h, y + 0.5 * h * y1, w + 0.5 * h * w1, z + 0.5 * h * z1)
        y3, w3, z3 = rates(s, i, 0.5 * h, y + 0.5 * h * y2, w + 0.5 * h * w2, z + 0.5 * h * z2)
        y4, w4, z4 = rates(s, i, h, y + h * y3, w + h * w3, z + h * z3)
        y += h / 6.0 * (y1 + 2.0 * (y2 + y3) + y4)
        w += h / 6.0 * (w1 + 2.0 * (w2 + w3) + w4)
        z += h / 6.0 * (z1 + 2.0 * (z2 + z3) + z4)
        dy, dw, dz = rates(s, i, h, y, w, z)
        s[at.TAKEN + i], s[at.GOOD + i] = h, 1.0
        s[at.Y_NEW + i], s[at.W_NEW + i], s[at.WEAK_NEW + i] = y, w, z
        s[at.DW_NEW + i], s[at.JERK_NEW + i] = dw, dy - s[at.G + i] * dw - dz
    interpolate(s)


@compiled
def handle_event(m, i):
    if smooth.commit(m, i) == DONE:
        return DONE
    derive(m, i)
    return RUNNING


def steady_friction(contact, law, cells, c, w):
    return cells[at.OWN_0, c]


contacts.register(Dahl, globals())
