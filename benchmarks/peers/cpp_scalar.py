"""The baseline's algorithm in C++ with OpenMP (`scalar.cpp`), compiled here, called through ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from peers import Peer
from problem import Answer, Cells

SOURCE = Path(__file__).with_name("scalar.cpp")
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fopenmp", "-shared", "-fPIC")


def compiler() -> str | None:
    return shutil.which("g++") or shutil.which("c++")


@cache
def library() -> ctypes.CDLL:
    target = Path(tempfile.mkdtemp(prefix="stickslip-bench-")) / "scalar.so"
    subprocess.run([compiler(), *FLAGS, str(SOURCE), "-o", str(target)], check=True, capture_output=True, text=True)
    return ctypes.CDLL(str(target))


@cache
def available() -> str | None:
    if compiler() is None:
        return "no C++ compiler"
    try:
        library()
    except subprocess.CalledProcessError as problem:
        return f"does not compile: {problem.stderr.strip().splitlines()[0]}"
    return None


def solve_threads(cells: Cells, horizon: float, rtol: float, threads: int) -> Answer:
    out = np.full((len(cells), 4), np.nan)
    numbers = ctypes.POINTER(ctypes.c_double)
    pointers = [array.ctypes.data_as(numbers) for array in (cells.k, cells.belt, out)]
    library().solve(
        ctypes.c_long(len(cells)),
        pointers[0],
        pointers[1],
        ctypes.c_double(horizon),
        ctypes.c_double(rtol),
        ctypes.c_int(threads),
        pointers[2],
    )
    return Answer(*out.T)


def solve(cells: Cells, horizon: float, rtol: float) -> Answer:
    return solve_threads(cells, horizon, rtol, 1)


PEERS = [
    Peer(
        "C++ scalar, OpenMP (g++ -O3 -march=native)",
        "by hand, step repeated to the root",
        solve,
        {1e-6: 4000, 1e-9: 2000},
        available,
        solve_threads,
        repeats=5,
    )
]
