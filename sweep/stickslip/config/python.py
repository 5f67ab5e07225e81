"""Python values in, the plain data of a YAML file out: what `reader.py` checks, wherever it came from.

Arrays become lists, numbers of NumPy plain numbers, paths texts. An array with units (`units` in the attributes of a
DataArray, or an array of Pint) becomes texts with that unit, which the reader understands or refuses like any other.
In arrays, which hold no words, NaN stands for the word of its quantity (none, sticking). An axis that `np.linspace` or
`np.geomspace` made is the range it came from, so that plots know its scale. A value that is none of these is left as
it is, for the reader to refuse.
"""

import os
from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any

import numpy as np

from stickslip.config.yaml import DEEPEST, Document
from stickslip.errors import Path, Problem
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import has_missing
from stickslip.vocabulary.quantities import QUANTITIES

_AXES = "axes"
_FEWEST = 3  # values of an array that can be told to be a range


def python_document(given: Mapping[Any, Any], name: str = "") -> Document:
    """The document that a mapping, shaped like the YAML, stands for; it has no places. `name` stands for a file."""
    document = Document(name)
    document.data = _PlainData(document).value(given, ())
    return document


class _PlainData:
    """Turns Python values into plain data, and notes what no YAML could say."""

    def __init__(self, document: Document) -> None:
        self._document = document

    def value(self, given: Any, path: Path) -> Any:
        """The plain data of a value."""
        if len(path) > DEEPEST:
            self._note(path[:3], f"nested more than {DEEPEST} levels deep")
            return None
        if hasattr(given, "columns") and hasattr(given, "to_xarray"):  # a table of pandas; its index are the labels
            given = given.to_xarray()
        if hasattr(given, "data_vars"):
            return self._dataset(given, path)
        if has_missing(given):
            return "values that are masked or missing"  # which the reader refuses, as any text
        if isinstance(given, Mapping):
            return self._mapping(given, path)
        unit = units.said_by(given)
        if unit is not None or hasattr(given, "__array__"):
            return self._array(np.asarray(units.without_unit(given)), path, unit)
        if isinstance(given, list | tuple | range):
            return [self.value(item, (*path, i)) for i, item in enumerate(given)]
        return _scalar(given)

    def _mapping(self, given: Mapping[Any, Any], path: Path) -> dict[str, Any]:
        mapping: dict[str, Any] = {}
        for key, value in given.items():
            if not isinstance(key, str):
                self._note(path, f"got the key {key!r}, expected a word")
            mapping[str(key)] = self.value(value, (*path, str(key)))
        return mapping

    def _dataset(self, given: Any, path: Path) -> Any:
        """A dataset over one dimension as quantities that vary together; its labels are the names of the points."""
        if len(given.dims) != 1:
            self._note(path, f"got a dataset with {len(given.dims)} dimensions, expected one with a single dimension")
            return {}
        (dim,) = given.dims
        numbers = [name for name, v in given.variables.items() if v.dims == (dim,) and v.dtype.kind not in "OUST"]
        names = [name for name in numbers if name != dim or dim in QUANTITIES]  # places in a row are no quantity
        zipped = {str(name): self.value(given[name], (*path, "zip", str(name))) for name in names}
        texts = (array.values for array in given.coords.values() if array.dims == (dim,) and array.dtype.kind in "OUT")
        labels = next(texts, None)
        return {"zip": zipped} | ({} if labels is None else {"labels": [*map(str, labels)]})

    def _array(self, values: Any, path: Path, unit: str | None) -> Any:
        """An array as a range or as lists; numbers that have a unit become texts, those of pure quantities do not."""
        names = [key for key in path if isinstance(key, str) and key in QUANTITIES]
        row = QUANTITIES[names[-1]] if names else None  # the innermost that the path names
        if values.dtype.kind == "O":
            return self.value(values.tolist(), path)
        if row is None or values.dtype.kind not in "iuf" or (row.units == "1" and unit in ("", "1")):
            unit = None

        def plain(number: Any) -> Any:
            if isinstance(number, list):
                return [plain(inner) for inner in number]
            if row is not None and row.word is not None and number != number:
                return row.word
            return _scalar(number) if unit is None else f"{number!r} {unit}"

        if row is not None and path == (_AXES, row.name) and (ends := _range(values)) and np.all(row.allows(values)):
            return ends | {key: plain(ends[key]) for key in ("start", "stop")}
        return plain(values.tolist())

    def _note(self, path: Path, message: str) -> None:
        self._document.problems.append(Problem(path, message))


def _range(values: Any) -> dict[str, Any] | None:
    """The range whose points these are to the last bit; None if there is none."""
    if values.dtype.kind not in "iuf" or values.ndim != 1 or values.size < _FEWEST or not values[0] < values[-1]:
        return None
    start, stop = float(values[0]), float(values[-1])
    for spacing, spread in (("linear", np.linspace), ("log", np.geomspace)):
        if (spacing == "linear" or start > 0) and np.array_equal(values, spread(start, stop, values.size)):
            return {"start": start, "stop": stop, "num": int(values.size), "spacing": spacing}
    return None


def _scalar(given: Any) -> Any:
    """A number or a path as YAML would give it; anything else as it is."""
    kinds: tuple[tuple[Any, Any], ...] = ((bool | np.bool_, bool), (Integral, int), (Real, float), (str, str))
    for kind, plain in kinds:
        if isinstance(given, kind):
            return plain(given)
    return os.fspath(given) if isinstance(given, os.PathLike) else given
