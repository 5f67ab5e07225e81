"""Points of friction over slip speed from a record at steps of speed and load: pin on disc, block on ring.

    time [s]; Drehzahl [U/min]; Reibkraft [N]; Normalkraft [N]        begin [s], end [s], speed [mm/s], load [N]
    0,00;     0;                0,02;          10,1                   0,         60,      5,            10

Left a record, right a plan: what was set, and when. Every column has its unit in brackets; others than these are left
out. Friction is a coefficient or, over the load, a force.

A step is where the speed, and the load, stay within a twentieth; ramps between steps are left out. So is the beginning
of each, in which the pair runs in: MSER-5 (White, Simulation 69 (1997) 323) cuts where the mean of what remains is
known best. Samples within a step follow each other: their mean is known as that of as many independent values as there
are integrated autocorrelation times in the step (Sokal's window, in: Functional Integration, Plenum 1997, p. 131).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from stickslip.errors import ConfigError
from stickslip.files.targets import replaced
from stickslip_materials.fit.columns import Signals
from stickslip_materials.fit.uncertainty import Floats
from stickslip_materials.fit.words import PLAN, STEPS

_ALIKE = 0.05  # of its value, within which a speed or load stays during a step
_TREND = 0.02  # of its value, by which it changes from the begin of a step to its end
_LEAST = 0.5  # share of a record in steps: less is a ramp of which pieces look like steps
_SURE = 6.0  # standard errors of the mean of a block of a noisy one, of whose median it is five
_MOST_BLOCKS = 5_000  # in which a record is cut to look for steps
_NOISY_BLOCK = 16  # samples, where speed or load are so noisy
_PARTS = 20  # of a record, in each of which the noise of speed and load is estimated
_OF_NOISE = 0.6745 * math.sqrt(6.0)  # median magnitude of the second differences of white noise, over its deviation
_FEWEST = 20  # samples of a step
_INDEPENDENT = 15  # values that differ on their own: of fewer, the error of a mean is not known
_WINDOW = 3.0  # autocorrelation times over which the autocorrelation is summed: six of Sokal's, who has half of them
_BATCH = 5  # samples, of MSER-5
_LEFT_OUT = 0.2  # of a step at least: what MSER-5 keeps of running-in shifts the mean by a third of its error
_RECORD = "time [s], speed [mm/s], force [N], load [N]"
_ARRAYS = ("speed", "mu", "sigma", "scatter", "load", "begin", "end", "independent")
_PLAN = "begin [s], end [s], speed [mm/s], load [N]"


@dataclass(frozen=True)
class StepPoints:
    """A point for each step, in the order of time; arrays of equal length.

    speed : m/s. mu : mean friction coefficient. sigma : standard deviation of that mean. scatter : that of the samples.
    load : N, NaN where it is not known. begin, end : of the samples used, s. independent : how many independent values
    they are worth. left_out : what is no point, and why. columns : what those of a file were taken for.
    """

    speed: Floats
    mu: Floats
    sigma: Floats
    scatter: Floats
    load: Floats
    begin: Floats
    end: Floats
    independent: Floats
    left_out: tuple[str, ...]
    columns: str = ""


def step_points(
    time: ArrayLike,
    mu: ArrayLike,
    speed: ArrayLike,
    load: ArrayLike | None = None,
    *,
    settle: float | None = None,
    steps: Sequence[tuple[float, float]] | None = None,
) -> StepPoints:
    """Points of friction over slip speed from a record at steps of speed and load.

    Parameters
    ----------
    time : s, increasing
    mu : friction coefficient, as long as `time`
    speed, load : m/s and N, set or measured, as long as `time`; without a load only speeds make steps
    settle : time at the beginning of each step that is left out, s; None finds where running-in ends
    steps : begin and end of each, s; None finds them where speed and load stay

    Returns
    -------
    StepPoints
        A speed that is visited again is another point.

    Raises
    ------
    ValueError
        For arrays of different lengths, time that does not increase, and where nothing is left to be a point.
    """
    t, y, v = (np.asarray(values, np.float64) for values in (time, mu, speed))
    n = np.full(t.shape, np.nan) if load is None else np.asarray(load, np.float64)
    if t.ndim != 1 or t.size < _FEWEST or any(values.shape != t.shape for values in (y, v, n)):
        raise ValueError(f"time: got the shape {t.shape}, expected {_FEWEST} samples or more, and all arrays as long")
    if not (np.isfinite(t).all() and np.isfinite(y).all() and (np.diff(t) > 0).all()):
        raise ValueError("time and mu: expected finite numbers, and time to increase")
    controls = np.array([values for values in (v, n) if not np.isnan(values).all()])
    if steps is None and not np.isfinite(controls).all():
        raise ValueError("speed and load: expected finite numbers")
    parts = _plateaus(controls) if steps is None else [tuple(np.searchsorted(t, ends).tolist()) for ends in steps]
    values = np.unique(y[:10_000])
    resolution = float(np.diff(values).min()) if values.size > 1 else 0.0  # to which friction was rounded
    rows, left_out = [], []
    for start, stop in parts:
        try:
            rows.append(_point(t[start:stop], y[start:stop], v[start:stop], n[start:stop], settle, resolution))
        except ValueError as error:
            left_out.append(f"{t[min(start, t.size - 1)]:.6g} to {t[max(stop - 1, 0)]:.6g} s: {error}")
    used = sum(stop - start for start, stop in parts) / t.size
    if steps is None and used < _LEAST:
        message = f"speed and load stay for {100 * used:.0f} % of the time, expected half or more"
        raise ValueError(f"{message}: a plan says when steps begin and end")
    if not rows:
        raise ValueError(f"no step is a point: {'; '.join(left_out[:3])}")
    if steps is None and used < 1 - _ALIKE:
        left_out.append(f"{100 * (1 - used):.0f} % of the samples, between steps")
    speeds, means, sigmas, scatters, loads, begins, ends, independent = np.array(rows).T
    return StepPoints(speeds, means, sigmas, scatters, loads, begins, ends, independent, tuple(left_out))


def _point(t: Floats, y: Floats, v: Floats, n: Floats, settle: float | None, resolution: float) -> tuple[float, ...]:
    """One point. Raises ValueError saying why a step is none."""
    if t.size < _FEWEST:
        raise ValueError(f"{t.size} samples, expected {_FEWEST} or more")
    speed = float(np.mean(v))
    if abs(speed) <= _ALIKE * float(np.std(v)) or speed == 0:
        raise ValueError("at rest")
    first = int(np.searchsorted(t, t[0] + settle)) if settle is not None else _settled(y)
    if t.size - first < _FEWEST:
        raise ValueError("over before it has settled")
    rest = y[first:] * math.copysign(1.0, speed)
    mean, scatter = float(rest.mean()), float(rest.std(ddof=1))
    if mean <= 0:
        raise ValueError(f"mean friction {mean:.3g}, expected more than 0: look for sign and zero of the sensor")
    independent = rest.size / _autocorrelation_time(rest)
    if independent < _INDEPENDENT:
        if scatter > _TREND * mean:
            values = f"{independent:.2g} independent values, expected {_INDEPENDENT} or more"
            raise ValueError(f"too short: friction varies so slowly that it holds {values}")
        independent = 1.0  # of what hardly varies the mean lies within its scatter
    sigma = math.hypot(scatter / math.sqrt(independent), resolution / math.sqrt(12.0))
    return abs(speed), mean, sigma, scatter, float(np.mean(n)), float(t[first]), float(t[-1]), independent


def _settled(y: Floats) -> int:
    """The first sample behind running-in, by MSER-5. Raises ValueError if friction still changes in the second half."""
    batch = max(_BATCH, y.size // 2000)
    means = y[: y.size // batch * batch].reshape(-1, batch).mean(axis=1)[::-1]
    count = np.arange(1, means.size + 1)
    centred = means - means.mean()
    squares = np.cumsum(centred**2) - np.cumsum(centred) ** 2 / count
    score = (squares / count**2)[::-1]  # of what remains behind each batch
    first = int(np.argmin(score[: max(means.size // 2, 1)]))
    if first >= means.size // 2 - 1 and means.size >= 2 * _BATCH:
        late, last = (float(part.mean()) for part in np.array_split(y[y.size // 2 :], 2))
        if abs(last - late) > _TREND * abs(last):
            raise ValueError("friction does not settle in the first half of the step")
    return max(first * batch, round(_LEFT_OUT * y.size))


def _autocorrelation_time(y: Floats) -> float:
    """Integrated autocorrelation time in samples, 1 or more: 1 + 2 sum of the autocorrelation up to Sokal's window."""
    centred = y - y.mean()
    power = np.abs(np.fft.rfft(centred, 1 << (2 * y.size - 1).bit_length())) ** 2
    correlation = np.fft.irfft(power)[: y.size]
    if not correlation[0] > 0:
        return 1.0
    times = np.maximum(2.0 * np.cumsum(correlation / correlation[0]) - 1.0, 1.0)
    closed = np.flatnonzero(np.arange(y.size) >= _WINDOW * times)
    if not closed.size:
        return float(y.size)
    bias = (2.0 * closed[0] + 1.0) / y.size  # Wolff, Comput. Phys. Commun. 156 (2004) 143, Eq. (49)
    return float(times[closed[0]] * (1.0 + bias))


def _plateaus(controls: Floats) -> list[tuple[int, int]]:
    """First and last sample + 1 of each stretch in which all signals of (signals, samples) stay."""
    controls = controls[[_changes(signal) for signal in controls]] if any(map(_changes, controls)) else controls
    needed = math.ceil((_SURE * max(map(_noise, controls)) / _ALIKE) ** 2)  # samples whose mean stays within it
    width = max(min(max(needed, 1), _NOISY_BLOCK), controls.shape[1] // _MOST_BLOCKS)
    count = controls.shape[1] // width
    blocks = controls[:, : count * width].reshape(len(controls), count, width)
    middles, errors = np.median(blocks, axis=2).T, (blocks.std(axis=2) / math.sqrt(width)).T
    edge = 1 if width > 1 else 0  # blocks that may hold a piece of a ramp
    stretches: list[tuple[int, int]] = []
    start, level, reach = 0, middles[0], _reach(middles[0], errors[0])
    for i in range(1, count + 1):
        if i < count and (np.abs(middles[i] - level) <= reach).all():
            level = level + (middles[i] - level) / (i + 1 - start)
            if i - start < 40:
                reach = _reach(level, np.median(errors[start : min(i + 1, start + 20)], axis=0))
            continue
        first, last = (start + edge) * width, (i - edge) * width
        if last - first >= _FEWEST and _stays(middles[start:i], level, errors[start:i]):
            stretches.append((first, last))
        if i < count:
            start, level, reach = i, middles[i], _reach(middles[i], errors[i])
    return stretches


def _changes(signal: Floats) -> bool:
    """True for a signal that is more than a constant with noise, by the medians of its blocks."""
    blocks = signal[: signal.size // _NOISY_BLOCK * _NOISY_BLOCK].reshape(-1, _NOISY_BLOCK)
    middles, error = np.median(blocks, axis=1), np.median(blocks.std(axis=1)) / math.sqrt(_NOISY_BLOCK)
    level = np.median(middles)
    return bool((np.abs(middles - level) > _reach(level, error)).any())


def _noise(signal: Floats) -> float:
    """Standard deviation of the noise of a signal over its level, where that share is largest."""
    parts = [part for part in np.array_split(signal, _PARTS) if part.size > 2 and np.median(np.abs(part)) > 0]
    shares = [np.median(np.abs(np.diff(part, 2))) / np.median(np.abs(part)) for part in parts]
    return float(max(shares, default=0.0)) / _OF_NOISE


def _reach(level: ArrayLike, errors: ArrayLike) -> Floats:
    """The distance from its level within which a signal stays."""
    return np.maximum(_ALIKE * np.abs(level), _SURE * np.asarray(errors))


def _stays(run: Floats, level: Floats, errors: Floats) -> bool:
    place = np.linspace(-0.5, 0.5, len(run))
    weight = float(place @ place) or 1.0
    slope = place @ (run - level) / weight
    allowed = np.maximum(_TREND * np.abs(level), _SURE * np.median(errors, axis=0) / weight**0.5)
    return bool((np.abs(slope) <= allowed).all())


# --- files ------------------------------------------------------------------------------------------------------------


def read_steps(
    path: Path, plan: Path | None = None, *, radius: float | None = None, load: float | None = None,
    settle: float | None = None, speed_column: str = "", friction_column: str = "",
) -> StepPoints:  # fmt: skip
    """The points of a record at steps of speed and load; see `step_points`.

    path : CSV or .xlsx with a column of time, one of friction or of its force, and, without a plan, one of speed.
    plan : a table of steps with columns of begin, end and speed, and of the load if it changes. radius : of the track,
    m, where speeds are those of rotation, and no line above the heading gives it. load : N, where neither a column nor
    a line above the heading tells it. speed_column, friction_column : headings of the columns to take, where they are
    none of the usual. Where the names of columns come again, each block is read as a record: its time may begin anew.
    Raises ConfigError for files that cannot be understood, by line and column.
    """
    blocks = Signals.of_file(path, _RECORD, STEPS, several=True)
    if len(blocks) > 1 and plan is not None:
        raise blocks[1].error("the names of the columns come again: each block is a step", "leave out --plan")
    parts, left_out = [], []
    for record in blocks:
        name = f"{record.block}: " if record.block else ""
        try:
            points = _points_of(record, plan, radius, load, settle, speed_column, friction_column)
        except ConfigError:
            raise
        except ValueError as error:
            left_out.append(f"{name}{error}")
            continue
        parts.append(points)
        left_out += [f"{name}{text}" for text in points.left_out]
    if not parts:
        raise blocks[0].error("; ".join(left_out[:3]))
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _ARRAYS}
    columns = f"{len(blocks)} blocks; " * (len(blocks) > 1) + parts[0].columns
    return StepPoints(**joined, left_out=tuple(left_out), columns=columns)


def _points_of(
    record: Signals, plan: Path | None, radius: float | None, load: float | None, settle: float | None,
    speed_column: str, friction_column: str,
) -> StepPoints:  # fmt: skip
    """The points of a record, or of a block of it. Raises ValueError where there are none."""
    time, steps = record.read("time"), None
    loads = record.read("load") if "load" in record else np.full(time.shape, record.given("load", load))
    if plan is None:
        speed = record.speed(radius, speed_column)
    else:
        (planned,) = Signals.of_file(plan, _PLAN, PLAN)
        begins, ends, speeds = planned.read("begin"), planned.read("end"), planned.speed(radius)
        if (ends <= begins).any() or (begins[1:] < ends[:-1]).any():
            raise planned.error("the steps overlap or are out of order", "each ends before the next one begins")
        steps, at = [*zip(begins.tolist(), ends.tolist(), strict=True)], np.searchsorted(begins, time, "right") - 1
        inside = (at >= 0) & (time < ends[at])
        speed = np.where(inside, speeds[at], np.nan)
        loads = np.where(inside, planned.read("load")[at], loads) if "load" in planned else loads
    friction = record.friction(loads, np.isfinite(speed), friction_column)
    known = None if np.isnan(loads).all() else loads
    points = step_points(time, friction, speed, known, settle=settle, steps=steps)
    return replace(points, columns=record.describe(load, radius))


def write_points(points: StepPoints, path: Path) -> None:
    """Points as CSV that `stickslip fit` and `stickslip compare` read."""
    head = "speed [mm/s], mu, sigma, load [N], begin [s], end [s], independent values"
    columns = (1000 * points.speed, points.mu, points.sigma, points.load, points.begin, points.end, points.independent)
    with replaced(path) as temporary:
        np.savetxt(
            temporary, np.column_stack(columns), "%.7g", delimiter=", ", header=head, comments="", encoding="utf-8"
        )
