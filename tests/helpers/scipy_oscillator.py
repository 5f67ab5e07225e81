"""The friction oscillator a second time, by SciPy, one event at a time: what the kernels are tested against.

Written from the equations of the model alone, in kernel units and in the true frame (no sign changes, no lanes, no
polynomial guesses): xi'' = sigma mu(w) - gamma xi' - xi, w = |b - xi'|.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from helpers.kernel_runs import ARTICLE, NAN

SHAPES = {  # over z = w/a4; even or linear continuation below zero does not matter here, events are located tightly
    "stribeck": lambda z, delta: np.exp(-z),
    "stribeck_delta": lambda z, delta: np.exp(-(np.abs(z) ** delta)),
    "rational": lambda z, delta: 1 / (1 + z),
    "cubic": lambda z, delta: 1 - 1.5 * z + 0.5 * z**3,
}
TIGHT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
LONGEST_STEP = 0.02  # short steps, so that no event hides between two of them


@dataclass
class Oscillator:
    """The motion up to `horizon`: final state, and what happened as (time, mode, xi, xi')."""

    belt: float
    horizon: float
    curve: tuple = ARTICLE
    gamma: float = 0.0
    mu_stop: float = NAN
    xi: float = 0.0
    eta: float = NAN
    law: str = "stribeck"
    delta: float = 1.0
    time: float = 0.0
    phases: list = field(default_factory=list)

    def __post_init__(self):
        a1, a2, a3, a4 = self.curve
        self.mu_static = a1 + a3
        self.hysteretic = not np.isnan(self.mu_stop)
        self.w_min = self.minimum() if self.hysteretic else 0.0
        self.hysteretic &= self.w_min > 0.0
        if np.isnan(self.eta):
            self.eta = self.belt
        mode = self.first_mode()
        while self.time < self.horizon:
            self.phases.append((self.time, mode.__name__, self.xi, self.eta))
            mode = mode()

    # --- the friction curve and the motion on it ---

    def stribeck(self, w):
        a1, a2, a3, a4 = self.curve
        return a1 + a2 * w + a3 * SHAPES[self.law](w / a4, self.delta)

    def minimum(self):
        """Where the curve is lowest; 0 if it rises from the start."""
        w = np.linspace(0.0, 60 * self.curve[3], 200_001)
        i = int(np.argmin(self.stribeck(w)))
        if i == 0:
            return 0.0
        return minimize_scalar(self.stribeck, bounds=(w[i - 1], w[i + 1]), options={"xatol": 1e-13}).x

    def line(self, w):
        return self.mu_stop + (self.mu_reversal - self.mu_stop) * w / self.w_reversal

    def speed(self, eta):
        return self.sigma * (self.belt - eta)

    def change_of_speed(self, xi, eta, law):
        return -self.sigma * (self.sigma * law(self.speed(eta)) - self.gamma * eta - xi)

    def slip(self, law, *guards):
        """Slip until one of the guards falls through zero; its index, None at the horizon."""

        def motion(_, state):
            xi, eta = state
            return [eta, self.sigma * law(self.speed(eta)) - self.gamma * eta - xi]

        def event(guard):
            def signed(_, state):
                return guard(state[0], state[1])

            signed.terminal, signed.direction = True, -1
            return signed

        # A guard may be zero at its start (every break-away): step over it by a short, tight integration first.
        birth = min(1e-4, self.horizon - self.time)
        first = solve_ivp(motion, (0.0, birth), [self.xi, self.eta], **TIGHT)
        start, events = first.y[:, -1], [event(g) for g in guards]
        rest = self.horizon - self.time - birth
        run = solve_ivp(motion, (0.0, rest), start, events=events, max_step=LONGEST_STEP, **TIGHT)
        self.time += birth + run.t[-1]
        self.xi, self.eta = run.y[:, -1]
        if run.status == 0:
            self.time = self.horizon
            return None
        return next(i for i, times in enumerate(run.t_events) if len(times))

    # --- modes; each returns the next ---

    def first_mode(self):
        if self.eta == self.belt:
            return self.rest()
        self.sigma = np.sign(self.belt - self.eta)
        return self.mode_of_slip()

    def mode_of_slip(self):
        w = self.speed(self.eta)
        if not self.hysteretic:
            return self.rise
        if w >= self.w_min:
            return self.fast
        return self.rise if self.change_of_speed(self.xi, self.eta, self.stribeck) > 0 else self.fix_line()

    def rest(self):
        self.eta = self.belt
        load = self.xi + self.gamma * self.belt
        if abs(load) <= self.mu_static:
            return self.stick
        self.sigma = np.sign(load)
        return self.rise

    def stick(self):
        load = self.xi + self.gamma * self.belt
        self.sigma = np.sign(self.belt) or 1.0
        dwell = (self.sigma * self.mu_static - load) / self.belt if self.belt else np.inf
        if self.time + dwell >= self.horizon:
            self.xi, self.time = self.xi + self.belt * (self.horizon - self.time), self.horizon
            return None
        self.time, self.xi = self.time + dwell, self.sigma * self.mu_static - self.gamma * self.belt
        return self.rise

    def rise(self):
        if not self.hysteretic:
            return None if self.slip(self.stribeck, lambda x, v: self.speed(v)) is None else self.rest()
        end = self.slip(
            self.stribeck,
            lambda x, v: self.speed(v),
            lambda x, v: self.w_min - self.speed(v),
            lambda x, v: self.change_of_speed(x, v, self.stribeck),
        )
        return {None: lambda: None, 0: self.rest, 1: lambda: self.fast, 2: self.fix_line}[end]()

    def fast(self):
        end = self.slip(self.stribeck, lambda x, v: self.speed(v) - self.w_min)
        return None if end is None else self.fix_line()

    def fix_line(self):
        self.w_reversal = self.speed(self.eta)
        self.mu_reversal = self.stribeck(self.w_reversal)
        return self.fall

    def fall(self):
        end = self.slip(self.line, lambda x, v: self.speed(v), lambda x, v: -self.change_of_speed(x, v, self.line))
        if end is None:
            return None
        if end == 0:
            return self.rest()
        w = self.speed(self.eta)
        return self.hold if self.stribeck(w) > self.line(w) else self.rise

    def hold(self):
        w = self.speed(self.eta)
        duration = (self.stribeck(w) - self.line(w)) / (self.sigma * self.eta)
        if self.time + duration >= self.horizon:
            self.xi, self.time = self.xi + self.eta * (self.horizon - self.time), self.horizon
            return None
        self.time, self.xi = self.time + duration, self.xi + self.eta * duration
        return self.rise
