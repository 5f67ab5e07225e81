"""Observer of signals: equidistant samples, stick phases, energies, the largest acceleration. Hooks of `observers`.

With the belt at speed b and acceleration alpha, the load on the contact is f = alpha + u + gamma u', and the mass
accelerates at u'' = alpha - w'. Every step is looked at.
"""

from math import isnan
from typing import Any, NamedTuple

from .. import contacts, observers
from .. import layout as at
from ..contacts.stribeck.hysteresis import motion, steepest
from ..dense import gauss, load_and_speed
from ..drive import belt_in_lane
from ..jit import by_type, compiled
from ..layout import DONE

NODES, WEIGHTS = gauss(6)
A_LITTLE = 1e-9  # of the time between samples, so that rounding does not lose the last one


class Signals(NamedTuple):
    """Tag of this observer, with what it fills.

    results : float64 (RIG_ROWS, n) from `layout.new_signals`. runs : float64 (n, RUN_COLUMNS), where each cell puts
        its samples. signals : float64 (SIGNAL_ROWS, any); what is not reached stays as it was.
    stops : a table of stick phases, for n = 1, or NO_STOPS.
    """

    results: Any
    runs: Any
    signals: Any
    stops: Any


# --- a cell begins and ends -----------------------------------------------------------------------------------------


def begin_cell(m, i, c):
    for row in at.RIG_SUMS:
        m.observer.results[row, c] = 0.0
    m.s[at.SAMPLE + i] = 0.0


def is_left(m, c):
    status = m.observer.results[at.RIG_STATUS, c]
    return status == at.NOT_RUN or status == at.STEP_UNDERFLOW or status == at.NOT_FINITE


def reject_cell(m, c, status):
    m.observer.results[at.RIG_STATUS, c] = status


def finish(m, i, status, u, velocity):
    results, c, sigma = m.observer.results, int(m.s[at.CELL + i]), m.s[at.SIGMA + i]
    results[at.RIG_STATUS, c], results[at.RIG_STEPS, c] = status, m.s[at.TRIED + i]
    if status == at.HORIZON_REACHED:
        results[at.RIG_XI_END, c], results[at.RIG_ETA_END, c] = sigma * u, sigma * velocity
    return DONE


# --- what happens ---------------------------------------------------------------------------------------------------


def before_commit(m):
    for i in range(at.WIDTH):
        m.s[at.LOOK + i] = 1.0


def observe_slip_begin(m, i, u, w, fresh):
    m.observer.results[at.RIG_SLIPS, int(m.s[at.CELL + i])] += 1.0


def observe_standstill(m, i, dw):
    note_acceleration(m, i, m.s[at.ALPHA + i] - dw)


def observe_step(m, i, h, y, w, dw, jerk, work):
    s = m.s
    note_acceleration(m, i, s[at.ALPHA + i] - s[at.DW + i])
    note_acceleration(m, i, s[at.ALPHA + i] - dw)
    if s[at.JERK + i] * jerk < 0.0:
        note_acceleration(m, i, s[at.ALPHA + i] - contacts.extreme_slope(m, i, h, (w, dw, jerk, 0.0)))
    m.observer.results[at.RIG_STEPS_TAKEN, int(s[at.CELL + i])] += 1.0
    record(m, i, Step(0), h)


def observe_constant_speed(m, i, u, b, w, duration):
    if duration > 0.0:  # else the phase ends before
        note_acceleration(m, i, m.s[at.ALPHA + i])
        record(m, i, ConstantSpeed(u, b, w), duration)


def observe_line(m, i, line, u, w, v, duration):
    alpha, push = m.s[at.ALPHA + i], m.s[at.B + i] - w
    note_acceleration(m, i, alpha - v)
    note_acceleration(m, i, alpha - motion(w, v, push, alpha, line.drag, duration)[1])
    extremal = steepest(w, v, push, alpha, line.drag, duration)
    note_acceleration(m, i, alpha - motion(w, v, push, alpha, line.drag, extremal)[1])
    record(m, i, OnLine(line, w, v), duration)


def observe_stick(m, i, start, u_start, load, after_slip, thrown):
    results, stops, c, now = m.observer.results, m.observer.stops, int(m.s[at.CELL + i]), m.s[at.TAU + i]
    results[at.RIG_STICKS, c] += 1.0
    results[at.RIG_STICK_TIME, c] += now - start
    if stops.shape[0] > 0:
        stops[0, 0] += 1.0
        row = int(stops[0, 0])
        if row < stops.shape[0]:
            stops[row, at.STOP_START], stops[row, at.STOP_END] = start, now
            stops[row, at.STOP_LOAD] = m.s[at.SIGMA + i] * load


def observe_breakaway(m, i, start, load, thrown):
    results, c = m.observer.results, int(m.s[at.CELL + i])
    if isnan(results[at.RIG_BREAKAWAY_TIME, c]):
        results[at.RIG_BREAKAWAY_TIME, c], results[at.RIG_BREAKAWAY_LOAD, c] = m.s[at.TAU + i], load


# --- the motion between ---------------------------------------------------------------------------------------------


class Step(NamedTuple):
    """Tag of a step of slip, the lane being at its start."""

    code: int


class ConstantSpeed(NamedTuple):
    """Tag of stick and hold: constant slip speed w from u on, the belt being at b."""

    u: float
    b: float
    w: float


class OnLine(NamedTuple):
    """Tag of a fall along a line, from w on, w' being v."""

    line: Any
    w: float
    v: float


@by_type(lambda phase, *_: phase, inline=True)
def motion_in(phase, m, i, t):
    """u, b, w and the friction coefficient at t after the present state of lane i, in a phase of its motion."""
    s = m.s
    y, w = load_and_speed(s, i, t)
    b, mu = belt_in_lane(m, i, t), contacts.friction(m, i, t, w)
    return y + s[at.OFFSET + i] - s[at.ALPHA + i] - s[at.G + i] * b, b, w, mu


@motion_in.of(ConstantSpeed)
def _at_constant_speed(phase, m, i, t):
    alpha, w = m.s[at.ALPHA + i], phase.w
    b, u = phase.b + alpha * t, phase.u + t * (phase.b - w + 0.5 * alpha * t)
    return u, b, w, alpha + u + m.s[at.G + i] * (b - w)


@motion_in.of(OnLine)
def _on_line(phase, m, i, t):
    alpha, push, line = m.s[at.ALPHA + i], m.s[at.B + i] - phase.w, phase.line
    w, dw, _, _ = motion(phase.w, phase.v, push, alpha, line.drag, t)
    b, mu = belt_in_lane(m, i, t), line.mu_stop + line.slope * w
    return mu + dw - alpha - m.s[at.G + i] * (b - w), b, w, mu


@compiled(inline=True)
def record(m, i, phase, duration):
    """Energies and samples of the next `duration` of lane i, no longer than a step."""
    s, results, c = m.s, m.observer.results, int(m.s[at.CELL + i])
    for node in range(len(NODES)):
        weight = WEIGHTS[node] * duration
        _, b, w, mu = motion_in(phase, m, i, NODES[node] * duration)
        results[at.RIG_DRIVE_WORK, c] += weight * mu * b
        results[at.RIG_FRICTION_HEAT, c] += weight * mu * w
        results[at.RIG_DAMPER_HEAT, c] += weight * s[at.G + i] * (b - w) * (b - w)
    first, last = due_samples(m, i, duration)
    for k in range(first, last):
        u, b, w, mu = motion_in(phase, m, i, time_to_sample(m, i, k))
        put_sample(m, i, k, u, b - w, mu)


# --- shared ---------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def note_acceleration(m, i, acceleration):
    """Extend the largest acceleration by this one."""
    results, c = m.observer.results, int(m.s[at.CELL + i])
    results[at.RIG_ACCELERATION_MAX, c] = max(results[at.RIG_ACCELERATION_MAX, c], abs(acceleration))


@compiled(inline=True)
def time_to_sample(m, i, k):
    """Time from the present state of lane i to its sample k."""
    runs, c = m.observer.runs, int(m.s[at.CELL + i])
    return runs[c, at.SAMPLE_START] + k * runs[c, at.SAMPLE_STEP] - m.s[at.TAU + i]


@compiled(inline=True)
def due_samples(m, i, duration):
    """Numbers of the samples of lane i within the next `duration`, first and past the last; they count as taken."""
    s, runs, c = m.s, m.observer.runs, int(m.s[at.CELL + i])
    first, most = int(s[at.SAMPLE + i]), int(runs[c, at.LAST_SAMPLE] - runs[c, at.FIRST_SAMPLE])
    last = first
    if first < most:
        reached = (s[at.TAU + i] + duration - runs[c, at.SAMPLE_START]) / runs[c, at.SAMPLE_STEP] + A_LITTLE
        last = min(most, max(first, int(reached + 1.0)))
    s[at.SAMPLE + i] = last
    return first, last


@compiled(inline=True)
def put_sample(m, i, k, u, velocity, friction):
    """Write sample k of lane i, in the true frame."""
    signals, sigma = m.observer.signals, m.s[at.SIGMA + i]
    n = int(m.observer.runs[int(m.s[at.CELL + i]), at.FIRST_SAMPLE]) + k
    signals[at.SIGNAL_XI, n], signals[at.SIGNAL_ETA, n] = sigma * u, sigma * velocity
    signals[at.SIGNAL_FRICTION, n], signals[at.SIGNAL_MODE, n] = sigma * friction, m.s[at.MODE + i]


observers.register(Signals, globals())
