"""The share that settles and the critical disturbances of cells that slip on the plain Stribeck curve, exactly.

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

The unstable cycle is found backwards in time, where it attracts, and sampled over one period. A cycle turns clockwise,
since the velocity is the derivative of the displacement. It crosses velocity zero twice only, so that its area in a box
[x1, x2] x [v1, v2] is the integral of clip(v, v1, v2) over clip(x, x1, x2).

x, v : displacements from steady sliding and velocities (n, samples), evenly over a period, both ends included.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stickslip.engine import Options, Results, Scales, StopFlag, flows, friction_at_belt_speed, solve, stop_flag
from stickslip.studies.search import Flags, Floats, Labels
from stickslip.theory import stribeck_slope, unstable_amplitude
from stickslip.vocabulary.cells import Parameters, taken
from stickslip.vocabulary.models import CURVE, STRIBECK
from stickslip.vocabulary.quantities import REGIMES, STATUSES

_INSIDE = 1.0 - 1e-6  # of the belt speed: larger amplitudes would reach w = 0
_FAR = 10.0  # times belt speed and friction: friction feeds a loop of that size a hundredth of what it takes
_RTOL = 1e-11  # of the cycle, whatever that of the map is
_CLOSED = 1e-8  # how well the cycle must be known, over the displacement in a radian at the speed of the belt
_ROUGHLY, _SAMPLES = 513, 2**14 + 1  # of a cycle, to count its returns, and to measure it: to 1e-7 where it is round
_STARTS = (1.0, 0.3, 0.03)  # of the guess
_PATIENCE = 20_000  # steps
_CORRECTIONS = 12
_COLLAPSED = 0.2  # of where the iteration began: what is smaller is on the way to steady sliding
_DISTURBANCE = 1e-5  # of the amplitude, for the slope of the return map
_AREA_ERROR, _LEAST = 1e-6, 1e-3  # of the area, or of this share of the box, as half as many samples show it
_SLIP_CYCLE = STATUSES.index("slip_cycle")
_CYCLES = [REGIMES.index(name) for name in ("stick_slip", "sustained")]
_DISTURBANCES = [f"critical_{kind}_{way}" for kind in ("shock", "shift") for way in ("along", "against")]
_MEASURED = ("settling_share", "unstable_amplitude", "unstable_velocity_amplitude", "unstable_period", *_DISTURBANCES)


class Box(NamedTuple):
    """Starting states: displacements (m) and velocities (m/s), from the lower end to the upper one."""

    displacement: tuple[float, float]
    velocity: tuple[float, float]

    @property
    def area(self) -> float:
        """Area in the plane of states (m2/s)."""
        (left, right), (low, high) = self
        return (right - left) * (high - low)


DISTURBANCE = 1e-4  # of the belt speed: how far from steady sliding a motion is started that is to be near it
SETTLED = (REGIMES.index("damped"), REGIMES.index("creep"))


def settled(regimes: Labels) -> Flags:
    """Return whether a motion settles to steady sliding."""
    return np.isin(regimes, SETTLED)


@dataclass(frozen=True)
class Motions:
    """Computing from starting states of cells.

    Methods raise StoppedError once `stop` is raised: half of what belongs to a cell says nothing. moved : called with
    motions computed, now and then.
    """

    options: Options
    stop: StopFlag
    moved: Callable[[int], None] | None = None

    def regimes(self, cells: Parameters, displacement: Floats, velocity: Floats) -> Labels:
        """The regime each cell reaches from a state."""
        alone = replace(self, options=replace(self.options, variables=("regime",)))
        return np.asarray(alone.results(cells, displacement, velocity)["regime"])

    def results(self, cells: Parameters, displacement: Floats, velocity: Floats) -> Results:
        """All results of cells that start from a state."""
        state = cells | {"displacement": displacement, "velocity": velocity}
        return solve(state, self.options, self.stop, self.moved)


def steady_state(cells: Parameters, options: Options) -> Floats:
    """Displacement of steady sliding (m), under any law; NaN where the belt is at rest."""
    by, turn = Scales(cells), np.sign(cells["belt_speed"])
    return np.where(turn == 0, np.nan, turn * (by.load * friction_at_belt_speed(cells, options)) / by.stiffness)


def unloaded(cells: Parameters) -> tuple[Floats, Floats]:
    """The state that sticks with no load on the contact: displacement and velocity."""
    x = -cells["damping"] * cells["belt_speed"] / cells["stiffness"]
    return x, np.full_like(x, np.nan)


# --- the theorems -----------------------------------------------------------------------------------------------------


def slips_on_curve(cells: Parameters, options: Options) -> Flags:
    """Of which cells all but the last of the theorems above holds."""
    if options.law != "stribeck":
        return np.zeros(cells["mass"].size, np.bool_)
    _, slope, drop, _ = STRIBECK.curve_of(cells)
    plain = np.isnan(cells["mu_stop"]) & (slope >= 0) & (drop >= 0)
    return np.asarray(plain & (cells["belt_speed"] != 0))


def forward(cells: Parameters) -> Parameters:
    """The same cells with the belt in the positive direction: those of the mirrored plane where it is not."""
    return cells | {"belt_speed": np.abs(cells["belt_speed"])}


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


def beyond_all_cycles(cells: Parameters, options: Options) -> Floats:
    """A displacement (m) at which, with the mass at rest, a state is outside of every cycle.

    A loop of radius r (in speeds) is fed at most N drop over the displacement it covers at 0 < w < b, 2 b^2/r. It loses
    to friction beyond, at least N level over 2 r, or c + N slope times pi r.
    """
    b, by = cells["belt_speed"], Scales(cells)
    _, slope, drop, _ = STRIBECK.curve_of(cells)
    viscous, fed = cells["damping"] + by.load * slope, by.load * drop * b**2
    cube = np.divide(fed, viscous, out=np.zeros_like(fed), where=viscous > 0)
    radius = _FAR * (np.abs(b) + by.load * STRIBECK.start_of(cells) / by.impedance + np.cbrt(cube))
    return np.asarray(steady_state(cells, options) + np.sign(b) * radius * by.impedance / by.stiffness)


# --- the unstable cycle -----------------------------------------------------------------------------------------------


class UnstableCycles(NamedTuple):
    """The unstable cycles of some cells, backwards in time.

    closes : whether there is one, that closes. reach : how far its largest displacement is from steady sliding (m).
    period : s.
    """

    closes: Flags
    reach: Floats
    period: Floats


def find_cycles(cells: Parameters, work: Motions) -> UnstableCycles:
    """The unstable cycles of cells that have one by the theorems; their belts move in positive direction.

    Newton's method on the return map of the motion backwards in time, from one largest displacement to the next: from
    a guess, which is good where friction is weak, and else from where that motion tends to. By itself it would tend to
    the cycle anyway, but too slowly to wait for where the damping is weak. There is only one cycle to be found.
    """
    back = backwards(cells)
    natural = 2.0 * np.pi * Scales(back).time
    cycles = _corrected(back, start_on_cycle(cells), natural, work.options)
    rest = ~cycles.closes
    if rest.any():
        part = taken(back, rest)
        late = _corrected(part, *_approached(part, start_on_cycle(taken(cells, rest)), work), work.options)
        for first, later in zip(cycles, late, strict=True):
            first[rest] = later
    return cycles


def _approached(back: Parameters, guess: Floats, work: Motions) -> tuple[Floats, Floats]:
    """Return where the motions backwards in time tend to, reach and period; NaN where that does not become clear.

    Those that start outside the cycle may leave w > 0, where they mean nothing.
    """
    centre = steady_state(back, work.options)
    reach, period = np.full_like(guess, np.nan), np.full_like(guess, np.nan)
    patient = replace(work.options, rtol=_RTOL, horizon=np.inf, max_steps=_PATIENCE)
    for share in _STARTS:
        left = np.flatnonzero(np.isnan(reach))
        if not left.size:
            break
        start = centre[left] + share * guess[left], np.zeros(left.size)
        done = replace(work, options=patient).results(taken(back, left), *start)
        cycle = (done["regime"] == REGIMES.index("sustained")) & (done["status"] == _SLIP_CYCLE)
        at = left[cycle]
        reach[at] = done["cycle_force_max"][cycle] / back["stiffness"][at] - centre[at]
        period[at] = done["period"][cycle]
    return reach, period


def _corrected(back: Parameters, reach: Floats, period: Floats, options: Options) -> UnstableCycles:
    """Newton's method on the return map; a cycle that does not close in the end is none, nor is steady sliding.

    A guess that is far off may lead to the second return, or to a later one: the period is the time of the first.
    """
    reach, period = reach.copy(), period.copy()
    scale = np.abs(back["belt_speed"]) * Scales(back).time
    closes = np.isfinite(reach) & (reach > 0)
    least, defect = _COLLAPSED * reach, np.full(reach.size, np.inf)
    left = np.flatnonzero(closes)
    for _ in range(_CORRECTIONS):
        if not left.size:
            break
        most = 0.5 * reach[left]
        change, time = _correction(taken(back, left), reach[left], period[left], options)
        good = np.isfinite(change) & (time > 0)
        left, change = left[good], np.clip(change, -most, most)[good]
        reach[left] += change
        period[left] = time[good]
        defect[left] = np.abs(change) / scale[left]
        left = left[defect[left] > 0.01 * _CLOSED]
    with np.errstate(invalid="ignore"):
        closes &= (defect <= _CLOSED) & (reach > least)
    near = np.flatnonzero(closes)
    if near.size:
        velocity = sampled_motion(taken(back, near), reach[near], period[near], _ROUGHLY, options)["velocity"]
        returns = ((velocity[:, 1:] > 0) & (velocity[:, :-1] <= 0)).sum(axis=1)
        slips = velocity.max(axis=1) < back["belt_speed"][near]  # what reaches w = 0 does not
        closes[near] = (returns > 0) & slips
        period[near] /= np.maximum(returns, 1)
    return UnstableCycles(closes, reach, period)


def _correction(back: Parameters, reach: Floats, period: Floats, options: Options) -> tuple[Floats, Floats]:
    """The step of Newton's method, the slope being that to a motion close by; and the time of the return.

    The motion returns at its next largest displacement after that at `reach`, near `period`.
    """
    n, beside = reach.size, reach * (1.0 + _DISTURBANCE)
    both, period = taken(back, np.tile(np.arange(n), 2)), np.tile(period, 2)
    motion = sampled_motion(both, np.concatenate([reach, beside]), period, 2, options)
    x, v, a = motion["displacement"][:, -1], motion["velocity"][:, -1], motion["acceleration"][:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        late = v / a  # v changes linearly as long as this is short, and Newton's method makes it so
        returned = x - steady_state(both, options) - 0.5 * v * late
        slope = (returned[n:] - returned[:n]) / (beside - reach)
        return (returned[:n] - reach) / (1.0 - slope), (period - late)[:n]


def sampled_motion(back: Parameters, reach: Floats, period: Floats, samples: int, options: Options) -> Results:
    """Motions from rest at `reach` beyond steady sliding, over `period`; both ends included."""
    start = {"displacement": steady_state(back, options) + reach, "velocity": np.zeros(reach.size)}
    return flows(back | start, period, samples, replace(options, rtol=_RTOL))


# --- measures of a cycle ----------------------------------------------------------------------------------------------


def area_in_box(x: Floats, v: Floats, left: Floats, right: Floats, low: Floats, high: Floats) -> Floats:
    """The area inside each cycle (n, samples) and its box (n,), by trapezia."""
    x = np.clip(x, left[:, np.newaxis], right[:, np.newaxis])
    v = np.clip(v, low[:, np.newaxis], high[:, np.newaxis])
    # Contiguous, for else sums depend on how many cycles there are.
    return np.asarray(0.5 * np.sum(np.ascontiguousarray((v[:, 1:] + v[:, :-1]) * np.diff(x)), axis=1))


def velocities_at_rest_point(x: Floats, v: Floats) -> tuple[Floats, Floats]:
    """The velocities above and below zero at which each cycle passes the displacement of steady sliding, on the line
    between two samples; NaN where there are more passes."""
    beyond, velocities = x > 0, []
    for passes in (beyond[:, 1:] & ~beyond[:, :-1], ~beyond[:, 1:] & beyond[:, :-1]):  # upward, downward
        rows, at = np.arange(len(passes)), np.argmax(passes, axis=1)
        (x0, x1), (v0, v1) = ((values[rows, at], values[rows, at + 1]) for values in (x, v))
        velocity = v0 + (v1 - v0) * x0 / np.where(x0 == x1, np.nan, x0 - x1)
        velocities.append(np.where(passes.sum(axis=1) == 1, velocity, np.nan))
    return velocities[0], velocities[1]


# --- cells ------------------------------------------------------------------------------------------------------------


def _verdicts(cells: Parameters, stick: Labels, work: Motions) -> tuple[Flags, Flags, Flags]:
    """Of which cells the theorems say that nothing settles, that all states do, and that those inside the unstable
    cycle do. stick : the regime reached from sticking."""
    known = slips_on_curve(cells, work.options)
    if not known.any():
        return known, known, known
    slope = stribeck_slope(np.abs(cells["belt_speed"]), *STRIBECK.curve_of(cells)[1:])
    stable = cells["damping"] + Scales(cells).load * slope > 0  # c + N mu'(b), of steady sliding
    static = cells["mu_static"]  # that of the curve, where it is the same or not given
    on_curve = (np.isnan(static) | (static == STRIBECK.start_of(cells))) & (cells["ageing_rate"] == 0)
    everywhere = known & stable & on_curve & settled(stick)
    far = taken(cells, everywhere)
    everywhere[everywhere] = settled(
        work.regimes(far, beyond_all_cycles(far, work.options), np.zeros(far["mass"].size))
    )
    return known & ~stable, everywhere, known & stable & np.isin(stick, _CYCLES)


def exact_results(cells: Parameters, stick: Labels, box: Box, work: Motions) -> tuple[Flags, Results]:
    """Of which cells the share is exact, and their results, by names of the variables of attractors; NaN elsewhere."""
    results: Results = {name: np.full(stick.size, np.nan) for name in _MEASURED}
    nowhere, everywhere, inside = _verdicts(cells, stick, work)
    for mask, share, disturbance in ((nowhere, 0.0, 0.0), (everywhere, 1.0, np.inf)):
        results["settling_share"][mask] = share
        for name in _DISTURBANCES:
            results[name][mask] = disturbance
    if inside.any():
        for name, values in _inside_cycles(taken(cells, inside), box, work).items():
            results[name][inside] = values
    return np.isfinite(results["settling_share"]), results


def _inside_cycles(cells: Parameters, box: Box, work: Motions) -> Results:
    """Of cells with an unstable cycle, all of it; NaN where it was not found, or its numbers contradict each other."""
    ahead = forward(cells)
    cycles, back = find_cycles(ahead, work), backwards(ahead)
    results: Results = {name: np.full(cycles.period.size, np.nan) for name in _MEASURED}
    there = np.flatnonzero(cycles.closes)
    if not there.size:
        return results
    part, ends = taken(back, there), _mirrored_box(taken(cells, there), box, work.options)
    motion = sampled_motion(part, cycles.reach[there], cycles.period[there], _SAMPLES, work.options)
    x, v = motion["displacement"] - steady_state(part, work.options)[:, np.newaxis], motion["velocity"]
    area, coarse = (area_in_box(x[:, ::step], v[:, ::step], *ends) for step in (1, 2))
    above, below = velocities_at_rest_point(x, v)
    measures = {  # displacements backwards in time have the other sign
        "settling_share": area / box.area, "unstable_period": cycles.period[there],
        "unstable_amplitude": 0.5 * np.ptp(x, axis=1), "unstable_velocity_amplitude": 0.5 * np.ptp(v, axis=1),
        "critical_shock_along": above, "critical_shock_against": -below,
        "critical_shift_along": -x.min(axis=1), "critical_shift_against": x.max(axis=1),
    }  # fmt: skip
    known = np.abs(area - coarse) <= _AREA_ERROR * np.maximum(area, _LEAST * box.area)
    known &= np.isfinite(list(measures.values())).all(axis=0)
    for name, values in measures.items():
        results[name][there[known]] = values[known]
    return results


def _mirrored_box(cells: Parameters, box: Box, options: Options) -> tuple[Floats, Floats, Floats, Floats]:
    """The box in the plane of the motion backwards in time: displacements from steady sliding, of the other sign.

    Where the belt goes the other way the whole plane is mirrored.
    """
    ahead, steady = cells["belt_speed"] > 0, np.abs(steady_state(cells, options))
    (left, right), (low, high) = box.displacement, box.velocity
    near, far = np.where(ahead, left, -right), np.where(ahead, right, -left)
    return steady - far, steady - near, np.where(ahead, low, -high), np.where(ahead, high, -low)


class Loop(NamedTuple):
    """An unstable cycle: displacements (m) and velocities (m/s) of one round, its end being its start; period in s."""

    displacement: Floats
    velocity: Floats
    period: float

    @property
    def velocity_amplitude(self) -> float:
        """Half the range of the velocity (m/s)."""
        return float(np.ptp(self.velocity) / 2.0)


def unstable_cycle(cell: Parameters, regime: int, options: Options, samples: int = 257) -> Loop | None:
    """The unstable cycle of a cell (arrays of length 1), where the theorems say that there is one; None elsewhere.

    regime : the one it reaches from sticking.
    """
    work = Motions(options, stop_flag())
    if not _verdicts(cell, np.array([regime], np.int8), work)[2][0]:
        return None
    ahead = forward(cell)
    cycles, back = find_cycles(ahead, work), backwards(ahead)
    if not cycles.closes[0]:
        return None
    motion = sampled_motion(back, cycles.reach, cycles.period, samples, options)
    turn = float(np.sign(cell["belt_speed"][0]))
    beyond = motion["displacement"][0] - steady_state(back, options)[0]  # backwards in time its sign is changed
    displacement = steady_state(ahead, options)[0] - beyond
    return Loop(turn * displacement, turn * motion["velocity"][0], float(cycles.period[0]))
