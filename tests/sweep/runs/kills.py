"""Starts a run over and over, kills it with -9 at random moments, and says what became of its blocks.

A process of its own, which loads everything once and forks a child per run: no time is lost between two kills.

    python kills.py CONFIG OUTPUT KILLS SEED

Prints JSON: how many runs were killed, how many maps came out, how many blocks were written, and how many of those had
been there before (none, if nothing is ever computed twice).
"""

import json
import os
import random
import signal
import sys
import time
from pathlib import Path

import dask.array  # noqa: F401

import stickslip
from stickslip import engine
from stickslip.cli import main, screen
from stickslip.files import writing as store
from stickslip.plots import maps as plots
from stickslip.runs import session

LOADED = (stickslip.run, plots, screen, session, store)  # what a child would load before it computes


def blocks(folder):
    """Finished blocks by name, with what tells whether a file was written again."""
    found = {}
    for path in folder.glob("block-*"):
        try:
            stat = path.stat()
        except FileNotFoundError:  # the run that is not killed yet removes its store
            continue
        found[path.name] = (stat.st_ino, stat.st_mtime_ns)
    return found


def start(*arguments):
    child = os.fork()
    if child:
        return child
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    main(list(arguments), standalone_mode=True)
    os._exit(99)  # never reached: click ends the process


def kill_and_resume(config, output, kills, random):
    folder = Path(f"{output}.parts")
    began = time.perf_counter()
    os.waitpid(start("run", str(config), "-o", str(output.with_name("undisturbed.nc"))), 0)
    longest = time.perf_counter() - began
    seen, told = {}, {"killed": 0, "maps": 1, "again": 0, "written": 0, "codes": []}
    while told["killed"] < kills or not output.exists():
        if output.exists():  # done before the last kill: once more from the beginning
            told["maps"] += 1
            os.rename(output, output.with_name(f"{told['maps']}.nc"))
            seen = {}
        child = start("run", str(config), "-o", str(output))
        if told["killed"] < kills:
            time.sleep(random.uniform(0.0, longest))
            os.kill(child, signal.SIGKILL)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        told["killed"] += code == -signal.SIGKILL
        if code not in (0, -signal.SIGKILL):
            told["codes"].append(code)
            break
        now = blocks(folder)
        told["again"] += sum(now[name] != was for name, was in seen.items() if name in now)
        told["written"] += len(set(now) - set(seen))
        seen = now or seen
    os.waitpid(start("run", str(config), "-o", str(output)), 0)  # removes what the last kill may have left
    return told


if __name__ == "__main__":
    engine.warm_up()
    print(
        json.dumps(kill_and_resume(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), random.Random(int(sys.argv[4]))))
    )
