"""Code that runs on the workers: plain data in, plain data out.

The scheduler loads this module too, so everything heavy is imported where it is used.
"""

from __future__ import annotations

import pickle
import platform
import signal
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, TypedDict

from stickslip._version import __version__
from stickslip.errors import StoreError, UncomputedError, UnlikeWorkerError
from stickslip.files.targets import host

if TYPE_CHECKING:
    from stickslip.runs.formats import Manifest
    from stickslip.runs.work import Work


class Job(TypedDict):
    """The data that all blocks of a run have in common.

    configuration : resolved, as YAML text. blocks : how the items are cut, as arguments of `Blocks`. packing : of them.
    place : path of the store. token : a name that exists in the store while the run lasts. versions : those of
    the process that runs it. law : a registered one, pickled. grid : with values of an
    older map (`Work.grid`), pickled.
    """

    configuration: str
    blocks: tuple[int, int, int]
    packing: str
    place: str
    token: str
    versions: dict[str, str]
    law: bytes
    grid: bytes


@cache
def versions() -> dict[str, str]:
    """Versions that must be equal for equal bits, as this process loaded them."""
    from importlib.metadata import version

    from stickslip import engine

    return {
        "stickslip": __version__,
        "kernels": engine.kernels_digest(),
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "numba": version("numba"),
        "numpy": version("numpy"),
    }


def unlike(here: Mapping[str, str], there: Mapping[str, str]) -> str:
    """`numba 0.61.0 (here 0.68.1)` and so on for what differs between two processes; empty if nothing does."""
    differing = [name for name in here if there.get(name) != here[name]]
    return ", ".join(f"{name} {there.get(name, 'unknown')} (here {here[name]})" for name in differing)


def dask_setup(_worker: object) -> None:
    """Called as worker processes on this machine start, or start again: Ctrl-C in the terminal is not for them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def loaded() -> bool:
    """Called on the scheduler, to know whether it has this module."""
    return True


def describe() -> dict[str, Any]:
    """Host, processor and versions of this worker, which has imported what its first block needs once it says so."""
    from stickslip import engine
    from stickslip.config import reader  # noqa: F401
    from stickslip.runs import block_store  # noqa: F401

    return {"host": host(), "processor": engine.processor(), "versions": versions()}


def compute_block(job: Job, number: int) -> bytes | None:
    """Compute a block and write it into the store; give its bytes where the store is not to be seen.

    Raises UnlikeWorkerError and UncomputedError.
    """
    if differing := unlike(job["versions"], versions()):
        raise UnlikeWorkerError(f"a worker on {host()}: {differing}")
    try:
        return _computed(job, number)
    except Exception as error:
        raise UncomputedError.of(error) from None


def _computed(job: Job, number: int) -> bytes | None:
    from stickslip import engine
    from stickslip.files.targets import folder_at
    from stickslip.runs.block_store import BlockStore

    work, manifest = _loaded(job["configuration"], job["blocks"], job["law"], job["grid"])
    for law in work.study.kernels:
        engine.warm_up(law)
    store = BlockStore(folder_at(job["place"]), manifest, job["packing"])
    data = store.packed(number, work.compute(number))
    try:
        # If this machine sees the store too, the token is there. Another folder of that name has no such token, nor
        # has the store once the run is over: a worker that comes late leaves nothing behind.
        store.folder.read(job["token"])
        store.put(number, data)
    except (FileNotFoundError, StoreError):  # whatever keeps this machine from it may not keep the other
        return data
    return None


@lru_cache(maxsize=2)
def _loaded(configuration: str, blocks: tuple[int, int, int], own_law: bytes, grid: bytes) -> tuple[Work, Manifest]:
    """The work of a configuration, read once per process."""
    if own_law:
        pickle.loads(own_law)
    from stickslip.config.reader import parse_config
    from stickslip.runs.formats import Manifest
    from stickslip.runs.work import Blocks, Work

    work = Work(parse_config(configuration), cut=Blocks(*blocks), grid=pickle.loads(grid) if grid else None)
    return work, Manifest.of(work)
