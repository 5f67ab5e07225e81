"""Results with flipped bits, missing ends and lost pieces: refused, or read as they were written. Never a wrong map.

    python tests/fuzz_files.py nc 5000 SEED      # or zarr; prints what happened, and ends with 1 if anything went wrong

Damaged files are read in processes of their own, because the HDF5 library may crash on one.
"""

import os
import random
import shutil
import signal
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import xarray as xr

from helpers.maps import axis, make_map
from stickslip import errors
from stickslip.files import reading as reading_
from stickslip.files import writing as store

LONGEST = 20  # s for one file
REFUSED, AS_WRITTEN = "refused", "as written"


def original() -> xr.Dataset:
    """A map with named points, a log axis, two dimensions that are not coordinates, and a configuration."""
    pads = axis("normal_load", [1.0, 2.0, 3.0], "values", "pad", ["felt", "rubber", "µ-foam"])
    others = axis("a1", [0.9, 1.0, 1.1], "values", "pad")
    stiffness, speed = np.geomspace(0.01, 10, 40), np.linspace(0.01, 0.8, 50)
    return make_map(pads, others, axis("stiffness", stiffness, "log"), axis("belt_speed", speed))


DAMAGES: dict[str, Callable[[random.Random, bytearray, int], object]] = {
    "cut off": lambda chance, data, i: data.__delitem__(slice(i, None)),
    "flip a bit": lambda chance, data, i: data.__setitem__(i, data[i] ^ (1 << chance.randrange(8))),
    "change a byte": lambda chance, data, i: data.__setitem__(i, chance.randrange(256)),
    "change many": lambda chance, data, i: [data.__setitem__(chance.randrange(len(data)), 0xA5) for _ in range(20)],
    "zero a range": lambda chance, data, i: data.__setitem__(slice(i, i + 512), bytes(len(data[i : i + 512]))),
    "insert": lambda chance, data, i: data.__setitem__(slice(i, i), chance.randbytes(chance.randrange(1, 64))),
    "repeat": lambda chance, data, i: data.__setitem__(slice(i, i), data[i : i + 200]),
}


def outcome(path: Path, expected: xr.Dataset) -> str:
    """What reading everything in a file gives."""
    try:
        with reading_.open(path) as ds:
            found = ds.load()
    except errors.StoreError:
        return REFUSED
    try:
        xr.testing.assert_equal(found, expected)
    except AssertionError as error:
        return f"WRONG VALUES {str(error)[-400:]}"
    units = {name: variable.attrs.get("units") for name, variable in expected.variables.items()}
    if any(found[name].attrs.get("units") != unit for name, unit in units.items()):
        return "WRONG UNITS"
    same = found.attrs["configuration"] == expected.attrs["configuration"]
    return AS_WRITTEN if same else "WRONG CONFIGURATION"


def apart(path: Path, expected: xr.Dataset) -> str:
    """`outcome` in a process of its own, or its death."""
    pool = ProcessPoolExecutor(1, get_context("fork"), initializer=quietly)
    try:
        return pool.submit(outcome, path, expected).result()
    except BrokenProcessPool:
        return "DIED"
    except Exception as error:
        return f"RAISED {type(error).__name__}: {error}"[:4000]
    finally:
        pool.shutdown()


def quietly() -> None:
    """HDF5 writes its troubles to the error channel; a process that takes too long dies."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    warnings.simplefilter("ignore")
    signal.alarm(LONGEST)


def main(kind: str, count: int, seed: int) -> int:
    """Damage a file `count` times; the number of times something went wrong."""
    chance, expected = random.Random(seed), original()
    folder = Path(tempfile.mkdtemp(prefix="stickslip-fuzz-"))
    path = store.write(expected, folder / f"map.{kind}")
    pieces = {p: p.read_bytes() for p in ([path] if path.is_file() else path.rglob("*")) if p.is_file()}
    seen: Counter[str] = Counter()
    for _ in range(count):
        piece = chance.choice(list(pieces))
        damage = chance.choice(["lose it", *DAMAGES] if len(pieces) > 1 else list(DAMAGES))
        if damage == "lose it":
            piece.unlink()
        else:
            data = bytearray(pieces[piece])
            DAMAGES[damage](chance, data, chance.randrange(len(data)))
            piece.write_bytes(bytes(data))
        what = apart(path, expected)
        seen[what if what in (REFUSED, AS_WRITTEN) else f"{damage} {piece.relative_to(folder)}: {what}"] += 1
        piece.write_bytes(pieces[piece])
    shutil.rmtree(folder)
    for text, times in seen.most_common():
        sys.stdout.write(f"{times:6} {text}\n")
    return seen.total() - seen[REFUSED] - seen[AS_WRITTEN]


if __name__ == "__main__":
    kind, count, seed = sys.argv[1:]
    sys.exit(min(1, main(kind, int(count), int(seed))))
