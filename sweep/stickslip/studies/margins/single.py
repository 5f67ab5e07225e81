"""Labels of cells that were changed, and the nearest borders below and above the value of a parameter."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import Options, StopFlag, solve
from stickslip.studies.borders.lines import growth_of, guide_of
from stickslip.studies.borders.search import Brackets, Floats, GuideAt, Integers, Labels, Looked, Scan, search_lines
from stickslip.studies.margins.reach import Reach
from stickslip.vocabulary.cells import Parameters, impossible, taken
from stickslip.vocabulary.flags import REGIMES, UNDECIDED, VIBRATING
from stickslip.vocabulary.models import model_of

NOT_COMPUTED = REGIMES.index("not_computed")
_VIBRATING = [REGIMES.index(name) for name in VIBRATING]


@dataclass(frozen=True, eq=False)
class MarginSearch:
    """Cells, by parameters of length n, and how they are computed, until `stop` is raised.

    speeds : belt speeds (m/s) at all of which a cell is computed: the worst of its regimes counts. None: its own.
    moved : as of a study. home : regimes of the cells, where those of the other kind are looked for: quiet ones of what
    vibrates, else vibrating ones. steps : of integration that each cell took so far (n,).
    """

    cells: Parameters
    options: Options
    stop: StopFlag
    speeds: tuple[float, ...] = ()
    moved: Callable[[int], None] | None = None
    home: Labels | None = field(default=None, kw_only=True)
    steps: Floats = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", np.zeros(next(iter(self.cells.values())).size))

    def regimes(self, which: Integers, changed: Parameters) -> Labels:
        """Regimes of the cells `which` (m,) with other values (m,) of some parameters; impossible ones are not
        computed. Raises StoppedError."""
        return self._computed(which, changed)[0]

    def looked(self, which: Integers, changed: Parameters, into: list[int] | None) -> Looked:
        """The same as a search takes it: labels (with `into`, whether it is one of these regimes), and the guide to
        where stick-slip ends by grazing."""
        regimes, guide = self._computed(which, changed)
        if into is None:
            return Looked(regimes, decided(regimes), guide)
        entered = np.isin(regimes, into)
        if self.home is not None:
            entered |= np.isin(regimes, _VIBRATING) != np.isin(self.home[which], _VIBRATING)
        return Looked(entered.astype(np.int8), decided(regimes), guide)

    def guide_at(self, cells_at: Callable[[Integers, Floats], tuple[Integers, Parameters]]) -> GuideAt | None:
        """The guide by theory, where it knows one. cells_at : which cells, and what is changed, by line and place."""
        if self.speeds:
            return None

        def cells(line: Integers, place: Floats) -> Parameters:
            which, changed = cells_at(line, place)
            return model_of(self.options.law).without_measured(taken(self.cells, which) | changed)

        return growth_of(cells, self.options)

    def _computed(self, which: Integers, changed: Parameters) -> tuple[Labels, Floats]:
        law, model = self.options.law, model_of(self.options.law)
        cells = model.without_measured(taken(self.cells, which) | changed)
        possible = np.flatnonzero(~impossible(cells, model.rules[law]))
        regimes, guide = np.full(which.size, NOT_COMPUTED, np.int8), np.full(which.size, np.nan)
        if possible.size:
            each = max(len(self.speeds), 1)
            lanes = taken(cells, np.repeat(possible, each))
            if self.speeds:
                lanes["belt_speed"] = np.tile(self.speeds, possible.size)
            results = solve(lanes, self.options, self.stop, self.moved)
            np.add.at(self.steps, which[possible], results["steps"].reshape(-1, each).sum(axis=1))
            regimes[possible] = worst(results["regime"].reshape(-1, each))
            if not self.speeds:  # of several speeds none leads to where all are quiet
                guide[possible] = guide_of(results, self.options)
        return regimes, guide


def worst(regimes: Labels) -> Labels:
    """Of regimes (n, k) those that matter most: a vibration, else one that is not decided, else the first."""
    rank = np.zeros(len(REGIMES), np.int8)
    rank[list(UNDECIDED)] = 1
    rank[[REGIMES.index(name) for name in reversed(VIBRATING)]] = 2, 3
    return np.take_along_axis(regimes, np.argmax(rank[regimes], axis=1)[:, None], 1)[:, 0]


def decided(regimes: Labels) -> NDArray[np.bool_]:
    """Return which regimes say what the motion is."""
    return ~np.isin(regimes, UNDECIDED)


@dataclass(frozen=True, eq=False)
class Borders:
    """The nearest borders of n cells: (n, 2), below and above the value; NaN, and regime 0, where there is none.

    low, high : the last bracket in SI. border : in it. change : of the side beyond, as `Reach` measures it.
    beyond : regime there.
    """

    low: Floats
    high: Floats
    border: Floats
    change: Floats
    beyond: Labels


def nearest(
    search: MarginSearch, reach: Reach, home: Labels, into: list[int] | None, points: int, tolerance: float
) -> Borders:
    """The first change of regime on the way down and up.

    home : regimes of the cells as they are; those that are undecided have no border. into : codes of the regimes to be
    entered; None for any other. points : places looked at first on either side, evenly spaced in the change.
    """
    size = home.size
    room = np.stack(reach.room)

    def cells_at(line: Integers, place: Floats) -> tuple[Integers, Parameters]:
        cell, up = lines[line] // 2, lines[line] % 2
        change = place * room[up, cell] * np.where(up == 1, 1.0, -1.0)
        return cell, {reach.name: reach.at(change, cell)}

    searched = np.flatnonzero(decided(home))
    lines = np.repeat(2 * searched, 2) + np.tile([0, 1], searched.size)
    lines = lines[room[lines % 2, lines // 2] > 0]
    scan = Scan(0.0, 1.0, points + 1, "linear")
    brackets, _ = search_lines(
        lines.size, scan, tolerance, lambda line, place: search.looked(*cells_at(line, place), into),
        search.guide_at(cells_at),
    )  # fmt: skip
    brackets["line"] = lines[brackets["line"]]
    return _table(first_entries(brackets, into), search, reach, size)


def first_entries(brackets: Brackets, into: list[int] | None) -> Brackets:
    """The first bracket of each line; with `into`, whose labels are 0 and 1, the first that enters."""
    entries = brackets if into is None else brackets[brackets["above"] == 1]
    _, first = np.unique(entries["line"], return_index=True)
    return entries[first]


def _table(brackets: Brackets, search: MarginSearch, reach: Reach, size: int) -> Borders:
    """First brackets as tables (n, 2)."""
    cell, up = brackets["line"] // 2, brackets["line"] % 2
    sign = np.where(up == 1, 1.0, -1.0)
    room = np.stack(reach.room)[up, cell]
    near, far, place = (reach.at(brackets[end] * room * sign, cell) for end in ("low", "high", "place"))
    low, high, border, change = (np.full((size, 2), np.nan) for _ in range(4))
    low[cell, up], high[cell, up] = np.minimum(near, far), np.maximum(near, far)
    border[cell, up] = place
    change[cell, up] = brackets["high"] * room * sign
    beyond = np.zeros((size, 2), np.int8)
    beyond[cell, up] = search.regimes(cell, {reach.name: far})
    return Borders(low, high, border, change, beyond)
