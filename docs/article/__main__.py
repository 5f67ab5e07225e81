"""Figures of the article, from the root of a checkout: PYTHONPATH=docs python -m article [fig3 ...] [-o FOLDER]."""

from __future__ import annotations

import argparse

from article import FIGURES, gallery, make

parser = argparse.ArgumentParser(prog="python -m article", description="Reproduce figures of the article.")
parser.add_argument("figures", nargs="*", help=f"{', '.join(FIGURES)}; all unless given")
parser.add_argument("-o", "--output", default="article", help="folder for NAME.png and NAME.nc (%(default)s)")
parser.add_argument("--page", help="write the gallery instead: a Markdown file with pictures beside it")
given = parser.parse_args()
if given.page:
    gallery.write(given.page, progress=print)
else:
    try:
        for figure in make(given.figures, given.output):
            print(f"{figure.name:8} {figure.plot}  {figure.data}")
    except ValueError as error:
        parser.error(str(error))
