"""Results with flipped bits, missing ends and lost pieces: refused, or read as they were written. Never a wrong map.

    python tests/fuzz_files.py nc 5000 SEED      # or zarr; prints what happened, and ends with 1 if anything went wrong
    python tests/fuzz_files.py nc every SEED     # a bit of every byte of a small file, one at a time: minutes

Damaged files are read in processes of their own, because the HDF5 library may crash on one.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from helpers.maps import axis, make_map
from stickslip import errors
from stickslip.files import reading as reading_
from stickslip.files import writing as store

LONGEST = 20  # s for one file
REFUSED, AS_WRITTEN = "refused", "as written"
END, AT_ONCE = b"\0", 500  # of what a process tells; bytes flipped for one process


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
    """`outcome` in a process of its own."""
    return next(told_apart(path, expected, iter([None])))


def told_apart(path: Path, expected: xr.Dataset, damaged: Iterator[object]) -> Iterator[str]:
    """`outcome` in another process, once for each time `damaged` has damaged the file; the last may be its death."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # HDF5 writes its troubles there
        warnings.simplefilter("ignore")
        for _ in damaged:
            signal.alarm(LONGEST)
            try:
                text = outcome(path, expected)
            except BaseException as error:
                text = f"RAISED {type(error).__name__}: {error}"
            os.write(writing, text.encode("utf-8", "replace")[:4000] + END)
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        texts = pipe.read().decode("utf-8", "replace").split(END.decode())
    _, status = os.waitpid(child, 0)
    yield from texts[:-1]
    if status:
        yield f"KILLED by signal {os.WTERMSIG(status)}" if os.WIFSIGNALED(status) else f"ENDED with {status}"


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
    return told(seen)


def told(seen: Counter[str]) -> int:
    """Print what happened; how often something went wrong."""
    for text, times in seen.most_common():
        sys.stdout.write(f"{times:6} {text}\n")
    return seen.total() - seen[REFUSED] - seen[AS_WRITTEN]


def small() -> xr.Dataset:
    """A flag and a number of six cells with their coordinates and a mass."""
    ds = make_map(axis("stiffness", [1.0, 2.0, 3.0], "log"), axis("belt_speed", [0.1, 0.2]))
    few = ["regime", "period", "stiffness", "belt_speed", "mass"]
    return ds.drop_vars([name for name in ds.variables if name not in few])


def every_byte(kind: str, seed: int) -> int:
    """Flip a bit of every byte of a small file, one at a time; the number of times something went wrong.

    The HDF5 library dies of a damaged global heap (31 of 23,925 bytes), before anything of ours sees the file. These
    deaths are shown, and are too many above half a percent.
    """
    chance, expected = random.Random(seed), small()
    folder = Path(tempfile.mkdtemp(prefix="stickslip-fuzz-"))
    path = store.write(expected, folder / f"map.{kind}")
    seen: Counter[str] = Counter()
    for piece in sorted(p for p in ([path] if path.is_file() else path.rglob("*")) if p.is_file()):
        good, done = piece.read_bytes(), 0
        bits = [1 << chance.randrange(8) for _ in good]

        def flipped(start: int, piece=piece, good=good, bits=bits) -> Iterator[None]:
            for i in range(start, min(start + AT_ONCE, len(good))):
                piece.write_bytes(good[:i] + bytes([good[i] ^ bits[i]]) + good[i + 1 :])
                yield

        while done < len(good):
            for what in told_apart(path, expected, flipped(done)):
                fine = what in (REFUSED, AS_WRITTEN)
                seen[what if fine else f"byte {done} bit {bits[done]} of {piece.relative_to(folder)}: {what}"] += 1
                done += 1
        piece.write_bytes(good)
    shutil.rmtree(folder)
    sys.stdout.write(f"{seen.total():6} bytes flipped\n")
    deaths = sum(times for text, times in seen.items() if "KILLED" in text)
    wrong = told(seen)
    return wrong - deaths if deaths <= seen.total() / 200 else wrong


if __name__ == "__main__":
    kind, count, seed = sys.argv[1:]
    sys.exit(min(1, every_byte(kind, int(seed)) if count == "every" else main(kind, int(count), int(seed))))
