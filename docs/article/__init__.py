"""The theoretical figures of *Controlling Stick-Slip Noise Generation with Lubricants*, reproduced.

`FIGURES` lists them, `make` writes them. Each comes from configurations in `configs/article` through the public calls,
and each states numbers, its findings, which the tests check and the gallery (`gallery.write`) prints.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from article.plotting import DPI
from article.recipe import Figure, Findings, Made
from article.registry import FIGURES
from stickslip import plots
from stickslip.files import writing

__all__ = ["FIGURES", "Figure", "Findings", "Made", "Written", "make"]


@dataclass(frozen=True)
class Written:
    """A figure in files: its plot (PNG), its data (netCDF), and its findings."""

    name: str
    plot: Path
    data: Path
    findings: Findings


def make(
    names: Iterable[str], folder: str | os.PathLike[str], *, progress: Callable[[str], None] | None = None
) -> list[Written]:
    """Make figures into a folder, which is created: NAME.png and NAME.nc each.

    names : of `FIGURES`; none at all means every one. progress : called with each name before it is made.
    Raises ValueError before anything is made.
    """
    wanted = list(dict.fromkeys(names)) or list(FIGURES)
    if unknown := [name for name in wanted if name not in FIGURES]:
        raise ValueError(f"no figure is called {', '.join(unknown)}; there are {', '.join(FIGURES)}")
    target = Path(folder)
    target.mkdir(parents=True, exist_ok=True)
    written = []
    for name in wanted:
        if progress is not None:
            progress(name)
        made = FIGURES[name].function()
        plot, data = target / f"{name}.png", target / f"{name}.nc"
        plots.save(made.plot, plot, DPI)
        writing.write(made.data, data)
        written.append(Written(name, plot, data, made.findings))
    return written
