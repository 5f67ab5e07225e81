"""xarray without the libraries of arrays that nobody has imported.

Of every variable xarray asks whether it holds an array of dask or pint, and imports both to know: 0.4 s of every
command, as much as all the rest of `stickslip inspect` (measured). But no array is one of a library that nobody has
imported. So what xarray keeps of each library (`xarray.namedarray.pycompat`, private; seen in 2026.9) says so, and so
does its question for collections of dask.
"""

import sys
from typing import Any

from xarray.namedarray import pycompat, utils

_CLASSES = {"dask": ("dask.array", "Array"), "pint": ("pint", "Quantity")}


class _LazyModule:
    """A `pycompat.DuckArrayModule` of a library that may never be imported."""

    def __init__(self, name: str) -> None:
        self._name = name

    @property
    def type(self) -> tuple[type[Any], ...]:
        """The class of its arrays, in a tuple; an empty one before the library is imported."""
        module, name = _CLASSES[self._name]
        kind = getattr(sys.modules.get(module), name, None)
        return () if kind is None else (kind,)

    def __getattr__(self, name: str) -> Any:
        """Everything else as xarray has it, for which it imports the library."""
        return getattr(pycompat.DuckArrayModule(self._name), name)  # type: ignore[arg-type]


def wait_for_imports() -> None:
    """Have xarray wait for others to import these libraries; where it has become another one, it goes on as before."""
    known = getattr(pycompat, "_cached_duck_array_modules", None)
    if isinstance(known, dict) and hasattr(pycompat, "DuckArrayModule"):
        for name in _CLASSES:
            known.setdefault(name, _LazyModule(name))
    ask = getattr(utils, "is_dask_collection", None)
    if ask is None or hasattr(ask, "asks_less"):
        return

    def is_dask_collection(x: object) -> Any:
        # Imported, and whole: another thread may be importing dask, which a second import would upset.
        spec = getattr(sys.modules.get("dask"), "__spec__", None)
        return spec is not None and not getattr(spec, "_initializing", False) and ask(x)

    is_dask_collection.asks_less = True  # type: ignore[attr-defined]
    utils.is_dask_collection = is_dask_collection  # type: ignore[assignment]
