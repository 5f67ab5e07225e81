"""Arrays in, labelled datasets out; and what is said and selected of a dataset.

build       cells given; maps, trajectories; the global attributes
display     units, words, axes, borders as lines   selection   parts of a dataset
coarse      maps of any size: counted, listed, reduced to pixels   export   tables for other programs
"""

import stickslip.files.reading  # noqa: F401  (has xarray wait for others to import dask)
