"""What the judge said of cells, on disk: by day tests read it, and the judge, which takes long to compile, sleeps.

`STICKSLIP_JUDGE=write python -m pytest -m "not slow" FILES`, in one process, adds what tests ask for; without the
variable the judge solves every cell again, as it does at night.
"""

import hashlib
import json
import os
from pathlib import Path

import numpy as np

BOOK = Path(__file__).parents[1] / "data" / "judge.json"


def answers(solve, rows, columns, *options):
    """The answers (n, columns) of `solve(rows, answers, *options)`, or those that it once gave to the same cells."""
    out, mode = np.full((len(rows), columns), np.nan), os.environ.get("STICKSLIP_JUDGE")
    text = " ".join([solve.__name__, *map(repr, options), *(f"{x:.10g}" for x in np.ravel(rows))])
    key = hashlib.sha256(text.encode()).hexdigest()[:16]
    book = json.loads(BOOK.read_text()) if mode and BOOK.exists() else {}
    if key in book:
        return np.array(book[key]).reshape(out.shape)
    if mode == "read":
        raise LookupError(f"the judge has not solved these cells yet: see {__file__}")
    solve(rows, out, *options)
    if mode == "write":
        book[key] = out.tolist()
        lines = (f'"{one}": {json.dumps(book[one])}' for one in sorted(book))
        BOOK.write_text("{\n" + ",\n".join(lines) + "\n}\n")
    return out
