"""The verdict on places of a plane: quiet over whole ranges, as often as a goal wants it, or not.

A range is looked at in some values, and then about the one at which the motion comes closest to re-sticking (the least
slip speed over the belt speed), at ever smaller distances. All places have the same draws of what scatters, so that
borders are smooth, and what differs between places is no luck.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.studies.draws import computed_where
from stickslip.studies.lines import Side
from stickslip.studies.margin_search import MarginSearch
from stickslip.studies.plane import OPEN
from stickslip.studies.search import Floats, Integers, Labels, Looked
from stickslip.vocabulary.cells import Parameters, impossible, taken
from stickslip.vocabulary.flags import REGIMES, UNDECIDED, VERDICTS, VIBRATING
from stickslip.vocabulary.models import model_of

VIBRATES, QUIET, IMPOSSIBLE = (VERDICTS.index(name) for name in ("vibrates", "quiet", "impossible"))
ROUNDS = 3  # of halving the distance to the values looked at next
_TOGETHER = 65_536  # cells with a draw each that are looked at together
_VIBRATING = [REGIMES.index(name) for name in VIBRATING]


class Judged(NamedTuple):
    """Of places (n,): verdicts, what is undecided being `plane.OPEN`; shares of the draws that are quiet, and that are
    undecided, and the standard error of the first; a guide to borders, as `search.Looked` has it."""

    verdict: Labels
    quiet: Floats
    undecided: Floats
    error: Floats
    guide: Floats


@dataclass(frozen=True, eq=False)
class Demand(MarginSearch):
    """A search whose labels are verdicts.

    measured : whether coefficients of friction follow from what is measured of the curve. ranges : of the values to be
    quiet over. drawn : what scatters, (draws,), `scramblings` independent parts one after the other. probability : of
    being quiet. computed : cells so far.
    """

    measured: bool = False
    ranges: tuple[Side, ...] = ()
    drawn: Parameters = field(default_factory=dict)
    scramblings: int = 1
    probability: float = 1.0
    computed: list[int] = field(default_factory=lambda: [0])

    @property
    def draws(self) -> int:
        """Return how many cells stand for a place at a value of each range."""
        return next((values.size for values in self.drawn.values()), 1)

    def judged(self, panel: Integers, changed: Parameters, shares: bool = False) -> Judged:
        """Verdicts on cells of panels with other values of some parameters. Raises StoppedError.

        shares : whether those are needed as well; else no place is looked at further once it is known to vibrate.
        """
        step, parts = max(_TOGETHER // self.draws, 1), []
        for start in range(0, max(panel.size, 1), step):
            part = slice(start, start + step)
            parts.append(self._together(panel[part], taken(changed, part), shares))
        return Judged(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def looked(self, which: Integers, changed: Parameters, into: list[int] | None) -> Looked:
        """Whether verdicts are among `into`; what is undecided is not quiet, and known to be."""
        judged = self.judged(which, changed)
        return Looked(np.isin(judged.verdict, into or []).astype(np.int8), judged.verdict != IMPOSSIBLE, judged.guide)

    def guide_at(self, cells_at: object) -> None:
        """None: theory knows no verdicts."""
        return

    def _computed(self, which: Integers, changed: Parameters) -> tuple[Labels, Floats]:
        judged = self.judged(which, changed)
        return judged.verdict, judged.guide

    @property
    def allowed(self) -> int:
        """Return how many draws need not be quiet."""
        return int((1.0 - self.probability) * self.draws * (1 + 1e-12))

    def _together(self, panel: Integers, changed: Parameters, shares: bool) -> Judged:
        lanes = {name: np.repeat(v, self.draws) for name, v in (taken(self.cells, panel) | changed).items()}
        lanes |= {name: np.tile(values, panel.size) for name, values in self.drawn.items()}
        seen = _Lanes(self, lanes, panel.size * self.draws, self.draws if shares else self.allowed)
        for place in _places(len(self.ranges), self.ranges[0].points):
            which = np.flatnonzero(seen.open)
            seen.look(which, np.broadcast_to(place, (which.size, len(place))))
        seen.close_in(1.0 / (self.ranges[0].points - 1))
        shape = panel.size, self.scramblings, self.draws // self.scramblings
        vibrates, undecided = (flags.reshape(shape) for flags in (seen.vibrates, seen.undecided & ~seen.vibrates))
        quiet = 1.0 - (vibrates | undecided).mean(axis=2)
        error = np.zeros(panel.size)
        if shape[1] > 1:
            error = np.fmax(quiet.std(axis=1, ddof=1) / np.sqrt(shape[1]), 1.0 / self.draws)
        allowed = self.allowed
        bad, open_ones = (flags.sum(axis=(1, 2)) for flags in (vibrates, undecided))
        verdict = np.where(bad > allowed, VIBRATES, np.where(bad + open_ones > allowed, OPEN, QUIET))
        verdict[~seen.possible.reshape(shape).any(axis=(1, 2))] = IMPOSSIBLE
        closest = np.where(seen.undecided, -np.inf, seen.closest).reshape(panel.size, self.draws)
        guide = np.partition(closest, allowed, axis=1)[:, allowed] if allowed < self.draws else np.inf * bad
        return Judged(verdict.astype(np.int8), quiet.mean(axis=1), undecided.mean(axis=(1, 2)), error,
                      np.where(np.isfinite(guide), guide, np.nan))  # fmt: skip


class _Lanes:
    """Cells with a draw each, all of them over the ranges, and what was seen of each so far.

    closest : least slip speed over the belt speed, below 0 where it sticks again; at : where that was, as shares of
    the ranges (lanes, ranges). possible : whether there is such a cell. most : draws of a place that may vibrate.
    """

    def __init__(self, demand: Demand, cells: Parameters, size: int, most: int) -> None:
        self._demand, self._cells, self._most = demand, cells, most
        self.vibrates, self.undecided, self.possible = (np.zeros(size, np.bool_) for _ in range(3))
        self.closest, self.at = np.full(size, np.inf), np.zeros((size, len(demand.ranges)))

    @property
    def open(self) -> NDArray[np.bool_]:
        """Return which lanes may still matter: not of places where more than `most` draws vibrate."""
        vibrating = self.vibrates.reshape(self.vibrates.size // self._demand.draws, self._demand.draws)
        return np.asarray(~(vibrating | (vibrating.sum(axis=1, keepdims=True) > self._most)).ravel())

    def look(self, which: Integers, shares: Floats) -> None:
        """Compute some lanes at shares (which, ranges) of the ranges."""
        if not which.size:
            return
        demand, law = self._demand, self._demand.options.law
        model, cells = model_of(law), taken(self._cells, which)
        cells |= {side.name: _value(side, shares[:, i]) for i, side in enumerate(demand.ranges)}
        cells = model.without_measured(cells) if demand.measured else cells
        possible = ~impossible(cells, model.rules.get(law, ()))
        computed = computed_where(cells, possible, demand.options, demand.stop, demand.moved)
        demand.computed[0] += int(possible.sum())
        regime, margin = computed["regime"], computed.get("restick_margin")
        margin = np.full(regime.shape, np.nan) if margin is None else margin
        self.possible[which] |= possible
        self.vibrates[which] |= np.isin(regime, _VIBRATING)
        self.undecided[which] |= np.isin(regime, UNDECIDED)
        with np.errstate(divide="ignore", invalid="ignore"):
            near = margin / np.abs(cells["belt_speed"])
        closer = near < self.closest[which]
        self.closest[which[closer]], self.at[which[closer]] = near[closer], shares[closer]

    def close_in(self, distance: float) -> None:
        """Look about the places that are closest to sticking, at halves of a distance, and of these, and so on."""
        for _ in range(ROUNDS):
            distance /= 2
            for column, sign in product(range(self.at.shape[1]), (-1.0, 1.0)):
                shares = self.at.copy()
                shares[:, column] += sign * distance
                inside = (shares[:, column] >= 0) & (shares[:, column] <= 1)
                which = np.flatnonzero(inside & self.open & np.isfinite(self.closest))
                self.look(which, shares[which])


def _places(ranges: int, points: int) -> Iterator[NDArray[np.float64]]:
    """Shares of the ranges that are looked at first, their ends before what is between: most vibrate there."""
    shares = np.linspace(0.0, 1.0, points)
    places = product(range(points), repeat=ranges)
    for place in sorted(places, key=lambda place: sum(0 < i < points - 1 for i in place)):
        yield shares[list(place)]


def _value(side: Side, share: Floats) -> Floats:
    """Values at shares of a range, by ratio where it is above 0; the ends are exact."""
    if side.spacing == "log":
        between = side.low * (side.high / side.low) ** share
    else:
        between = side.low + (side.high - side.low) * share
    return np.asarray(np.select([share == 0.0, share == 1.0], [side.low, side.high], between))
