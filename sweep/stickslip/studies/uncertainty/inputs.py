"""The cells behind draws: what the configuration fixes or varies, and what it leaves to chance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.config.grid import build_grid
from stickslip.config.model import Config
from stickslip.config.uncertain import Uncertain
from stickslip.engine import Computed, Options, StopFlag, blank_results, compute_range
from stickslip.vocabulary.cell_values import impossible
from stickslip.vocabulary.cells import Cells, Parameters, taken
from stickslip.vocabulary.flags import REGIMES
from stickslip.vocabulary.models import model_of
from stickslip.vocabulary.quantities import MEASURED

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Inputs:
    """Cells of a configuration with uncertain quantities."""

    config: Config

    @property
    def uncertain(self) -> Uncertain:
        """The quantities that scatter."""
        if self.config.uncertain is None:
            raise ValueError("this configuration has no section uncertain")
        return self.config.uncertain

    @cached_property
    def grid(self) -> Cells:
        """The cells of its axes, without what is uncertain."""
        return build_grid(self.config)

    def cells(self, numbers: NDArray[np.int64], normals: Floats) -> tuple[Parameters, NDArray[np.bool_]]:
        """Parameters of cells of the axes, their uncertain ones drawn; and which of the draws an oscillator can have.

        numbers : of cells of the axes, (n,). normals : independent standard normal deviates, (n, quantities).
        Others (friction below 0, mu_stop above its start, ...) are `failed`; a configuration with more than one in some
        thousand of them is refused when it is read.
        """
        drawn = self.uncertain.values(normals)
        cells = self.grid.take(numbers, **drawn)
        law = self.config.friction.law
        model = model_of(law)
        wrong, curve = impossible(cells, model.rules[law]), model.curve
        if curve and MEASURED.keys() & drawn.keys():
            wrong |= ~(cells[curve.drop] > 0)  # its minimum is not below its start
        return cells, ~wrong

    def compute(
        self,
        numbers: NDArray[np.int64],
        normals: Floats,
        options: Options,
        stop: StopFlag,
        moved: Callable[[int], None] | None = None,
    ) -> Computed:
        """Their results, by the calling thread."""
        cells, possible = self.cells(numbers, normals)
        chosen = Cells.of(taken(cells, possible))
        computed = compute_range(chosen, 0, chosen.size, options, stop, moved)
        results = blank_results(numbers.size, options)
        results["regime"][:] = REGIMES.index("failed")
        for name, values in results.items():
            values[possible] = computed.results[name]
        return Computed(results, computed.done + numbers.size - chosen.size)

    def attributes(self, undecided: float) -> dict[str, str]:
        """Global attributes of a result: method, quantities, correlation, and the share of undecided draws."""
        uncertain = self.uncertain
        return {
            "uncertain_method": uncertain.method_in_words,
            "uncertain_quantities": "; ".join(
                f"{name}: {scatter.in_words(name)}" for name, scatter in uncertain.quantities.items()
            ),
            "uncertain_correlation": uncertain.correlation_in_words,
            "uncertain_undecided": f"{100 * undecided:.3g} % of all draws were unresolved, failed or not computed",
        }
