"""Compiled kernels as object files in a cache folder.

An object is a law, and named so; or the machine of a contact, CONTACT-maps or CONTACT-signals, that laws are linked to.
`building.py` makes them, and `runtime.py` loads them. Their folder is named by the digest of all kernel sources, so
that any edit anywhere gives a fresh one, a file by whatever else decides about the code: processor, compiler, Python.
It begins with the digest of the rest.

A package may bring objects for kinds of processors, which are loaded in place of such files: nothing is
compiled then, and machines of a kind run the same instructions.

A digest says that a file is whole, not whose it is. So code is loaded only from files of this user or of root, in a
folder of theirs in which nobody else may write.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import llvmlite.binding as llvm

_HERE = Path(__file__).parent
_DIGEST_BYTES = hashlib.sha256().digest_size
_AS_IT_IS = ("O_NOFOLLOW", "O_NONBLOCK", "O_BINARY")  # no link, no waiting at a pipe, no conversion of lines
_SETTINGS = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")  # of the environment: Numba compiles for another processor
# Files of contacts, and how the names of their laws begin.
CONTACTS = {"regularised": "rate_state_", "lugre": "lugre_", "stribeck.modes": ""}
# Kinds of processors by the beginning of their triple, the most able one first: the name that LLVM has for them, and
# what they can do (x86-64 psABI, microarchitecture levels).
_LEVEL_3 = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")
_LEVEL_4 = (*_LEVEL_3, "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl")
KINDS: dict[str, dict[str, tuple[str, ...]]] = {
    "x86_64": {"x86-64-v4": _LEVEL_4, "x86-64-v3": _LEVEL_3},
    "aarch64": {"generic": ()},
}


@cache  # a process runs the files it has loaded, whatever becomes of them
def source_digest() -> str:
    """Digest of the kernel sources (names and contents), 16 hexadecimal digits."""
    digest = hashlib.sha256()
    for path in sorted(_HERE.rglob("*.py")):
        digest.update(path.relative_to(_HERE).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _cache_root() -> Path | None:
    """Folder for compiled code: NUMBA_CACHE_DIR, else XDG_CACHE_HOME, else that of the user; None without home."""
    if named := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(named)
    if windows := os.environ.get("LOCALAPPDATA"):
        return Path(windows) / "stickslip"
    home = os.path.expanduser("~")  # stays "~" for a user whom the system does not know
    base = os.environ.get("XDG_CACHE_HOME") or (os.path.join(home, ".cache") if os.path.isabs(home) else None)
    return Path(base) / "stickslip" if base else None


def _usable_folder() -> tuple[Path | None, str]:
    """The cache folder of these sources, or None and the reason: the kernels are then compiled by each process."""
    root = _cache_root()
    if root is None:
        return None, "no home folder is known"
    folder = root / f"kernels-{source_digest()}"
    try:
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        mode = root.stat().st_mode
        if os.name != "nt" and mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return None, f"{root}: others may write there"
        if why := objection(folder.lstat(), stat.S_ISDIR):
            return None, f"{folder}: {why}"
        with tempfile.TemporaryFile(dir=folder):
            return folder, ""
    except OSError as error:
        return None, f"{folder}: {error.strerror}"


def objection(found: os.stat_result, is_kind: Callable[[int], bool] = stat.S_ISREG) -> str | None:
    """Why a file or folder, not followed if it is a link, must not be trusted with code; None if it may be."""
    if not is_kind(found.st_mode):
        return "a link, or something else that does not belong there"
    if os.name == "nt":
        return None
    if found.st_uid not in (os.geteuid(), 0):
        return f"owned by another user (number {found.st_uid})"
    return "others may write it" if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else None


CACHE_FOLDER, NO_CACHE = _usable_folder()


@cache
def _host() -> str:
    """Names what an object was compiled for and by."""
    python = f"python{sys.version_info[0]}{sys.version_info[1]}"
    target = llvm.get_process_triple(), llvm.get_host_cpu_features().flatten(), version("llvmlite")
    settings = [os.environ.get(name, "") for name in _SETTINGS]
    rest = hashlib.sha256(json.dumps([target, settings]).encode()).hexdigest()[:8]
    return f"{llvm.get_host_cpu_name()}-numba{version('numba')}-{python}-{rest}"


class Object(NamedTuple):
    """Machine code. symbols : the functions it expects to find."""

    symbols: list[str]
    code: bytes


def contact_of(law: str) -> str:
    """The contact whose machine a law is linked to, by its name: of the file, or of the folder that it is in."""
    return next(file.partition(".")[0] for file, beginning in CONTACTS.items() if law.startswith(beginning))


def machine_of(contact: str, signals: bool) -> str:
    """Name of the object of a machine, for maps or for signals."""
    return f"{contact}-{'signals' if signals else 'maps'}"


def file_of(name: str) -> str:
    """Name of the file of an object on this machine."""
    return f"{name}-{_host()}.o"


def shipped_folder() -> Path:
    """Folder in the package for objects of these sources."""
    return _HERE / f"shipped-{source_digest()}"


def shipped_file(name: str, kind: str) -> str:
    """Name of its file for a kind of processor."""
    return f"{name}-{sys.platform}-{llvm.get_process_triple().partition('-')[0]}-{kind}.o"


def kinds_here() -> dict[str, tuple[str, ...]]:
    """The kinds of processors of this family, and what they can do."""
    return KINDS.get(llvm.get_process_triple().partition("-")[0], {})


@cache
def shipped_kind() -> str | None:
    """The kind of this processor for which the package brings objects; None where it brings none."""
    folder = shipped_folder()
    if any(os.environ.get(name) for name in _SETTINGS) or not folder.is_dir():
        return None
    if objection(folder.lstat(), stat.S_ISDIR):
        return None
    able = llvm.get_host_cpu_features()
    fitting = (kind for kind, features in kinds_here().items() if all(able.get(feature) for feature in features))
    return next((kind for kind in fitting if (folder / shipped_file("stribeck", kind)).is_file()), None)


def shipped(name: str) -> Object | None:
    """The object that the package brings for this processor; None where it brings none that may be trusted."""
    kind = shipped_kind()
    return None if kind is None else read(shipped_folder() / shipped_file(name, kind))


def packed(file: str, made: Object) -> bytes:
    """An object as the bytes of a file of this name."""
    content = json.dumps({"file": file, "symbols": made.symbols}).encode() + b"\n" + made.code
    return hashlib.sha256(content).digest() + content


def unpacked(file: str, data: bytes) -> Object | None:
    """Return what `packed` was given; None where damaged, or the object of another file: such code must not run."""
    content = data[_DIGEST_BYTES:]
    if data[:_DIGEST_BYTES] != hashlib.sha256(content).digest():
        return None
    head, _, code = content.partition(b"\n")
    try:
        plain = json.loads(head)
        symbols = [str(symbol) for symbol in plain["symbols"]]
        return Object(symbols, code) if plain["file"] == file else None
    except (ValueError, TypeError, KeyError, RecursionError):
        return None


def write(path: Path, made: Object) -> None:
    """Put an object into a file that nobody else may read or write, whole or not at all."""
    descriptor, fresh = tempfile.mkstemp(prefix=f"{path.name}.", dir=path.parent)
    try:
        with open(descriptor, "wb") as file:
            file.write(packed(path.name, made))
        os.replace(fresh, path)
    finally:
        Path(fresh).unlink(missing_ok=True)


def read(path: Path) -> Object | None:
    """Return what `write` put into a file; None where there is none, or it is damaged or may be somebody else's."""
    data = _bytes(path)
    return None if data is None else unpacked(path.name, data)


def _bytes(path: Path) -> bytes | None:
    """The content of a file that may be trusted with code."""
    try:
        descriptor = os.open(path, os.O_RDONLY | sum(getattr(os, flag, 0) for flag in _AS_IT_IS))
    except OSError:
        return None
    with open(descriptor, "rb") as file:
        return None if objection(os.fstat(descriptor)) else file.read()
