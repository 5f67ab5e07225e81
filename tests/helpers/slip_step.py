"""One slip in all lanes, for the tests of the step: set up, stepped, and solved exactly by SciPy."""

import numpy as np
from hypothesis import strategies as st
from numba import njit
from scipy.integrate import solve_ivp

from stickslip_kernels import layout as at
from stickslip_kernels.contacts.stribeck.equations import jerk_in_lane, slope_in_lane
from stickslip_kernels.contacts.stribeck.laws import LAWS

B, GAMMA, OFFSET, SLOPE, DROP, RATE = 0.4, 0.05, 1.0, 0.1, 0.3, 3.0
Y0, W0 = 0.4, 0.3
WEAKENING = {
    "stribeck": lambda z: np.exp(-z),
    "rational": lambda z: 1.0 / (1.0 + z),
    "gaussian": lambda z: np.exp(-z * z),
    "cubic": lambda z: 1.0 - 1.5 * z + 0.5 * z**3,
}


def lanes(law="stribeck", y=Y0, w=W0, gamma=GAMMA, rate=RATE, step=np.inf, end=np.inf):
    """A buffer with this slip in every lane."""
    s, tag = np.zeros(at.LANE_NUMBERS), LAWS[law]
    rows = {
        at.Y: y, at.W: w, at.WEAK: DROP * WEAKENING[law](rate * w), at.B: B, at.G: gamma, at.OFFSET: OFFSET,
        at.SLOPE: SLOPE, at.DROP: DROP, at.RATE: rate, at.EXPONENT: 1.0, at.STEP: step, at.LONGEST: 1.0,
        at.TAU_END: end, at.FLOOR: 1e-3, at.FAR: 37.0 / rate, at.HIDES: 2.0 / rate,
    }  # fmt: skip
    for row, value in rows.items():
        s[row : row + at.WIDTH] = value
    s[at.DW : at.DW + at.WIDTH] = slope(tag, s, y, w)
    s[at.JERK : at.JERK + at.WIDTH] = jerk(tag, s, y, w, s[at.DW])
    return s


@njit
def slope(tag, s, y, w):
    """w' of the first lane."""
    return slope_in_lane(tag, s, 0, y, w)


@njit
def jerk(tag, s, y, w, dw):
    """w'' of the first lane."""
    return jerk_in_lane(tag, s, 0, y, w, dw, B)


def exact(t, law="stribeck", y=Y0, w=W0, gamma=GAMMA, rate=RATE):
    """y, w, w' and the friction work after t: u' = b - w, w' = u + gamma u' - mu(w) written out."""

    def mu(w):
        return OFFSET + SLOPE * w + DROP * WEAKENING[law](rate * w)

    def slip(_, state):
        u, w, _ = state
        return [B - w, u + gamma * (B - w) - mu(w), mu(w) * w]

    start = [y - gamma * B + OFFSET, w, 0.0]
    u, w, work = solve_ivp(slip, (0.0, t), start, "DOP853", rtol=1e-13, atol=1e-15).y[:, -1] if t else start
    return u + gamma * B - OFFSET, w, u + gamma * (B - w) - mu(w), work


def end_of_step(s, lane=0):
    """y, w, w' and the friction work at the end of the tried step."""
    return tuple(s[row + lane] for row in (at.Y_NEW, at.W_NEW, at.DW_NEW, at.WORK))


# --- a step whose motion is any polynomial --------------------------------------------------------------------------

LANE = 5
numbers = st.floats(-3.0, 3.0).map(lambda x: round(x, 6))
polynomials = st.lists(numbers, min_size=3, max_size=at.ORDER + 1)


def holding(coefficients):
    """A buffer whose lane LANE moves along this polynomial of w."""
    s = np.zeros(at.LANE_NUMBERS)
    s[at.SERIES + LANE :: at.WIDTH][: len(coefficients)] = coefficients
    s[at.W + LANE], s[at.DW + LANE], s[at.JERK + LANE] = coefficients[0], coefficients[1], 2.0 * coefficients[2]
    return s
