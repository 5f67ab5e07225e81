"""The gallery: a page with every figure, its configuration, and what agrees with the article and what does not.

The sentences are those of the registry, the numbers those that were just computed.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.image import imread, imsave

from article import Written, make
from article.plotting import in_words
from article.recipe import FOLDER, config_name
from article.registry import FIGURES

_HEAD = """# The article, figure by figure

Every theoretical figure of *Controlling Stick-Slip Noise Generation with Lubricants*, reproduced. Each comes from a
configuration in [configs/article](../configs/article), which `stickslip run` takes; one command makes all plots and
their data (netCDF) in about a minute:

    PYTHONPATH=docs python -m article --output figures

This page is written by `make gallery`, its numbers by the computation; tests check them
([tests/sweep/test_article.py](../tests/sweep/test_article.py)). Unless said otherwise mass 1 kg, load 1 N, no damper,
the curve of Figure 2, and a start from sticking. Figures 12 to 18 show the rig and its measurements: not here. What is
headed *Beyond the article* answers what its sentences leave open.
The [glossary](glossary.md) translates the article's words.
"""


def write(page: str | os.PathLike[str], *, progress: Callable[[str], None] | None = None) -> list[Written]:
    """Make every figure and the page that shows them.

    page : the Markdown file; plots go into images/article beside it, data files are not kept.
    """
    target = Path(page)
    folder = target.parent / "images" / FOLDER
    written = make((), folder, progress=progress)
    for figure in written:
        figure.data.unlink()
        slim(figure.plot)
    target.write_text(text(written, f"images/{FOLDER}"), encoding="utf-8")
    return written


def slim(plot: Path) -> None:
    """Make a PNG half as large: 16 shades of each colour, which is not visible in a diagram."""
    shades = np.round(imread(plot)[..., :3] * 15) / 15
    imsave(plot, np.round(255 * shades).astype(np.uint8))


def text(written: Sequence[Written], images: str) -> str:
    """The page, in Markdown. images : the folder of the plots, seen from the page."""
    return "\n".join([_HEAD, *(_entry(figure, images) for figure in written)])


def _entry(figure: Written, images: str) -> str:
    """One figure: heading, what the article says, plot, what agrees and what differs, configuration."""
    known = FIGURES[figure.name]
    words = {name: in_words(value) if isinstance(value, str) else value for name, value in figure.findings.items()}
    lines = [f"## {heading(figure.name)}: {_lowered(known.description)}", ""]
    lines += [f"![{known.description}]({images}/{figure.plot.name})", ""]
    lines += [f"- The article: {known.statement}", f"- Agrees: {known.agrees.format(**words)}"]
    if known.differs:
        lines.append(f"- Differs: {known.differs.format(**words)}")
    links = ", ".join(f"[{Path(name).name}.yaml](../configs/{config_name(name)}.yaml)" for name in known.configs)
    return "\n".join([*lines, f"- From {links}: `python -m article {figure.name}`", ""])


def heading(name: str) -> str:
    """A figure's name as the article writes it, ``Figure 2`` or ``Equation (3)``; what it does not have is said."""
    if name.startswith("fig"):
        return f"Figure {name.removeprefix('fig')}"
    return "Equation (3)" if name.startswith("eq3") else "Beyond the article"


def _lowered(words: str) -> str:
    return words if words.startswith("Stribeck") else words[0].lower() + words[1:]
