"""Plain data before it is checked: from Python, and with what some of its words stand for; names of files.

Arrays become lists, numbers of NumPy plain numbers, paths texts. An array with units (`units` in the attributes of a
DataArray, or an array of Pint) becomes texts with that unit, which the reader understands or refuses like any other.
In arrays, which hold no words, NaN stands for the word of its quantity (none, sticking). An axis that `np.linspace` or
`np.geomspace` made is the range it came from, so that plots know its scale. A value that is none of these is left as
it is, for the reader to refuse.

Whoever owns such a word puts in what it stands for, once: keys of extensions (`uncertain: {explained: felt.nc}` stands
for draws, say), a damping in percent, a table of points. What is checked then names no file that is still to be read.
"""

import math
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Integral, Real
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from stickslip import extensions
from stickslip.config.yaml import DEEPEST, Document
from stickslip.errors import Path, Problem
from stickslip.vocabulary import units
from stickslip.vocabulary.cells import has_missing, scales_of
from stickslip.vocabulary.models import PREFIX, own_law
from stickslip.vocabulary.own_laws import Table
from stickslip.vocabulary.quantities import QUANTITIES, nearest

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


# --- what words stand for ---------------------------------------------------------------------------------------------

LAWS_FITTED = ("stribeck",)  # whose curves are fitted to points
_FORMS = "a CSV file of slip speeds and friction, {file: FILE.csv, monotone: true}, or {speed: [...], mu: [...]}"
_AT: Path = ("friction", "table")
_KEYS = ("file", "speed", "mu", "monotone")
_SHARE = re.compile(r"\s*([-+0-9.eE]+)\s*%(\s*of critical)?\s*")


def resolved(document: Document) -> Document:
    """The document, with what its words stand for. Raises ConfigError."""
    for extension in extensions.installed():
        done = set()
        for pattern, place in extension.resolvers.items():
            if place not in done and _has(document.data, pattern.split(".")):
                done.add(place)
                document = extensions.imported(place)(document)
    return with_table(_with_damping(document))


_MEASURED = ("friction.fit", "friction.table", "axes.*.zip.fit")  # files of points, which extensions read


def has_unread(data: object) -> bool:
    """True if plain data names points that nothing which is installed reads."""
    read = extensions.brought("resolvers")
    return any(_has(data, place.split(".")) for place in _MEASURED if place not in read)


def varied_paths(axes: object) -> list[Path]:
    """The positions of the quantities along axes, whether they are right or wrong."""
    paths: list[Path] = []
    for name, axis in axes.items() if isinstance(axes, dict) else ():
        zipped = axis.get("zip") if isinstance(axis, dict) else None
        if isinstance(zipped, dict):
            paths += [("axes", name, "zip", member) for member in zipped if member in QUANTITIES]
        elif name in QUANTITIES:
            paths.append(("axes", name))
    return paths


def _has(value: Any, path: Sequence[str]) -> bool:
    """True if there is something at a path, of which `*` is any key of a mapping, or any number of a list."""
    if not path:
        return True
    key, *rest = path
    if key == "*":
        inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
        return any(_has(part, rest) for part in inner)
    return isinstance(value, dict) and key in value and _has(value[key], rest)


def _section(document: Document, key: str) -> dict[str, Any]:
    """A section of the plain data; empty where it is none."""
    section = document.data.get(key) if isinstance(document.data, dict) else None
    return section if isinstance(section, dict) else {}


def _with_damping(document: Document) -> Document:
    """The document with a damping in percent of critical damping, 2 sqrt(k m), in N s/m.

    Raises ConfigError where mass or stiffness is not one value beside it.
    """
    system = _section(document, "system")
    written = system.get("damping")
    share = _SHARE.fullmatch(written) if isinstance(written, str) else None
    if share is None:
        return document
    try:
        names = [name for name in system if name in QUANTITIES and name != "damping"]
        scales = scales_of({name: QUANTITIES[name].read(system[name]) for name in names})
        damping = float(share[1]) / 100.0 * float(scales.critical_damping)
    except ValueError:  # QuantityError is one
        damping = math.nan
    if not damping >= 0.0:
        text = f"got {written!r}, a share of critical damping, expected one mass and one stiffness beside it"
        raise document.refused(("system", "damping"), text, "or write the damping in N s/m")
    return replace(document, data={**document.data, "system": {**system, "damping": f"{damping!r} N s/m"}})


def with_table(document: Document) -> Document:
    """The document, with the points of the table that it names, the law they make, and its coefficients where none are
    given. Raises ConfigError for points that are no curve.
    """
    friction = _section(document, "friction")
    law, given = friction.get("law"), friction.get("table")
    if given is None and isinstance(law, str) and isinstance(known := own_law(law), Table):
        given = known.points()
    if given is None:
        return document
    table, described = _table(document, given)
    if law not in (None, table, f"{PREFIX}{table}"):  # behind bristles, in a resolved configuration
        raise document.refused(("friction", "law"), f"got {law} besides a table, expected none: the table is the law")
    if friction.get("fit") is not None:
        raise document.refused(("friction", "fit"), "got fit besides a table, expected one of them")
    scattered = _section(document, "uncertain").get("quantities")
    elsewhere = {path[-1] for path in varied_paths(_section(document, "axes"))}
    elsewhere |= set(scattered) if isinstance(scattered, dict) else set()
    own = {name: value for name, value in table.coefficients.items() if name not in elsewhere}
    whole = {**own, **friction, "law": str(table), "table": described}
    return replace(document, data={**document.data, "friction": whole})


def _table(document: Document, given: Any) -> tuple[Table, dict[str, Any]]:
    """The table, and what a resolved configuration says of it."""
    plain = {"file": given} if isinstance(given, str) else given
    if not isinstance(plain, Mapping) or not {"file"} <= plain.keys() and not {"speed", "mu"} <= plain.keys():
        raise document.refused(_AT, f"got {given!r}, expected {_FORMS}")
    if unknown := [key for key in plain if key not in _KEYS]:
        raise document.refused((*_AT, unknown[0]), f"unknown key, expected {', '.join(_KEYS)}")
    file, monotone = plain.get("file"), plain.get("monotone", False)
    if not isinstance(monotone, bool):
        raise document.refused((*_AT, "monotone"), f"got {monotone!r}, expected true or false")
    if file is not None and not (isinstance(file, str) and file.lower().endswith(".csv")):
        raise document.refused((*_AT, "file"), f"got {file!r}, expected the name of a CSV file")
    if "speed" not in plain:  # a resolved configuration has them
        raise document.refused(_AT, f"nothing here reads {file}, expected {_FORMS}")
    try:
        table = Table(plain["speed"], plain["mu"], monotone)
    except (TypeError, ValueError) as error:
        raise document.refused(_AT, str(error)) from None
    return table, ({} if file is None else {"file": file}) | table.points()


# --- configurations that come with the package ------------------------------------------------------------------------

# A wheel carries them inside the package (``stickslip/configs``); in a checkout they are the folder ``configs`` at its
# root. Those in folders below it are called by folder and name: ``article/fig3``. ``configs/article/fig3.yaml`` calls
# the same one wherever there is no such file, so that commands which work in a checkout work everywhere.
_PREFIX = "configs/"
_PACKAGE = FilePath(__file__).resolve().parents[1]
_FOLDERS = (_PACKAGE / "configs", _PACKAGE.parents[1] / "configs")


def starter() -> str:
    """Return the text of the configuration to start from: every section with a comment, ready to run and to change."""
    return FilePath(__file__).with_name("starter.yaml").read_text(encoding="utf-8")


def config_names() -> list[str]:
    """Names of the configurations that come with the package, sorted, without ``.yaml``; folders before a slash."""
    return sorted(_shipped())


def config_path(name: str) -> FilePath:
    """The file of the configuration called `name` (with or without ``configs/`` and ``.yaml``).

    Raises FileNotFoundError, naming those that exist.
    """
    shipped, stem = _shipped(), stem_of(name)
    if stem not in shipped:
        near = nearest(stem, sorted(shipped))
        hint = f"did you mean {near}? " if near else ""
        raise FileNotFoundError(f"no configuration is called {name!r}; {hint}there are {', '.join(sorted(shipped))}")
    return shipped[stem]


def existing_config(path: str | os.PathLike[str]) -> FilePath:
    """The file at `path`; where there is none, the configuration of the package that ``configs/NAME.yaml`` or a bare
    ``NAME`` calls. A path that calls none either is returned as it is, for whoever reads it to complain.
    """
    here = FilePath(path)
    calls = not here.suffix or here.as_posix().startswith(_PREFIX)  # my.yaml that is not there is a mistake
    if here.exists() or not calls or not any(folder.is_dir() for folder in _FOLDERS):
        return here
    return _shipped().get(stem_of(here.as_posix()), here)


def points_path(path: str | os.PathLike[str]) -> FilePath:
    """The file of measured points at `path`; where there is none, that of the package which ``configs/NAME.csv`` or
    ``NAME.csv`` calls, such as ``measured/dry.csv``. A path that calls none either is returned as it is.
    """
    here = FilePath(path)
    if here.exists() or here.is_absolute() or ".." in here.parts:
        return here
    shipped = (folder / here.as_posix().removeprefix(_PREFIX) for folder in _FOLDERS)
    return next((there for there in shipped if there.is_file()), here)


def _shipped() -> dict[str, FilePath]:
    if folder := next((folder for folder in _FOLDERS if folder.is_dir()), None):
        return {path.relative_to(folder).with_suffix("").as_posix(): path for path in folder.rglob("*.yaml")}
    folders = ", ".join(f"no {folder}" for folder in _FOLDERS)
    raise FileNotFoundError(f"the configurations that come with stickslip are missing: {folders}")


def stem_of(name: str) -> str:
    """The name of a configuration, without ``configs/`` and ``.yaml``."""
    return name.removeprefix(_PREFIX).removesuffix(".yaml")
