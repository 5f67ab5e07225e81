"""Rigs in kernel units, run through a block."""

from dataclasses import dataclass

import numpy as np

from helpers.kernel_runs import cell
from helpers.scipy_rig import trapezoidal
from stickslip.engine.compiling import kernels
from stickslip_kernels import layout as at
from stickslip_kernels.layout import NO_STOPS, new_signals

MOST_STOPS = 20_000


def rig(**contact):
    """One column of kernel input: arguments of `kernel_runs.cell`."""
    return cell(belt=0.0, **contact)


def drive_of(*times_and_accelerations, start=0.0):
    """Segments (duration, belt speed, acceleration) of a belt that begins at the speed `start`."""
    segments, speed = [], start
    for duration, alpha in times_and_accelerations:
        segments.append((duration, speed, alpha))
        speed += duration * alpha
    return np.array(segments)


def strokes(speed, ramp, plateau, dwell=0.0, count=2, wait=0.0):
    """Reciprocating strokes: up to `speed` within `ramp`, constant for `plateau`, down again, `dwell` at rest."""
    return np.array(trapezoidal(speed * (plateau + ramp), speed, ramp, dwell, count, wait))


def cut(drive, times):
    """The same drive in more segments, which end at these times as well."""
    ends = np.cumsum(drive[:, at.SEGMENT_TIME])
    pieces = []
    for (duration, speed, alpha), end in zip(drive, ends, strict=True):
        begin, done = end - duration, 0.0
        for t in [*sorted(t - begin for t in times if begin < t < end), duration]:
            if t > done:
                pieces.append((t - done, speed + alpha * done, alpha))
            done = max(done, t)
    return np.array(pieces)


@dataclass
class RigOutcome:
    """Results by their names in `layout.py` in small letters without RIG_, samples, and stick phases."""

    values: np.ndarray
    signals: np.ndarray
    time: np.ndarray
    stops: np.ndarray

    def __getattr__(self, name):
        return float(self.values[getattr(at, f"RIG_{name.upper()}")])

    @property
    def breakaways(self):
        """Ends of the stick phases but one that lasts to the end of the drive."""
        ends = self.stops[:, at.STOP_END]
        return ends if self.slips and ends.size and ends[-1] < self.time_end * (1.0 - 1e-12) else ends[:-1]

    @property
    def resticks(self):
        return self.stops[self.stops[:, at.STOP_START] > 0.0, at.STOP_START]

    time_end: float = np.inf


def run(columns, drives, samples=0, start=0.0, rtol=1e-6, max_steps=1e6, law="stribeck", stops=NO_STOPS, stop=0):
    """Results (RIG_ROWS, n) and signals (n, SIGNAL_ROWS, samples) of rigs, each with its drive.

    samples : how many each takes from `start` to the end of its drive.
    """
    n = len(columns)
    lengths = [len(drive) for drive in drives]
    lasts = np.cumsum(lengths)
    runs = np.zeros((n, at.RUN_COLUMNS))
    runs[:, at.FIRST_SAMPLE], runs[:, at.LAST_SAMPLE] = samples * np.arange(n), samples * (1 + np.arange(n))
    runs[:, at.SAMPLE_START] = start
    ends = np.array([drive[:, at.SEGMENT_TIME].sum() for drive in drives])
    runs[:, at.SAMPLE_STEP] = (ends - start) / max(samples - 1, 1)
    signals = np.full((at.SIGNAL_ROWS, n * samples), np.nan)
    results = new_signals(n)
    segments = np.ascontiguousarray(np.concatenate(drives)) if n else np.zeros((0, at.SEGMENT_COLUMNS))
    cells = np.ascontiguousarray(np.array(columns).reshape(n, at.CELL_ROWS).T)
    belts = segments, np.column_stack([lasts - lengths, lasts]).astype(float)
    flag = np.array([stop], np.int64)
    kernels(law, signals=True).run_signals(cells, rtol, max_steps, flag, belts, results, runs, signals, stops)
    return results, signals.reshape(at.SIGNAL_ROWS, n, samples).transpose(1, 0, 2)


def outcome(drive, samples=0, start=0.0, rtol=1e-6, max_steps=1e6, law="stribeck", **contact):
    """Run one rig: arguments of `rig` and of `run`."""
    table = np.zeros((MOST_STOPS, at.STOP_COLUMNS))
    results, signals = run([rig(**contact)], [drive], samples, start, rtol, max_steps, law, table)
    end = drive[:, at.SEGMENT_TIME].sum()
    time = start + (end - start) / max(samples - 1, 1) * np.arange(samples)
    return RigOutcome(results[:, 0], signals[0], time, table[1 : int(table[0, 0]) + 1], end)


def imbalance(drive, found, xi=0.0):
    """What the drive gives less heat and change of stored energy, over all that is moved."""
    before = xi**2 + drive[0, at.SEGMENT_BELT] ** 2
    stored = 0.5 * (found.xi_end**2 + found.eta_end**2 - before)
    moved = abs(found.drive_work) + found.friction_heat + found.damper_heat + abs(stored)
    return (found.drive_work - found.friction_heat - found.damper_heat - stored) / max(moved, 1e-9)


def random_drive(random):
    """A random drive: reciprocating strokes, or a walk in accelerations, some of them none."""
    if random.random() < 0.4:
        plateau, dwell, wait = random.uniform(0.1, 20.0), random.choice([0.0, 5.0]), random.choice([0.0, 3.0])
        return strokes(10.0 ** random.uniform(-1.5, 0.3), random.uniform(0.1, 10.0), plateau, dwell, 4, wait)
    pieces = [
        (random.uniform(0.1, 8.0), random.choice([0.0, 1.0]) * random.normal() * 10.0 ** random.uniform(-2.0, 0.0))
        for _ in range(random.integers(3, 12))
    ]
    return drive_of(*pieces, start=random.choice([0.0, random.normal()]))


def random_contact(random, law, hysteretic):
    """Arguments of `rig`, by chance."""
    a1, a2, a3 = random.uniform(0.1, 0.8), random.uniform(0.01, 0.3), random.uniform(0.05, 0.5)
    # A cubic climbs steeply beyond its minimum at a4.
    a4 = 10.0 ** (random.uniform(-0.5, 0.5) if law == "cubic" else random.uniform(-1.5, 0.0))
    contact = {"curve": (a1, a2, a3, a4), "gamma": random.choice([0.0, 0.02, 0.3])}
    contact["delta"] = random.choice([1.0, 1.5, 2.0]) if law == "stribeck_delta" else 1.0
    if hysteretic:
        contact["mu_stop"] = a1 * random.uniform(0.5, 1.0)
    if random.random() < 0.4:
        contact |= {"mu_static": a1 + a3 + random.choice([0.0, 0.05]), "ageing": random.choice([0.0, 0.02])}
    return contact
