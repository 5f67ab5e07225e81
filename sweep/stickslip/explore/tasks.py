"""Work beside the loop of the server, one thread for each kind: only what is asked for last is done."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from stickslip.engine import StopFlag, stop_flag

Job = TypeVar("Job")


class LatestOnly(Generic[Job]):
    """A thread that works on the job asked for last.

    work : called with a job and a stop flag, which is raised once another job waits or all is closed; errors are its
    own business. A job that is overtaken before it began is never begun.
    """

    def __init__(self, work: Callable[[Job, StopFlag], None], name: str) -> None:
        self._work, self._waiting = work, list[Job]()
        self._changed, self._closed = threading.Condition(), False
        self._stop = stop_flag()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def ask(self, job: Job) -> None:
        """Have this done, and nothing else any more."""
        with self._changed:
            self._waiting = [job]
            self._stop[0] = 1
            self._changed.notify()

    def pause(self, seconds: float) -> None:
        """For the job that runs: wait, no longer than until the next one is asked for."""
        with self._changed:
            self._changed.wait_for(lambda: bool(self._waiting) or self._closed, seconds)

    def close(self) -> None:
        """End the thread, which leaves within milliseconds."""
        with self._changed:
            self._closed, self._waiting = True, []
            self._stop[0] = 1
            self._changed.notify()
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=2.0)

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._waiting and not self._closed:
                    self._changed.wait()
                if self._closed:
                    return
                job, self._stop = self._waiting.pop(), stop_flag()
                stop = self._stop
            self._work(job, stop)
