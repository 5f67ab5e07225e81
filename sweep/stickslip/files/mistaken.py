"""Files of another kind than a command expects: what they are, and which command takes them."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

_BEGINNINGS = {  # of files, whatever they are called
    b"\x89HDF\r\n\x1a\n": "netcdf", b"CDF\x01": "netcdf", b"CDF\x02": "netcdf", b"CDF\x05": "netcdf",
    b"PK\x03\x04": "zip", b"\xd0\xcf\x11\xe0": "workbook", b"\x89PNG": "plot", b"%PDF": "plot", b"RIFF": "sound",
}  # fmt: skip
_SUFFIXES = {
    ".yaml": "configuration", ".yml": "configuration", ".csv": "table", ".tsv": "table", ".svg": "plot",
    ".html": "page", ".htm": "page", ".py": "program", ".ipynb": "notebook", ".json": "json",
}  # fmt: skip
_STORE = ".parts"
_TAKEN_BY = {  # what a kind is called, and who takes it; {} is the name of the file
    "configuration": ("a configuration", "`stickslip run {}` computes it, `stickslip validate {}` checks it"),
    "netcdf": ("a netCDF file", "`stickslip inspect {}` says what is in a result, `stickslip plot {}` draws it"),
    "zarr": ("a Zarr store", "`stickslip inspect {}` says what is in a result, `stickslip plot {}` draws it"),
    "store": ("the working store of a run", "`stickslip status {}` shows the run, `stickslip collect {}` writes it"),
    "workbook": ("an Excel workbook", "save the sheet as CSV: `stickslip fit` reads measured points from it"),
    "table": ("a table", "`stickslip fit {}` fits measured points, `stickslip rig features {}` judges a rig record"),
    "zip": ("an archive", None),
    "plot": ("a plot", None),
    "page": ("a web page", None),
    "sound": ("a sound", None),
    "program": ("a program", None),
    "notebook": ("a notebook", None),
    "json": ("JSON", None),
    "folder": ("a folder", None),
}
_RESULTS, _CONFIGURATIONS = ("netcdf", "zarr"), ("configuration", "json")  # JSON is YAML too
_TABLES = ("table", "json", "page", "program")  # whatever is text may have a first line of names
CONFIGURATIONS_HERE, RESULTS_HERE = ("*.yaml", "*.yml"), ("*.nc", "*.zarr")  # patterns of names
TABLES_HERE = ("*.csv", "*.txt", "*.tsv", "*.dat")


class Mistaken(NamedTuple):
    """What a file is instead of what was expected, and the next step or None."""

    what: str
    hint: str | None


def no_configuration(path: Path) -> Mistaken | None:
    """What there is at `path` if that cannot be a configuration; None if it can be one, or is not there."""
    kind = _kind(path)
    return None if kind in (None, *_CONFIGURATIONS) else _mistaken(path, kind, CONFIGURATIONS_HERE)


def no_result(path: Path) -> Mistaken | None:
    """What there is at `path` if that cannot be a result; None if it can be one, or is not there."""
    kind = _kind(path)
    return None if kind in (None, *_RESULTS) else _mistaken(path, kind, RESULTS_HERE)


def no_table(path: Path) -> Mistaken | None:
    """What there is at `path` if that cannot be a table as text; None if it can be one, or is not there."""
    kind = _kind(path)
    return None if kind in (None, *_TABLES) else _mistaken(path, kind, TABLES_HERE)


def names_in(folder: Path, patterns: tuple[str, ...], most: int = 8) -> list[str]:
    """Names of what is in a folder by pattern, sorted; of more than `most` the first ones, and how many there are."""
    try:
        found = sorted({path.name for pattern in patterns for path in folder.glob(pattern)})
    except OSError:
        return []
    return found if len(found) <= most else [*found[:most], f"... ({len(found)} in all)"]


def _mistaken(path: Path, kind: str, wanted: tuple[str, ...]) -> Mistaken:
    what, hint = _TAKEN_BY[kind]
    if kind == "folder" and (inside := names_in(path, wanted)):
        hint = f"{path} holds {', '.join(inside)}"
    return Mistaken(what, hint and hint.replace("{}", str(path)))


def _kind(path: Path) -> str | None:
    """The kind of what is at `path`; None for nothing, and for a file that may be anything."""
    if path.is_dir():
        if path.suffix == _STORE:
            return "store"
        is_zarr = path.suffix == ".zarr" or any((path / name).exists() for name in ("zarr.json", ".zgroup"))
        return "zarr" if is_zarr else "folder"
    try:
        with path.open("rb") as file:
            begins = file.read(8)
    except OSError:
        return None
    kind = next((kind for start, kind in _BEGINNINGS.items() if begins.startswith(start)), None)
    if kind == "zip" and path.suffix.lower().startswith((".xls", ".ods")):
        return "workbook"
    return kind or _SUFFIXES.get(path.suffix.lower())
