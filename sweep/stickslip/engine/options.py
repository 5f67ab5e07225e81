"""How to integrate, and what comes back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isinf
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.vocabulary.laws import LAWS
from stickslip.vocabulary.settings import EXECUTION, SOLVER

Results = dict[str, NDArray[Any]]
Progress = Callable[[float, int], None]
StopFlag = NDArray[np.int64]
_CHECKED = (SOLVER["rtol"], SOLVER["max_steps"], EXECUTION["block"], EXECUTION["threads"])


@dataclass(frozen=True)
class Options:
    """How to integrate and how to spread the work. Defaults and limits are those of the configuration.

    law : one of `vocabulary.laws.LAWS`. horizon : s; inf for none. threads : None for one per processor.
    block : most cells computed together. variables : the only ones that are kept, `regime` among them; None for all.
    """

    law: str = "stribeck"
    rtol: float = 1e-6
    horizon: float = inf
    max_steps: int = 100_000
    early_stop: bool = True
    threads: int | None = None
    block: int = 4096
    variables: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ValueError(f"law: got {self.law!r}, expected {', '.join(LAWS)}")
        if not self.horizon > 0:
            raise ValueError(f"horizon: got {self.horizon!r}, expected a time > 0 (s)")
        if not self.early_stop and isinf(self.horizon):
            raise ValueError("early_stop=False integrates every cell to the horizon, so it needs a finite horizon (s)")
        for row in _CHECKED:
            value = getattr(self, row.name)
            if value is None and row.word:
                continue
            if row.whole and not isinstance(value, int | Integral) or not row.allows(value):
                raise ValueError(f"{row.name}: got {value!r}, expected {row.expected.removesuffix(row.otherwise)}")


@dataclass(frozen=True)
class Computed:
    """Results by names of `VARIABLES`, flat, in SI; `done` cells of them, fewer than all after an interruption."""

    results: Results
    done: int

    @property
    def complete(self) -> bool:
        """Whether every cell was computed."""
        return self.done == len(self.results["regime"])
