"""What margins ask the engine: labels of cells that were changed."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.borders import Looked
from stickslip.distances.reach import is_possible
from stickslip.engine import Options, StopFlag, compute_range
from stickslip.errors import StoppedError
from stickslip.vocabulary.cells import Cells
from stickslip.vocabulary.flags import DECIDED, REGIMES, UNDECIDED

Integers = NDArray[np.int64]
Floats = NDArray[np.float64]
Labels = NDArray[np.int8]
NOT_COMPUTED = REGIMES.index("not_computed")


@dataclass(frozen=True, eq=False)
class Asked:
    """Cells, by parameters of length n, and how they are computed, until `stop` is raised. moved : as of a study."""

    cells: Cells
    options: Options
    stop: StopFlag
    moved: Callable[[int], None] | None = None

    def regimes(self, which: Integers, changed: Cells) -> Labels:
        """Regimes of the cells `which` (m,) with other values (m,) of some parameters; impossible ones are not
        computed. Raises StoppedError."""
        return self._computed(which, changed)[0]

    def looked(self, which: Integers, changed: Cells, into: list[int] | None) -> Looked:
        """The same as a search takes it: labels (with `into`, whether it is one of these regimes), and the guide to
        where stick-slip ends by grazing."""
        regimes, guide = self._computed(which, changed)
        labels = regimes if into is None else np.isin(regimes, into).astype(np.int8)
        return Looked(labels, decided(regimes), guide)

    def _computed(self, which: Integers, changed: Cells) -> tuple[Labels, Floats]:
        some = {name: values[which] for name, values in self.cells.items()} | changed
        possible = np.flatnonzero(is_possible(some))
        found, guide = np.full(which.size, NOT_COMPUTED, np.int8), np.full(which.size, np.nan)
        if possible.size:
            kept = {name: values[possible] for name, values in some.items()}

            def cells(start: int, stop: int) -> Cells:
                return {name: values[start:stop] for name, values in kept.items()}

            done = compute_range(cells, 0, possible.size, self.options, self.stop, self.moved, often=True)
            if not done.complete:
                raise StoppedError
            found[possible], guide[possible] = done.results["regime"], done.results["restick_margin"]
        return found, guide


def decided(regimes: Labels) -> NDArray[np.bool_]:
    """Which regimes say what the motion is."""
    return ~np.isin(regimes, UNDECIDED)


def codes(names: Collection[str]) -> list[int]:
    """Codes of regimes by names; raises ValueError for others."""
    for name in names:
        if name not in DECIDED:
            raise ValueError(f"into: got {name!r}, expected {', '.join(DECIDED)}")
    return [REGIMES.index(name) for name in names]
