"""The laws of rate-and-state friction, with cut-offs and without, for both forms of it (`rate_and_state.py`,
`regularised.py`), in the symbols of these.

Laws with cut-offs have -a ln(1 + v_1/w) + b ln(1 + v_2 theta/D), but for a constant (P. G. Okubo, J. Geophys. Res. 94
(1989) 12321): the direct effect ceases at w beyond v_1, that of theta at theta below D/v_2. So friction is a (phi -
ln(1 + p e^phi)) + b (psi + ln(1 + q e^-psi)) beside a constant, with p = V/v_1, q = V/v_2.
"""

from math import log
from typing import NamedTuple

from .. import layout as at
from ..exponential import exp
from ..exponential import log as ln
from ..intrinsics import select
from ..jit import compiled
from ..linking import by_law


class Ageing(NamedTuple):
    """Tag of the ageing law."""

    code: int


class Slip(NamedTuple):
    """Tag of the slip law."""

    code: int


class AgeingCutOff(Ageing):
    """The same with cut-offs."""


class SlipCutOff(Slip):
    """The same with cut-offs."""


LAWS = {
    "rate_state_ageing": Ageing(0), "rate_state_slip": Slip(0), "rate_state_ageing_cut_off": AgeingCutOff(0),
    "rate_state_slip_cut_off": SlipCutOff(0),
}  # fmt: skip

# rows of cells; the last two are one over v_1 and v_2
MU_0, DIRECT, EVOLUTION, DISTANCE, V_0 = at.OWN_0, at.OWN_1, at.OWN_2, at.OWN_3, at.OWN_4
PER_DIRECT, PER_EVOLUTION = at.OWN_5, at.OWN_6
# rows of a lane: a, b, mu_V, V, V/D, p, q
ROWS = A, B_STATE, MU_V, V, RATE, CUT_P, CUT_Q = (
    at.SLOPE, at.DROP, at.EXPONENT, at.FAR, at.RATE, at.GAIN, at.GAIN_TOP
)  # fmt: skip
RATIO = at.K_2  # b/a, in the regularised form
NOTHING = 1e-300


@by_law(inline=True)
def growth(law, e, phi, psi):
    """g and its derivatives with respect to phi and psi; e = exp(phi)."""
    healed = exp(-psi)
    return healed - e, -e, -healed


@growth.of(Slip)
def _growth_by_slip(law, e, phi, psi):
    return -e * (phi + psi), -e * (1.0 + phi + psi), -e


# --- cut-offs: without them, what is 0.0 is subtracted, which leaves nothing in the code ------------------------------


@by_law("sif:f", inline=True)
def direct(law, s, i, e):
    """Slope of friction over phi."""
    return s[A + i]


@by_law("sif:f", inline=True)
def evolution(law, s, i, psi):
    """Slope of friction over psi."""
    return s[B_STATE + i]


@by_law("sif:f", inline=True)
def above(law, s, i, e):
    """What friction is above a phi, and ..."""
    return 0.0


@by_law("sif:f", inline=True)
def further(law, s, i, psi):
    """... above b psi, beside mu_V."""
    return 0.0


@by_law(inline=True)
def bent(law, s, i, e, psi, phi_1, psi_1):
    """What comes to friction's second derivative over time from changes of these slopes."""
    return 0.0


@by_law("sif:f", inline=True)
def state_of(law, s, i, load):
    """psi at which friction is by so much above that of psi = 0."""
    return load / s[B_STATE + i]


@direct.of(AgeingCutOff, SlipCutOff)
def _direct(law, s, i, e):
    return s[A + i] / (1.0 + s[CUT_P + i] * e)


@evolution.of(AgeingCutOff, SlipCutOff)
def _evolution(law, s, i, psi):
    return s[B_STATE + i] / (1.0 + s[CUT_Q + i] * exp(-psi))


@above.of(AgeingCutOff, SlipCutOff)
def _above(law, s, i, e):
    return -s[A + i] * ln(1.0 + s[CUT_P + i] * e)


@further.of(AgeingCutOff, SlipCutOff)
def _further(law, s, i, psi):
    return s[B_STATE + i] * ln(1.0 + s[CUT_Q + i] * exp(-psi))


@bent.of(AgeingCutOff, SlipCutOff)
def _bent(law, s, i, e, psi, phi_1, psi_1):
    p, q = s[CUT_P + i] * e, s[CUT_Q + i] * exp(-psi)
    by_phi, by_psi = -s[A + i] * p / ((1.0 + p) * (1.0 + p)), s[B_STATE + i] * q / ((1.0 + q) * (1.0 + q))
    return by_phi * phi_1 * phi_1 + by_psi * psi_1 * psi_1


@state_of.of(AgeingCutOff, SlipCutOff)
def _state_of(law, s, i, load):
    return ln(max((1.0 + s[CUT_Q + i]) * exp(load / s[B_STATE + i]) - s[CUT_Q + i], NOTHING))


# --- the same for the regularised form --------------------------------------------------------------------------------


@by_law("siff:f", inline=True)
def risen(law, s, i, psi_0, psi):
    """By how much c is larger at psi than at psi_0."""
    return s[RATIO + i] * (psi - psi_0)


@by_law("sif:f", inline=True)
def damper(law, s, i, w):
    """By what w' falls as w grows, chi being the same."""
    return s[at.G + i]


@by_law(inline=True)
def less_turned(law, s, i, psi, z, tanh):
    """What r' z tanh is below 0, r' being the slope of r."""
    return 0.0


@by_law(inline=True)
def less_bent(law, s, i, psi, z, tanh, w, dw):
    """What the third derivative of w loses to the slopes of r and of the damper."""
    return 0.0


@risen.of(AgeingCutOff, SlipCutOff)
def _risen(law, s, i, psi_0, psi):
    return s[RATIO + i] * (psi - psi_0) + (further(law, s, i, psi) - further(law, s, i, psi_0)) / s[A + i]


@damper.of(AgeingCutOff, SlipCutOff)
def _damper(law, s, i, w):
    return s[at.G + i] - s[A + i] * s[CUT_P + i] / (s[V + i] + s[CUT_P + i] * abs(w))


@less_turned.of(AgeingCutOff, SlipCutOff)
def _less_turned(law, s, i, psi, z, tanh):
    q = s[CUT_Q + i] * exp(-psi)
    return -s[RATIO + i] * q / ((1.0 + q) * (1.0 + q)) * z * tanh


@less_bent.of(AgeingCutOff, SlipCutOff)
def _less_bent(law, s, i, psi, z, tanh, w, dw):
    steep = s[CUT_P + i] * dw / (s[V + i] + s[CUT_P + i] * abs(w))
    turned = s[A + i] * steep * steep
    return select(w < 0.0, -turned, turned) - s[A + i] * z * less_turned(law, s, i, psi, z, tanh)


# --- steady sliding ---------------------------------------------------------------------------------------------------


@compiled
def in_logarithms(cells, c, w):
    """Friction in steady sliding."""
    a, b, v_0, per_direct, per_evolution = (
        cells[DIRECT, c], cells[EVOLUTION, c], cells[V_0, c], cells[PER_DIRECT, c], cells[PER_EVOLUTION, c]
    )  # fmt: skip
    cut = a * log((1.0 + per_direct * w) / (1.0 + per_direct * v_0))
    cut -= b * log((1.0 + per_evolution * w) / (1.0 + per_evolution * v_0))
    return cells[MU_0, c] + (a - b) * log(w / v_0) - cut


@compiled
def over_a(cells, c, w):
    """ln(2 sinh chi) in steady sliding."""
    over = in_logarithms(cells, c, w) / cells[DIRECT, c]
    return over + log(1.0 + w * cells[PER_DIRECT, c])
