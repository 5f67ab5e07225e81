"""Dask's own messages, suppressed: they report lost connections at length, and ours would be lost among them."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import dask.config

SILENT = logging.CRITICAL + 1
_TALKATIVE = ("distributed", "tornado", "asyncio")


@contextmanager
def quiet() -> Iterator[None]:
    """Silence Dask, unless its configuration says how it is to log (`logging`, or DASK_LOGGING__DISTRIBUTED)."""
    if dask.config.get("logging", None) is not None:
        yield
        return
    names = [name for name in logging.root.manager.loggerDict if name.split(".")[0] in _TALKATIVE]
    before = {name: logging.getLogger(name).level for name in [*names, *_TALKATIVE]}
    for name in before:
        logging.getLogger(name).setLevel(SILENT)
    try:
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)
