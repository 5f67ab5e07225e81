"""The ready-to-run configurations, wherever the package is installed.

A wheel carries them inside the package (``stickslip/configs``); in a checkout, and in an editable install of one, they
are the folder ``configs`` at its root. Those in folders below it are called by folder and name: ``article/fig3``.
``configs/article/fig3.yaml`` calls the same one wherever there is no such file, so that commands which work in a
checkout work everywhere.
"""

from __future__ import annotations

import os
from pathlib import Path

from stickslip.vocabulary.words import nearest

_PREFIX = "configs/"
_PACKAGE = Path(__file__).resolve().parents[1]
_FOLDERS = (_PACKAGE / "configs", _PACKAGE.parents[1] / "configs")


def _folder() -> Path:
    """The first of the two folders that exists."""
    for folder in _FOLDERS:
        if folder.is_dir():
            return folder
    raise FileNotFoundError(
        f"the configurations that come with stickslip are missing: no {_FOLDERS[0]}, no {_FOLDERS[1]}"
    )


def config_names() -> list[str]:
    """Names of the configurations that come with the package, sorted, without ``.yaml``; folders before a slash."""
    folder = _folder()
    return sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.yaml"))


def config_path(name: str) -> Path:
    """File of the configuration called `name` (with or without ``configs/`` and ``.yaml``).

    Raises FileNotFoundError, naming those that exist.
    """
    names = config_names()
    stem = _stem(name)
    if stem not in names:
        near = nearest(stem, names)
        meant = f"did you mean {near}? " if near else ""
        raise FileNotFoundError(f"no configuration is called {name!r}; {meant}there are {', '.join(names)}")
    return _folder() / f"{stem}.yaml"


def found(path: str | os.PathLike[str]) -> Path:
    """The file at `path`; where there is none, the configuration of the package that ``configs/NAME.yaml`` or a bare
    ``NAME`` calls. A path that calls none either is returned as it is, for whoever reads it to complain.
    """
    here = Path(path)
    name = here.as_posix()
    called = name.startswith(_PREFIX) if here.suffix else True  # my.yaml that is not there is a mistake
    if here.exists() or not called or not any(folder.is_dir() for folder in _FOLDERS):
        return here
    stem = _stem(name)
    return config_path(stem) if stem in config_names() else here


def found_points(path: str | os.PathLike[str]) -> Path:
    """The file of measured points at `path`; where there is none, that of the package which ``configs/NAME.csv`` or
    ``NAME.csv`` calls, such as ``measured/dry.csv``. A path that calls none either is returned as it is.
    """
    here = Path(path)
    if here.exists() or here.is_absolute() or ".." in here.parts:
        return here
    for folder in _FOLDERS:
        if (there := folder / here.as_posix().removeprefix(_PREFIX)).is_file():
            return there
    return here


def _stem(name: str) -> str:
    return name.removeprefix(_PREFIX).removesuffix(".yaml")
