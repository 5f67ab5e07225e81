"""The belt speed above which a pair is quiet, for many friction curves in one system, measured or drawn.

Quiet is a pair whose vibration, begun in stick with a relaxed spring, does not last: no stick-slip, and none without
sticking. Along the belt speed each curve is a line, searched as borders are (`studies/search.py`), where labels
are two: vibrates, or does not. The borders of curves drawn from a fit are the interval that the scatter of the
measured points leaves.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.engine import Options, compute
from stickslip.errors import Interrupted
from stickslip.studies.border import Border
from stickslip.studies.lines import search_options
from stickslip.studies.search import Looked, Scan, search_lines
from stickslip.vocabulary.cells import Cells, Parameters, as_cells
from stickslip.vocabulary.models import CURVE
from stickslip.vocabulary.quantities import QUIET_STATES, REGIMES, UNDECIDED, VIBRATING
from stickslip_materials.fit import CurveFit, Drawn, draw_curves

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
BORDER, QUIET, VIBRATES, UNRESOLVED, NOT_DETERMINED = (
    QUIET_STATES.index(name)
    for name in ("border", "quiet_throughout", "vibrates_throughout", "unresolved", "not_determined")
)
VIBRATING_CODES = tuple(REGIMES.index(name) for name in VIBRATING)

DRAWN_TO = 1e-3  # tolerance of the borders of drawn curves, which scatter by far more
_DRAWN_STEPS = 20_000  # of a cell of a drawn curve
_LONGER = 10  # times as many of curves without a verdict by then; what has none then either widens the interval
_TO_TELL = 100  # curves drawn to see whether there are any, where no intervals are asked for


@dataclass(frozen=True)
class Comparing:
    """A comparison to compute.

    system : mass, stiffness, damping and normal load, in SI. speeds : m/s, in ascending order, at which motions are
    computed, or the two ends of a range; there may be none. level : of confidence. draws : curves drawn per
    material, 0 for no intervals.
    """

    system: Mapping[str, float]
    speeds: tuple[float, ...]
    is_range: bool
    level: float
    draws: int
    seed: int
    search: Border
    options: Options

    @property
    def several_speeds(self) -> bool:
        """True where there are numbers at several belt speeds."""
        return len(self.speeds) > 1 and not self.is_range

    def draw(self, curve: CurveFit) -> Drawn | None:
        """Curves as likely as the points leave them; None where there are none, or the points follow no such curve."""
        if not curve.has_intervals:
            return None
        return draw_curves(curve, self.draws or _TO_TELL, self.seed, falling=True)


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


def friction_of(fits: Sequence[CurveFit]) -> dict[str, Floats]:
    """Friction of fitted curves by names of PARAMETERS, each (n,), as cells have it; curves drawn have theirs in
    `Drawn.coefficients`. mu_stop is NaN where friction is the same on the way down."""
    return {name: np.array([fit.coefficients().get(name, math.nan) for fit in fits]) for name in (*CURVE, "mu_stop")}


def regimes(cells: Parameters, options: Options) -> dict[str, NDArray[Any]]:
    """The results of the engine for cells. Raises Interrupted on Ctrl-C."""
    block = compute(Cells.of(cells), options)
    if not block.complete:
        raise Interrupted(block.done, cells["mass"].size)
    return block.results


def quiet_above(
    curves: Mapping[str, Floats], system: Mapping[str, ArrayLike], scan: Scan, tolerance: float, options: Options
) -> QuietSpeeds:
    """The speed at which the vibration of each curve ends for good.

    curves : coefficients by name, each (n,). scan : the speeds looked at first, between the ends of the range; a
    vibration that begins and ends between two of them is missed. tolerance : width of the last bracket over the border.
    """
    cells, options = as_cells({**system, **curves, "belt_speed": scan.low}), search_options(options)
    scanned: list[Looked] = []

    def labels(line: NDArray[np.int64], place: Floats) -> Looked:
        results = regimes({name: values[line] for name, values in cells.items()} | {"belt_speed": place}, options)
        regime = results["regime"]
        vibrates = np.isin(regime, VIBRATING_CODES).astype(np.int8)
        scanned.append(Looked(vibrates, ~np.isin(regime, UNDECIDED), results["restick_margin"]))
        return scanned[-1]

    brackets, _ = search_lines(cells["mass"].size, scan, tolerance, labels)
    vibrates, decided = (values.reshape(-1, scan.points) for values in (scanned[0].labels == 1, scanned[0].decided))
    return _last_borders(brackets, vibrates, decided, scan, tolerance)


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
    ends = brackets[(brackets["below"] == 1) & (brackets["above"] == 0)]
    for line, below, above in zip(ends["line"], ends["low"], ends["high"], strict=True):  # the last one stays
        if state[line] != UNRESOLVED or above < places[doubtful[line]]:
            continue
        narrow = above - below <= scan.width(tolerance, below, above)
        speed[line] = below + (above - below) / 2 if narrow else above
        low[line], state[line] = below, BORDER if narrow else UNRESOLVED
    return QuietSpeeds(speed, low, state)


# --- scatter ----------------------------------------------------------------------------------------------------------


def scatter_of(drawn: Drawn, comparing: Comparing, scan: Scan) -> dict[str, float | Floats]:
    """The interval of a border, and the chance to be quiet, by names of MATERIAL_VARIABLES."""
    least, most = _borders(drawn, comparing, scan).between()
    tail = round((1.0 - comparing.level) / 2.0 * most.size)
    values: dict[str, float | Floats] = {
        "quiet_above_low": float(np.sort(least)[tail]), "quiet_above_high": float(np.sort(most)[-1 - tail]),
    }  # fmt: skip
    if comparing.speeds:
        chance = np.mean(most[:, None] < np.array(comparing.speeds), axis=0)
        values["quiet_probability"] = chance if comparing.several_speeds else float(chance[0])
    return values


def _borders(drawn: Drawn, comparing: Comparing, scan: Scan) -> QuietSpeeds:
    """The borders of drawn curves. One that falls for ever faster than the damper grows vibrates at any speed; so does,
    as far as this can tell, one whose friction would be negative within the range."""
    options = replace(comparing.options, rtol=Options.rtol, max_steps=_DRAWN_STEPS)
    tolerance = max(DRAWN_TO, comparing.search.tolerance)
    level, slope = drawn.coefficients[CURVE.level], drawn.coefficients[CURVE.slope]
    is_damped = comparing.system["damping"] + comparing.system["normal_load"] * slope >= 0
    lost = (slope < 0) & ~(is_damped & (level + slope * scan.high >= 0))
    fastest = np.full(slope.size, scan.high)
    borders = QuietSpeeds(fastest, fastest.copy(), np.full(slope.size, VIBRATES, np.int8))

    def search(which: Flags, options: Options) -> None:
        if which.any():
            curves = {name: values[which] for name, values in drawn.coefficients.items()}
            part = quiet_above(curves, comparing.system, scan, tolerance, options)
            borders.speed[which], borders.low[which], borders.state[which] = part.speed, part.low, part.state

    search(~lost, options)
    search(borders.state == UNRESOLVED, replace(options, max_steps=_LONGER * _DRAWN_STEPS))
    return borders
