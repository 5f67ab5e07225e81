"""The one compile decorator of the kernels, and the cache it writes to.

Numba's on-disk cache does not notice an edit in another file: an edited friction law would go on computing the old one.
So the cache lives in a folder named by the digest of all kernel sources: any edit anywhere gives a fresh folder.
The folder is set only while a kernel is being decorated; the process-wide Numba setting is left as it was.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
from pathlib import Path

import llvmlite.binding as llvm
import numba
from numba.extending import overload

_HERE = Path(__file__).parent


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


def compiled(function=None, *, inline=False, allocates=False):
    """Compile a kernel: serial, nogil, cached, IEEE except for fused multiply-add.

    inline : True for the small functions of the hot loop, which LLVM must merge before it can vectorise the loop, and
        for scalar functions called from one place only, since a call hands over seven words for each array.
    allocates : True where the function makes arrays. All others go without Numba's reference counts: each is an atomic
        instruction, and together they took a sixth of the time.
    Division by zero gives inf or NaN (`error_model="numpy"`): NaN is a signal here, and kernels never raise.
    """
    if function is None:
        return lambda body: compiled(body, inline=inline, allocates=allocates)
    options = {
        "nogil": True,
        "error_model": "numpy",
        "fastmath": {"contract"},
        "forceinline": inline,
        "no_cfunc_wrapper": True,
        "_nrt": allocates,
    }
    before = numba.config.CACHE_DIR
    try:
        numba.config.CACHE_DIR = "" if CACHE_FOLDER is None else str(CACHE_FOLDER)
        return numba.njit(cache=CACHE_FOLDER is not None, **options)(function)
    finally:
        numba.config.CACHE_DIR = before


def by_type(type_of_tag, *, inline=False):
    """Decorator: a function that is compiled as the type of a tag says, so that the choice costs nothing at run time.

    type_of_tag : picks the type of the tag from those of the arguments. A version for tags of a class is registered
    with `.of(class)`; the decorated function itself, which exists in compiled code only, is what others get.
    """

    def decorate(default):
        versions = {}
        options = {"_nrt": False, "error_model": "numpy", "fastmath": {"contract"}, "forceinline": inline}

        @overload(default, strict=False, jit_options=options)
        def choose(*types):
            version = versions.get(type_of_tag(*types).instance_class, default)
            return getattr(version, "py_func", version)

        def of(*classes):
            return lambda version: [versions.update({tag: version}) for tag in classes] and version

        default.of = of
        return default

    return decorate


def _mark_of(version: str) -> Path | None:
    """The file that says that a compiled version of the kernels lies in the cache."""
    # Numba keeps the code of a file by the path of that file, so that a second checkout finds nothing of the first.
    place = hashlib.sha256(str(_HERE).encode()).hexdigest()[:8]
    python = f"python{sys.version_info[0]}{sys.version_info[1]}"
    machine = f"{llvm.get_host_cpu_name()}-numba{numba.__version__}-{python}-{place}"
    return None if CACHE_FOLDER is None else CACHE_FOLDER / f"ready-{version}-{machine}"


def is_ready(version: str) -> bool:
    """Whether the kernels compiled as `version` (a friction law) are in the cache, so that a first call is quick."""
    mark = _mark_of(version)
    return mark is not None and mark.exists()


def mark_ready(version: str) -> None:
    """Note that the kernels have been compiled as `version`."""
    if mark := _mark_of(version):
        with contextlib.suppress(OSError):
            mark.touch()
