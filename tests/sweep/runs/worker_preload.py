"""What the workers of these tests load first: small blocks, which are counted, and slow or deadly if a test says so.

STICKSLIP_TEST_FOLDER holds the file `computed`, a number a line, and what tests put there: `slow` (seconds a block
takes), `deadly-N` (computing block N kills the worker), `broken-N` (it raises).
"""

import functools
import os
import time
from pathlib import Path

from stickslip.runs import work

FOLDER = Path(os.environ["STICKSLIP_TEST_FOLDER"])
compute = getattr(work.Work.compute, "__wrapped__", work.Work.compute)  # Dask loads this twice


@functools.wraps(compute)
def watched(self, number, *rest):
    if (FOLDER / f"deadly-{number}").exists():
        os._exit(1)
    if (FOLDER / f"broken-{number}").exists():
        raise ArithmeticError("broken on purpose")
    block = compute(self, number, *rest)
    with open(FOLDER / "computed", "a") as file:
        file.write(f"{number}\n")
    if (FOLDER / "slow").exists():
        time.sleep(float((FOLDER / "slow").read_text()))
    return block


work._FEWEST, work._BLOCKS = int(os.environ["STICKSLIP_TEST_BLOCK"]), 10**9
work.Work.compute = watched
