"""The belt speed above which a pair is quiet, for many friction curves in one system.

Quiet is a pair whose vibration, begun in stick with a relaxed spring, does not last: no stick-slip, and none without
sticking. Along the belt speed each curve is a line, searched by the machinery of borders (`borders/search.py`), where
labels are two: vibrates, or does not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.borders import Limits, Looked, Scan, search_lines
from stickslip.engine import Options, Progress, compute
from stickslip.errors import Interrupted
from stickslip.study import Meter, Moved
from stickslip.vocabulary.cell_values import as_cells
from stickslip.vocabulary.cells import Cells, Parameters
from stickslip.vocabulary.flags import QUIET_STATES, REGIMES, UNDECIDED, VIBRATING

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
BORDER, QUIET, VIBRATES, UNRESOLVED, NOT_DETERMINED = (
    QUIET_STATES.index(name)
    for name in ("border", "quiet_throughout", "vibrates_throughout", "unresolved", "not_determined")
)
VIBRATING_CODES = tuple(REGIMES.index(name) for name in VIBRATING)


@dataclass(frozen=True)
class Quiet:
    """What was found for each curve.

    speed : m/s; at the ends of the range it is a bound, as `state` (codes of QUIET_STATES) says. low : the fastest
    speed known to vibrate, 0 where none is; between the two lies the border.
    """

    speed: Floats
    low: Floats
    state: NDArray[np.int8]

    def between(self) -> tuple[Floats, Floats]:
        """What the speeds may be at least and at most: 0 for curves that are quiet throughout and inf for those that
        vibrate throughout; of those without a verdict the bounds, of the others the border twice."""
        beyond = np.where(self.state == VIBRATES, np.inf, self.speed)
        most = np.where(self.state == QUIET, 0.0, beyond)
        return np.where(self.state == UNRESOLVED, self.low, most), most


def quiet_above(
    curves: Mapping[str, Floats], system: Mapping[str, ArrayLike], scan: Scan, tolerance: float, options: Options,
    moved: Moved | None = None,
) -> Quiet:  # fmt: skip
    """Where the vibration of each curve ends for good.

    curves : a1 to a4 by name, each (n,). system : the other parameters of a cell but the belt speed, in SI, and
    `friction_scale`. scan : the speeds looked at first, between the ends of the range; a vibration that begins and ends
    between two of them is missed. tolerance : width of the last bracket over the border. moved : called with cells
    computed, now and then.
    Raises Interrupted on Ctrl-C.
    """
    full = cells_of(curves, system, scan.low)
    count = full["mass"].size
    first: list[Looked] = []

    def looked(line: NDArray[np.int64], place: Floats) -> Looked:
        found = regimes({name: values[line] for name, values in full.items()} | {"belt_speed": place}, options, moved)
        regime = found["regime"]
        labels = np.isin(regime, VIBRATING_CODES).astype(np.int8)
        answer = Looked(labels, ~np.isin(regime, UNDECIDED), found["restick_margin"])
        first.append(answer)
        return answer

    brackets, _ = search_lines(count, scan, tolerance, looked)
    shape = (count, scan.points)
    vibrates = first[0].labels.reshape(shape) == 1
    decided = first[0].decided.reshape(shape)
    return _last_borders(brackets, vibrates, decided, scan, tolerance)


def cells_of(curves: Mapping[str, Floats], system: Mapping[str, ArrayLike], belt_speed: ArrayLike) -> Parameters:
    """Cells of curves in a system, whose `friction_scale` multiplies friction at every speed; arrays broadcast."""
    scale = np.asarray(system["friction_scale"])
    of_cell = {name: value for name, value in system.items() if name != "friction_scale"}
    friction = {name: values * (1.0 if name == "a4" else scale) for name, values in curves.items()}
    return as_cells({**of_cell, **friction, "belt_speed": belt_speed})


def regimes(cells: Parameters, options: Options, moved: Moved | None = None) -> dict[str, NDArray[Any]]:
    """What the engine says of cells. Raises Interrupted on Ctrl-C."""
    size, before = cells["mass"].size, 0

    def note(done: float, _: int) -> None:
        nonlocal before
        if moved:
            moved(int(done) - before)
        before = int(done)

    found = compute(Cells.of(cells), options, note)
    if not found.complete:
        raise Interrupted(found.done, size)
    return found.results


def watcher(limits: Limits, first: int, curves: int, progress: Progress | None) -> Callable[[int, int], Moved]:
    """For one search of curves after the other, by number and how many they are, what counts its cells.

    first : curves of search 0. curves : of all searches. progress : called with curves done, in part too, and in all.
    """
    meter, sizes = Meter(limits.scan + int(-np.log2(limits.tolerance))), {0: first}

    def watch(number: int, size: int) -> Moved:
        if number:
            meter.end(number - 1, sizes[number - 1])
        sizes[number] = size
        count = meter.watch(number, size)

        def moved(cells: int) -> None:
            count(cells)
            if progress:
                progress(meter.items, curves)

        return moved

    return watch


def _last_borders(brackets: NDArray[np.void], vibrates: Flags, decided: Flags, scan: Scan, tolerance: float) -> Quiet:
    """From the brackets of all lines, and what the scan saw, the last end of vibration on each line."""
    count, places = len(vibrates), scan.places
    doubtful = vibrates | ~decided
    last = np.where(doubtful.any(axis=1), scan.points - 1 - np.argmax(doubtful[:, ::-1], axis=1), -1)
    speed, low = np.full(count, scan.low), np.zeros(count)
    state = np.full(count, QUIET, np.int8)
    at_top = last == scan.points - 1
    speed[at_top], state[at_top] = scan.high, VIBRATES
    known = vibrates & decided
    low[at_top] = np.where(known.any(axis=1), places[scan.points - 1 - np.argmax(known[:, ::-1], axis=1)], 0.0)[at_top]
    inside = np.flatnonzero((last >= 0) & ~at_top)
    speed[inside], state[inside] = places[last[inside] + 1], UNRESOLVED
    for one in brackets[(brackets["below"] == 1) & (brackets["above"] == 0)]:  # in order, so that the last one stays
        line = one["line"]
        if state[line] != UNRESOLVED or one["high"] < places[last[line]]:
            continue
        narrow = one["high"] - one["low"] <= scan.width(tolerance, one["low"], one["high"])
        speed[line] = one["low"] + (one["high"] - one["low"]) / 2 if narrow else one["high"]
        low[line], state[line] = one["low"], BORDER if narrow else UNRESOLVED
    return Quiet(speed, low, state)
