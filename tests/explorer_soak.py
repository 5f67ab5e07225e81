"""Many people at one explorer: memory and threads of the server while tabs are opened, clicked in and closed.

    python tests/explorer_soak.py --tabs 50 --clicks 1000 --rounds 2

Tabs are websockets, which another process holds open and reads; clicks are events of the server's documents, whose
answers go to the tabs. Prints a line for each moment; what is left once all tabs are gone must not grow.
"""

import argparse
import os
import random
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

from bokeh.events import Tap

from stickslip_explore.server import Explorer
from stickslip_explore.session import Session
from stickslip_explore.source import open_source

ROOT = Path(__file__).resolve().parents[1]
PATIENCE = 600.0  # s
TABS = """
import sys, threading
from bokeh.client import pull_session
for _ in range(int(sys.argv[2])):
    tab = pull_session(url=sys.argv[1])
    threading.Thread(target=tab._connection.loop_until_closed, daemon=True).start()
print("open", flush=True)
sys.stdin.read()
"""


def main(tabs: int, clicks: int, rounds: int, seed: int) -> None:
    """Run the rounds; ends with 1 where a click had no answer, or memory or threads grew."""
    explorer, started = Explorer(open_source(ROOT / "configs" / "quickstart.yaml")), threading.Event()
    threading.Thread(target=explorer.run, args=(started.set,), daemon=True).start()
    started.wait(PATIENCE)
    random.seed(seed)
    tell("no tab yet")
    left = [one_round(explorer, tabs, clicks, f"round {number}: ") for number in range(1, rounds + 1)]
    (memory, threads), (last, more) = left[0], left[-1]
    if last > 1.1 * memory or more > threads:
        sys.exit(f"left after round 1: {memory:.0f} MB, {threads} threads; after the last: {last:.0f} MB, {more}")


def one_round(explorer: Explorer, tabs: int, clicks: int, name: str) -> tuple[float, int]:
    """MB and threads that are left once all tabs of a round are gone."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", TABS, explorer.address, str(tabs)], **pipes) as people:
        assert people.stdout is not None and people.stdout.readline() == b"open\n"
        sessions = list(explorer._sessions)
        assert len(sessions) == tabs
        until(lambda: all("exact borders in" in one.page.status.text for one in sessions))
        tell(f"{name}{tabs} tabs open")
        took = sorted(click(explorer, sessions[k % tabs]) for k in range(clicks))
        tell(f"{name}{clicks} clicks, median {1e3 * took[clicks // 2]:.0f} ms, slowest {1e3 * took[-1]:.0f} ms")
        people.kill()  # as a browser that crashes
    sessions.clear()
    until(lambda: not explorer._sessions)
    time.sleep(2.0)
    return tell(f"{name}all closed")


def click(explorer: Explorer, session: Session) -> float:
    """Seconds from a click at a random place to what it shows."""
    plot, before, began = session.page.map.plot, session._cell, time.perf_counter()
    tap = Tap(plot, x=random.uniform(0.02, 1.19), y=random.uniform(0.1, 3.9))
    explorer._loop.call_soon_threadsafe(plot._trigger_event, tap)
    until(lambda: session._cell is not before)
    return time.perf_counter() - began


def until(there: Callable[[], bool]) -> None:
    """Wait for something."""
    end = time.monotonic() + PATIENCE
    while not there():
        if time.monotonic() > end:
            sys.exit("no answer")
        time.sleep(0.002)


def tell(moment: str) -> tuple[float, int]:
    """Print resident memory (MB) and threads of this process, and return them."""
    status = dict(line.split(":", 1) for line in Path(f"/proc/{os.getpid()}/status").read_text().splitlines())
    memory, threads = int(status["VmRSS"].split()[0]) / 1e3, int(status["Threads"])
    print(f"{memory:8.0f} MB {threads:4} threads  {moment}", flush=True)
    return memory, threads


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    for option, default in (("--tabs", 50), ("--clicks", 1000), ("--rounds", 2), ("--seed", 1)):
        parser.add_argument(option, type=int, default=default)
    main(**vars(parser.parse_args()))
