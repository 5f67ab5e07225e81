"""The belt speed above which a pair is quiet, for many friction curves in one system, measured or drawn.

Quiet is a pair whose vibration, begun in stick with a relaxed spring, does not last: no stick-slip, and none without
sticking. Along the belt speed each curve is a line, searched as borders are (`studies/borders/search.py`), where labels
are two: vibrates, or does not. The borders of curves drawn from a fit are the interval that the scatter of the
measured points leaves, and tell which points would narrow it.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.config.studies import Moved
from stickslip.engine import Options, Progress, compute
from stickslip.errors import Interrupted
from stickslip.fit import CurveFit, Drawn, RepeatedFit, draw_curves
from stickslip.fit.uncertainty import student
from stickslip.materials.system import Request
from stickslip.studies.borders import Border, Looked, Scan, search_lines, search_options
from stickslip.studies.study import Meter
from stickslip.theory import stribeck
from stickslip.vocabulary.cell_values import as_cells
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.flags import QUIET_STATES, REGIMES, UNDECIDED, VIBRATING
from stickslip.vocabulary.models import CURVE

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
BORDER, QUIET, VIBRATES, UNRESOLVED, NOT_DETERMINED = (
    QUIET_STATES.index(name)
    for name in ("border", "quiet_throughout", "vibrates_throughout", "unresolved", "not_determined")
)
VIBRATING_CODES = tuple(REGIMES.index(name) for name in VIBRATING)

_DRAWN_TO = 1e-3  # tolerance of the borders of drawn curves, which scatter by far more
_DRAWN_STEPS = 20_000  # of a cell of a drawn curve
_LONGER = 10  # times as many of curves without a verdict by then; what has none then either widens the interval
_TO_TELL = 100  # curves drawn to see whether there are any, where no intervals are asked for
_NEXT = ("next_speed_1", "next_speed_2", "next_low", "next_high")
CHANCES = ("quiet_probability", "undecided_probability")
_MORE = 2  # measurements proposed
_SLOWER = 0.2  # of the slowest speed measured: where a fall that no point shows would be looked for
_FEWEST = 30  # curves drawn that agree with new points, from which quantiles are known well enough
_LIKELY = 100  # curves drawn, from which covariances are known well enough to propose measurements
_CANDIDATES = 40  # speeds tried for them, by equal ratios


@dataclass(frozen=True)
class QuietSpeeds:
    """The end of vibration of each curve.

    speed : m/s; at the ends of the range it is a bound, as `state` (codes of QUIET_STATES) says. low : the fastest
    speed known to vibrate, 0 where none is; between the two lies the border.
    """

    speed: Floats
    low: Floats
    state: NDArray[np.int8]

    def between(self) -> tuple[Floats, Floats]:
        """The least and the most that the speeds may be: 0 for curves that are quiet throughout and inf for those that
        vibrate throughout; of those without a verdict the bounds, of the others the border twice."""
        beyond = np.where(self.state == VIBRATES, np.inf, self.speed)
        most = np.where(self.state == QUIET, 0.0, beyond)
        return np.where(self.state == UNRESOLVED, self.low, most), most


def quiet_above(
    curves: Mapping[str, Floats], system: Mapping[str, ArrayLike], scan: Scan, tolerance: float, options: Options,
    moved: Moved | None = None,
) -> QuietSpeeds:  # fmt: skip
    """The speed at which the vibration of each curve ends for good.

    curves : coefficients by name, each (n,). system : the other parameters of a cell but the belt speed, in SI, and
    `friction_scale`. scan : the speeds looked at first, between the ends of the range; a vibration that begins and ends
    between two of them is missed. tolerance : width of the last bracket over the border. moved : called with cells
    computed, now and then.
    Raises Interrupted on Ctrl-C.
    """
    cells, options = cells_of(curves, system, scan.low), search_options(options)
    scanned: list[Looked] = []

    def labels(line: NDArray[np.int64], place: Floats) -> Looked:
        results = regimes(
            {name: values[line] for name, values in cells.items()} | {"belt_speed": place}, options, moved
        )
        regime = results["regime"]
        vibrates = np.isin(regime, VIBRATING_CODES).astype(np.int8)
        scanned.append(Looked(vibrates, ~np.isin(regime, UNDECIDED), results["restick_margin"]))
        return scanned[-1]

    brackets, _ = search_lines(cells["mass"].size, scan, tolerance, labels)
    vibrates, decided = (values.reshape(-1, scan.points) for values in (scanned[0].labels == 1, scanned[0].decided))
    return _last_borders(brackets, vibrates, decided, scan, tolerance)


def cells_of(curves: Mapping[str, Floats], system: Mapping[str, ArrayLike], belt_speed: ArrayLike) -> Parameters:
    """Cells of curves in a system, whose `friction_scale` multiplies friction at every speed; arrays broadcast."""
    others = {**system, "belt_speed": belt_speed}
    scale = np.asarray(others.pop("friction_scale"))
    return as_cells(
        {**others, **{name: values * (1.0 if name == CURVE.decay else scale) for name, values in curves.items()}}
    )


def regimes(cells: Parameters, options: Options, moved: Moved | None = None) -> dict[str, NDArray[Any]]:
    """The results of the engine for cells. Raises Interrupted on Ctrl-C."""
    size, before = cells["mass"].size, 0

    def note(done: float, _: int) -> None:
        nonlocal before
        if moved:
            moved(int(done) - before)
        before = int(done)

    block = compute(Cells.of(cells), options, note)
    if not block.complete:
        raise Interrupted(block.done, size)
    return block.results


def watcher(search: Border, curves: int, progress: Progress | None) -> Callable[[int, int], Moved]:
    """For one search of curves after the other, by number and how many they are, what counts its cells.

    curves : of all searches. progress : called with curves done, in part too, and in all.
    """
    meter, sizes = Meter(search.scan + int(-np.log2(search.tolerance))), list[int]()

    def watch(number: int, size: int) -> Moved:
        if number:
            meter.end(number - 1, sizes[number - 1])
        sizes.append(size)
        count = meter.watch(number, size)

        def moved(cells: int) -> None:
            count(cells)
            if progress:
                progress(meter.items, curves)

        return moved

    return watch


def _last_borders(
    brackets: NDArray[np.void], vibrates: Flags, decided: Flags, scan: Scan, tolerance: float
) -> QuietSpeeds:
    """The last end of vibration on each line, from the brackets of all lines and the labels of the scan."""
    count, places = len(vibrates), scan.places

    def last(flags: Flags) -> NDArray[np.intp]:
        return np.where(flags.any(axis=1), scan.points - 1 - np.argmax(flags[:, ::-1], axis=1), -1)

    doubtful, known = last(vibrates | ~decided), last(vibrates & decided)
    speed, low = np.full(count, scan.low), np.zeros(count)
    state = np.full(count, QUIET, np.int8)
    at_top = doubtful == scan.points - 1
    speed[at_top], state[at_top] = scan.high, VIBRATES
    low[at_top] = np.where(known >= 0, places[known], 0.0)[at_top]
    inside = np.flatnonzero((doubtful >= 0) & ~at_top)
    speed[inside], state[inside] = places[doubtful[inside] + 1], UNRESOLVED
    for one in brackets[(brackets["below"] == 1) & (brackets["above"] == 0)]:  # in order, so that the last one stays
        line = one["line"]
        if state[line] != UNRESOLVED or one["high"] < places[doubtful[line]]:
            continue
        narrow = one["high"] - one["low"] <= scan.width(tolerance, one["low"], one["high"])
        speed[line] = one["low"] + (one["high"] - one["low"]) / 2 if narrow else one["high"]
        low[line], state[line] = one["low"], BORDER if narrow else UNRESOLVED
    return QuietSpeeds(speed, low, state)


# --- scatter --------------------------------------------------------------------------------------------------------


def drawn_of(curve: CurveFit, request: Request) -> Drawn | None:
    """Curves as likely as the points leave them; None where none can be drawn, or the points follow no such curve."""
    if not curve.has_intervals:
        return None
    return draw_curves(curve, request.draws or _TO_TELL, request.seed, falling=True)


def scatter_of(
    curve: CurveFit, drawn: Drawn | None, request: Request, scan: Scan, border: float, moved: Moved | None = None
) -> tuple[dict[str, float | Floats], QuietSpeeds | None]:
    """The interval of a border, chances and measurements to make, and the borders of the drawn curves."""
    if not request.draws or drawn is None:
        return {}, None
    quiet = _borders(drawn, request, scan, moved)
    least, most = quiet.between()
    tail = round((1.0 - request.level) / 2.0 * most.size)
    ends = float(np.sort(least)[tail]), float(np.sort(most)[-1 - tail])
    values: dict[str, float | Floats] = {
        "quiet_above_low": ends[0], "quiet_above_high": ends[1],
        "draws_used": float(np.count_nonzero(quiet.state != UNRESOLVED)), "draws_falling": float(drawn.falling.mean()),
    }  # fmt: skip
    speeds = np.array(request.speeds.values)
    if speeds.size:
        certain, possible = (np.mean(borders[:, None] < speeds, axis=0) for borders in (most, least))
        for name, chance in zip(CHANCES, (certain, possible - certain), strict=True):
            values[name] = chance if request.several_speeds else float(chance[0])
    return values | _measurements(curve, drawn, (least, most), ends, border, tail / most.size), quiet


def names_of_scatter(request: Request) -> tuple[str, ...]:
    """The results of `scatter_of`, and the chance to be better than the next, which follows from them."""
    if not request.draws:
        return ()
    interval = ("quiet_above_low", "quiet_above_high", "draws_used", "draws_falling", "better_than_next")
    return (*interval, *_NEXT, *(CHANCES if request.speeds.values else ()))


def _borders(drawn: Drawn, request: Request, scan: Scan, moved: Moved | None) -> QuietSpeeds:
    """The borders of drawn curves.

    A curve that falls for ever faster than the damper grows vibrates at any speed; so does, as far as this can tell,
    one whose friction would be negative within the range.
    """
    options = replace(request.options, rtol=Options.rtol, max_steps=_DRAWN_STEPS)
    tolerance = max(_DRAWN_TO, request.search.tolerance)
    level, slope = drawn.coefficients[CURVE.level], drawn.coefficients[CURVE.slope]
    is_damped = request.system["damping"] + request.load * slope >= 0
    lost = drawn.falling & ~(is_damped & (level + slope * scan.high >= 0))
    fastest = np.full(slope.size, scan.high)
    borders = QuietSpeeds(fastest, fastest.copy(), np.full(slope.size, VIBRATES, np.int8))

    def search(which: Flags, options: Options, moved: Moved | None) -> None:
        if which.any():
            curves = {name: values[which] for name, values in drawn.coefficients.items()}
            part = quiet_above(curves, request.system, scan, tolerance, options, moved)
            borders.speed[which], borders.low[which], borders.state[which] = part.speed, part.low, part.state

    search(~lost, options, moved)
    search(borders.state == UNRESOLVED, replace(options, max_steps=_LONGER * _DRAWN_STEPS), None)
    return borders


def _measurements(
    curve: CurveFit, drawn: Drawn, borders: tuple[Floats, Floats], ends: tuple[float, float], border: float, tail: float
) -> dict[str, float]:
    """The two speeds, among those measured, at which more points would narrow the interval most, and about where its
    ends would be then; of repeats the ends with another specimen. NaN where nothing can be told.

    borders : of each curve drawn, the least and the most it may be. tail : share of them beyond either end.
    """
    values = dict.fromkeys(_NEXT, math.nan)
    is_closed = ends[0] > 0 and math.isfinite(ends[1])

    def shrunk(factor: float) -> dict[str, float]:
        return dict(zip(_NEXT[2:], (border + (end - border) * factor for end in ends), strict=True))

    if isinstance(curve, RepeatedFit):  # points of the same specimens tell nothing of what differs between specimens
        n = len(curve.repeats)
        return values | (shrunk(student(n) / student(n - 1) * math.sqrt(n / (n + 1))) if is_closed else {})
    least, most = borders
    inside = np.isfinite(most) & (most >= ends[0]) & (most <= ends[1]) & (most > 0)
    spare = max(curve.points - 4 + len(curve.assumed), 1)
    sigma = curve.residual_rms * math.sqrt(curve.points / spare)
    slowest = (curve.speeds[0] or 10.0 * curve.searched[0]) * (1.0 if curve.declines else _SLOWER)
    curves = {name: coefficients[inside] for name, coefficients in drawn.coefficients.items()}
    design = best_measurements(most[inside], curves, (slowest, curve.speeds[1]), sigma)
    if design is None:
        return values
    proposed, narrower = design
    values |= dict(zip(_NEXT, proposed, strict=False))
    if is_closed:
        return values | shrunk(narrower * student(curve.freedom + _MORE) / student(curve.freedom))
    if not sigma > 0:
        return values
    speeds = np.array(proposed)[:, None]
    off = (stribeck(speeds, *(drawn.coefficients[name] for name in CURVE)) - curve.predict(speeds)) / sigma
    weight = np.exp(-0.5 * np.sum(off**2, axis=0))  # of a curve where the points lie on the fitted one
    if weight.sum() ** 2 > _FEWEST * np.sum(weight**2):
        values |= {"next_low": _quantile(least, weight, tail), "next_high": _quantile(most, weight, 1.0 - tail)}
    return values


def _quantile(values: Floats, weights: Floats, share: float) -> float:
    """The value below which a share of the weight lies."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][min(np.searchsorted(total, share * total[-1]), values.size - 1)])


def below(one: QuietSpeeds, other: QuietSpeeds) -> float:
    """Probability that a draw of one is below an independent one of the other; equal ones count half."""
    values, ordered = one.between()[1], np.sort(other.between()[1])
    left, right = (np.searchsorted(ordered, values, side=side) for side in ("left", "right"))
    return float(np.mean(ordered.size - 0.5 * (left + right)) / ordered.size)


def best_measurements(
    target: Floats, curves: Mapping[str, Floats], between: tuple[float, float], sigma: float
) -> tuple[tuple[float, float], float] | None:
    """The two speeds at which another point each would narrow the target most.

    The target and the friction at any speed scatter together over the curves drawn; of a point measured there, with
    its own scatter, follows what is left of the variance of the target (linear regression; c-optimal design).

    target : (n,), a number of each of n drawn curves. curves : coefficients by name, each (n,). between : the slowest
    speed tried, above 0, and the fastest, m/s. sigma : standard deviation of a point.

    Returns the speeds (m/s), the slower one first, and the factor by which the standard deviation of the target
    shrinks; None where fewer than 100 curves tell or nothing scatters.
    """
    if target.size < _LIKELY or not np.ptp(target) > 0:
        return None
    tried = np.geomspace(*between, _CANDIDATES)
    friction = stribeck(tried[:, None], *(curves[name] for name in CURVE))
    together = np.cov(np.vstack([target, friction]))
    variance, with_target, among = together[0, 0], together[0, 1:], together[1:, 1:]
    own = np.diag(among) + sigma**2
    i, j = np.triu_indices(_CANDIDATES)
    c1, c2, cross = with_target[i], with_target[j], among[i, j]
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = own[i] * own[j] - cross**2
        explained = (c1**2 * own[j] - 2.0 * c1 * c2 * cross + c2**2 * own[i]) / determinant
    explained[~np.isfinite(explained)] = 0.0
    best = int(np.argmax(explained))
    left = max(1.0 - float(explained[best] / variance), 0.0)
    return (float(tried[i[best]]), float(tried[j[best]])), left**0.5
