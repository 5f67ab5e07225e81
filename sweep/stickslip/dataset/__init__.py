"""Arrays in, labelled datasets out; and what is said and selected of a dataset.

What is where:

    build       variables, coordinates and attributes from arrays     provenance  what made them
    axis        a dimension as an axis        select   a part of a map        summary, inspect   what a dataset holds
    chunks      arrays larger than memory, read in parts              coarse      maps with more cells than pixels
"""

from stickslip.files.duck_arrays import import_no_more

import_no_more()
