"""What a rig shows of its motion: samples at even times, energies, the largest acceleration.

In the frame of `layout.py`, with the belt at speed b and acceleration alpha: the load on the contact is
f = alpha + u + gamma u', and the specimen accelerates at u'' = alpha - w'.
"""

from ..dense import load_and_speed, speed
from ..equations import weakening_in_lane
from ..jit import compiled
from ..layout import (
    ALPHA, B, CELL, DW, FIRST_SAMPLE, G, JERK, LAST_SAMPLE, MODE, OFFSET, RIG_ACCELERATION_MAX, RIG_DAMPER_HEAT,
    RIG_DRIVE_WORK, RIG_FRICTION_HEAT, RIG_SAMPLE, SAMPLE_START, SAMPLE_STEP, SIGMA, SIGNAL_ETA, SIGNAL_FRICTION,
    SIGNAL_MODE, SIGNAL_XI, SLOPE, TAU,
)  # fmt: skip
from ..quadrature import gauss
from ..dense import series_speed
from .drive import belt_in_lane
from .line import motion, steepest
from ..roots import TO_ROUNDING, crossing

NODES, WEIGHTS = gauss(6)
A_LITTLE = 1e-9  # of the time between samples, so that rounding does not lose the last one


@compiled(inline=True)
def displacement_in_lane(s, i, y, t):
    """u of lane i, from y, at t after the start of its step."""
    return y + s[OFFSET + i] - s[ALPHA + i] - s[G + i] * belt_in_lane(s, i, t)


# --- slip -----------------------------------------------------------------------------------------------------------


@compiled
def record_slip(law, s, i, runs, results, signals, h, dw1, jerk1):
    """Record the first h of the step of lane i, at the end of which w' and w'' are dw1 and jerk1."""
    c = int(s[CELL + i])
    note_acceleration(results, c, s[ALPHA + i] - s[DW + i])
    note_acceleration(results, c, s[ALPHA + i] - dw1)
    if s[JERK + i] * jerk1 < 0.0:
        steepest = crossing(s, i, 2, 0.0, h, (0.0, dw1, jerk1, 0.0), TO_ROUNDING)
        note_acceleration(results, c, s[ALPHA + i] - speed(s, i, steepest)[1])
    for node in range(len(NODES)):
        t, weight = NODES[node] * h, WEIGHTS[node] * h
        w, b = series_speed(s, i, t), belt_in_lane(s, i, t)
        mu = s[OFFSET + i] + s[SLOPE + i] * w + weakening_in_lane(law, s, i, w)
        add_energy(results, c, weight, mu, b, w, s[G + i])
    first, last = due_samples(s, i, runs, h)
    for k in range(first, last):
        t = runs[c, SAMPLE_START] + k * runs[c, SAMPLE_STEP] - s[TAU + i]
        y, w = load_and_speed(s, i, t)
        friction = s[OFFSET + i] + s[SLOPE + i] * w + weakening_in_lane(law, s, i, w)
        put_sample(s, i, runs, signals, k, displacement_in_lane(s, i, y, t), belt_in_lane(s, i, t) - w, friction)


# --- stick and hold -------------------------------------------------------------------------------------------------


@compiled
def record_constant_speed(s, i, runs, results, signals, u, b, w, duration):
    """Record the next `duration` of lane i, at constant slip speed w from u on, the belt now at b."""
    if duration == 0.0:  # it did not come to that
        return
    c, alpha, gamma = int(s[CELL + i]), s[ALPHA + i], s[G + i]
    note_acceleration(results, c, alpha)
    for node in range(len(NODES)):
        t, weight = NODES[node] * duration, WEIGHTS[node] * duration
        b1, u1 = b + alpha * t, u + t * (b - w + 0.5 * alpha * t)
        add_energy(results, c, weight, alpha + u1 + gamma * (b1 - w), b1, w, gamma)
    first, last = due_samples(s, i, runs, duration)
    for k in range(first, last):
        t = runs[c, SAMPLE_START] + k * runs[c, SAMPLE_STEP] - s[TAU + i]
        b1, u1 = b + alpha * t, u + t * (b - w + 0.5 * alpha * t)
        put_sample(s, i, runs, signals, k, u1, b1 - w, alpha + u1 + gamma * (b1 - w))


# --- the line of the hysteretic curve -------------------------------------------------------------------------------


@compiled(inline=True)
def displacement_on_line(s, i, mu, w, dw, b):
    """u of lane i from the equation of motion, friction being mu."""
    return mu + dw - s[ALPHA + i] - s[G + i] * (b - w)


@compiled
def record_line(s, i, runs, results, signals, mu_stop, slope, w, v, duration):
    """Record the next `duration` of lane i along the line mu_stop + slope w, from w on, w' being v."""
    c, alpha, b = int(s[CELL + i]), s[ALPHA + i], belt_in_lane(s, i, 0.0)
    push, drag = s[B + i] - w, s[G + i] + slope
    note_acceleration(results, c, alpha - v)
    note_acceleration(results, c, alpha - motion(w, v, push, alpha, drag, duration)[1])
    extremal = steepest(w, v, push, alpha, drag, duration)
    note_acceleration(results, c, alpha - motion(w, v, push, alpha, drag, extremal)[1])
    for node in range(len(NODES)):
        t, weight = NODES[node] * duration, WEIGHTS[node] * duration
        w1 = motion(w, v, push, alpha, drag, t)[0]
        add_energy(results, c, weight, mu_stop + slope * w1, b + alpha * t, w1, s[G + i])
    first, last = due_samples(s, i, runs, duration)
    for k in range(first, last):
        t = runs[c, SAMPLE_START] + k * runs[c, SAMPLE_STEP] - s[TAU + i]
        w1, v1, _, _ = motion(w, v, push, alpha, drag, t)
        b1, mu = b + alpha * t, mu_stop + slope * w1
        put_sample(s, i, runs, signals, k, displacement_on_line(s, i, mu, w1, v1, b1), b1 - w1, mu)


# --- shared ---------------------------------------------------------------------------------------------------------


@compiled(inline=True)
def note_acceleration(results, c, acceleration):
    """Let an acceleration count towards the largest."""
    results[RIG_ACCELERATION_MAX, c] = max(results[RIG_ACCELERATION_MAX, c], abs(acceleration))


@compiled(inline=True)
def add_energy(results, c, weight, friction, b, w, gamma):
    """Add what friction moves in a time `weight`: work of the drive, heat in the contact and in the damper."""
    results[RIG_DRIVE_WORK, c] += weight * friction * b
    results[RIG_FRICTION_HEAT, c] += weight * friction * w
    results[RIG_DAMPER_HEAT, c] += weight * gamma * (b - w) * (b - w)


@compiled(inline=True)
def due_samples(s, i, runs, duration):
    """Numbers of the samples of lane i within the next `duration`, first and past the last; they count as taken."""
    c = int(s[CELL + i])
    first, most = int(s[RIG_SAMPLE + i]), int(runs[c, LAST_SAMPLE] - runs[c, FIRST_SAMPLE])
    last = first
    if first < most:
        reached = (s[TAU + i] + duration - runs[c, SAMPLE_START]) / runs[c, SAMPLE_STEP] + A_LITTLE
        last = min(most, max(first, int(reached + 1.0)))
    s[RIG_SAMPLE + i] = last
    return first, last


@compiled(inline=True)
def put_sample(s, i, runs, signals, k, u, velocity, friction):
    """Write sample k of lane i, in the true frame."""
    n, sigma = int(runs[int(s[CELL + i]), FIRST_SAMPLE]) + k, s[SIGMA + i]
    signals[SIGNAL_XI, n], signals[SIGNAL_ETA, n] = sigma * u, sigma * velocity
    signals[SIGNAL_FRICTION, n], signals[SIGNAL_MODE, n] = sigma * friction, s[MODE + i]
