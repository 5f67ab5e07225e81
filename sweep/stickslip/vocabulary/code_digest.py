"""A digest of functions that people write: of their byte code, and of all that it refers to.

Functions that differ in it compute something else, so that compiled code named by it is never that of an older version.
"""

import hashlib
import sys
from collections.abc import Callable
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

_DIGITS = 16
_NOT_FOLLOWED = {*sys.stdlib_module_names, "numba", "numpy"}  # whose versions name the compiled code besides
_PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))


def code_digest(*functions: Callable[..., Any]) -> str:
    """The digest of functions, in hexadecimal digits. Raises ValueError for what they refer to and nobody can read."""
    digest = hashlib.sha256()
    for function in functions:
        _add(digest, function, set())
    return digest.hexdigest()[:_DIGITS]


def _add(digest: Any, value: Any, seen: set[int], within: CodeType | None = None) -> None:
    """Add a value that code refers to. within : the code, whose names tell what it takes of a module."""
    value = getattr(value, "py_func", value)  # of Numba
    digest.update(type(value).__name__.encode() + b"\0")
    if isinstance(value, _PLAIN):
        digest.update(repr(value).encode() + b"\0")
    elif id(value) in seen:
        return
    elif isinstance(value, FunctionType):
        seen.add(id(value))
        _add_function(digest, value, seen)
    elif isinstance(value, tuple | frozenset):
        for one in sorted(value, key=repr) if isinstance(value, frozenset) else value:
            _add(digest, one, seen, within)
    elif isinstance(value, ModuleType):
        digest.update(value.__name__.encode() + b"\0")
        if within is not None and value.__name__.partition(".")[0] not in _NOT_FOLLOWED:
            for name in within.co_names:
                if hasattr(value, name):
                    _add(digest, getattr(value, name), seen, within)
    elif hasattr(value, "tobytes") and hasattr(value, "dtype"):
        digest.update(f"{value.dtype} {value.shape}".encode() + value.tobytes())
    elif isinstance(value, BuiltinFunctionType | type) or type(value).__name__ == "ufunc":
        digest.update(value.__name__.encode() + b"\0")
    else:
        raise ValueError(f"it refers to {value!r}, expected numbers, arrays, modules and functions")


def _add_function(digest: Any, function: FunctionType, seen: set[int]) -> None:
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        digest.update(name.encode() + b"\0")
        _add(digest, cell.cell_contents, seen, function.__code__)
    _add(digest, function.__defaults__ or (), seen)
    _add_code(digest, function.__code__, function.__globals__, seen)


def _add_code(digest: Any, code: CodeType, known: dict[str, Any], seen: set[int]) -> None:
    digest.update(code.co_code + repr((code.co_names, code.co_varnames, code.co_argcount)).encode())
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            _add_code(digest, constant, known, seen)
        else:
            _add(digest, constant, seen)
    for name in code.co_names:
        if name in known:
            _add(digest, known[name], seen, code)
