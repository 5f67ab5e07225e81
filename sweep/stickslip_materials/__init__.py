"""Measured friction: an extension of `stickslip`.

`stickslip fit` fits curves and ageing to measured points, `stickslip points` reads points from a
record, `stickslip compare` ranks materials by the belt speed above which each is quiet; `friction: {fit: FILE.csv}` and
`{table: FILE.csv}` of a configuration are curves of measured points.

    extension.py   what the engine is told      fit/       tables, their headings, and what is fitted to them
    resolve.py     files in configurations      compare/   ranks, the page, the dataset
    plots.py       pictures of both             commands.py   `fit`, `points`, `compare`

Other extensions read tables of measured points through `fit.headings`, `fit.columns` and `fit.words`.
"""
