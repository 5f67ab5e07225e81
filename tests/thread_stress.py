"""Threads of one process that read, write, run and extend results at once: every value is checked, nothing crashes.

python tests/thread_stress.py SECONDS   # prints how often each was done, and ends with 1 if anything went wrong
"""

import sys
import tempfile
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import xarray as xr

import stickslip
from helpers.maps import plane
from stickslip.config.model import Config
from stickslip.config.reader import parse_config
from stickslip.files import writing

KINDS = ["nc", "zarr"] if find_spec("zarr") else ["nc"]
ROWS, COLUMNS = 60, 80
CONFIG = """
system: {mass: 1, normal_load: 1}
friction: {a1: 1, a2: 0.1, a3: 0.3, a4: 0.1}
axes:
  stiffness: [0.5, 1, 2, 5, 10]
  belt_speed: [%s]
"""


def config(speeds: int) -> Config:
    return parse_config(CONFIG % ", ".join(f"{0.1 + 0.01 * i:.2f}" for i in range(speeds)), "stress.yaml")


def load(path: Path, expected: xr.Dataset) -> None:
    ds = stickslip.open(path)
    xr.testing.assert_equal(ds.load(), expected)
    ds.close()


def read_pieces_and_forget(path: Path, expected: xr.Dataset) -> None:
    """Chunks through dask's threads; the garbage collector closes the file."""
    ds = stickslip.open(path)
    part = {"stiffness": slice(3, 40, 7), "belt_speed": slice(None, 50)}
    xr.testing.assert_equal(ds.isel(part).compute(), expected.isel(part))


def read_plainly(ds: xr.Dataset, expected: xr.Dataset) -> None:
    """Values of a file that plain xarray opened before the other threads began."""
    for name in expected.data_vars:
        assert (ds[name].values == expected[name].values).sum() == expected[name].notnull().sum(), name


def write(path: Path, expected: xr.Dataset) -> None:
    load(writing.write(expected, path), expected)


def rewrite(source: Path, path: Path, expected: xr.Dataset) -> None:
    """A lazy dataset from one file into another."""
    with stickslip.open(source) as ds:
        writing.write(ds, path)
    load(path, expected)


def run_and_extend(path: Path, few: xr.Dataset, many: xr.Dataset) -> None:
    for speeds, expected, fresh in ((few.sizes["belt_speed"], few, True), (many.sizes["belt_speed"], many, False)):
        with stickslip.run(config(speeds), path, fresh=fresh) as ds:
            xr.testing.assert_equal(ds.load(), expected)


def tasks(folder: Path) -> dict[str, Callable[[], None]]:
    """What each thread does again and again."""
    expected = plane(ROWS, COLUMNS)
    few, many = stickslip.run(config(20)), stickslip.run(config(30))
    found: dict[str, Callable[[], None]] = {}
    for kind in KINDS:
        path = writing.write(expected, folder / f"map.{kind}")
        found |= {f"load {number} {kind}": partial(load, path, expected) for number in range(2)}
        found |= {f"read pieces {kind}": partial(read_pieces_and_forget, path, expected)}
        found |= {f"write {kind}": partial(write, folder / f"written.{kind}", expected)}
        found |= {f"rewrite {kind}": partial(rewrite, path, folder / f"rewritten.{kind}", expected)}
        found |= {f"run and extend {kind}": partial(run_and_extend, folder / f"run.{kind}", few, many)}
    plain = xr.open_dataset(folder / "map.nc", engine="netcdf4", cache=False)
    return found | {"plain xarray": partial(read_plainly, plain, expected)}


def main(seconds: float) -> int:
    """Do it all at once for so long; the number of things that went wrong."""
    done, failures = Counter[str](), list[str]()

    def again_and_again(name: str, task: Callable[[], None]) -> None:
        try:
            while time.monotonic() < end and not failures:
                task()
                done[name] += 1
        except BaseException:
            failures.append(f"{name}:\n{traceback.format_exc()}")

    with tempfile.TemporaryDirectory(prefix="stickslip-threads-") as folder:
        todo = tasks(Path(folder))
        end = time.monotonic() + seconds
        threads = [threading.Thread(target=again_and_again, args=item, daemon=True) for item in todo.items()]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(seconds + 60)
        failures += [f"{thread.name} is deadlocked" for thread in threads if thread.is_alive()]
    for name in todo:
        sys.stdout.write(f"{done[name]:6} {name}\n")
    sys.stdout.write("".join(failures))
    return len(failures) + sum(not done[name] for name in todo)


if __name__ == "__main__":
    sys.exit(min(1, main(float(sys.argv[1]))))
