"""The motions of one cell, from stick and from near sliding: samples over time, friction curve, unstable cycle."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, isfinite, isnan, pi

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, compute, flows, friction_at_belt_speed
from stickslip.studies.exact import DISTURBANCE, Loop, steady_state, unstable_cycle
from stickslip.theory.contacts import time_to_cycle
from stickslip.vocabulary.cells import Cells, Parameters, as_cells
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.models.model import Scales
from stickslip.vocabulary.quantities import MODES, REGIMES, STATUS_MESSAGES, STATUSES

Floats = NDArray[np.float64]
_CYCLES, _SLOW_CYCLES = 3.4, 1.6  # shown of a cycle, and of one that sticks most of its time
_MOSTLY = 0.9  # of the period
_ALONE = 0.9  # of the period, after a slip that is not repeated
_LEAD = 0.12  # of what is shown, before the first break-away
_RINGING = 40.0  # natural periods at most, where something decays or never ends
_GROWTH = 12.0  # natural periods of growth that are shown before the first stick phase
_LONGEST = 400.0  # natural periods, of what vibrates without sticking
_SHORT = 6.0  # natural periods, where nothing happens
_PER_PERIOD, _FEWEST, _MOST = 400, 2001, 100_001  # samples
_OF_SLIP = 601  # samples
_DRAWN = 4000  # samples
_CURVE = 400  # points of the friction curve


@dataclass(frozen=True, eq=False)
class Motion:
    """One motion: samples by names of `TRACE_VARIABLES` over `time` (s, 0 at the first break-away if there is one).

    results : numbers by names of `VARIABLES`, in SI. why : the samples end early, or there are none. late : whether the
    beginning is left out.
    """

    label: str
    results: Mapping[str, float]
    time: Floats
    samples: Mapping[str, Floats]
    why: str = ""
    late: bool = False

    @property
    def regime(self) -> str:
        """The name of its regime."""
        return REGIMES[int(self.results["regime"])]

    @property
    def status(self) -> str:
        """The name of its status."""
        return STATUSES[int(self.results["status"])]


@dataclass(frozen=True, eq=False)
class CellMotions:
    """Both motions of a cell (parameters in SI), the second None where the belt is at rest; and what is behind them.

    steady : displacement of steady sliding, NaN where the belt is at rest. curve : slip speeds and friction
    coefficients. cycle : the unstable cycle, where one is known.
    """

    cell: Mapping[str, float]
    law: str
    stick: Motion
    sliding: Motion | None
    steady: float
    curve: tuple[Floats, Floats]
    cycle: Loop | None

    @property
    def motions(self) -> dict[str, Motion]:
        """Those there are, by the names of their lines."""
        return {"stick": self.stick} | ({} if self.sliding is None else {"sliding": self.sliding})


def motions_of(cell: Mapping[str, float], options: Options) -> CellMotions:
    """Both motions of a cell (parameters in SI by name). Raises TypeError or ValueError for what is no cell."""
    options = replace(options, early_stop=True, threads=1)
    arrays = as_cells(cell, options.law)
    sticking, results = isnan(arrays["velocity"][0]), _results(arrays, options)
    stick = _motion("from stick" if sticking else "from the start", arrays, results, options, sticking)
    steady = steady_state(arrays, options)
    beside = float(stick.time[-1]) if stick.time.size else inf
    slid = None
    if isfinite(steady[0]):
        near = arrays | {"displacement": steady, "velocity": arrays["belt_speed"] * DISTURBANCE}
        slid = _motion("from near sliding", near, _results(near, options), options, False, beside)
    cycle = unstable_cycle(arrays, int(results["regime"]), options) if sticking else None
    curve = _curve(arrays, [stick] if slid is None else [stick, slid], options)
    parameters = {name: float(values[0]) for name, values in arrays.items()}
    return CellMotions(parameters, options.law, stick, slid, float(steady[0]), curve, cycle)


def _results(cell: Parameters, options: Options) -> dict[str, float]:
    results = compute(Cells.of(cell), options).results
    return {name: float(values[0]) for name, values in results.items()}


def _motion(
    label: str, cell: Parameters, results: Mapping[str, float], options: Options, sticking: bool, beside: float = inf
) -> Motion:
    """The samples that show what happens; a long first stick phase is left out, and slow growth.

    beside : how long the motion is that it is shown with (s): what settles is not shown longer.
    """
    natural = 2.0 * pi * float(Scales(cell).time[0])
    if "growth_rate" in results and isfinite(results["period"]):  # no break-away; it cannot be begun later either
        far, belt = results["spring_force_max"] / cell["stiffness"][0], float(cell["belt_speed"][0])
        away = min(time_to_cycle(far, belt, results["growth_rate"]), _LONGEST * natural)
        begin, end = _window({**results, "breakaway_time": away}, natural, True, beside)
        sticking = False
    else:
        begin, end = _window(results, natural, sticking, beside)
    if _is_slow(results) and cell["ageing_rate"][0] != 0:
        end = min(end, results["breakaway_time"] + _ALONE * results["period"])
    first = begin if sticking else 0.0  # what sticks can be begun anywhere
    origin = results["breakaway_time"] if isfinite(results["breakaway_time"]) else 0.0
    if first > 0.0:
        cell = _carried(cell, first)
    count = int(np.clip((end - first) / natural * _PER_PERIOD, _FEWEST, _MOST))
    times = np.linspace(0.0, end - first, count)
    samples = {name: values[0] for name, values in flows(cell, times[-1:], count, options).items()}
    known = int(np.isfinite(samples["displacement"]).sum())  # none behind where the integration ended
    why = "" if known == count else _why(results, times[max(known - 1, 0)] + first)
    shown = _essential(samples["mode"][:known], times[:known] + first >= begin) if known > 1 else np.zeros(0, np.intp)
    drawn = {name: values[shown] for name, values in samples.items()} if shown.size else {}
    times = times[shown] + first - origin
    if sticking and _is_slow(results):
        times, drawn = _with_slips(times, drawn, cell, origin - first, results, options)
    return Motion(label, results, times, drawn, why, late=begin > first)


def _carried(cell: Parameters, seconds: float) -> Parameters:
    """A cell that sticks, started so much later: the mass moves with the belt."""
    return cell | {
        "displacement": cell["displacement"] + cell["belt_speed"] * seconds,
        "contact_time": cell["contact_time"] + seconds,
    }


def _is_slow(results: Mapping[str, float]) -> bool:
    """True if slips are so short beside the stick phases that even samples do not show them."""
    return results["stick_fraction"] > _MOSTLY


def _with_slips(
    times: Floats, drawn: Mapping[str, Floats], cell: Parameters, away: float, results: Mapping[str, float],
    options: Options,
) -> tuple[Floats, dict[str, Floats]]:  # fmt: skip
    """A motion that sticks most of its time, its slips sampled for themselves.

    All of them begin in the same state. On an ageing contact they do not, and what is shown ends before the second.
    away : from the state of `cell` to the first break-away (s).
    """
    slip = results["restick_time"] - results["breakaway_time"]
    whole = flows(_carried(cell, away), np.array([slip]), _OF_SLIP, options)
    dense = {name: values[0] for name, values in whole.items()}
    sticks = drawn["mode"] == MODES.index("stick")
    slips = [start for start in (0.0, results["period"]) if start < times[-1]]
    at = np.concatenate([times[sticks], *(np.linspace(start, start + slip, _OF_SLIP) for start in slips)])
    order = np.argsort(at, kind="stable")
    merged = {name: np.concatenate([drawn[name][sticks], *([dense[name]] * len(slips))])[order] for name in drawn}
    rising = np.flatnonzero(np.diff(at[order], prepend=-inf) > 0)
    return at[order][rising], {name: values[rising] for name, values in merged.items()}


def _why(results: Mapping[str, float], reached: float) -> str:
    """The reason why the integration ended early, as far as the verdict on the cell tells."""
    status = STATUSES[int(results["status"])]
    why = f"{status.replace('_', ' ')}: {STATUS_MESSAGES[status]}"
    return f"the motion is known to {reached:.4g} s after its start, {why}"


def _window(results: Mapping[str, float], natural: float, sticking: bool, beside: float) -> tuple[float, float]:
    """From when to when a motion is worth seeing (s since its start)."""
    regime, period = REGIMES[int(results["regime"])], results["period"]
    away = results["breakaway_time"] if isfinite(results["breakaway_time"]) else 0.0
    if regime == "stick_slip" and not sticking and _is_slow(results):
        return max(0.0, away - period), results["restick_time"] + 2.0 * natural  # growth until it sticks
    if regime == "stick_slip":
        cycles = _SLOW_CYCLES if results["stick_fraction"] > _MOSTLY else _CYCLES
        shown = period * cycles if isfinite(period) else _RINGING * natural  # irregular
        growth = 0.0 if sticking else _GROWTH * natural
        return max(0.0, away - max(growth, _LEAD * shown)), away + shown
    if regime in ("damped", "creep"):
        settling = results["settling_time"]
        shown = min(1.2 * settling, _RINGING * natural) if isfinite(settling) else _RINGING * natural
        shown = min(max(shown, natural), beside)
    elif regime == "stuck":
        return 0.0, _SHORT * natural
    else:
        whole = min(max(10.0 * period, _SHORT * natural), _LONGEST * natural)
        shown = whole if isfinite(period) else _RINGING * natural
    away = away if sticking else 0.0
    return max(0.0, away - _LEAD * shown), away + shown


def _essential(mode: Floats, visible: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return which samples are drawn: of a stick phase, a straight line, its ends; of slip as many as can be seen."""
    stick = mode == MODES.index("stick")
    inside = stick.copy()
    inside[0] = inside[-1] = False
    inside[1:-1] &= stick[:-2] & stick[2:]
    edges = stick & ~inside | np.append(False, stick[:-1]) | np.append(stick[1:], False)
    slips = np.flatnonzero(visible & ~inside)
    step = max(1, int(np.ceil(slips.size / _DRAWN)))
    chosen = np.zeros(mode.size, np.bool_)
    chosen[slips[::step]] = True
    chosen |= edges & visible & ~inside
    places = np.flatnonzero(chosen)
    return places if places.size > 1 else np.flatnonzero(visible)[:: max(1, mode.size // _DRAWN)]


def _curve(cell: Parameters, shown: list[Motion], options: Options) -> tuple[Floats, Floats]:
    """The friction curve over the slip speeds that occur, dense where it is steep."""
    fastest = [np.abs(motion.samples["relative_speed"]).max() for motion in shown if motion.samples]
    curve = model_of(options.law).curve
    decay = cell[curve.decay][0] if curve else 0.0
    reach = 1.05 * max([*fastest, 2.0 * abs(cell["belt_speed"][0]), 3.0 * decay])
    least = 0.0 if curve else 1e-6 * reach  # other friction need not be finite at rest
    w = np.unique(np.concatenate([np.linspace(least, reach, _CURVE), np.geomspace(1e-6 * reach, reach, _CURVE)]))
    cells = {name: np.full(w.size, values[0]) for name, values in cell.items()} | {"belt_speed": w}
    return w, friction_at_belt_speed(cells, options)
