"""The ready-to-run configurations, wherever the package is installed, and the one that `stickslip init` writes.

A wheel carries them inside the package (``stickslip/configs``); in a checkout, and in an editable install of one, they
are the folder ``configs`` at its root. Those in folders below it are called by folder and name: ``article/fig3``.
``configs/article/fig3.yaml`` calls the same one wherever there is no such file, so that commands which work in a
checkout work everywhere.
"""

import os
from pathlib import Path

from stickslip.vocabulary.suggest import nearest

_PREFIX = "configs/"
_PACKAGE = Path(__file__).resolve().parents[1]
_FOLDERS = (_PACKAGE / "configs", _PACKAGE.parents[1] / "configs")


def starter() -> str:
    """Return the text of the configuration to start from: every section with a comment, ready to run and to change."""
    return Path(__file__).with_name("starter.yaml").read_text(encoding="utf-8")


def config_names() -> list[str]:
    """Names of the configurations that come with the package, sorted, without ``.yaml``; folders before a slash."""
    return sorted(_shipped())


def config_path(name: str) -> Path:
    """The file of the configuration called `name` (with or without ``configs/`` and ``.yaml``).

    Raises FileNotFoundError, naming those that exist.
    """
    shipped, stem = _shipped(), stem_of(name)
    if stem not in shipped:
        near = nearest(stem, sorted(shipped))
        hint = f"did you mean {near}? " if near else ""
        raise FileNotFoundError(f"no configuration is called {name!r}; {hint}there are {', '.join(sorted(shipped))}")
    return shipped[stem]


def existing_config(path: str | os.PathLike[str]) -> Path:
    """The file at `path`; where there is none, the configuration of the package that ``configs/NAME.yaml`` or a bare
    ``NAME`` calls. A path that calls none either is returned as it is, for whoever reads it to complain.
    """
    here = Path(path)
    calls = not here.suffix or here.as_posix().startswith(_PREFIX)  # my.yaml that is not there is a mistake
    if here.exists() or not calls or not any(folder.is_dir() for folder in _FOLDERS):
        return here
    return _shipped().get(stem_of(here.as_posix()), here)


def points_path(path: str | os.PathLike[str]) -> Path:
    """The file of measured points at `path`; where there is none, that of the package which ``configs/NAME.csv`` or
    ``NAME.csv`` calls, such as ``measured/dry.csv``. A path that calls none either is returned as it is.
    """
    here = Path(path)
    if here.exists() or here.is_absolute() or ".." in here.parts:
        return here
    shipped = (folder / here.as_posix().removeprefix(_PREFIX) for folder in _FOLDERS)
    return next((there for there in shipped if there.is_file()), here)


def _shipped() -> dict[str, Path]:
    if folder := next((folder for folder in _FOLDERS if folder.is_dir()), None):
        return {path.relative_to(folder).with_suffix("").as_posix(): path for path in folder.rglob("*.yaml")}
    folders = ", ".join(f"no {folder}" for folder in _FOLDERS)
    raise FileNotFoundError(f"the configurations that come with stickslip are missing: {folders}")


def stem_of(name: str) -> str:
    """The name of a configuration, without ``configs/`` and ``.yaml``."""
    return name.removeprefix(_PREFIX).removesuffix(".yaml")
