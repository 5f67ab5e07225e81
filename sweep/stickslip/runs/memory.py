"""Studies computed in memory, their blocks on the threads of this process, and what the calls for them share."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import prod
from typing import Any

import xarray as xr
from numpy.typing import ArrayLike

from stickslip.config.grid import options_of
from stickslip.config.model import Config
from stickslip.config.reader import Given, as_config
from stickslip.config.sections import StudySection
from stickslip.config.studies import Study, is_config, study_class
from stickslip.dataset.provenance import provenance
from stickslip.engine import Options, Progress, Results, SolverKeywords, spread, stop_flag, warm_up
from stickslip.errors import Interrupted, StoppedError
from stickslip.progress import Watch, watched
from stickslip.runs.blocks import blocks_of
from stickslip.studies.study import Meter

CellsLike = Mapping[str, ArrayLike] | xr.Dataset
CellsOrConfig = CellsLike | Given


def compute_study(study: Study, progress: Progress | None = None) -> list[Results]:
    """The results of all blocks, in order. Raises Interrupted on Ctrl-C, and what computing a block raises.

    progress : called with (items done, in part too, and items in all) from this thread, now and then.
    """
    for law in study.kernels:
        warm_up(law)
    size = prod(study.shape)
    blocks, stop, meter = blocks_of((size,), study.weight), stop_flag(), Meter(study.cells_each)
    computed: dict[int, Results] = {}

    def compute(number: int) -> None:
        items = blocks.cells(number)
        with suppress(StoppedError):
            computed[number] = study.compute(items, stop, meter.watch(number, len(items)))
        meter.end(number, len(items) if number in computed else 0)

    def show(_: list[None]) -> None:
        if progress:
            progress(meter.items, size)

    try:
        show([])
        spread(compute, range(blocks.count), study.options.threads, stop, show)
    except KeyboardInterrupt:
        raise Interrupted(sum(len(blocks.cells(number)) for number in computed), size, counted=study.counted) from None
    return [computed[number] for number in range(blocks.count)]


@dataclass(frozen=True)
class Subject:
    """The cells that a call is about, a configuration or a list, and how to integrate them."""

    cells: CellsLike | Config
    options: Options
    solver: Mapping[str, Any]  # of the keywords, those that a configuration has in its section

    @classmethod
    def of(cls, given: CellsOrConfig, keywords: SolverKeywords) -> Subject:
        """From what a call was given. Raises TypeError, ValueError or ConfigError."""
        if not is_config(given):
            return cls(given, Options.of(keywords).for_contact(given), {})  # type: ignore[arg-type]
        config = as_config(given)
        named = keywords.get("options")
        law = named.law if named else keywords.get("law")
        if keywords.get("law") is not None or law not in (None, config.friction.law):
            raise ValueError(f"law: got {law!r}, but a configuration says its law itself: {config.friction.law}")
        options = Options.of(keywords, options_of(config))
        solver = {name: keywords[name] for name in ("horizon", "max_steps") if keywords.get(name) is not None}
        return cls(config, options, solver)

    def computed(self, section: StudySection, progress: Watch) -> xr.Dataset:
        """The result of the study that a section asks for, which it keeps. Raises TypeError or ValueError."""
        study = study_class(section.key).of(self.cells, section, self.options)
        title = study.title
        if isinstance(self.cells, Config):
            title = f"{title}: {self.cells.title}"
            solver = self.cells.solver.model_copy(update=self.solver)
            text = self.cells.model_copy(update={"study": section, "solver": solver}).to_yaml()
        else:
            text = study.options.described(**{section.key: section.resolved()})
        with watched(progress, study.counted, study.options.law) as moved:
            return study.dataset(compute_study(study, moved), provenance(text, title=title, action=section.action))
