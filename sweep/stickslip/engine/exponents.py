"""Cells of `stribeck_delta` by their exponent: 1 and 2 have kernels of their own, which take a tenth of the time.

Which kernels compute a cell depends on that cell alone, so its numbers do not depend on its neighbours.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.engine import compiled
from stickslip.engine.options import StopFlag
from stickslip_kernels import layout
from stickslip_kernels.drive import Segments
from stickslip_kernels.observers.signals import Signals

Floats = NDArray[np.float64]
OWN_KERNELS = {1.0: "stribeck", 2.0: "gaussian"}  # by exponent: laws of the kernels that have a Taylor step
_load = cache(compiled.warm_up)  # once a process, and only what some cell needs


def run(
    law: str, belts: Any, observer: Any, cells: Floats, rtol: float, max_steps: int, stop: StopFlag | None = None
) -> None:
    """`compiled.run`, each cell by the kernels that suit it; they are loaded, or compiled, when first needed."""
    for name, chosen in _kernels(law, cells[layout.DELTA]):
        _load(name, isinstance(observer, Signals))
        if chosen is None:
            compiled.run(name, belts, observer, cells, rtol, max_steps, stop)
            continue
        part = observer._replace(results=np.ascontiguousarray(observer.results[:, chosen]))
        if isinstance(part, Signals):
            part = part._replace(runs=part.runs[chosen])
        spans = belts._replace(spans=belts.spans[chosen]) if isinstance(belts, Segments) else belts
        compiled.run(name, spans, part, np.ascontiguousarray(cells[:, chosen]), rtol, max_steps, stop)
        observer.results[:, chosen] = part.results


def _kernels(law: str, exponents: Floats) -> Iterator[tuple[str, NDArray[np.bool_] | None]]:
    """Names of kernels, and which cells are theirs; None for all."""
    left = np.ones(exponents.size, bool)
    for exponent, name in OWN_KERNELS.items() if law == "stribeck_delta" else ():
        chosen = exponents == exponent
        left &= ~chosen
        if chosen.any():
            yield name, None if chosen.all() else chosen
    if left.any() or not left.size:
        yield law, None if left.all() else left
