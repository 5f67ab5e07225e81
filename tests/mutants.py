"""Small errors put into a copy of the packages, one at a time, and whether the tests by day notice.

    python tests/mutants.py [WORD]      # by hand, those with this word: one in the kernels takes minutes

prints each of `data/mutants.csv` with the first of its tests that failed, or SURVIVED, and ends with the number of
those.
"""

import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COPIED = ("kernels", "sweep", "tests", "docs", "configs", "pyproject.toml", "README.md", "CONTRIBUTING.md")


def first_failure(file, before, after, tests):
    """What pytest says of the first test that fails, where `after` stands in place of `before`; None if none does."""
    with tempfile.TemporaryDirectory() as folder:
        for name in COPIED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
            copy(ROOT / name, Path(folder, name))
        path = Path(folder, file)
        text = path.read_text(encoding="utf-8")
        assert text.count(before) == 1, f"{file}: {before!r} stands there {text.count(before)} times"
        path.write_text(text.replace(before, after), encoding="utf-8")
        roots = os.pathsep.join(str(Path(folder, name)) for name in ("sweep", "kernels"))
        environment = os.environ | {"PYTHONPATH": roots}
        if file.startswith("kernels"):  # the objects of others stay as they are
            environment["NUMBA_CACHE_DIR"] = str(Path(folder, "cache"))
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-m", "not slow", *tests.split()]
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode == 0:
        return None
    failed = re.search(r"^(?:FAILED|ERROR) .*$", done.stdout, re.MULTILINE)
    return failed[0] if failed else done.stdout[-500:] + done.stderr[-500:]


def mutants():
    """File, what stands there, what is put in its place, and tests, of all."""
    with (ROOT / "tests/data/mutants.csv").open(encoding="utf-8") as file:
        return [[cell.replace("\\n", "\n") for cell in row] for row in csv.reader(file)][1:]


def main(word=""):
    """Try all; how many survived."""
    survived = 0
    for row in mutants():
        if word in " ".join(row):
            failure = first_failure(*row)
            survived += failure is None
            print(*row[:3], failure or "SURVIVED", sep="\n    ", flush=True)
    return survived


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
