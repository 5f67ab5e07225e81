"""A Dask scheduler and workers on the loopback interface, as processes of their own."""

import os
import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

BLOCK = 64  # cells
PRELOAD = Path(__file__).parents[1] / "sweep" / "runs" / "worker_preload.py"
CLI = f"from stickslip.runs import work; work._FEWEST, work._BLOCKS = {BLOCK}, 10**9\n"
CLI += "from stickslip.cli import main; main(prog_name='stickslip')"


def environment(folder, block=BLOCK):
    return os.environ | {
        "PYTHONPATH": os.pathsep.join(sys.path),
        "PYTHONWARNINGS": "ignore",
        "STICKSLIP_TEST_FOLDER": str(folder),
        "STICKSLIP_TEST_BLOCK": str(block),
        "DASK_DISTRIBUTED__WORKER__PRELOAD": str(PRELOAD),
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
    }


class Cluster:
    """A scheduler and `count` workers of one thread; `folder` is where tests and workers talk, and the logs lie."""

    def __init__(self, folder, count, block=BLOCK):
        self.folder, self._environment = folder, environment(folder, block)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        self._processes = []
        self.scheduler = self._started("scheduler", "--host", "127.0.0.1", "--port", str(port))
        for _ in range(count):
            self._started(
                "worker", self.address, "--nthreads", "1", "--memory-limit", "0",
                "--local-directory", str(folder),
            )  # fmt: skip

    def _started(self, kind, *arguments):
        with open(self.folder / f"{kind}-{len(self._processes)}.log", "w") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", kind, "--no-dashboard", *arguments],
                stdout=log, stderr=log, env=self._environment, cwd=self.folder,
            )  # fmt: skip
        self._processes.append(process)
        return process

    def say(self, name, text=""):
        (self.folder / name).write_text(text)

    def computed(self):
        """Numbers of the blocks computed since `forget`, in their order."""
        with suppress(FileNotFoundError):
            return [int(line) for line in (self.folder / "computed").read_text().split()]
        return []

    def forget(self):
        for pattern in ("computed", "slow", "deadly-*", "broken-*"):
            for path in self.folder.glob(pattern):
                path.unlink()

    def close(self):
        for process in self._processes:
            process.kill() if process is self.scheduler else process.terminate()
        for process in self._processes:
            with suppress(subprocess.TimeoutExpired):
                process.wait(20)
            process.kill()
            process.wait()
