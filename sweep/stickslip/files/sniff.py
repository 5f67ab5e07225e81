"""Files of another kind than a command expects: their kind, and the command that takes them."""

from pathlib import Path
from typing import NamedTuple

_BEGINNINGS = {  # of files, whatever they are called
    b"\x89HDF\r\n\x1a\n": "netcdf", b"CDF\x01": "netcdf", b"CDF\x02": "netcdf", b"CDF\x05": "netcdf",
    b"PK\x03\x04": "zip", b"\xd0\xcf\x11\xe0": "workbook", b"\x89PNG": "plot", b"%PDF": "plot",
}  # fmt: skip
_SUFFIXES = {".yaml": "configuration", ".yml": "configuration", ".csv": "table", ".tsv": "table", ".svg": "plot"}
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
    "folder": ("a folder", None),
}


class Expected(NamedTuple):
    """Files that a command takes: their kinds, and patterns of their names."""

    kinds: tuple[str, ...]
    patterns: tuple[str, ...]


CONFIGURATIONS = Expected(("configuration",), ("*.yaml", "*.yml"))
RESULTS = Expected(("netcdf", "zarr"), ("*.nc", "*.zarr"))
TABLES = Expected(("table",), ("*.csv", "*.txt", "*.tsv", "*.dat"))  # any text


class FileKind(NamedTuple):
    """The kind of a file that was not expected, and the next step or None."""

    name: str
    hint: str | None


def wrong_file_type(path: Path, expected: Expected) -> FileKind | None:
    """The kind of what is at `path`, if it cannot be one of those expected; None if it can, or is not there."""
    kind = _kind(path)
    if kind is None or kind in expected.kinds:
        return None
    name, hint = _TAKEN_BY[kind]
    if kind == "folder" and (inside := names_in(path, expected)):
        hint = f"{path} holds {', '.join(inside)}"
    return FileKind(name, hint and hint.replace("{}", str(path)))


def names_in(folder: Path, expected: Expected, most: int = 8) -> list[str]:
    """Names of the files in a folder, sorted; of more than `most` the first ones, and how many there are."""
    try:
        names = sorted({path.name for pattern in expected.patterns for path in folder.glob(pattern)})
    except OSError:
        return []
    return names if len(names) <= most else [*names[:most], f"... ({len(names)} in all)"]


def neighbours(path: Path, expected: Expected) -> str | None:
    """`this folder holds a.nc, b.nc`, for a file that is not there; None where there is none of the kind."""
    names = names_in(path.parent, expected)
    return f"{path.parent if path.parent != Path() else 'this folder'} holds {', '.join(names)}" if names else None


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
