"""The one compile decorator of the kernels.

Whole machines run from an object (`building.py`, `runtime.py`). What calls a single kernel, as tests do, has Numba
compile it alone, and keep it on disk. That cache does not notice an edit in another file: an edited friction law would
go on computing the old one. So it lies in the folder of the objects, which is named by the digest of all kernel
sources. The folder is set only while a kernel is being decorated; the process-wide Numba setting is left as it was.
"""

from __future__ import annotations

import numba
from numba.extending import overload

from .objects import CACHE_FOLDER

_parts = False  # whether functions are parts of one object, see `compile_parts`
FASTMATH, WIDEST_VECTORS = {"contract"}, '"prefer-vector-width"="512"'
APART: set[str] = set()  # names of functions that are merged into no other


def compile_parts() -> None:
    """Decorate kernels from now on as parts of one object (`building.py`): without a way in, and without a cache."""
    global _parts
    _parts = True


def compiled(function=None, *, inline=False, apart=False):
    """Compile a kernel: serial, nogil, cached, IEEE except for fused multiply-add.

    inline : True for the small functions of the hot loop, which LLVM must merge before it can vectorise the loop, and
        for scalar functions called from one place only, since a call hands over seven words for each array.
    apart : True for rare functions with loops of their own, which the hot loop is better without.

    Kernels make no arrays, so that none counts references: each count is an atomic instruction, and together they took
    a sixth of the time.
    Division by zero gives inf or NaN (`error_model="numpy"`): NaN is a signal here, and kernels never raise.
    """
    if function is None:
        return lambda body: compiled(body, inline=inline, apart=apart)
    if apart:
        APART.add(function.__qualname__)
    options = {
        "nogil": True,
        "error_model": "numpy",
        "fastmath": FASTMATH,
        "forceinline": inline,
        "no_cfunc_wrapper": True,
        "no_cpython_wrapper": _parts,
        "_nrt": False,
    }
    if _parts:
        return numba.njit(**options)(function)
    before = numba.config.CACHE_DIR
    try:
        numba.config.CACHE_DIR = "" if CACHE_FOLDER is None else str(CACHE_FOLDER)
        return numba.njit(cache=CACHE_FOLDER is not None, **options)(function)
    finally:
        numba.config.CACHE_DIR = before


def by_type(type_of_tag, *, inline=False):
    """Decorator: a function that is compiled as the type of a tag says, so that the choice costs nothing at run time.

    type_of_tag : picks the type of the tag from those of the arguments. A version for tags of a class, and of those
    derived from it, is registered with `.of(class)`; the decorated function itself, which exists in compiled code only,
    is what others get.
    """

    def decorate(default):
        versions = {}
        options = {"_nrt": False, "error_model": "numpy", "fastmath": FASTMATH, "forceinline": inline}
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

        @overload(default, strict=False, jit_options=options)
        def choose(*types):
            kinds = type_of_tag(*types).instance_class.__mro__
            version = next((versions[kind] for kind in kinds if kind in versions), default)
            return getattr(version, "py_func", version)

        def of(*classes):
            return lambda version: [versions.update({tag: version}) for tag in classes] and version

        default.of = of
        return default

    return decorate
