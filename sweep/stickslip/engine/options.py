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

Results = dict[str, NDArray[Any]]
Progress = Callable[[int, int], None]
StopFlag = NDArray[np.int64]

RTOL_RANGE = (1e-12, 1e-2)


@dataclass(frozen=True)
class Options:
    """How to integrate and how to spread the work. Defaults and limits are those of the configuration.

    law : one of `vocabulary.laws.LAWS`. horizon : s; inf for none. threads : None for one per processor.
    block : most cells computed together.
    """

    law: str = "stribeck"
    rtol: float = 1e-6
    horizon: float = inf
    max_steps: int = 100_000
    early_stop: bool = True
    threads: int | None = None
    block: int = 4096

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ValueError(f"law: got {self.law!r}, expected {', '.join(LAWS)}")
        if not RTOL_RANGE[0] <= self.rtol <= RTOL_RANGE[1]:
            raise ValueError(f"rtol: got {self.rtol!r}, expected {RTOL_RANGE[0]:g} to {RTOL_RANGE[1]:g}")
        if not self.horizon > 0:
            raise ValueError(f"horizon: got {self.horizon!r}, expected a time > 0 (s)")
        if not self.early_stop and isinf(self.horizon):
            raise ValueError("early_stop=False integrates every cell to the horizon, so it needs a finite horizon (s)")
        for name in ("max_steps", "block", "threads"):
            value = getattr(self, name)
            if not (value is None and name == "threads" or (isinstance(value, Integral) and int(value) >= 1)):
                raise ValueError(f"{name}: got {value!r}, expected a whole number >= 1")


@dataclass(frozen=True)
class Computed:
    """Results by names of `VARIABLES`, flat, in SI; `done` cells of them, fewer than all after an interruption."""

    results: Results
    done: int

    @property
    def complete(self) -> bool:
        """Whether every cell was computed."""
        return self.done == len(self.results["regime"])
