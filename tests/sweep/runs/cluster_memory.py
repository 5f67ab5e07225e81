"""Computes many tiny blocks on a cluster, and says what that took and whether anything grew.

    python cluster_memory.py CONFIG STORE ADDRESS

A process of its own, for its peak memory. Prints JSON, all counted from a fifth of the blocks to the end: the number of
blocks, the time for each, the growth of the peaks of memory (MB), and processor time.
"""

import json
import os
import sys
import time
import warnings
from pathlib import Path

import distributed
import numpy as np
import psutil

import stickslip
from helpers.cluster import BLOCK
from stickslip.runs import blocks

NAMES = ("client", "scheduler", "worker 1", "worker 2", "worker 3")
blocks._FEWEST, blocks._BLOCKS = BLOCK, 10**9


def state(pids):
    """Wall clock (s), and peak memory (MB) and processor time (s) of these processes."""
    status = [Path(f"/proc/{pid}/status").read_text() for pid in pids]
    times = [psutil.Process(pid).cpu_times() for pid in pids]
    return np.array(
        [time.perf_counter(), *(int(text.split("VmHWM:")[1].split()[0]) / 1e3 for text in status)]
        + [used.user + used.system for used in times]
    )


def main(config, store, address):
    with distributed.Client(address, set_as_default=False) as client:
        pids = [os.getpid(), client.run_on_scheduler(os.getpid), *client.run(os.getpid).values()]
    seen = []

    def progress(done, of):
        if not seen and done > of / 5:
            seen.append((of - done, state(pids)))

    stickslip.run_shard(config, "1/1", store, dask=address, progress=progress)
    cells, early = seen[0]
    (elapsed, *growth), count = state(pids) - early, cells / BLOCK
    memory, used = growth[: len(pids)], growth[len(pids) :]
    print(
        json.dumps(
            {
                "blocks": count,
                "ms_per_block": elapsed / count * 1e3,
                "growth": dict(zip(NAMES, memory, strict=True)),
                "cpu_ms_per_block": {name: time / count * 1e3 for name, time in zip(NAMES, used, strict=True)},
            }
        )
    )


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main(*sys.argv[1:])
