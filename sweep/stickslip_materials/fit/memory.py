"""Contacts with memory from records: rate-and-state friction from velocity steps and holds.

    time [s], speed [um/s], mu
    0.00,     1,            0.601
    0.10,     1,            0.600

A record of a drive whose speed takes steps, 0 during a hold. The drive at the speed V pulls the slider by a spring of
stiffness k over the load N, slowly enough that its mass does not count: mu' = (k/N)(V - w), and w follows from friction
(J. C. Gu et al., J. Mech. Phys. Solids 32 (1984) 167; fitted so by A. Reinen and J. D. Weeks, J. Geophys. Res. 98
(1993) 15937).
"""

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip_materials.fit.columns import Signals
from stickslip_materials.fit.uncertainty import Floats, Interval, covariance, points_of, r_squared, rms, student

RATE_STATE = ("rate_state_ageing", "rate_state_slip")
_STEP = 0.05  # by which a speed differs from those of the step before it
_FEWEST = 20  # samples
_MOST_STEPS = 0.1  # of the samples
_DECADES, _LEVELS, _RATIOS = 9, (0.4, 1.5), (0.4, 0.9, 1.3, 2.0)  # where the search begins: of D_c, a and b/a
_STIFFNESSES = (1.0, 10.0, 100.0)  # and k/N times D_c, where the stiffness is not known
_FOLLOWED = 3  # of these
_LINEAR = ("mu_0", "b")  # fitted themselves, the others by their logarithms
_ALIKE, _EXPLAINED = 0.5, 0.9  # residuals as correlated with those before, or so little explained: another law
_WIDE = 8.0  # ratio of the ends of an interval of what is not determined

Steps = Sequence[tuple[int, float]]  # first sample and speed of each


@dataclass(frozen=True)
class MemoryFit:
    """A contact with memory, fitted to a record.

    law : "rate_state_ageing" or "rate_state_slip". values : its parameters in SI, by the names of a configuration, and
    `drive_stiffness` (over the load, 1/m) where it was fitted. interval : their 95 % intervals. time : s, of each
    sample. mu, predicted : friction coefficient there. good : whether the record determines them. quality : that in
    plain words. columns : what those of a file were taken for.
    """

    law: str
    values: Mapping[str, float]
    interval: Mapping[str, Interval]
    time: Floats
    mu: Floats
    predicted: Floats
    residual_rms: float
    r_squared: float
    good: bool
    quality: str
    columns: str = ""


def fit_rate_state(
    time: ArrayLike, speed: ArrayLike, mu: ArrayLike, *, law: str = "rate_state_ageing", stiffness: float | None = None
) -> MemoryFit:
    """Rate-and-state friction from a record of velocity steps and holds.

    Parameters
    ----------
    time : (n,) s, increasing.
    speed : (n,) of the drive, m/s, in steps; 0 during a hold. The record begins at steady sliding, and its first speed
        is v_0.
    mu : (n,) friction coefficient, the force of the spring over the load.
    law : "rate_state_ageing" or "rate_state_slip".
    stiffness : of the drive over the load, 1/m; None fits it as well (`drive_stiffness` of the result).

    Returns
    -------
    MemoryFit
        With mu_0, v_0, a, b, D_c. Intervals are those of linear least squares, widened by the correlation of residuals
        that follow each other.

    Raises
    ------
    ValueError
        For impossible records, and for one without steps of speed.
    """
    if law not in RATE_STATE:
        raise ValueError(f"law: got {law!r}, expected {' or '.join(RATE_STATE)}")
    t, v, y = _record(time=time, speed=speed, mu=mu)
    if not (np.diff(t) > 0.0).all():
        raise ValueError("time: expected an increasing one")
    if stiffness is not None and not (math.isfinite(stiffness) and stiffness > 0.0):
        raise ValueError(f"stiffness: got {stiffness!r}, expected a value > 0 (1/m)")
    steps, slip = _steps(v), float(np.sum(v[:-1] * np.diff(t)))

    def predict(p: Floats) -> Floats:
        return _friction(t, steps, p.tolist(), stiffness or math.exp(p[4]), law == "rate_state_slip")

    change = max(float(np.ptp(y)), 1e-6)
    names = ["mu_0", "a", "b", "D_c", *(["drive_stiffness"] if stiffness is None else [])]
    free = _STIFFNESSES if stiffness is None else (1.0,)
    starts = [
        np.array([y[0], math.log(level * change), ratio * level * change, math.log(d), math.log(k / d)][: len(names)])
        for d, level, ratio, k in product(np.geomspace(slip / 3e4, slip / 3.0, _DECADES), _LEVELS, _RATIOS, free)
    ]
    return _fit_of(_nearest(predict, starts, y), names, t, y, law, steps[0][1])


def fit_memory_file(
    path: str | Path, law: str, *, load: float | None = None, stiffness: float | None = None
) -> MemoryFit:
    """The fit of a law of `MemoryFit` to a file with the columns time, speed and mu; a friction force with a column of
    loads, or `load`, serves for mu.

    load : N, where the file tells none. stiffness : of the drive, N/m; None fits it. Raises ConfigError for what cannot
    be read, by line and column, and ValueError as the fit does.
    """
    kinds = ("time", "speed", "mu", "friction_force", "force", "load")
    (record,) = Signals.of_file(Path(path), "time, speed, mu", kinds)
    time, speed = record.read("time"), record.read("speed")
    loads = record.read("load") if "load" in record else np.full(time.shape, record.given("load", load))
    mu, weight = record.friction(loads, np.ones(loads.shape, np.bool_)), float(np.median(loads))
    if not math.isfinite(weight) and stiffness is not None:
        raise record.error("got no load", "name it: --load '10 N'")
    fit = fit_rate_state(time, speed, mu, law=law, stiffness=stiffness / weight if stiffness else None)
    return replace(fit, columns=record.describe(load))


# --- records ----------------------------------------------------------------------------------------------------------


def _record(**columns: ArrayLike) -> list[Floats]:
    length = np.size(next(iter(columns.values())))
    if length < _FEWEST:
        raise ValueError(f"got {length} samples, expected {_FEWEST} or more")
    return [points_of(name, values, length, -math.inf) for name, values in columns.items()]


def _steps(speed: Floats) -> Steps:
    """Raises ValueError where there are none, or nothing but steps."""
    if not speed[0] > 0.0 or (speed < 0.0).any():
        raise ValueError("speed: expected steady sliding at first, and no speed below 0")
    begins = [0]
    for i in range(1, speed.size):
        if abs(speed[i] - speed[begins[-1]]) > _STEP * max(speed[i], speed[begins[-1]]):
            begins.append(i)
    if not 1 < len(begins) <= _MOST_STEPS * speed.size:
        raise ValueError(f"speed: got {len(begins)} steps in {speed.size} samples, expected 2 to a tenth of them")
    return [(a, float(np.mean(speed[a:b]))) for a, b in zip(begins, [*begins[1:], speed.size], strict=True)]


def _friction(t: Floats, steps: Steps, p: Sequence[float], rate: float, is_slip: bool) -> Floats:
    """Friction at each sample; NaN from where it cannot be integrated. p : mu_0, ln a, b, ln D_c. rate : k/N, 1/m."""
    from scipy.integrate import solve_ivp  # type: ignore[import-untyped]

    mu_0, a, b, d, v_0 = p[0], math.exp(p[1]), p[2], math.exp(p[3]), steps[0][1]

    def slopes(_: float, s: Floats, speed: float) -> list[float]:
        log_w = min((s[0] - mu_0 - b * s[1]) / a, 200.0)  # over v_0; s[1] = ln(v_0 theta/D_c)
        w = v_0 * math.exp(log_w)
        return [rate * (speed - w), (-w * (log_w + s[1]) if is_slip else v_0 * math.exp(min(-s[1], 200.0)) - w) / d]

    state, values = [mu_0, 0.0], np.full(t.size, np.nan)
    for (begin, speed), end in zip(steps, [*(i for i, _ in steps[1:]), t.size], strict=True):
        times, span = t[begin : end + 1], (t[begin], t[min(end, t.size - 1)])
        solved = solve_ivp(slopes, span, state, "LSODA", times, args=(speed,), rtol=1e-7, atol=1e-9)
        if solved.status != 0 or not np.isfinite(solved.y).all():
            return values
        values[begin:end] = solved.y[0][: end - begin]
        state = solved.y[:, -1].tolist()
    return values


# --- least squares ----------------------------------------------------------------------------------------------------


def _nearest(predict: Callable[[Floats], Floats], starts: Sequence[Floats], y: Floats) -> Any:
    """SciPy's result of least squares, from the best few of the starts."""
    from scipy.optimize import least_squares  # type: ignore[import-untyped]

    def residuals(p: Floats) -> Floats:
        with np.errstate(over="ignore", invalid="ignore"):
            return np.nan_to_num(predict(p) - y, nan=1e3, posinf=1e3, neginf=-1e3)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of LSODA, on starts that are no good
        first = sorted(starts, key=lambda p: float(np.sum(residuals(p) ** 2)))[:_FOLLOWED]
        return min((least_squares(residuals, p, x_scale="jac", max_nfev=60) for p in first), key=lambda fit: fit.cost)


def _fit_of(best: Any, names: Sequence[str], time: Floats, y: Floats, law: str, v_0: float) -> MemoryFit:
    """Values, their intervals and the quality of what is nearest. names : of the parameters."""
    left, freedom = best.fun, y.size - best.x.size
    alike = float(np.corrcoef(left[1:], left[:-1])[0, 1]) if left.std() > 0.0 else 0.0  # with those that follow them
    worth = max((1.0 - alike) / (1.0 + alike), 1.0 / y.size) if alike > 0.0 else 1.0  # independent ones, of all
    errors = np.sqrt(np.diag(covariance(best.jac)) * float(left @ left) / freedom / worth)
    values, interval, open_ones = {"v_0": v_0}, {}, []
    for name, middle, half in zip(names, best.x, student(max(freedom * worth, 1.0)) * errors, strict=True):
        ends = np.array([middle, middle - half, middle + half])
        values[name], *both = map(float, ends if name in _LINEAR else np.exp(np.clip(ends, -700.0, 700.0)))
        interval[name] = both[0], both[1]
        if not math.isfinite(half) or name not in _LINEAR and not both[1] < _WIDE * both[0]:
            open_ones.append(name)
    share = r_squared(y, left, np.ones_like(y))
    is_other = alike > _ALIKE or share < _EXPLAINED
    quality = f"The contact explains {100 * share:.3g} % of the variance of the record."
    quality += f" The record does not determine {', '.join(open_ones)}." if open_ones else ""
    quality += " What is left is no scatter: it is another law, another stiffness of the drive, or a drift." * is_other
    good = not open_ones and not is_other
    return MemoryFit(law, values, interval, time, y, y + left, rms(left), share, good, quality)
