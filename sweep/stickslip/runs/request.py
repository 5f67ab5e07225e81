"""The request of a run, and its outcome."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from stickslip.config.model import Config
from stickslip.config.overrides import Setting
from stickslip.config.reader import Given, as_config, load_config, parse_config
from stickslip.config.sections import ADDRESS, HERE, is_address
from stickslip.engine import Progress, warm_up
from stickslip.errors import StoreError
from stickslip.files.locations import Location, Url, location
from stickslip.runs.blocks import Shard
from stickslip.runs.workdir import block_store
from stickslip.runs.workdir.folder import Folder, folder_at
from stickslip.runs.workdir.lock import Notice

OnError = Literal["continue", "stop"]


@dataclass(frozen=True)
class Request:
    """The request of a run.

    output : result to write; None leaves the blocks in the store.
    place : path or URL of the store; None lays it beside the output.
    shard : compute only its blocks. fresh : start over. keep : leave the store once the result is written.
    on_error : whether a block that fails ends the run or not.
    progress, assembling : called with (cells done, cells in all) while computing and while writing the result.
    notice : called with a line for people when something is worth knowing. news : instead of it where that is no
        warning; None for the same.
    prepare : called with the friction law before the first block is computed here.
    dask : address of a Dask scheduler, its file, `local` or `none`; or a `distributed.Client`; None takes what the
        configuration says.
    """

    config: Config
    output: Location | None = None
    place: str | None = None
    shard: Shard | None = None
    fresh: bool = False
    keep: bool = False
    on_error: OnError = "continue"
    progress: Progress | None = None
    assembling: Progress | None = None
    notice: Notice = lambda text: None  # noqa: E731
    news: Notice | None = None
    prepare: Callable[[str], None] = warm_up
    dask: Any = None

    def __post_init__(self) -> None:
        if self.on_error not in ("continue", "stop"):
            raise ValueError(f"on_error: got {self.on_error!r}, expected 'continue' or 'stop'")
        if self.fresh and self.shard:
            raise ValueError("fresh: a shard cannot start over, since other shards share its store")
        if isinstance(self.dask, str) and not is_address(self.dask):
            raise ValueError(f"dask: got {self.dask!r}, expected {ADDRESS}")

    @property
    def cluster(self) -> Any:
        """The address or client of the cluster that computes; None for threads of this process."""
        named = self.config.execution.dask if self.dask is None else self.dask
        return None if isinstance(named, str) and named == HERE else named

    def folder(self) -> Folder:
        """The place of the store. Raises StoreError if neither it nor an output is named."""
        if self.place is not None:
            return folder_at(self.place)
        if self.output is None:
            raise StoreError("a run needs a place", hint="name an output file, or a store with {store}")
        return folder_at(block_store.beside(self.output))


@dataclass(frozen=True)
class Outcome:
    """The outcome of a run, in cells: of the map, found in the store, taken over from an older result, computed.

    output : the result, if it was written or (`up_to_date`) was there already. where : the store, if it is still there.
    machines : what computed, if not threads of this process.
    """

    cells: int
    found: int = 0
    reused: int = 0
    computed: int = 0
    output: Location | None = None
    where: str | None = None
    machines: str | None = None
    up_to_date: bool = False


def request_for(
    place: Given,
    output: str | os.PathLike[str] | None = None,
    store: str | None = None,
    settings: Sequence[Setting] = (),
) -> Request:
    """The request behind a configuration, or behind the path or URL of a store.

    store : place of the store of a configuration, if not beside its output.
    settings : of a command line, put into the configuration; those that change the results of a store are refused when
        it is used.
    The output is the one named, else that of the configuration; a store called `FILE.parts` belongs to FILE.
    Raises ConfigError or StoreError.
    """
    text = os.fspath(place) if isinstance(place, str | os.PathLike) else None
    if text is None or not _is_store(text):
        config = as_config(place, rig=None) if text is None else load_config(text, settings, rig=None)
        return Request(config, _output(output, config), store)
    config = block_store.config_of(block_store.find(folder_at(text)))
    if settings:
        changed = parse_config(config.to_yaml(), text, settings)
        config = changed.shown_in(config.written_in | changed.written_in)
    return Request(config, _beside(text) if output is None and _beside(text) else _output(output, config), text)


def _is_store(place: str) -> bool:
    return "://" in place or os.path.isdir(place)


def _output(named: str | os.PathLike[str] | None, config: Config) -> Location | None:
    file = config.output.file if named is None else named
    return None if file is None else location(file)


def _beside(place: str) -> Location | None:
    """The result beside whose name a store was laid."""
    store = location(place)
    output = store.with_suffix("") if store.suffix == block_store.SUFFIX else None
    return None if isinstance(output, Url) and output.suffix != ".zarr" else output
