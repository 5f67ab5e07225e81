"""Blocks computed on the threads of this process: of a run, each written as soon as it is there, or of a study that
stays in memory, with what the calls for one share.
"""

from __future__ import annotations

import threading
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from math import prod
from typing import TYPE_CHECKING, Any

import xarray as xr
from numpy.typing import ArrayLike

from stickslip import engine
from stickslip.config.grid import options_of
from stickslip.config.model import Config
from stickslip.config.reader import Given, as_config
from stickslip.config.sections import StudySection
from stickslip.config.studies import Moved, Study, is_config, study_class
from stickslip.dataset.build import provenance
from stickslip.engine import Options, Progress, Results, SolverKeywords, StopFlag
from stickslip.errors import Interrupted, StoppedError, StoreError
from stickslip.progress import Watch, watched
from stickslip.runs.work import Block, Work, blocks_of

if TYPE_CHECKING:
    from stickslip.runs.block_store import BlockStore

_MOST = 0.95  # of items that may take more cells than expected, until they are done
_WAITING = 2  # threads that may wait for the disk, besides those that compute
CellsLike = Mapping[str, ArrayLike] | xr.Dataset
CellsOrConfig = CellsLike | Given


class Meter:
    """Count of finished items, by many threads; those under way by the share of the cells they may take.

    cells_each : as that of a study. done : items found finished.
    """

    def __init__(self, cells_each: int, done: int = 0) -> None:
        self._each, self._done, self._lock = cells_each, done, threading.Lock()
        self._under_way: dict[int, tuple[int, int]] = {}  # items and cells, by number of the block

    def watch(self, number: int, items: int) -> Moved:
        """Return what computing a block of so many items calls with cells computed."""

        def moved(cells: int) -> None:
            with self._lock:
                self._under_way[number] = items, self._under_way.get(number, (items, 0))[1] + cells

        return moved

    def end(self, number: int, items: int) -> None:
        """Count a block as done, or with no items as none."""
        with self._lock:
            self._under_way.pop(number, None)
            self._done += items

    @property
    def items(self) -> float:
        """Items done; a whole number where no block is under way, or where an item is a cell."""
        with self._lock:
            most = 1.0 if self._each <= 1 else _MOST  # where they take more cells than expected, not yet all
            return self._done + sum(min(cells / max(self._each, 1), most * n) for n, cells in self._under_way.values())


@dataclass
class Tally:
    """The outcome of the blocks of a run. `cells` counts those of finished blocks, `reused` cells among them."""

    cells: int = 0
    reused: int = 0
    failed: list[int] = field(default_factory=list)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def finish(self, cells: int, reused: int) -> None:
        """Count a block that is in the store."""
        with self._lock:
            self.cells += cells
            self.reused += reused

    def fail(self, store: BlockStore, number: int, error: Exception) -> None:
        """Record the failure of a block in the store."""
        store.note_failure(number, error)
        with self._lock:
            self.failed.append(number)


def compute_blocks(
    store: BlockStore, work: Work, numbers: Collection[int], tally: Tally, stop: StopFlag, progress: Progress | None
) -> None:
    """Compute these blocks and count them in `tally`; it stays right whatever interrupts.

    An exception while computing is recorded in the store, and the others are computed. Blocks that cannot be written
    raise StoreError. `progress` is called with items done, in part too.
    """
    threads, before = work.options.threads or engine.processors(), store.cells(store.finished())
    meter, turns = Meter(work.study.cells_each, before), threading.Semaphore(threads)

    def packed(number: int, items: int) -> tuple[Block, bytes]:
        """A block and what its file holds; no more than `threads` at a time, while others wait for the disk."""
        with turns:
            if stop[0]:
                raise StoppedError
            block = work.compute(number, stop, meter.watch(number, items))
            return block, store.packed(number, block)

    def compute(number: int) -> None:
        items = len(store.blocks.cells(number))
        try:
            block, data = packed(number, items)
        except StoreError:
            raise  # the older result cannot be read: no fault of the block
        except StoppedError:
            return meter.end(number, 0)
        except Exception as error:
            meter.end(number, 0)
            return tally.fail(store, number, error)
        store.put(number, data)
        tally.finish(items, block.reused)
        meter.end(number, items)

    def show(_: list[None]) -> None:
        if progress:
            progress(meter.items, work.size)

    engine.spread(compute, sorted(numbers), threads + _WAITING, stop, show)


# --- in memory --------------------------------------------------------------------------------------------------------


def compute_study(study: Study, progress: Progress | None = None) -> list[Results]:
    """The results of all blocks, in order. Raises Interrupted on Ctrl-C, and what computing a block raises.

    progress : called with (items done, in part too, and items in all) from this thread, now and then.
    """
    for law in study.kernels:
        engine.warm_up(law)
    size = prod(study.shape)
    blocks, stop, meter = blocks_of((size,), study.weight), engine.stop_flag(), Meter(study.cells_each)
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
        engine.spread(compute, range(blocks.count), study.options.threads, stop, show)
    except KeyboardInterrupt:
        raise Interrupted(sum(len(blocks.cells(number)) for number in computed), size, counted=study.counted) from None
    return [computed[number] for number in range(blocks.count)]


@dataclass(frozen=True)
class Subject:
    """The cells that a call is about, a configuration or a list, and how to integrate them.

    solver : of the keywords, those that a configuration has in its section.
    """

    cells: CellsLike | Config
    options: Options
    solver: Mapping[str, Any]

    @classmethod
    def of(cls, given: CellsOrConfig, keywords: SolverKeywords) -> Subject:
        """From what a call was given. Raises TypeError, ValueError or ConfigError."""
        if not is_config(given):
            return cls(given, Options.of(keywords).for_contact(given), {})  # type: ignore[arg-type]
        config, named = as_config(given), keywords.get("options")
        law = named.law if named else keywords.get("law")
        if keywords.get("law") is not None or law not in (None, config.friction.law):
            raise ValueError(f"law: got {law!r}, but a configuration says its law itself: {config.friction.law}")
        solver = {name: keywords[name] for name in ("horizon", "max_steps") if keywords.get(name) is not None}
        return cls(config, Options.of(keywords, options_of(config)), solver)

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
