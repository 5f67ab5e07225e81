"""Arrays in, labelled datasets out; and what is said and selected of a dataset.

build       maps, cells, trajectories     studies     borders, contours, margins, attractors, probabilities
materials   materials compared            provenance  the global attributes
axis        a dimension as an axis        display     units in which people see values
selection   parts of a dataset            polylines   borders as lines
coarse      maps in chunks, and in pixels summary, survey   regimes of a map, cells that need attention
export      tables for other programs     given       cells that people give
"""

from stickslip.files.lazy_duck_arrays import wait_for_imports

wait_for_imports()
