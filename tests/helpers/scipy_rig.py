"""A stick-slip rig by SciPy, one phase at a time: an independent reference for whatever computes the same rig.

A specimen of mass m hangs on a flat spring (stiffness k, damping c) and is pressed with the load N on a
reciprocating plate, which moves in segments of constant acceleration. With the plate at velocity u and the specimen at
x, x' = v,

    m v' = F - k x - c v,   F = N mu(|u - v|) sgn(u - v) while slipping,   F = k x + c v + m u' while sticking,

mu(w) = a1 + a2 w + a3 exp(-w/a4). The contact breaks away where |F| reaches the static limit, which may grow with the
time in contact, N (mu_static + beta log10(1 + t/t0)). All in SI. Nothing here knows the package under test.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

TIGHT = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-14}
STEPS_PER_PERIOD = 24  # short steps, so that no event hides between two of them


def trapezoidal(stroke, speed, ramp, dwell=0.0, strokes=2, wait=0.0):
    """Segments (duration, velocity at the start, acceleration): reciprocating strokes with ramps of `ramp` seconds.

    stroke : its length, m. dwell : standstill after each stroke, s. wait : hold time before the first, s.
    """
    plateau = stroke / speed - ramp
    assert plateau >= 0, "the ramps alone are longer than the stroke"
    segments = [(wait, 0.0, 0.0)]
    for i in range(strokes):
        v = speed if i % 2 == 0 else -speed
        segments += [(ramp, 0.0, v / ramp), (plateau, v, 0.0), (ramp, v, -v / ramp), (dwell, 0.0, 0.0)]
    return [segment for segment in segments if segment[0] > 0]


@dataclass
class Phase:
    """An interval without events: when, whether sticking, the direction of slip, the plate, and the dense solution."""

    start: float
    end: float
    sticks: bool
    sigma: float
    velocity: float  # of the plate at the start
    acceleration: float  # of the plate
    state: object  # x, v, plate position, work of the drive, friction heat, damper heat over time


@dataclass
class Rig:
    """The motion over all segments of the drive, starting at rest with the spring relaxed."""

    segments: list
    mass: float = 0.1
    stiffness: float = 5000.0
    damping: float = 0.0
    load: float = 10.0
    curve: tuple = (0.3, 0.0, 0.1, 0.01)
    mu_static: float = np.nan  # mu(0) unless given
    beta: float = 0.0
    t0: float = 1.0
    tolerance: dict = field(default_factory=lambda: TIGHT)
    phases: list = field(default_factory=list)
    breakaways: list = field(default_factory=list)  # times
    resticks: list = field(default_factory=list)

    def __post_init__(self):
        a1, _, a3, _ = self.curve
        self.mu_static = a1 + a3 if np.isnan(self.mu_static) else self.mu_static
        self.period = 2 * np.pi * np.sqrt(self.mass / self.stiffness)
        self.time, self.y = 0.0, np.zeros(6)
        self.sticks, self.sigma, self.contact_since = True, 1.0, 0.0
        for duration, velocity, acceleration in self.segments:
            self.drive(self.time + duration, velocity, acceleration)

    def mu(self, w):
        """Friction coefficient; a step beyond w = 0, where a slip ends, must not overflow the exponential."""
        a1, a2, a3, a4 = self.curve
        return a1 + a2 * w + a3 * np.exp(-np.maximum(w, -0.1 * a4) / a4)

    def limit(self, t):
        return self.load * (self.mu_static + self.beta * np.log10(1 + (t - self.contact_since) / self.t0))

    # --- phases ---

    def drive(self, end, velocity, acceleration):
        """All phases of one segment of the drive, from now to `end`."""
        begin = self.time

        def plate(t):
            return velocity + acceleration * (t - begin)

        def needed(y):
            return self.stiffness * y[0] + self.damping * y[1] + self.mass * acceleration

        def friction(t, y):
            if self.sticks:
                return needed(y)
            return self.sigma * self.load * self.mu(self.sigma * (plate(t) - y[1]))

        def motion(t, y):
            f, u, v = friction(t, y), plate(t), y[1]
            force = f - self.stiffness * y[0] - self.damping * v
            return [v, force / self.mass, u, f * u, f * (u - v), self.damping * v**2]

        def over_limit(t, y):
            return abs(needed(y)) - self.limit(t)

        def slip_speed(t, y):
            return self.sigma * (plate(t) - y[1])

        over_limit.terminal, over_limit.direction = True, 1
        slip_speed.terminal, slip_speed.direction = True, -1
        while self.time < end:
            if self.sticks and over_limit(self.time, self.y) >= 0:
                self.break_away(needed(self.y))
            elif not self.sticks and slip_speed(self.time, self.y) < 0:
                # only by rounding, or because the plate has another acceleration from here
                self.y[1] = plate(self.time)
            stopped = self.integrate(motion, over_limit if self.sticks else slip_speed, end, plate, acceleration)
            if stopped and self.sticks:
                self.break_away(needed(self.y))
            elif stopped:
                self.y[1] = plate(self.time)
                self.stop(needed(self.y))

    def integrate(self, motion, event, end, plate, acceleration):
        """One phase, to the event or to `end`; whether it was the event."""
        pieces = [(self.time, end, event)]
        if not self.sticks:  # a slip starts on its own event: leave it by a short step first
            birth = min(self.time + 1e-4 * self.period, end)
            pieces = [(self.time, birth, None), (birth, end, event)]
        for begin, finish, guard in pieces:
            if finish <= begin:
                continue
            longest = np.inf if self.sticks else self.period / STEPS_PER_PERIOD
            how = {"events": guard, "dense_output": True, "max_step": longest, **self.tolerance}
            run = solve_ivp(motion, (begin, finish), self.y, **how)
            assert run.success, run.message
            at = float(run.t[-1])
            self.phases.append(Phase(begin, at, self.sticks, self.sigma, plate(begin), acceleration, run.sol))
            self.time, self.y = at, run.y[:, -1].copy()
            if run.status == 1:
                return True
        self.time = end
        return False

    def break_away(self, needed):
        self.sticks, self.sigma = False, float(np.sign(needed))
        self.breakaways.append(self.time)

    def stop(self, needed):
        """The slip speed is zero: the contact sticks, or slips the other way."""
        if abs(needed) < self.load * self.mu_static:
            self.sticks, self.contact_since = True, self.time
            self.resticks.append(self.time)
        else:
            self.sigma = float(np.sign(needed))

    # --- what comes out ---

    def balance(self):
        """Energy-balance residual: work of the drive minus heat minus stored energy, over the work."""
        x, v, _, work, heat, damped = self.y
        return (work - heat - damped - 0.5 * (self.stiffness * x**2 + self.mass * v**2)) / work

    def sample(self, rate):
        """Times and signals at `rate` samples per second."""
        time = np.arange(0.0, self.time, 1.0 / rate)
        found = {name: np.empty(time.size) for name in
                 ("spring_force", "friction_force", "acceleration", "drive_velocity", "drive_displacement", "stick",
                  "displacement", "velocity")}  # fmt: skip
        for phase in self.phases:
            inside = slice(np.searchsorted(time, phase.start), np.searchsorted(time, phase.end))
            if inside.start >= inside.stop:
                continue
            t = time[inside]
            x, v, way, *_ = phase.state(t)
            u = phase.velocity + phase.acceleration * (t - phase.start)
            spring = self.stiffness * x
            if phase.sticks:
                friction = spring + self.damping * v + self.mass * phase.acceleration
            else:
                friction = phase.sigma * self.load * self.mu(np.abs(u - v))
            values = (spring, friction, (friction - spring - self.damping * v) / self.mass, u, way,
                      np.full(t.size, phase.sticks), x, v)  # fmt: skip
            for name, column in zip(found, values, strict=True):
                found[name][inside] = column
        return time, found
