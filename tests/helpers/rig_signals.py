"""Signals of a rig made by hand, whose features are known."""

import numpy as np
import xarray as xr

from stickslip_rig.api import make_record
from stickslip_rig.quantities import SIGNALS


def record(time, force, acceleration=None, **more) -> xr.Dataset:
    """A record of a spring force; `more` are other signals, and conditions."""
    signals = {name: more.pop(name) for name in list(more) if name in SIGNALS}
    a = np.zeros_like(time) if acceleration is None else acceleration
    return make_record(time, {"spring_force": force, "acceleration": a, **signals}, more)


def times(duration, rate):
    """`duration` seconds at `rate` samples per second, both ends included."""
    return np.linspace(0.0, duration, round(duration * rate) + 1)


def saw_tooth(time, low=2.0, high=5.0, stick=0.2, slip=0.01):
    """Force that rises steadily from `low` to `high` in `stick` seconds and falls as half a cosine in `slip`."""
    phase = np.mod(time, stick + slip)
    falling = 0.5 * (high + low) + 0.5 * (high - low) * np.cos(np.pi * (phase - stick) / slip)
    return np.where(phase < stick, low + (high - low) * phase / stick, falling)


def to_and_fro(time, half, loading, plateau, teeth=0.0, tooth=0.1):
    """Force of a drive that reverses every `half` seconds: steep changes of sign, then sliding or a saw-tooth.

    loading : N/s while sticking. plateau : largest force. teeth : how far it falls at once, every `tooth` seconds.
    """
    force, found = 0.0, []
    step = time[1] - time[0]
    for t in time:
        found.append(force)
        sign = 1.0 if int(t / half + 1e-9) % 2 == 0 else -1.0
        force += sign * loading * step
        if sign * force >= plateau:
            force = sign * (plateau - teeth)
    return np.array(found)
