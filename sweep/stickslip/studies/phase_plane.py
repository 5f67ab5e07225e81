"""Cells that slip on the plain Stribeck curve: what can be said of their phase plane for certain.

Where a curve has no hysteresis (slope and drop being not negative, and the belt moving), slip is a flow in the plane of
displacement and velocity, and orbits of a plane do not cross. In q = w - |b|, with the slip speed w > 0, it is a
Lienard system, q'' + F'(q) q' + q = 0, where F' = gamma + mu' rises with w:

- Where the damping of steady sliding is not positive, it repels, and nothing settles.
- Where it is positive, F'(q)/q falls for q < 0 and for q > 0. So at most one cycle runs in w > 0, and it is unstable
  (the theorem of Zhang Zhifen, in Ye Yanqian et al., Theory of Limit Cycles, AMS 1986, backwards in time). If it is
  there, exactly the states inside it settle, whatever the contact does at w = 0: nothing crosses it.
- It is there if and only if the slip that begins at w = 0 on the curve comes back to w = 0. Backwards in time, the
  region between that slip and w = 0 is then entered and never left, and steady sliding repels (Poincare and Bendixson);
  and a slip that spirals into steady sliding would have to cross the cycle.
- If there is none, every state settles unless a cycle of slip in both directions surrounds everything: as long as
  static friction is that of the curve and does not age, so that motions from w = 0 continue as the slip above. Such a
  cycle is excluded by a motion from farther out than any cycle can be, which ends in steady sliding.
"""

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, Scales
from stickslip.theory import stribeck, stribeck_slope, unstable_amplitude
from stickslip.vocabulary.cells import Parameters
from stickslip.vocabulary.models import CURVE, STRIBECK

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
_INSIDE = 1.0 - 1e-6  # of the belt speed: larger amplitudes would reach w = 0
_FAR = 10.0  # times belt speed and friction: friction feeds a loop of that size a hundredth of what it takes


def slips_on_curve(cells: Parameters, options: Options) -> Flags:
    """Of which cells all but the last of the theorems above holds."""
    if options.law != "stribeck":
        return np.zeros(cells["mass"].size, np.bool_)
    _, slope, drop, _ = STRIBECK.curve_of(cells)
    plain = np.isnan(cells["mu_stop"]) & (slope >= 0) & (drop >= 0)
    return np.asarray(plain & (cells["belt_speed"] != 0))


def sticks_on_curve(cells: Parameters) -> Flags:
    """Return whether static friction is where the curve begins, and stays there."""
    begins = np.isnan(cells["mu_static"]) | (cells["mu_static"] == STRIBECK.start_of(cells))
    return np.asarray(begins & (cells["ageing_rate"] == 0))


def forward(cells: Parameters) -> Parameters:
    """The same cells with the belt in the positive direction: those of the mirrored plane where it is not."""
    return cells | {"belt_speed": np.abs(cells["belt_speed"])}


def steady_displacement(cells: Parameters) -> Floats:
    """Displacement of steady sliding (m), on the plain curve of the law stribeck."""
    speed = np.abs(cells["belt_speed"])
    by, friction = Scales(cells), stribeck(speed, *STRIBECK.curve_of(cells))
    return np.asarray(np.sign(cells["belt_speed"]) * friction * by.load / by.stiffness)


def backwards(cells: Parameters) -> Parameters:
    """Cells of which the slip w > 0 is that of `cells` backwards in time, their displacement changing sign.

    With x -> -x and t -> -t the equation m x'' + c x' + k x = N mu(w) keeps its form: c and mu change their signs, the
    velocity does not. The level of friction only shifts the displacement; it is raised until no slip speed of interest
    has a negative friction coefficient.
    """
    turned = {name: -cells[name] for name in ("damping", CURVE.slope, CURVE.drop)}
    level = cells[CURVE.drop] + _FAR * cells[CURVE.slope] * np.abs(cells["belt_speed"])
    return cells | turned | {CURVE.level: level, "mu_static": np.full_like(level, np.nan)}


def start_on_cycle(cells: Parameters) -> Floats:
    """A guess of how far the unstable cycle goes beyond steady sliding (m), inside it unless friction is strong."""
    by, (_, slope, drop, decay) = Scales(cells), STRIBECK.curve_of(cells)
    speed = unstable_amplitude(cells["belt_speed"], slope, drop, decay, cells["damping"], by.load)
    speed = np.minimum(speed, _INSIDE * np.abs(cells["belt_speed"]))
    return np.asarray(speed * by.time)


def beyond_all_cycles(cells: Parameters) -> Floats:
    """A displacement (m) at which, with the mass at rest, a state is outside of every cycle.

    A loop of radius r (in speeds) is fed at most N drop over the displacement it covers at 0 < w < b, 2 b^2/r. It loses
    to friction beyond, at least N level over 2 r, or c + N slope times pi r.
    """
    b, by = np.abs(cells["belt_speed"]), Scales(cells)
    _, slope, drop, _ = STRIBECK.curve_of(cells)
    viscous = cells["damping"] + by.load * slope
    fed = by.load * drop * b**2
    cube = np.divide(fed, viscous, out=np.zeros_like(fed), where=viscous > 0)
    radius = _FAR * (b + by.load * STRIBECK.start_of(cells) / by.impedance + np.cbrt(cube))
    beyond = steady_displacement(cells) + np.sign(cells["belt_speed"]) * radius * by.impedance / by.stiffness
    return np.asarray(beyond)


def damping(cells: Parameters) -> Floats:
    """c + N mu'(b) (N s/m): steady sliding is stable where it is positive."""
    slope = stribeck_slope(np.abs(cells["belt_speed"]), *STRIBECK.curve_of(cells)[1:])
    return np.asarray(cells["damping"] + Scales(cells).load * slope)
