"""Arrays in, labelled datasets out; and what is said and selected of a dataset.

build       cells given; maps, trajectories    provenance  the global attributes
display     units, words and axes              selection   parts of a dataset
polylines   borders as lines                   coarse      maps in chunks, and in pixels
summary     regimes of a map, cells that need attention
export      tables for other programs
"""

from stickslip.files.reading import wait_for_imports

wait_for_imports()
