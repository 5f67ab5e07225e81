"""Compiled kernels as object files in a cache folder.

An object holds the kernels of one friction law, for maps or for signals, as `building.py` makes them and `machine.py`
loads them. Its folder is named by the digest of all kernel sources, so that any edit anywhere gives a fresh one, its
file by whatever else decides about the code: processor, compiler, Python. A file begins with the digest of the rest.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import tempfile
from functools import cache
from importlib.metadata import version
from pathlib import Path

import llvmlite.binding as llvm

_HERE = Path(__file__).parent
_DIGEST_BYTES = hashlib.sha256().digest_size
_SETTINGS = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")  # of the environment: Numba compiles for another processor


@cache  # a process runs the files it has loaded, whatever becomes of them
def source_digest() -> str:
    """Digest of the kernel sources (names and contents), 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for path in sorted(_HERE.rglob("*.py")):
        digest.update(path.relative_to(_HERE).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _cache_root() -> Path:
    """Folder for compiled code: NUMBA_CACHE_DIR, else XDG_CACHE_HOME, else the user's cache folder."""
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(named)
    if windows := os.environ.get("LOCALAPPDATA"):
        return Path(windows) / "stickslip"
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return Path(base) / "stickslip"


def _usable_folder() -> Path | None:
    """The cache folder of these sources, or None where none can be written (the kernels then compile each time)."""
    folder = _cache_root() / f"kernels-{source_digest()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        return None


CACHE_FOLDER = _usable_folder()


@cache
def _host() -> str:
    """Names what an object was compiled for and by."""
    python = f"python{sys.version_info[0]}{sys.version_info[1]}"
    target = llvm.get_process_triple(), llvm.get_host_cpu_features().flatten(), version("llvmlite")
    settings = [os.environ.get(name, "") for name in _SETTINGS]
    rest = hashlib.sha256(json.dumps([target, settings]).encode()).hexdigest()[:8]
    return f"{llvm.get_host_cpu_name()}-numba{version('numba')}-{python}-{rest}"


def name_of(law: str, signals: bool) -> str:
    """Name of the object with the kernels of a law, for maps or for signals, on this machine."""
    return f"{law}{'-signals' if signals else ''}-{_host()}.o"


def write(path: Path, symbols: list[str], code: bytes) -> None:
    """Put an object into a file, whole or not at all. symbols : the functions it expects to find in the process."""
    content = json.dumps(symbols).encode() + b"\n" + code
    fresh = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        fresh.write_bytes(hashlib.sha256(content).digest() + content)
        os.replace(fresh, path)
    finally:
        fresh.unlink(missing_ok=True)


def read(path: Path) -> tuple[list[str], bytes] | None:
    """What `write` put into a file; None where there is none, or it is damaged: such code must not run."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    digest, content = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    if hashlib.sha256(content).digest() != digest:
        return None
    symbols, _, code = content.partition(b"\n")
    return json.loads(symbols), code
